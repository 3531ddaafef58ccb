use super::*;
use crate::data::{Cloud, CloudFrame};
use crate::math::Similarity;
use crate::spatial::Termination;
use crate::template::{head, head_coarse};
use nalgebra::Rotation3;

/// Points on the front of the head in the camera frame, with the transform that was applied.
fn measured(angles: (f64, f64, f64), wall: bool) -> (Cloud, Similarity) {
    let mesh = head().mesh;
    let normals = mesh.vertex_normals();
    let camera_from_model = Similarity::rigid(
        nalgebra::Matrix3::from_diagonal(&Vec3::new(1.0, -1.0, -1.0))
            * Rotation3::from_euler_angles(angles.0, angles.1, angles.2).into_inner(),
        Vec3::new(40.0, -25.0, 1300.0),
    );
    let mut points: Vec<Vec3> = mesh
        .vertices
        .iter()
        .zip(&normals)
        .filter(|(v, n)| n.z > 0.3 && v.z > 0.0 && v.y > -110.0)
        .map(|(v, _)| camera_from_model.apply(v))
        .step_by(2)
        .collect();
    if wall {
        for i in 0..200 {
            points.push(Vec3::new(
                f64::from(i % 20) * 20.0 - 200.0,
                f64::from(i / 20) * 20.0,
                1900.0,
            ));
        }
    }
    (Cloud::from_points(points), camera_from_model)
}

fn error_mm(found: &Registration, camera_from_model: &Similarity) -> f64 {
    let residual = found.model_from_data.compose(camera_from_model);
    let corners =
        [Vec3::new(70.0, 0.0, 60.0), Vec3::new(-70.0, 80.0, 60.0), Vec3::new(0.0, -90.0, 90.0)];
    corners.iter().map(|c| (residual.apply(c) - c).norm()).fold(0.0, f64::max)
}

#[test]
fn the_pose_is_recovered_for_heads_turned_either_way_and_with_a_wall() {
    let (model, coarse) = (head().mesh, head_coarse().mesh);
    for (angles, wall) in
        [((0.0, 0.0, 0.0), false), ((0.12, 0.3, -0.08), false), ((-0.1, -0.35, 0.1), true)]
    {
        let (data, truth) = measured(angles, wall);
        let input = RegisterInput {
            data: &data,
            model: &model,
            coarse: Some(&coarse),
            chin_y: None,
            landmarks: &[],
            frame: CloudFrame::Metric,
        };
        let params = RegisterParams { tolerance: 1e-6, ..RegisterParams::default() };
        let found = register(&input, &params, &()).unwrap();
        assert!(error_mm(&found, &truth) < 0.5, "{angles:?}: {} mm", error_mm(&found, &truth));
        assert_eq!(found.inliers.len(), data.len() - if wall { 200 } else { 0 });
        assert!(found.rms_after <= found.rms_before);
        assert!(found.history.windows(2).all(|w| w[1] <= w[0]), "the error never rises");
        let kept = found.assignments(&data, &model);
        assert!(kept.windows(2).all(|w| w[0].0 < w[1].0), "each vertex once");
    }
}

#[test]
fn landmarks_need_fewer_steps_and_allow_a_large_rotation() {
    let template = head();
    let (data, truth) = measured((0.2, 0.9, 0.3), false);
    let landmarks: Vec<(Vec3, Vec3)> = template
        .landmarks
        .values()
        .map(|&v| (truth.apply(&template.mesh.vertices[v]), template.mesh.vertices[v]))
        .collect();
    let with = RegisterInput {
        data: &data,
        model: &template.mesh,
        coarse: None,
        chin_y: None,
        landmarks: &landmarks,
        frame: CloudFrame::Metric,
    };
    let found = register(&with, &RegisterParams::default(), &()).unwrap();
    assert!(found.from_landmarks && error_mm(&found, &truth) < 0.1);
    let (data, truth) = measured((0.1, 0.1, 0.0), false);
    let moved: Vec<(Vec3, Vec3)> =
        landmarks.iter().map(|(_, m)| (truth.apply(m) + m.zxy() * 0.01, *m)).collect();
    let with = RegisterInput { data: &data, landmarks: &moved, ..with };
    let without = RegisterInput { landmarks: &[], ..with };
    let params = RegisterParams::default();
    let (a, b) =
        (register(&with, &params, &()).unwrap(), register(&without, &params, &()).unwrap());
    assert!(a.iterations < b.iterations, "{} with, {} without", a.iterations, b.iterations);
}

#[test]
fn the_scale_is_found_from_landmarks_when_requested() {
    let template = head();
    let truth = Similarity { scale: 1.1, ..measured((0.0, 0.1, 0.0), false).1 };
    let landmarks: Vec<(Vec3, Vec3)> = template
        .landmarks
        .values()
        .map(|&v| (truth.apply(&template.mesh.vertices[v]), template.mesh.vertices[v]))
        .collect();
    let data = Cloud::from_points(template.mesh.vertices.iter().map(|v| truth.apply(v)).collect());
    let input = RegisterInput {
        data: &data,
        model: &template.mesh,
        coarse: None,
        chin_y: None,
        landmarks: &landmarks,
        frame: CloudFrame::Metric,
    };
    let params = RegisterParams { scale: true, ..RegisterParams::default() };
    let found = register(&input, &params, &()).unwrap();
    assert!((found.model_from_data.scale * 1.1 - 1.0).abs() < 1e-6);
}

#[test]
fn data_that_cannot_be_a_face_are_rejected() {
    let model = head().mesh;
    let (data, truth) = measured((0.0, 0.0, 0.0), false);
    let input = RegisterInput {
        data: &data,
        model: &model,
        coarse: None,
        chin_y: None,
        landmarks: &[],
        frame: CloudFrame::Metric,
    };
    let params = RegisterParams::default();

    let few = Cloud::from_points(data.points[..5].to_vec());
    let error = register(&RegisterInput { data: &few, ..input }, &params, &()).unwrap_err();
    assert_eq!(error, RegisterError::TooFewPoints { got: 5, needed: 12 });

    let metres = Cloud::from_points(data.points.iter().map(|p| p * 10.0).collect());
    let error = register(&RegisterInput { data: &metres, ..input }, &params, &()).unwrap_err();
    assert!(
        matches!(error, RegisterError::Implausible { .. } | RegisterError::TooFewPoints { .. }),
        "{error}"
    );

    let mut broken = data.clone();
    broken.points[7].y = f64::NAN;
    let error = register(&RegisterInput { data: &broken, ..input }, &params, &()).unwrap_err();
    assert_eq!(error, RegisterError::NotFinite { index: 7 });

    let line = Cloud::from_points((0..40).map(|i| Vec3::new(f64::from(i), 0.0, 1000.0)).collect());
    let error = register(&RegisterInput { data: &line, ..input }, &params, &()).unwrap_err();
    assert_eq!(error, RegisterError::Degenerate);

    // left and right exchanged
    let template = head();
    let landmarks: Vec<(Vec3, Vec3)> = template
        .landmarks
        .values()
        .map(|&v| template.mesh.vertices[v])
        .map(|m| (truth.apply(&Vec3::new(-m.x, m.y, m.z)), m))
        .collect();
    let error =
        register(&RegisterInput { landmarks: &landmarks, ..input }, &params, &()).unwrap_err();
    assert!(matches!(error, RegisterError::Landmarks { rms, limit, .. } if rms > limit), "{error}");
}

#[test]
fn a_registration_worse_than_its_start_is_rejected() {
    let worse = Registration {
        model_from_data: Similarity::identity(),
        iterations: 3,
        start_iterations: 0,
        coarse_iterations: 0,
        history: vec![1.0],
        termination: Termination::Converged,
        from_landmarks: true,
        rms_before: 2.0,
        rms_after: 3.0,
        inliers: Vec::new(),
    };
    let error = reject_implausible(&worse, &head().mesh, &RegisterParams::default()).unwrap_err();
    assert_eq!(error, RegisterError::Worse { before: 2.0, after: 3.0 });
}
