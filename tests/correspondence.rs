//! A vertex of the mesh is the same point of the face in every reconstruction of one subject.
#![allow(clippy::unwrap_used)] // also the helpers of tests may stop a test
#![allow(clippy::print_stdout)] // the figures are of interest

use facerecon_core::data::Pair;
use facerecon_core::math::{Vec2, Vec3, percentile};
use facerecon_core::render::Frame;
use facerecon_core::synthetic::Person;
use facerecon_core::synthetic::simulate::{SimulateParams, simulate};
use facerecon_core::{Params, reconstruct, template};

/// Greatest error of a mark in each direction, pixels: that of a careful hand.
const MARK_ERROR_PX: f64 = 0.7;

/// Reconstructs a simulated capture with marked landmarks; the positions of the template's vertices
/// in the frame of the subject, mm.
fn vertices_on_subject(person: &Person, rig: &SimulateParams, count: usize) -> Vec<Vec3> {
    let mut simulated = simulate(&person.subject(), rig, &()).unwrap();
    let mut number = 0.0;
    let mut off = |p: Vec2| {
        number += 1.0;
        let error = |k: f64| MARK_ERROR_PX * (number * k + rig.seed as f64).sin();
        p + Vec2::new(error(12.99), 0.3 * error(78.23))
    };
    simulated.capture.landmarks = simulated
        .truth
        .landmarks
        .iter()
        .map(|(name, p)| (name.clone(), Pair { left: off(p.left), right: off(p.right) }))
        .collect();
    let found =
        reconstruct(&simulated.capture, &template::built_in(), &Params::default(), &()).unwrap();
    let subject_from_camera = simulated.truth.camera_from_model.inverse();
    let mesh = found.mesh_in(Frame::Camera);
    mesh.vertices[..count].iter().map(|p| subject_from_camera.apply(p)).collect()
}

#[test]
fn two_reconstructions_of_one_subject_have_corresponding_vertices() {
    let person = Person::new(5);
    let template = template::head();
    let count = template.mesh.vertices.len();
    let one = SimulateParams { yaw_deg: 4.0, seed: 1, ..SimulateParams::default() };
    let other = SimulateParams {
        yaw_deg: -8.0,
        pitch_deg: 4.0,
        roll_deg: 3.0,
        shift_x_mm: 8.0,
        distance_mm: 1150.0,
        baseline_mm: 170.0,
        focal_px: 2400.0,
        toe_in_deg: 3.0,
        dot_mm: 5.0,
        soft_light: 0.02,
        soft_plain: 0.3,
        ambient_plain: 0.45,
        seed: 2,
        ..SimulateParams::default()
    };
    let [a, b] = [&one, &other].map(|rig| vertices_on_subject(&person, rig, count));

    let at = |name: &str| template.mesh.vertices[template.landmarks[name]];
    let (eye, mouth) = (at("eye_right_outer"), at("mouth_down"));
    let normals = template.mesh.vertex_normals();
    let inner = |v: &usize| {
        let p = template.mesh.vertices[*v];
        p.x.abs() < 1.05 * eye.x
            && (mouth.y - 8.0..eye.y + 14.0).contains(&p.y)
            && p.z > eye.z - 6.0
            && normals[*v].z > 0.0
    };
    let apart: Vec<f64> = (0..count).filter(inner).map(|v| (a[v] - b[v]).norm()).collect();
    let [median, p90, most] = [0.5, 0.9, 1.0].map(|q| percentile(&apart, q).unwrap());
    println!("{} vertices: median {median:.2}, p90 {p90:.2}, at most {most:.2} mm", apart.len());
    assert!(apart.len() > 1000, "{}", apart.len());
    assert!(median <= 1.0 && p90 <= 2.5, "median {median:.2}, p90 {p90:.2} mm");

    // and each landmark's vertex lies at the landmark of the subject
    for (name, &v) in &template.landmarks {
        let truth = person.head.mesh.vertices[person.head.landmarks[name]];
        let limit_mm = if name.starts_with("ear_") { 5.0 } else { 4.0 };
        for found in [a[v], b[v]] {
            assert!((found - truth).norm() < limit_mm, "{name}: {found} {truth}");
        }
    }
}
