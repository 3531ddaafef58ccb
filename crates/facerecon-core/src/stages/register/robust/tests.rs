use nalgebra::Rotation3;

use super::super::{RegisterError, RegisterInput, RegisterMethod, RegisterParams, register};
use crate::data::{Cloud, CloudFrame, Mesh};
use crate::math::{Mat3, Similarity, Vec3};

fn robust() -> RegisterParams {
    RegisterParams { method: RegisterMethod::Robust, ..Default::default() }
}

/// The front of the built-in head in the camera frame, with noise; every `wrong`th point is an outlier.
fn measured(model: &Mesh, camera_from_model: &Similarity, wrong: usize) -> Cloud {
    let normals = model.vertex_normals();
    let mut cloud = Cloud::default();
    for (i, (p, n)) in model.vertices.iter().zip(&normals).enumerate() {
        let (p, n) = (camera_from_model.apply(p), camera_from_model.rotate(n));
        if n.z > -0.3 {
            continue; // turned away from the camera at z = 0
        }
        let t = i as f64;
        let noise = 0.3 * ((t * 12.99).sin() + (t * 78.2).sin());
        let off = if i % wrong == 0 { 25.0 * (t * 0.37).sin() } else { 0.0 };
        cloud.points.push(p + n * (noise + off));
        cloud.normals.push(n);
    }
    cloud
}

fn pose(yaw: f64, pitch: f64, roll: f64) -> Similarity {
    let turn =
        Rotation3::from_euler_angles(pitch.to_radians(), yaw.to_radians(), roll.to_radians());
    let camera = Mat3::from_diagonal(&Vec3::new(1.0, -1.0, -1.0));
    Similarity::rigid(camera * turn.into_inner(), Vec3::new(60.0, -35.0, 1250.0))
}

#[test]
fn turned_heads_are_registered_without_landmarks_and_without_scale() {
    let model = crate::template::head().mesh;
    for (yaw, pitch, roll) in [(0.0, 0.0, 0.0), (38.0, 5.0, -8.0), (-35.0, -15.0, 10.0)] {
        let truth = pose(yaw, pitch, roll);
        let data = measured(&model, &truth, 20);
        let input = RegisterInput {
            data: &data,
            model: &model,
            coarse: None,
            chin_y: None,
            landmarks: &[],
            frame: CloudFrame::Metric,
        };
        let found = register(&input, &robust(), &()).unwrap();
        assert_eq!(found.model_from_data.scale, 1.0);
        let error = found.model_from_data.compose(&truth);
        assert!(error.angle().to_degrees() < 0.3, "{yaw}: {}", error.angle().to_degrees());
        let worst = [Vec3::zeros(), Vec3::new(0.0, 0.0, 100.0)]
            .iter()
            .map(|p| (error.apply(p) - p).norm())
            .fold(0.0, f64::max);
        assert!(worst < 0.5, "{yaw}: {worst} mm off");
        // an upright head starts at the right pose, where noise decides
        let (before, after) = (found.rms_before, found.rms_after);
        assert!(after <= 1.01 * before, "{yaw}: from {before} to {after}");
        assert!(found.inliers.len() * 10 > data.len() * 9);
    }
}

#[test]
fn without_a_rig_the_scale_is_found_too() {
    let model = crate::template::head().mesh;
    let mut data = measured(&model, &pose(10.0, 0.0, 0.0), 30);
    // into a model-like frame of another unit
    let other = Similarity {
        scale: 0.9,
        rotation: Mat3::from_diagonal(&Vec3::new(1.0, -1.0, -1.0)),
        translation: Vec3::new(5.0, 9.0, 1100.0),
    };
    data = data.transformed(&other);
    let input = RegisterInput {
        data: &data,
        model: &model,
        coarse: None,
        chin_y: None,
        landmarks: &[],
        frame: CloudFrame::Model,
    };
    let found = register(&input, &robust(), &()).unwrap();
    assert!((found.model_from_data.scale * 0.9 - 1.0).abs() < 0.01);
}

#[test]
fn points_that_are_not_a_head_are_rejected() {
    let model = crate::template::head().mesh;
    // a cube-shaped cloud two metres wide
    let points: Vec<Vec3> = (0..3000)
        .map(|i| {
            let t = f64::from(i);
            Vec3::new((t * 12.9).sin(), (t * 78.2).sin(), (t * 37.7).sin()) * 1000.0
        })
        .collect();
    let data = Cloud::from_points(points);
    let input = RegisterInput {
        data: &data,
        model: &model,
        coarse: None,
        chin_y: None,
        landmarks: &[],
        frame: CloudFrame::Metric,
    };
    let error = register(&input, &robust(), &()).unwrap_err();
    assert!(matches!(error, RegisterError::NotTheHead { .. }), "{error}");
    let few = Cloud::from_points(data.points[..8].to_vec());
    let input = RegisterInput { data: &few, ..input };
    let error = register(&input, &robust(), &()).unwrap_err();
    assert!(matches!(error, RegisterError::TooFewPoints { got: 8, .. }), "{error}");
}
