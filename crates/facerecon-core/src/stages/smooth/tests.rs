use super::*;

/// A cone: a vertex of height 1 above a hexagon.
fn cone() -> Mesh {
    let mut vertices = vec![Vec3::z()];
    for i in 0..6 {
        let a = f64::from(i) * std::f64::consts::FRAC_PI_3;
        vertices.push(Vec3::new(a.cos(), a.sin(), 0.0));
    }
    let faces = (0..6).map(|i| [0, 1 + i, 1 + (i + 1) % 6]).collect();
    Mesh { vertices, faces, ..Mesh::default() }
}

/// A closed sphere with radius 10 and a roughness of amplitude `rough`.
fn ball(rough: f64) -> Mesh {
    let (rings, around) = (24u32, 36u32);
    let mut mesh = Mesh::default();
    mesh.vertices.push(Vec3::new(0.0, 0.0, 10.0));
    for r in 1..rings {
        for a in 0..around {
            let (t, p) = (
                f64::from(r) / f64::from(rings) * std::f64::consts::PI,
                f64::from(a) / f64::from(around) * std::f64::consts::TAU,
            );
            let sign = if (r + a) % 2 == 0 { 1.0 } else { -1.0 };
            let radius = 10.0 + rough * sign;
            mesh.vertices.push(Vec3::new(t.sin() * p.cos(), t.sin() * p.sin(), t.cos()) * radius);
        }
    }
    mesh.vertices.push(Vec3::new(0.0, 0.0, -10.0));
    let at = |r: u32, a: u32| 1 + (r - 1) * around + a % around;
    let last = mesh.vertices.len() as u32 - 1;
    for a in 0..around {
        mesh.faces.push([0, at(1, a), at(1, a + 1)]);
        mesh.faces.push([last, at(rings - 1, a + 1), at(rings - 1, a)]);
        for r in 1..rings - 1 {
            mesh.faces.push([at(r, a), at(r + 1, a), at(r + 1, a + 1)]);
            mesh.faces.push([at(r, a), at(r + 1, a + 1), at(r, a + 1)]);
        }
    }
    mesh
}

fn volume(mesh: &Mesh) -> f64 {
    (0..mesh.faces.len()).map(|f| mesh.corners(f)).map(|[a, b, c]| a.dot(&b.cross(&c)) / 6.0).sum()
}

fn plain(method: SmoothMethod, steps: usize) -> SmoothParams {
    SmoothParams { method, steps, enlarge: false, ..SmoothParams::default() }
}

#[test]
fn one_step_by_hand() {
    let mesh = cone();
    let out = smooth(&mesh, &[], &plain(SmoothMethod::Laplacian, 1), &()).unwrap();
    // the mean of the neighbours is the origin: lambda 0.5 moves half the distance
    assert!((out.mesh.vertices[0] - Vec3::new(0.0, 0.0, 0.5)).norm() < 1e-12);
    assert_eq!(out.mesh.vertices[1..], mesh.vertices[1..], "the border stays in place");
    assert!((out.movement[0] - 0.5 / 7.0).abs() < 1e-12);

    let params = SmoothParams { keep_border: false, ..plain(SmoothMethod::Laplacian, 1) };
    let out = smooth(&mesh, &[], &params, &()).unwrap();
    // vertex 1 at (1, 0, 0): neighbours are the top and the two beside it
    let mean = (mesh.vertices[0] + mesh.vertices[2] + mesh.vertices[6]) / 3.0;
    assert!((out.mesh.vertices[1] - (mesh.vertices[1] + mean) / 2.0).norm() < 1e-12);

    let params = SmoothParams { lambda: 0.5, mu: -0.6, ..plain(SmoothMethod::Taubin, 1) };
    let out = smooth(&mesh, &[], &params, &()).unwrap();
    // 1 -> 0.5, then 0.5 + 0.6 * 0.5
    assert!((out.mesh.vertices[0].z - 0.8).abs() < 1e-12);
}

#[test]
fn taubin_preserves_the_volume_that_laplacian_reduces() {
    let rough = ball(0.3);
    let whole = volume(&ball(0.0));
    let roughness = |m: &Mesh| {
        let r: Vec<f64> = m.vertices[37..m.vertices.len() - 37].iter().map(|v| v.norm()).collect();
        let mean = r.iter().sum::<f64>() / r.len() as f64;
        (r.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / r.len() as f64).sqrt()
    };
    let laplacian = smooth(&rough, &[], &plain(SmoothMethod::Laplacian, 40), &()).unwrap().mesh;
    let taubin = smooth(&rough, &[], &plain(SmoothMethod::Taubin, 40), &()).unwrap().mesh;
    let lost = |m: &Mesh| (volume(m) / whole - 1.0).abs();
    assert!(
        lost(&taubin) < 0.05 && lost(&laplacian) > 0.08,
        "{} {}",
        lost(&taubin),
        lost(&laplacian)
    );
    assert!(roughness(&taubin) < 0.2 * roughness(&rough));
}

#[test]
fn enlargement_restores_the_bounds_of_the_reference_points() {
    let mesh = ball(0.0);
    let reference: Vec<Vec3> = mesh.vertices.iter().copied().step_by(3).collect();
    let shrunk = smooth(&mesh, &reference, &plain(SmoothMethod::Laplacian, 40), &()).unwrap();
    let params = SmoothParams { enlarge: true, ..plain(SmoothMethod::Laplacian, 40) };
    let out = smooth(&mesh, &reference, &params, &()).unwrap();
    let width = |m: &Mesh, k: usize| m.bounds().map(|(lo, hi)| hi[k] - lo[k]).unwrap();
    for axis in 0..3 {
        assert!(width(&shrunk.mesh, axis) < 0.97 * width(&mesh, axis));
        assert!((width(&out.mesh, axis) / width(&mesh, axis) - 1.0).abs() < 0.01);
        assert!(out.enlarged[axis] > 1.02);
    }
    assert_eq!(shrunk.enlarged, Vec3::repeat(1.0));
}

#[test]
fn manual_factors_scale_about_the_middle() {
    let mut mesh = cone();
    mesh.vertices.iter_mut().for_each(|v| *v += Vec3::new(5.0, 0.0, 0.0));
    let params = SmoothParams { enlarge_x: 2.0, enlarge_z: 0.5, ..plain(SmoothMethod::None, 9) };
    let out = smooth(&mesh, &[], &params, &()).unwrap();
    assert_eq!(out.steps, 0);
    let (low, high) = out.mesh.bounds().unwrap();
    assert!((low - Vec3::new(3.0, -0.75f64.sqrt(), 0.25)).norm() < 1e-12);
    assert!((high - Vec3::new(7.0, 0.75f64.sqrt(), 0.75)).norm() < 1e-12);
}

#[test]
fn the_threshold_ends_smoothing_and_invalid_input_is_refused() {
    let mesh = ball(0.3);
    let params = SmoothParams { threshold: 0.05, ..plain(SmoothMethod::Laplacian, 500) };
    let out = smooth(&mesh, &[], &params, &()).unwrap();
    assert!(out.steps < 500 && out.movement[out.steps - 1] < 0.05);
    assert!(out.movement[..out.steps - 1].iter().all(|m| *m >= 0.05));

    let params = SmoothParams { mu: -0.4, ..plain(SmoothMethod::Taubin, 1) };
    assert!(matches!(smooth(&mesh, &[], &params, &()), Err(SmoothError::Mu { .. })));
    let bad = [Vec3::repeat(f64::NAN)];
    let result = smooth(&mesh, &bad, &SmoothParams::default(), &());
    assert_eq!(result.unwrap_err(), SmoothError::NotFinite { index: 0 });
    let empty = Mesh::default();
    assert!(matches!(smooth(&empty, &[], &params, &()), Err(SmoothError::Mesh(_))));
}
