//! A textured, curved surface seen by two cameras, one of them not where the calibration says.

use nalgebra::Rotation3;

use super::*;
use crate::camera::{Pinhole, StereoRig};
use crate::math::{Mat3, Similarity, Vec2, Vec3};

const SIZE: (usize, usize) = (480, 360);
const FOCAL: f64 = 1500.0;

fn depth(x: f64, y: f64) -> f64 {
    1000.0 + 0.004 * (x * x + 0.6 * y * y) - 30.0 * (-(x * x + y * y) / 1500.0).exp()
}

/// A texture that does not repeat: smoothly interpolated random values on two grids.
fn skin(x: f64, y: f64) -> f64 {
    let random =
        |i: f64, j: f64| ((i * 127.1 + j * 311.7).sin() * 43758.5453).rem_euclid(1.0) - 0.5;
    let noise = |x: f64, y: f64| {
        let (i, j) = (x.floor(), y.floor());
        let fade = |t: f64| t * t * (3.0 - 2.0 * t);
        let (u, v) = (fade(x - i), fade(y - j));
        let row = |j: f64| random(i, j) * (1.0 - u) + random(i + 1.0, j) * u;
        row(j) * (1.0 - v) + row(j + 1.0) * v
    };
    120.0 + 70.0 * noise(x / 13.0, y / 13.0) + 50.0 * noise(x / 6.0 + 50.0, y / 6.0)
}

/// The same under dots 6 mm apart.
fn dotted(x: f64, y: f64) -> f64 {
    let k = std::f64::consts::TAU / 6.0;
    0.4 * skin(x, y) + 130.0 * ((1.0 + (k * x).cos()) * (1.0 + (k * y).cos()) / 4.0).powi(2)
}

/// The photo of a camera; the subject is near (0, 0, 1000) in the world.
fn photo(camera: &Pinhole, camera_from_world: &Similarity, colour: fn(f64, f64) -> f64) -> Gray {
    let world = camera_from_world.inverse();
    let start = world.apply(&Vec3::zeros());
    Gray::from_fn(SIZE.0, SIZE.1, |x, y| {
        let ray = world.rotate(&camera.ray(Vec2::new(x as f64, y as f64)));
        let mut p = start + ray * (1000.0 / ray.z);
        for _ in 0..6 {
            p = start + ray * ((depth(p.x, p.y) - start.z) / ray.z);
        }
        colour(p.x, p.y) as f32
    })
}

fn centre() -> Vec2 {
    Vec2::new(SIZE.0 as f64 / 2.0 - 0.5, SIZE.1 as f64 / 2.0 - 0.5)
}

fn at(x: f64, rotation: Mat3) -> Similarity {
    Similarity::rigid(rotation, -(rotation * Vec3::new(x, 0.0, 0.0)))
}

/// A parallel rig that looks at the subject through shifted sensors.
fn parallel() -> (StereoRig, Rectification) {
    let shift = Vec2::new(FOCAL * 50.0 / 1000.0, 0.0);
    let rig = StereoRig::parallel(100.0, FOCAL, centre() - shift, centre() + shift);
    (rig, Rectification::from_rig(&rig, SIZE))
}

/// Pair of the parallel rig after its right camera rolled, moved down and zoomed.
fn moved_pair(roll_deg: f64, offset_px: f64, zoom: f64) -> (Rectification, Photos) {
    let (rig, rectification) = parallel();
    let roll = Rotation3::from_euler_angles(0.0, 0.0, roll_deg.to_radians()).into_inner();
    let right =
        Pinhole { fx: FOCAL * zoom, fy: FOCAL * zoom, cy: rig.right.cy + offset_px, ..rig.right };
    let cameras = [(&rig.left, at(-50.0, Mat3::identity())), (&right, at(50.0, roll))];
    (rectification, photos(cameras))
}

/// The dotted and the plain pair.
type Photos = [[Gray; 2]; 2];

fn photos(cameras: [(&Pinhole, Similarity); 2]) -> Photos {
    [dotted, skin].map(|colour| cameras.map(|(c, pose)| photo(c, &pose, colour)))
}

fn measure(rectification: &Rectification, photos: &Photos) -> RowCorrection {
    let [dots, plain] = [0, 1].map(|n| [&photos[n][0], &photos[n][1]]);
    correct_rows(rectification, Some(dots), Some(plain), &RowsParams::default())
}

/// Greatest row difference of points of the surface in corrected views of the true cameras.
fn worst_row(views: &Rectification, cameras: [(&Pinhole, Similarity); 2]) -> f64 {
    let mut worst: f64 = 0.0;
    for i in 0..49 {
        let (x, y) = (f64::from(i % 7 - 3) * 25.0, f64::from(i / 7 - 3) * 25.0);
        let point = Vec3::new(x, y, depth(x, y));
        let pixel = |n: usize| cameras[n].0.project(&cameras[n].1.apply(&point)).unwrap();
        let (l, r) = (views.left.to_rectified(pixel(0)), views.right.to_rectified(pixel(1)));
        worst = worst.max((l.y - r.y).abs());
    }
    worst
}

#[test]
fn rows_of_a_correct_calibration_are_not_changed() {
    let (rectification, pair) = moved_pair(0.0, 0.0, 1.0);
    let found = measure(&rectification, &pair);
    assert!(found.rectification.is_none() && found.warning.is_none());
    assert!(found.report.residual_px.unwrap() < 0.05, "{:?}", found.report);
    assert!(found.report.offset_px.abs() < 0.03, "{:?}", found.report);
}

#[test]
fn a_moved_camera_is_detected_and_corrected() {
    for (roll, offset, zoom) in [(0.0, 1.5, 1.0), (0.4, -2.0, 1.0), (0.0, 0.3, 1.01)] {
        let (rectification, pair) = moved_pair(roll, offset, zoom);
        let found = measure(&rectification, &pair);
        let views = found.rectification.unwrap();
        assert!(found.report.corrected && found.warning.is_some());
        assert!((found.report.offset_px - offset).abs() < 0.1, "{:?}", found.report);
        assert!((found.report.roll_deg - roll).abs() < 0.03, "{:?}", found.report);
        let (rig, _) = parallel();
        let rotation = Rotation3::from_euler_angles(0.0, 0.0, roll.to_radians()).into_inner();
        let right =
            Pinhole { fx: FOCAL * zoom, fy: FOCAL * zoom, cy: rig.right.cy + offset, ..rig.right };
        let cameras = [(&rig.left, at(-50.0, Mat3::identity())), (&right, at(50.0, rotation))];
        let worst = worst_row(&views, cameras);
        assert!(worst < 0.12, "{roll} {offset} {zoom}: {worst}");
    }
}

#[test]
fn a_calibration_of_another_rig_is_reported_and_not_corrected() {
    let (rectification, pair) = moved_pair(0.0, 15.0, 1.0);
    let found = measure(&rectification, &pair);
    assert!(found.rectification.is_none() && !found.report.corrected);
    let warning = found.warning.unwrap();
    assert!(warning.contains("calibrate again"), "{warning}");
}

#[test]
fn toed_in_photos_without_calibration_become_level_and_keep_a_flat_disparity() {
    for roll in [0.01, 0.1] {
        let camera = Pinhole::ideal(FOCAL, centre());
        let inward = |yaw: f64, pitch: f64, roll: f64| {
            Rotation3::from_euler_angles(pitch, yaw, roll).into_inner()
        };
        // both look at the subject from 100 mm to either side; the right one also pitches and rolls
        let left = at(-100.0, inward(-0.1, 0.0, 0.0));
        let right = at(100.0, inward(0.1, 0.006, roll));
        let pair = photos([(&camera, left), (&camera, right)]);
        let found = measure(&Rectification::identity(SIZE), &pair);
        assert!(found.report.corrected, "{:?}", found.warning);
        let views = found.rectification.unwrap();
        assert!(found.report.residual_px.unwrap() < 0.1, "{:?}", found.report);
        let worst = worst_row(&views, [(&camera, left), (&camera, right)]);
        assert!(worst < 0.3, "roll {roll}: {worst}");
        // the disparities of a plane perpendicular to the view must not be curved
        let disparity = |x: f64, y: f64| {
            let p = Vec3::new(x, y, 1000.0);
            let l = views.left.to_rectified(camera.project(&left.apply(&p)).unwrap());
            l.x - views.right.to_rectified(camera.project(&right.apply(&p)).unwrap()).x
        };
        let bow = disparity(-75.0, 0.0) + disparity(75.0, 0.0) - 2.0 * disparity(0.0, 0.0);
        assert!(bow.abs() < 0.5, "roll {roll}: bow {bow}");
    }
}

#[test]
fn level_photos_without_calibration_keep_their_pixels() {
    let (_, pair) = moved_pair(0.0, 0.0, 1.0);
    let found = measure(&Rectification::identity(SIZE), &pair);
    assert!(found.rectification.is_none() && !found.report.corrected);
    assert!(found.report.residual_px.unwrap() < 0.1);
}

#[test]
fn photos_without_texture_are_not_changed() {
    let flat = |w: usize, h: usize| [0, 1].map(|_| [0, 1].map(|_| Gray::filled(w, h, 80.0)));
    for (width, height) in [(0, 0), (3, 2), (90, 70), SIZE] {
        let found = measure(&Rectification::identity((width, height)), &flat(width, height));
        assert!(found.rectification.is_none() && found.warning.is_some());
    }
    let (_, rectification) = parallel();
    let found = measure(&rectification, &flat(SIZE.0, SIZE.1));
    assert_eq!(found.report, RowReport::default());
}
