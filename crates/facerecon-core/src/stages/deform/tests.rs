use super::rbf::{Centre, centres};
use super::*;
use crate::data::test_meshes::open_grid;

/// A template, points and assignments, without landmarks and outlines.
fn input<'a>(
    template: &'a Mesh,
    data: &'a Cloud,
    assignments: &'a [(usize, Vec3)],
) -> DeformInput<'a> {
    DeformInput { template, data, assignments, landmarks: &[], outlines: &[] }
}

/// A flat sheet of `n` x `n` vertices, 1 apart.
fn sheet(n: u32) -> Mesh {
    open_grid(n, n, |x, y| Vec3::new(x, y, 0.0))
}

fn hill(p: &Vec3) -> Vec3 {
    Vec3::new(0.02 * p.y, -0.01 * p.x, (p.x * 0.3).sin() * 2.0 + (p.y * 0.25).cos())
}

/// Targets on a smooth hill for scattered vertices.
fn targets(mesh: &Mesh) -> Vec<(usize, Vec3)> {
    (0..mesh.vertices.len())
        .filter(|i| (i * 7 + i / 20) % 5 == 0)
        .map(|i| (i, mesh.vertices[i] + hill(&mesh.vertices[i])))
        .collect()
}

fn run(
    method: DeformMethod,
    change: impl Fn(&mut DeformParams),
) -> (Mesh, Deformed, Vec<(usize, Vec3)>) {
    let mesh = sheet(21);
    let targets = targets(&mesh);
    let data = Cloud::from_points(targets.iter().map(|g| g.1).collect());
    let mut params = DeformParams { method, ..DeformParams::default() };
    change(&mut params);
    let input = input(&mesh, &data, &targets);
    let deformed = deform(&input, &params, &()).unwrap();
    (mesh, deformed, targets)
}

#[test]
fn every_function_passes_through_its_centres() {
    for method in [DeformMethod::GaussianRbf, DeformMethod::LinearRbf, DeformMethod::BiharmonicRbf]
    {
        let (_, out, targets) = run(method, |p| (p.stiffness, p.rounds) = (0.0, 1));
        for (vertex, target) in targets {
            let residual = (out.mesh.vertices[vertex] - target).norm();
            assert!(residual < 1e-7, "{method}: vertex {vertex} is off by {residual}");
        }
        assert!(out.rms_after < 1e-7 && out.rms_before > 0.5);
    }
}

#[test]
fn a_gaussian_has_the_given_value_at_its_nearest_neighbour() {
    let positions = [0.0, 1.0, 4.0, 9.0].map(|x| Vec3::new(x, 0.0, 0.0));
    let list: Vec<Centre> =
        positions.iter().map(|p| Centre { position: *p, displacement: Vec3::zeros() }).collect();
    let rates = rbf_gaussian::rates(&list, 0.07).unwrap();
    for (rate, nearest) in rates.iter().zip([1.0f64, 1.0, 3.0, 5.0]) {
        assert!(((-rate * nearest * nearest).exp() - 0.07).abs() < 1e-12);
    }
}

#[test]
fn two_gaussians_agree_with_the_solution_by_hand() {
    let mut mesh = sheet(3);
    mesh.vertices[4].z = 0.5;
    // vertices 0 and 2 lie 2 apart: R = [1 v; v 1], so c = (d0 - v d1) / (1 - v^2)
    let (d0, d1, v) = (Vec3::new(0.0, 0.0, 3.0), Vec3::new(1.0, 0.0, -1.0), 0.1);
    let targets = [(0, mesh.vertices[0] + d0), (2, mesh.vertices[2] + d1)];
    let data = Cloud::default();
    let input = input(&mesh, &data, &targets);
    let params = DeformParams { neighbour_value: v, ..DeformParams::default() };
    let out = deform(&input, &params, &()).unwrap();
    let c = [(d0 - d1 * v) / (1.0 - v * v), (d1 - d0 * v) / (1.0 - v * v)];
    for (i, x) in mesh.vertices.iter().enumerate() {
        let r = |k: usize| (v.ln() * (x - mesh.vertices[k]).norm_squared() / 4.0).exp();
        let expected = x + c[0] * r(0) + c[1] * r(2);
        assert!((out.mesh.vertices[i] - expected).norm() < 1e-12);
    }
}

#[test]
fn the_linear_function_ends_at_its_radius() {
    let mesh = sheet(21);
    let lift = Vec3::new(0.0, 0.0, 2.0);
    // two centres 10 apart: radius 10 / (1 - 0.5) would be 20, here v = 0.2 gives 12.5
    let (a, b) = (5 + 10 * 21, 15 + 10 * 21);
    let targets = [(a, mesh.vertices[a] + lift), (b, mesh.vertices[b])];
    let data = Cloud::default();
    let input = input(&mesh, &data, &targets);
    let params = DeformParams {
        method: DeformMethod::LinearRbf,
        neighbour_value: 0.2,
        ..DeformParams::default()
    };
    let out = deform(&input, &params, &()).unwrap();
    for (x, moved) in mesh.vertices.iter().zip(&out.mesh.vertices) {
        let (da, db) = ((x - mesh.vertices[a]).norm(), (x - mesh.vertices[b]).norm());
        let share = |d: f64| (1.0 - d / 12.5).max(0.0);
        let expected = lift.z * share(da) / f64::max(share(da) + share(db), 1.0);
        let expected = if da == 0.0 { lift.z } else { expected };
        let expected = if db == 0.0 { 0.0 } else { expected };
        assert!((moved.z - expected).abs() < 1e-12, "at {x:?}");
        assert_eq!((moved.x, moved.y), (x.x, x.y), "only along the direction of the centre");
    }
}

#[test]
fn the_biharmonic_reproduces_an_affine_motion_and_smooths_noise() {
    let mesh = sheet(21);
    let affine = |p: &Vec3| Vec3::new(1.1 * p.x + 0.2 * p.y, 0.9 * p.y - 3.0, 5.0 - 0.1 * p.x);
    let targets: Vec<_> = (0..441).step_by(9).map(|i| (i, affine(&mesh.vertices[i]))).collect();
    let noisy_targets = |noise: f64| -> Vec<(usize, Vec3)> {
        targets
            .iter()
            .enumerate()
            .map(|(k, (i, g))| (*i, g + Vec3::z() * noise * if k % 2 == 0 { 1.0 } else { -1.0 }))
            .collect()
    };
    let fit = |noise: f64, stiffness: f64| {
        // a bowl, so that the affine part is determined in all three directions
        let mut bowl = mesh.clone();
        bowl.vertices.iter_mut().for_each(|v| v.z = 0.02 * (v.x - 10.0).powi(2));
        let targets: Vec<_> = noisy_targets(noise);
        let data = Cloud::from_points(targets.iter().map(|g| g.1).collect());
        let input = input(&bowl, &data, &targets);
        let params = DeformParams {
            method: DeformMethod::BiharmonicRbf,
            stiffness,
            rounds: 1,
            ..DeformParams::default()
        };
        let out = deform(&input, &params, &()).unwrap();
        let sum: f64 = out
            .mesh
            .vertices
            .iter()
            .zip(&mesh.vertices)
            .map(|(v, x)| (v.z - affine(x).z).powi(2))
            .sum();
        (sum / 441.0).sqrt()
    };
    assert!(fit(0.0, 10.0) < 0.3);
    assert!(fit(0.5, 50.0) < 0.6 * fit(0.5, 0.0));
}

#[test]
fn landmarks_are_centres_and_take_precedence_over_points() {
    let mesh = sheet(5);
    let up = |i: usize, z: f64| (i, mesh.vertices[i] + Vec3::z() * z);
    let landmark = |(vertex, position)| LandmarkTarget { vertex, position, sigma_mm: 1.0 };
    let (assignments, landmarks) =
        ([up(0, 1.0), up(6, 1.0)], [up(6, 4.0), up(24, 2.0)].map(landmark));
    let data = Cloud::default();
    let input = DeformInput {
        template: &mesh,
        data: &data,
        assignments: &assignments,
        landmarks: &landmarks,
        outlines: &[],
    };
    let with = centres(&input, &DeformParams::default());
    assert_eq!(with.iter().map(|c| c.displacement.z).collect::<Vec<_>>(), [1.0, 4.0, 2.0]);
    let params = DeformParams { use_landmarks: false, ..DeformParams::default() };
    assert_eq!(centres(&input, &params).len(), 2);
}

#[test]
fn vertices_at_one_position_stay_together() {
    let mut mesh = sheet(5);
    mesh.vertices[7] = mesh.vertices[6];
    let targets: Vec<_> =
        [0, 6, 7, 20].map(|i| (i, mesh.vertices[i] + Vec3::z() * i as f64)).to_vec();
    let data = Cloud::default();
    let input = input(&mesh, &data, &targets);
    let out = deform(&input, &DeformParams::default(), &()).unwrap();
    assert_eq!(out.mesh.vertices[6], out.mesh.vertices[7]);
    assert!((out.mesh.vertices[6].z - 6.5).abs() < 1e-9);
}

#[test]
fn the_spacings_agree_with_an_exhaustive_search() {
    let mesh = sheet(21);
    let data = Cloud::default();
    let targets = targets(&mesh);
    let input = input(&mesh, &data, &targets);
    let list = centres(&input, &DeformParams::default());
    let spacing = rbf::spacings(&list).unwrap();
    for (i, s) in spacing.iter().enumerate() {
        let naive = (0..list.len())
            .filter(|&j| j != i)
            .map(|j| (list[i].position - list[j].position).norm())
            .fold(f64::INFINITY, f64::min);
        assert_eq!(*s, naive);
    }
}

#[test]
fn impossible_targets_are_refused() {
    let mesh = sheet(5);
    let data = Cloud::default();
    let refuse = |targets: &[(usize, Vec3)], method: DeformMethod| {
        let input = input(&mesh, &data, targets);
        deform(&input, &DeformParams { method, ..DeformParams::default() }, &()).unwrap_err()
    };
    let gaussian = DeformMethod::GaussianRbf;
    let error = refuse(&[(25, Vec3::zeros())], gaussian);
    assert_eq!(error, DeformError::Vertex { position: 0, vertex: 25, count: 25 });
    let error = refuse(&[(3, Vec3::repeat(f64::INFINITY))], gaussian);
    assert_eq!(error, DeformError::NotFinite { vertex: 3 });
    for method in [gaussian, DeformMethod::LinearRbf, DeformMethod::BiharmonicRbf] {
        assert!(matches!(
            refuse(&[(3, Vec3::zeros())], method),
            DeformError::TooFew { got: 1, .. }
        ));
    }
}
