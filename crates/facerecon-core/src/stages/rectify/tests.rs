use super::*;
use crate::camera::{Distortion, Pinhole, RigError, StereoRig, View};
use crate::data::{Pattern, PatternKind, Photo, PhotoRole, Rgb};
use crate::math::{Mat3, Similarity, Vec2, Vec3};
use nalgebra::Rotation3;

fn capture(left: Photo, right: Photo, rig: Option<StereoRig>) -> Capture {
    Capture {
        left,
        right,
        plain: None,
        extra: Vec::new(),
        pattern: Pattern { kind: PatternKind::Dots, columns: 85, rows: 64, rotation: 0.0 },
        rig,
        seeds: None,
        landmarks: Default::default(),
    }
}

fn photo(width: usize, height: usize, value: impl Fn(f64, f64) -> f64) -> Photo {
    let gray = Gray::from_fn(width, height, |x, y| value(x as f64, y as f64) as f32);
    Photo { rgb: Rgb::filled(width, height, [0; 3]), gray }
}

/// A smooth texture on the plane z = 1000 mm, by its x and y in mm.
fn texture(x: f64, y: f64) -> f64 {
    128.0 + 60.0 * (x / 14.0).sin() * (y / 11.0).cos() + 40.0 * (x / 23.0 + y / 17.0).sin()
}

fn seen(camera: &Pinhole, camera_from_left: &Similarity, width: usize, height: usize) -> Photo {
    let left_from_camera = camera_from_left.inverse();
    photo(width, height, |x, y| {
        let (origin, ray) = (
            left_from_camera.apply(&Vec3::zeros()),
            left_from_camera.rotate(&camera.ray(Vec2::new(x, y))),
        );
        let p = origin + ray * ((1000.0 - origin.z) / ray.z);
        texture(p.x, p.y)
    })
}

#[test]
fn photos_of_a_toed_in_rig_show_one_row_for_one_point() {
    let (width, height) = (240, 180);
    let rotation = Rotation3::from_euler_angles(0.01, 0.1, -0.02).into_inner();
    let lens = Distortion([-0.1, 0.2, 0.001, -0.0005, 0.0, 0.0, 0.0, 0.0]);
    let rig = StereoRig {
        left: Pinhole { distortion: lens, ..Pinhole::ideal(800.0, Vec2::new(118.0, 91.0)) },
        right: Pinhole { distortion: lens, ..Pinhole::ideal(815.0, Vec2::new(122.0, 88.0)) },
        right_from_left: Similarity::rigid(rotation, -(rotation * Vec3::new(100.0, -2.0, 3.0))),
        image_size: None,
    };
    let still = Similarity::rigid(Mat3::identity(), Vec3::zeros());
    let left = seen(&rig.left, &still, width, height);
    let right = seen(&rig.right, &rig.right_from_left, width, height);
    let rectified =
        rectify(&capture(left, right, Some(rig)), &RectifyParams::default(), &()).unwrap();
    let metric = rectified.rectification.rig.unwrap();
    // points of the plane: both rectified pictures show the texture there, in the same row
    let mut checked = 0;
    for (x, y) in [(0.0, 0.0), (30.0, -40.0), (60.0, 30.0), (-10.0, 60.0), (45.0, 5.0)] {
        let (l, r) = metric.pixels(&Vec3::new(x, y, 1000.0)).unwrap();
        assert!((l.y - r.y).abs() < 1e-9);
        for (image, p) in [(&rectified.left, l), (&rectified.right, r)] {
            let value = f64::from(image.bilinear(p.x, p.y).unwrap());
            assert!((value - texture(x, y)).abs() < 1.5, "{value} {}", texture(x, y));
            checked += 1;
        }
    }
    assert_eq!(checked, 10);
}

#[test]
fn cubic_resampling_is_exact_for_a_parabola_and_better_than_bilinear() {
    let parabola = |x: f64, y: f64| 20.0 + 0.05 * (x - 20.0).powi(2) + 0.5 * y;
    let image = photo(41, 31, parabola).gray;
    let shift = Mat3::new(1.0, 0.0, -0.3, 0.0, 1.0, 0.4, 0.0, 0.0, 1.0);
    let out = warp(&image, &View::plane(shift).unwrap(), (41, 31));
    for (x, y) in [(5, 5), (20, 15), (33, 25)] {
        let expected = parabola(x as f64 + 0.3, y as f64 - 0.4);
        assert!((f64::from(out.at(x, y)) - expected).abs() < 1e-4);
    }
    // outside the photo there is nothing
    let far = Mat3::new(1.0, 0.0, 100.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0);
    let out = warp(&image, &View::plane(far).unwrap(), (41, 31));
    assert!(out.data().iter().all(|v| *v == 0.0));
}

#[test]
fn parallel_rigs_keep_every_pixel_and_odd_sizes_are_refused() {
    let image = photo(60, 40, |x, y| (x * 7.0 + y * 3.0) % 255.0);
    let rig = StereoRig::parallel(100.0, 500.0, Vec2::new(30.0, 20.0), Vec2::new(35.0, 20.0));
    let both = capture(image.clone(), image.clone(), Some(rig));
    let out = rectify(&both, &RectifyParams::default(), &()).unwrap();
    assert_eq!((&out.left, &out.right), (&image.gray, &image.gray));
    assert!(out.rectification.rig.is_some());

    let odd = capture(image.clone(), photo(60, 41, |_, _| 0.0), Some(rig));
    let error = rectify(&odd, &RectifyParams::default(), &()).unwrap_err();
    assert!(matches!(
        error,
        RectifyError::Capture(CaptureError::PhotoSize {
            photo: PhotoRole::Right,
            got: (60, 41),
            ..
        })
    ));

    let swapped = StereoRig { right_from_left: rig.right_from_left.inverse(), ..rig };
    let error =
        rectify(&capture(image.clone(), image, Some(swapped)), &RectifyParams::default(), &());
    assert!(matches!(
        error,
        Err(RectifyError::Capture(CaptureError::Rig(RigError::Swapped { .. })))
    ));
}
