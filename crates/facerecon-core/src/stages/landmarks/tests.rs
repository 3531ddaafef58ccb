use super::*;
use crate::data::{Raster, Rgb};
use crate::math::{Vec2, median};
use crate::observer::WarningCollector;
use crate::synthetic::Person;
use crate::synthetic::simulate::{SimulateParams, Simulated, simulate};

/// The surface that a depth map shows, without the measurement: every second pixel with its normal.
fn surface_of(depth_mm: &Raster<f32>, rectification: &Rectification) -> Cloud {
    let rig = rectification.rig.as_ref().unwrap();
    let at = |x: usize, y: usize| {
        let z = f64::from(depth_mm.at(x, y));
        z.is_finite().then(|| rig.point(Vec2::new(x as f64, y as f64), rig.disparity_px(z)))?
    };
    let mut cloud = Cloud::default();
    for y in (1..depth_mm.height() - 1).step_by(2) {
        for x in (1..depth_mm.width() - 1).step_by(2) {
            let sides = [at(x - 1, y), at(x + 1, y), at(x, y - 1), at(x, y + 1)];
            let (Some(p), [Some(w), Some(e), Some(n), Some(s)]) = (at(x, y), sides) else {
                continue;
            };
            cloud.points.push(p);
            cloud.normals.push((s - n).cross(&(e - w)).normalize());
        }
    }
    cloud
}

/// A made-up person before the virtual cameras.
fn photographed(seed: u64, params: &SimulateParams) -> Simulated {
    let person = Person::new(seed);
    let small =
        SimulateParams { width_px: 384, height_px: 288, focal_px: 1383.0, ..params.clone() };
    simulate(&person.subject(), &small, &()).unwrap()
}

fn found_on(simulated: &Simulated) -> FoundLandmarks {
    let size = simulated.capture.left.size();
    let rectification = Rectification::from_rig(simulated.capture.rig.as_ref().unwrap(), size);
    let surface = surface_of(&simulated.truth.depth_mm, &rectification);
    let plain: [&Rgb; 2] =
        simulated.capture.plain.as_ref().map(|p| [&p[0].rgb, &p[1].rgb]).unwrap();
    let input = LandmarksInput {
        surface: &surface,
        plain: Some(plain),
        outlines: [None, None],
        rectification: &rectification,
    };
    find_landmarks(&input, &LandmarksParams::default(), &()).unwrap()
}

/// Distances of the landmarks from the ground truth, mm.
fn errors(found: &FoundLandmarks, simulated: &Simulated) -> Vec<f64> {
    let truth = &simulated.truth.landmark_points;
    found.landmarks.iter().map(|l| (l.position - truth[&l.name]).norm()).collect()
}

#[test]
fn the_landmarks_of_a_straight_and_of_a_turned_head_are_found() {
    let straight = SimulateParams::default();
    let turned =
        SimulateParams { yaw_deg: 20.0, pitch_deg: 8.0, roll_deg: -10.0, ..Default::default() };
    for (seed, params) in [(1, &straight), (2, &turned)] {
        let simulated = photographed(seed, params);
        let found = found_on(&simulated);
        let errors = errors(&found, &simulated);
        assert!(found.landmarks.len() >= 14, "{seed}: {}", found.landmarks.len());
        assert!(median(&errors).unwrap() < 2.5, "{seed}: {errors:?}");
        assert!(errors.iter().all(|e| *e < 8.0), "{seed}: {errors:?}");
    }
}

#[test]
fn a_plane_and_a_ball_have_no_face() {
    let rectification = Rectification::identity((64, 48));
    let plane: Vec<Vec3> = (0..10_000)
        .map(|i| Vec3::new(f64::from(i % 100) * 2.0, f64::from(i / 100) * 2.0, 1000.0))
        .collect();
    let ball: Vec<Vec3> = (0..20_000)
        .map(|i| {
            // a spiral over the half that faces the camera
            let (z, turn) = (-f64::from(i) / 20_000.0, f64::from(i) * 2.4);
            let radius = (1.0 - z * z).sqrt();
            Vec3::new(radius * turn.cos(), radius * turn.sin(), z) * 90.0
        })
        .collect();
    let toward_camera = vec![-Vec3::z(); plane.len()];
    let outward = ball.iter().map(Vec3::normalize).collect();
    let ball: Vec<Vec3> = ball.iter().map(|p| p + Vec3::z() * 1000.0).collect();
    for (points, normals) in [(plane, toward_camera), (ball, outward)] {
        let surface = Cloud { points, normals, ..Cloud::default() };
        let input = LandmarksInput {
            surface: &surface,
            plain: None,
            outlines: [None, None],
            rectification: &rectification,
        };
        let warnings = WarningCollector::new(&());
        let found = find_landmarks(&input, &LandmarksParams::default(), &warnings).unwrap();
        assert!(found.landmarks.is_empty(), "{:?}", found.landmarks);
        assert!(warnings.into_warnings()[0].contains("no face was found"));
    }
}

#[test]
fn nothing_is_looked_for_without_the_method() {
    let surface = Cloud::default();
    let rectification = Rectification::identity((64, 48));
    let input = LandmarksInput {
        surface: &surface,
        plain: None,
        outlines: [None, None],
        rectification: &rectification,
    };
    let params = LandmarksParams { method: LandmarkMethod::None, ..LandmarksParams::default() };
    let warnings = WarningCollector::new(&());
    assert_eq!(find_landmarks(&input, &params, &warnings), Ok(FoundLandmarks::default()));
    assert!(warnings.into_warnings().is_empty());
    let params = LandmarksParams { min_symmetry: 2.0, ..LandmarksParams::default() };
    let error = find_landmarks(&input, &params, &()).unwrap_err();
    assert!(error.to_string().contains("min_symmetry"), "{error}");
}
