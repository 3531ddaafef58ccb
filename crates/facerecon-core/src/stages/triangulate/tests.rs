use super::*;
use crate::camera::{Rectification, View};
use crate::data::Gray;
use crate::math::{Mat3, Vec2};

fn matched(left: Vec2, disparity: f64) -> Match {
    Match {
        left,
        right: left - Vec2::new(disparity, 0.0),
        lattice: None,
        sigma_px: 0.0,
        score: 1.0,
    }
}

fn rig() -> RectifiedRig {
    RectifiedRig {
        focal_px: 2500.0,
        baseline_mm: 140.0,
        principal_left: Vec2::new(300.0, 280.0),
        principal_right: Vec2::new(420.0, 280.0),
        camera_from_rectified: Mat3::identity(),
        metric: true,
    }
}

/// A box 200 high, 160 wide, 180 deep about the origin: front at z = 90.
fn template() -> Mesh {
    let corner = |i: u32| {
        let side = |bit: u32, half: f64| if i >> bit & 1 == 1 { half } else { -half };
        Vec3::new(side(0, 80.0), side(1, 100.0), side(2, 90.0))
    };
    Mesh {
        vertices: (0..8).map(corner).collect(),
        faces: vec![[4, 5, 7], [4, 7, 6], [1, 0, 2], [1, 2, 3]],
        ..Mesh::default()
    }
}

#[test]
fn a_known_rig_gives_millimetres_by_eq_2_2() {
    let (rig, params) = (rig(), TriangulateParams::default());
    let truth: Vec<Vec3> = (0..60)
        .map(|i| {
            let t = f64::from(i);
            Vec3::new(80.0 * t.sin(), 90.0 * (1.7 * t).cos(), 1250.0 + 60.0 * (0.3 * t).sin())
        })
        .collect();
    let matches: Vec<Match> = truth
        .iter()
        .map(|p| {
            let (left, right) = rig.pixels(p).unwrap();
            Match { left, right, lattice: None, sigma_px: 0.1, score: 1.0 }
        })
        .collect();
    let out = triangulate(&matches, Some(&rig), &template(), &params, &()).unwrap();
    assert_eq!(out.frame, CloudFrame::Metric);
    for (found, expected) in out.cloud.points.iter().zip(&truth) {
        assert!((found - expected).norm() < 1e-9);
    }
    // depth of a tenth of a pixel, by differences
    let nearer = rig.depth_mm(matches[0].disparity() + 0.1).unwrap();
    assert!((out.cloud.sigmas[0] - (truth[0].z - nearer)).abs() < 1e-3 * out.cloud.sigmas[0]);
}

#[test]
fn unknown_cameras_give_units_of_the_template_by_eq_2_3_to_2_6() {
    // disparities 100 (far), 125 and 110 (near is large)
    let matches = [
        matched(Vec2::new(100.0, 50.0), 100.0),
        matched(Vec2::new(200.0, 150.0), 125.0),
        matched(Vec2::new(150.0, 250.0), 110.0),
        matched(Vec2::new(120.0, 90.0), 100.0),
    ];
    let cloud = model_units(&matches, &template()).unwrap();
    let p = &cloud.points;
    // Eq. 2.4: Ix = 50, 137.5, 95, 70 and Iy = 50, 150, 250, 90; Eq. 2.5: w = 87.5 * 200 / 200
    for (i, x) in [-43.75, 43.75, 1.25, -23.75].into_iter().enumerate() {
        assert!((p[i].x - x).abs() < 1e-9, "{}", p[i].x);
    }
    for (i, y) in [100.0, 0.0, -100.0, 60.0].into_iter().enumerate() {
        assert!((p[i].y - y).abs() < 1e-9, "{}", p[i].y);
    }
    // Eq. 2.3 between the bounds of the part that faces the viewer, the front: z = 90 throughout
    assert!(p.iter().all(|p| (p.z - 90.0).abs() < 1e-9));

    // give the face depth: a ridge at z = 150 in front of it
    let mut mesh = template();
    mesh.vertices.extend([Vec3::new(0.0, 50.0, 150.0), Vec3::new(0.0, -50.0, 150.0)]);
    mesh.faces.extend([[4, 9, 8], [5, 8, 9]]);
    let cloud = model_units(&matches, &mesh).unwrap();
    let z: Vec<f64> = cloud.points.iter().map(|p| p.z).collect();
    assert!(z[1] > z[2] && z[2] > z[0] && (z[0] - z[3]).abs() < 1e-9, "{z:?}");
    assert!((z[1] - 150.0).abs() < 1e-9);
    // Z' = d_min / d: 1 at 100, 0.909 at 110 and 0.8 at 125 (bounds at the 1st and 99th percent)
    let near = 124.55;
    let expected = (1.0 - 100.0 / 110.0) / (1.0 - 100.0 / near);
    assert!(((z[2] - z[0]) / (z[1] - z[0]) - expected).abs() < 1e-3);
}

#[test]
fn disparities_around_zero_still_order_depth() {
    let at = |i: usize| Vec2::new(40.0 * i as f64, 35.0 * (i * i % 7) as f64);
    let matches: Vec<Match> = (0..8).map(|i| matched(at(i), -20.0 + 5.0 * i as f64)).collect();
    let mut mesh = template();
    mesh.vertices.push(Vec3::new(0.0, 0.0, 150.0));
    mesh.faces.push([4, 5, 8]);
    let cloud = model_units(&matches, &mesh).unwrap();
    let z: Vec<f64> = cloud.points.iter().map(|p| p.z).collect();
    assert!(z.is_sorted() && z[7] > z[0] + 10.0, "{z:?}");
}

#[test]
fn matches_without_points_are_refused() {
    let (rig, template) = (rig(), template());
    let params = TriangulateParams::default();
    let at = |d: f64| matched(Vec2::new(10.0 * d, 7.0 * d), d);
    let run = |m: &[Match], rig, params: &TriangulateParams| {
        triangulate(m, rig, &template, params, &()).unwrap_err()
    };
    let two = [at(1.0), at(2.0)];
    let error = run(&two, Some(&rig), &params);
    assert_eq!(error, TriangulateError::TooFewMatches { got: 2, needed: 3 });
    // the principal points are 120 px apart: a disparity of -120 is infinity
    let beyond = [at(200.0), at(150.0), at(-120.0)];
    let error = run(&beyond, Some(&rig), &params);
    assert_eq!(error, TriangulateError::Behind { index: 2, disparity_px: -120.0 });
    let three = [at(1.0), at(2.0), at(3.0)];
    let metric = TriangulateParams { method: TriangulateMethod::Metric };
    assert_eq!(run(&three, None, &metric), TriangulateError::NoRig);
    let nan = [at(1.0), at(2.0), at(f64::NAN)];
    assert_eq!(run(&nan, Some(&rig), &params), TriangulateError::NotFinite { index: 2 });
    let row: Vec<Match> =
        (0..4).map(|i| matched(Vec2::new(9.0 * f64::from(i), 5.0), 3.0)).collect();
    assert!(matches!(run(&row, None, &params), TriangulateError::Flat { .. }));
    let error = model_units(&three, &Mesh::default()).unwrap_err();
    assert!(matches!(error, TriangulateError::Template { .. }));
}

#[test]
fn depth_maps_are_light_where_near_and_black_where_unknown() {
    let mut matches = Vec::new();
    for row in 0..12 {
        for column in 0..12 {
            let left = Vec2::new(60.0 + 8.0 * f64::from(column), 20.0 + 8.0 * f64::from(row));
            matches.push(matched(left, 30.0 + f64::from(column)));
        }
    }
    let rectification = Rectification::identity((200, 130));
    let [left, right] = depth_maps(&matches, &rectification, (200, 130));
    // disparity increases to the right, and so does the grey, also between the dots
    let row: Vec<f32> = (60..=148).step_by(4).map(|x| left.at(x, 60)).collect();
    assert!(row.is_sorted() && row[0] >= 40.0 && row[22] > 250.0, "{row:?}");
    assert_eq!(left.at(20, 60), 0.0);
    // a match has its grey in both photos
    let m = matches[77];
    let at = |image: &Gray, p: Vec2| image.at(p.x as usize, p.y as usize);
    assert!((at(&left, m.left) - at(&right, m.right)).abs() < 2.0);
    // in pixels of the photo, not of the rectified picture
    let shift = Mat3::new(1.0, 0.0, 30.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0);
    let shifted = Rectification { left: View::plane(shift).unwrap(), ..rectification };
    let [moved, _] = depth_maps(&matches, &shifted, (200, 130));
    assert!((moved.at(70, 60) - left.at(100, 60)).abs() < 1e-3);
    let [none, _] = depth_maps(&[], &rectification, (20, 10));
    assert!(none.data().iter().all(|v| *v == 0.0));
}
