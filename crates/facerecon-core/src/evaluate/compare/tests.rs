use super::*;
use crate::data::test_meshes::closed_grid;
use crate::math::Mat3;

/// A bumpy, unsymmetric closed surface, mm.
fn bumpy_ellipsoid() -> Mesh {
    closed_grid(50, 60, |d| {
        let bump = 1.0 + 0.1 * (3.0 * d.x + 1.0).sin() * (4.0 * d.y).cos() + 0.08 * d.z * d.x;
        Vec3::new(75.0 * d.x, 110.0 * d.y, 90.0 * d.z) * bump
    })
}

fn plate(z: f64, half: f64) -> Mesh {
    Mesh {
        vertices: vec![
            Vec3::new(-half, -half, z),
            Vec3::new(half, -half, z),
            Vec3::new(half, half, z),
            Vec3::new(-half, half, z),
        ],
        faces: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

fn with(alignment: Alignment) -> CompareParams {
    CompareParams { alignment, samples: 5000, ..CompareParams::default() }
}

#[test]
fn distances_of_two_plates() {
    let (a, b) = (plate(0.0, 10.0), plate(0.7, 20.0));
    let both = compare(&MeshRegion::whole(&a), &MeshRegion::whole(&b), &with(Alignment::None), &())
        .unwrap();
    let d = both.before.first_to_second;
    for value in [d.median_mm, d.mean_mm, d.rms_mm, d.p90_mm, d.p99_mm, d.max_mm] {
        assert!((value - 0.7).abs() < 1e-9, "{value}");
    }
    assert_eq!((d.within_1mm, d.points), (1.0, 5000));
    // three quarters of the larger plate stick out
    let back = both.before.second_to_first;
    assert!((back.within_1mm - 0.27).abs() < 0.03 && back.max_mm > 13.0, "{back:?}");
    assert!(both.after.is_none() && both.vertex_distances.iter().all(|v| (v - 0.7).abs() < 1e-9));
    let params = CompareParams { reach_mm: Some(0.5), ..with(Alignment::None) };
    let error = compare(&MeshRegion::whole(&a), &MeshRegion::whole(&b), &params, &())
        .unwrap_err()
        .to_string();
    assert!(error.contains("within 0.5 mm") && error.contains("28.3"), "{error}");
}

#[test]
fn a_known_motion_is_recovered() {
    let first = bumpy_ellipsoid();
    let motion = Similarity {
        scale: 1.07,
        rotation: nalgebra::Rotation3::from_euler_angles(0.15, -0.2, 0.1).into_inner(),
        translation: Vec3::new(20.0, -14.0, 33.0),
    };
    let second = first.transformed(&motion);
    let sides = (MeshRegion::whole(&first), MeshRegion::whole(&second));
    let found = compare(&sides.0, &sides.1, &with(Alignment::Similarity), &()).unwrap();
    for v in &first.vertices {
        assert!((found.second_from_first.apply(v) - motion.apply(v)).norm() < 1e-3);
    }
    assert!((found.scale - 1.07).abs() < 1e-5);
    assert!(found.after.unwrap().second_to_first.max_mm < 1e-3);
    assert!(found.before.first_to_second.median_mm > 5.0);
    // without a change of size the rest of 7 % stays
    let rigid = compare(&sides.0, &sides.1, &with(Alignment::Rigid), &()).unwrap();
    assert_eq!(rigid.scale, 1.0);
    assert!(rigid.after.unwrap().first_to_second.median_mm > 2.0);
}

#[test]
fn meshes_in_different_frames_and_units_are_aligned() {
    let first = bumpy_ellipsoid();
    let turned = Similarity {
        scale: 0.1,
        rotation: Mat3::from_diagonal(&Vec3::new(1.0, -1.0, -1.0)),
        translation: Vec3::new(1.0, 2.0, 130.0),
    };
    let second = first.transformed(&turned);
    let found = compare(
        &MeshRegion::whole(&first),
        &MeshRegion::whole(&second),
        &with(Alignment::Similarity),
        &(),
    )
    .unwrap();
    assert!((found.scale - 0.1).abs() < 1e-6, "{}", found.scale);
    assert!(found.after.unwrap().first_to_second.max_mm < 1e-4);
}

#[test]
fn a_part_is_aligned_with_the_whole_despite_an_outlier_region() {
    let whole = bumpy_ellipsoid();
    let motion = Similarity::rigid(
        nalgebra::Rotation3::from_euler_angles(0.05, 0.1, -0.04).into_inner(),
        Vec3::new(4.0, -3.0, 6.0),
    );
    let mut part = whole.clone();
    // the front, with a knob that is not there on the whole
    for v in &mut part.vertices {
        if (*v - Vec3::new(30.0, 60.0, 60.0)).norm() < 22.0 {
            *v *= 1.15;
        }
    }
    let front: Vec<bool> = part.vertices.iter().map(|v| v.z > -10.0).collect();
    let moved = part.transformed(&motion.inverse());
    let side = MeshRegion { mesh: &moved, mask: Some(&front) };
    let params = CompareParams { keep: 0.8, ..with(Alignment::Rigid) };
    let found = compare(&side, &MeshRegion::whole(&whole), &params, &()).unwrap();
    let worst = part
        .vertices
        .iter()
        .map(|v| (found.second_from_first.apply(&motion.inverse().apply(v)) - v).norm())
        .fold(0.0, f64::max);
    assert!(worst < 0.3, "{worst}");
    assert!(found.after.unwrap().first_to_second.median_mm < 0.1);
    let empty = vec![false; front.len()];
    let side = MeshRegion { mesh: &moved, mask: Some(&empty) };
    assert!(matches!(
        compare(&side, &MeshRegion::whole(&whole), &params, &()),
        Err(CompareError::Region { which: "first", .. })
    ));
}

#[test]
fn samples_are_distributed_by_area_and_results_do_not_depend_on_threads() {
    let mut mesh = plate(0.0, 1.0);
    mesh.vertices.push(Vec3::new(-1.0, -9.0, 0.0));
    mesh.faces.push([0, 4, 1]); // area 8 beside the plate's 4
    let samples = sample_surface(&mesh, None, 3000);
    let below = samples.iter().filter(|s| s.point.y < -1.0).count();
    assert_eq!(samples.len(), 3000);
    assert!((below as f64 - 2000.0).abs() < 5.0, "{below}");
    let mean = samples.iter().filter(|s| s.point.y >= -1.0).map(|s| s.point).sum::<Vec3>() / 1000.0;
    assert!(mean.norm() < 0.02, "{mean}");

    let (a, b) = (bumpy_ellipsoid(), plate(3.0, 90.0));
    let run = || {
        compare(&MeshRegion::whole(&a), &MeshRegion::whole(&b), &with(Alignment::Similarity), &())
            .unwrap()
    };
    let pool = |n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
    let (one, three) = (pool(1).install(run), pool(3).install(run));
    assert_eq!(one.second_from_first, three.second_from_first);
    assert_eq!(one.before, three.before);
    assert_eq!(one.vertex_distances, three.vertex_distances);
}

#[test]
fn invalid_meshes_are_refused() {
    let good = plate(0.0, 1.0);
    let error = compare(
        &MeshRegion::whole(&Mesh::default()),
        &MeshRegion::whole(&good),
        &with(Alignment::None),
        &(),
    );
    assert!(error.unwrap_err().to_string().contains("first mesh"));
    let mut flat = plate(0.0, 1.0);
    flat.vertices.iter_mut().for_each(|v| *v = Vec3::zeros());
    assert!(
        compare(&MeshRegion::whole(&flat), &MeshRegion::whole(&good), &with(Alignment::Rigid), &())
            .is_err()
    );
}
