use super::*;
use nalgebra::Rotation3;

/// Matches of a curved surface under a lattice from a projector below the cameras, tilted upward by
/// `tilt` radians, for cameras with a focal length, `baseline` apart, with principal points shifted
/// apart.
fn matches(focal: f64, baseline: f64, shift: f64, tilt: f64) -> Vec<Match> {
    let middle = Vec2::new(383.5, 287.5);
    let projector = Vec3::new(0.0, 1250.0 * tilt.tan(), 0.0);
    let to_camera = Rotation3::from_axis_angle(&Vec3::x_axis(), tilt);
    let mut out = Vec::new();
    for row in -22..=22 {
        for column in -18..=18 {
            let ray = Vec3::new(f64::from(column) * 0.0036, f64::from(row) * 0.0036, 1.0);
            let ray = to_camera * ray;
            // intersection with the surface z(x, y) by fixed-point steps along the ray
            let mut point = projector + ray * (1250.0 / ray.z);
            for _ in 0..40 {
                let r = (point.x / 75.0).powi(2) + (point.y / 95.0).powi(2);
                let nose = 25.0 * (-(point.x / 14.0).powi(2) - (point.y / 25.0).powi(2)).exp();
                let z = 1200.0 + 45.0 * r - nose;
                point = projector + ray * ((z - projector.z) / ray.z);
            }
            let pixel = |x: f64, c: f64| {
                Vec2::new((point.x - x) * focal / point.z + c, point.y * focal / point.z + middle.y)
            };
            out.push(Match {
                left: pixel(-baseline / 2.0, middle.x + shift / 2.0),
                right: pixel(baseline / 2.0, middle.x - shift / 2.0),
                lattice: Some([column, row]),
                sigma_px: 0.0,
                score: 1.0,
            });
        }
    }
    out
}

fn estimate(matches: &[Match]) -> Result<EstimatedCameras, CamerasError> {
    estimate_cameras(matches, (768, 576), &CamerasParams::default(), &())
}

/// Depth against width of an estimate relative to the truth, minus 1; `truth` is focal length,
/// baseline and shift.
fn stretch(found: &EstimatedCameras, seen: &[Match], truth: [f64; 3]) -> f64 {
    let disparity = median(&seen.iter().map(Match::disparity).collect::<Vec<_>>()).unwrap();
    let [focal, baseline, shift] = truth;
    let distance = focal * baseline / (disparity - shift);
    found.rig.depth_mm(disparity).unwrap() / found.rig.baseline_mm / (distance / baseline) - 1.0
}

#[test]
fn the_lattice_determines_depth_against_width() {
    for truth in [
        [2300.0, 150.0, 0.0],
        [1600.0, 110.0, 0.0],
        [3200.0, 200.0, -300.0],
        [2300.0, 190.0, -90.0],
    ] {
        let [focal, baseline, shift] = truth;
        let seen = matches(focal, baseline, shift, 0.1);
        let found = estimate(&seen).unwrap();
        let off = stretch(&found, &seen, truth);
        assert!(off.abs() < found.depth_error, "{truth:?}: {off:+.3}, {found:?}");
        assert!(found.depth_error < 0.2 && !found.rig.metric);
        // with the usual lens the estimate is nearly exact
        assert!((focal - 2300.0).abs() > 1.0 || off.abs() < 0.02, "{truth:?}: {off:+.3}");
    }
}

#[test]
fn wrong_labels_and_noise_change_little() {
    let mut seen = matches(2500.0, 150.0, 0.0, 0.1);
    for (i, m) in seen.iter_mut().enumerate() {
        let wave = |k: f64| 0.08 * (i as f64 * k).sin();
        m.left += Vec2::new(wave(1.7), wave(2.3));
        m.right += Vec2::new(wave(3.1), wave(4.7));
        if i % 40 == 0 {
            m.lattice = m.lattice.map(|[c, r]| [c + 1, r]);
        }
        if i % 7 == 0 {
            m.lattice = None;
        }
    }
    let off = stretch(&estimate(&seen).unwrap(), &seen, [2500.0, 150.0, 0.0]);
    assert!(off.abs() < 0.03, "{off}");
}

#[test]
fn matches_that_do_not_determine_the_cameras_are_refused() {
    let seen = matches(2500.0, 150.0, 0.0, 0.1);
    let bare: Vec<Match> = seen.iter().map(|m| Match { lattice: None, ..*m }).collect();
    assert_eq!(
        estimate(&bare).unwrap_err(),
        CamerasError::TooFewLabels { got: 0, needed: MIN_LABELS }
    );
    // a projector between the cameras, or nearly so
    assert!(estimate(&matches(2500.0, 150.0, 0.0, 0.0)).is_err());
    let level = matches(2500.0, 150.0, 0.0, 0.02);
    assert!(matches!(estimate(&level).unwrap_err(), CamerasError::Uncertain { .. }));
    // all dots at one position
    let one: Vec<Match> =
        seen.iter().map(|m| Match { left: seen[0].left, right: seen[0].right, ..*m }).collect();
    assert!(estimate(&one).is_err());
    let mut broken = seen;
    broken[3].left.x = f64::NAN;
    assert!(estimate(&broken).is_err());
}

#[test]
fn parameters_are_validated_and_cancelling_is_obeyed() {
    struct Stop;
    impl Observer for Stop {
        fn cancelled(&self) -> bool {
            true
        }
    }
    let params = CamerasParams { focal_widths: 0.0, ..CamerasParams::default() };
    let error = estimate_cameras(&[], (768, 576), &params, &()).unwrap_err();
    assert!(error.to_string().contains("cameras.focal_widths"), "{error}");
    let error = estimate_cameras(&[], (768, 576), &CamerasParams::default(), &Stop).unwrap_err();
    assert_eq!(error, CamerasError::Cancelled(Cancelled));
}
