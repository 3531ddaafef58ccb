use super::*;
use crate::camera::{Distortion, Pinhole};
use crate::data::test_meshes::dummy_head;
use crate::data::{Mesh, Rgb};
use crate::math::{Mat3, Similarity, Vec2, Vec3};

fn pose() -> Similarity {
    let turn = nalgebra::Rotation3::from_euler_angles(0.2, 0.5, -0.1).into_inner();
    Similarity::rigid(
        Mat3::from_diagonal(&Vec3::new(1.0, -1.0, -1.0)) * turn,
        Vec3::new(12.0, -5.0, 800.0),
    )
}

/// Nearest hit of a ray from the origin with every triangle: depth, face, weights.
fn nearest_hit(points: &[[Vec3; 3]], ray: &Vec3) -> Option<(f64, usize, [f64; 3])> {
    let mut best: Option<(f64, usize, [f64; 3])> = None;
    for (face, [a, b, c]) in points.iter().enumerate() {
        let matrix = Mat3::from_columns(&[*a, *b, *c]);
        let Some(inverse) = matrix.try_inverse() else { continue };
        let w = inverse * ray; // ray = sum w_i p_i, so it leaves the triangle at ray / sum w
        let sum = w.sum();
        if w.min() < 0.0 || sum <= 0.0 {
            continue;
        }
        let depth = ray.z / sum;
        if best.is_none_or(|(z, _, _)| depth < z) {
            best = Some((depth, face, [w.x / sum, w.y / sum, w.z / sum]));
        }
    }
    best
}

#[test]
fn agrees_with_casting_a_ray_at_every_triangle() {
    let mesh = dummy_head(14, 18);
    let camera = Pinhole::ideal(420.0, Vec2::new(60.0, 70.0));
    let buffers = rasterize(&mesh, &camera, &pose(), (130, 140)).unwrap();
    let points: Vec<[Vec3; 3]> =
        (0..mesh.faces.len()).map(|f| mesh.corners(f).map(|v| pose().apply(&v))).collect();
    let (mut hits, mut other) = (0, 0);
    for y in 0..140 {
        for x in 0..130 {
            let found = nearest_hit(&points, &camera.ray(Vec2::new(x as f64, y as f64)));
            let face = buffers.face.at(x, y);
            match found {
                None => assert_eq!(face, NO_FACE, "({x}, {y})"),
                Some((depth, expected, weights)) => {
                    hits += 1;
                    assert!((f64::from(buffers.depth_mm.at(x, y)) - depth).abs() < 1e-3);
                    if face as usize != expected {
                        other += 1; // on a shared edge
                        continue;
                    }
                    let got = buffers.barycentric.at(x, y);
                    assert!((0..3).all(|k| (f64::from(got[k]) - weights[k]).abs() < 1e-5));
                }
            }
        }
    }
    assert!(hits > 5000 && other < 5, "{hits} hits, {other} on another face");
}

#[test]
fn a_face_that_reaches_behind_the_camera_is_cut_not_dropped() {
    let floor = Mesh {
        vertices: vec![
            Vec3::new(-500.0, 50.0, -300.0),
            Vec3::new(500.0, 50.0, -300.0),
            Vec3::new(0.0, 50.0, 2000.0),
        ],
        faces: vec![[0, 1, 2]],
        ..Mesh::default()
    };
    let camera = Pinhole::ideal(100.0, Vec2::new(49.5, 49.5));
    let buffers = rasterize(&floor, &camera, &Similarity::identity(), (100, 100)).unwrap();
    let points = vec![floor.corners(0)];
    for y in 0..100 {
        for x in 0..100 {
            let found = nearest_hit(&points, &camera.ray(Vec2::new(x as f64, y as f64)));
            // the near plane itself is the only difference
            if let Some((depth, _, weights)) = found.filter(|f| f.0 > 1.0) {
                assert!((f64::from(buffers.depth_mm.at(x, y)) - depth).abs() < 1e-4 * depth);
                let got = buffers.barycentric.at(x, y);
                assert!((0..3).all(|k| (f64::from(got[k]) - weights[k]).abs() < 1e-4));
            } else {
                assert_eq!(buffers.face.at(x, y), NO_FACE);
            }
        }
    }
    assert!(buffers.face.data().iter().filter(|f| **f == 0).count() > 2000);
}

#[test]
fn odd_geometry_and_bad_input_are_survived() {
    let mut mesh = dummy_head(6, 8);
    mesh.faces.push([0, 0, 0]);
    mesh.faces.push([0, 1, 1]);
    mesh.vertices.push(Vec3::new(1e12, -1e12, 1e12));
    let far = mesh.vertices.len() as u32 - 1;
    mesh.faces.push([0, 5, far]);
    let camera = Pinhole {
        distortion: Distortion([-0.3, 0.1, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
        ..Pinhole::ideal(100.0, Vec2::new(20.0, 20.0))
    };
    rasterize(&mesh, &camera, &pose(), (40, 40)).unwrap();
    assert!(matches!(
        rasterize(&mesh, &camera, &pose(), (0, 40)),
        Err(RenderError::Size { width: 0, .. })
    ));
    mesh.faces.push([0, 1, 99_999]);
    assert!(matches!(rasterize(&mesh, &camera, &pose(), (9, 9)), Err(RenderError::Mesh(_))));
    let heat = picture(&Scene::new(&dummy_head(6, 8)), View::Front, Mode::Heat, (50, 50));
    assert!(heat.unwrap_err().to_string().contains("one value for each"));
    assert!("sideways".parse::<View>().unwrap_err().to_string().contains("profile-right"));
}

#[test]
fn points_seen_by_the_lens_land_where_they_are_drawn() {
    let mesh = dummy_head(60, 80);
    let camera = Pinhole {
        distortion: Distortion([-0.12, 0.2, 0.001, -0.002, 0.0, 0.0, 0.0, 0.0]),
        ..Pinhole::ideal(600.0, Vec2::new(90.0, 80.0))
    };
    let buffers = rasterize(&mesh, &camera, &pose(), (200, 180)).unwrap();
    let mut seen = 0;
    for y in 0..180 {
        for x in 0..200 {
            let face = buffers.face.at(x, y);
            if face == NO_FACE {
                continue;
            }
            let w = buffers.barycentric.at(x, y);
            let corners = mesh.corners(face as usize);
            let point = crate::math::interpolate(corners, w.map(f64::from));
            let pixel = camera.project(&pose().apply(&point)).unwrap();
            assert!((pixel - Vec2::new(x as f64, y as f64)).norm() < 2e-3);
            seen += 1;
        }
    }
    assert!(seen > 8000);
}

#[test]
fn same_bytes_for_any_number_of_threads() {
    let mesh = dummy_head(30, 40);
    let draw = || {
        let heat: Vec<f64> = mesh.vertices.iter().map(|v| v.x.abs() / 50.0).collect();
        let heat = Some(Heat { values: &heat, limit: None, unit: "mm" });
        let scene = Scene { heat, ..Scene::new(&mesh) };
        contact_sheet(&scene, &View::ALL, Mode::Heat, (90, 100)).unwrap()
    };
    let pool = |n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
    assert_eq!(pool(1).install(draw), pool(3).install(draw));
}

#[test]
fn the_texture_stands_the_right_way_up() {
    // a square in the model frame whose texture is red above and blue below
    let mesh = Mesh {
        vertices: vec![
            Vec3::new(-50.0, -50.0, 0.0),
            Vec3::new(50.0, -50.0, 0.0),
            Vec3::new(50.0, 50.0, 0.0),
            Vec3::new(-50.0, 50.0, 0.0),
        ],
        faces: vec![[0, 1, 2], [0, 2, 3]],
        uvs: vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
        face_uvs: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    };
    let texture = Rgb::from_fn(8, 8, |x, y| {
        [if y < 4 { 255 } else { 0 }, x as u8 * 30, if y < 4 { 0 } else { 255 }]
    });
    let scene = Scene { texture: Some(&texture), ..Scene::new(&mesh) };
    let image = picture(&scene, View::Front, Mode::Textured, (100, 100)).unwrap();
    let (top, bottom) = (image.at(50, 20), image.at(50, 80));
    assert!(top[0] > 250 && top[2] < 5 && bottom[0] < 5 && bottom[2] > 250, "{top:?} {bottom:?}");
    assert!(image.at(20, 20)[1] < image.at(80, 20)[1]);
    assert_eq!(sample_texture(&texture, [0.5 / 8.0, 1.0 - 0.5 / 8.0]), [255.0, 0.0, 0.0]);
    assert_eq!(sample_texture(&texture, [7.5 / 8.0, 0.5 / 8.0]), [0.0, 210.0, 255.0]);
}

#[test]
fn hollows_are_darker_than_hills() {
    // a bowl: its bottom sees less of the sky than its rim
    let n = 30u32;
    let mut mesh = Mesh::default();
    for y in 0..=n {
        for x in 0..=n {
            let (u, v) = (f64::from(x) / 15.0 - 1.0, f64::from(y) / 15.0 - 1.0);
            mesh.vertices.push(Vec3::new(u, v, 1.5 * (u * u + v * v)));
        }
    }
    for y in 0..n {
        for x in 0..n {
            let i = y * (n + 1) + x;
            mesh.faces.push([i, i + 1, i + n + 1]);
            mesh.faces.push([i + 1, i + n + 2, i + n + 1]);
        }
    }
    let open = ambient_openness(&mesh).unwrap();
    let bottom = open[(15 * 31 + 15) as usize];
    assert!(bottom < 0.6 && open[0] > bottom + 0.2, "{bottom} {}", open[0]);
    let sphere = ambient_openness(&dummy_head(30, 40)).unwrap();
    assert!(sphere[200] > 0.95, "{}", sphere[200]);
}

#[test]
fn the_uncertainty_of_a_mesh_is_drawn_and_required() {
    let mut mesh = Mesh {
        vertices: vec![Vec3::zeros(), Vec3::new(80.0, 0.0, 0.0), Vec3::new(0.0, 80.0, 0.0)],
        faces: vec![[0, 1, 2]],
        ..Mesh::default()
    };
    let drawn = |mesh: &Mesh| picture(&Scene::new(mesh), View::Front, Mode::Uncertainty, (80, 80));
    assert_eq!(drawn(&mesh).unwrap_err(), RenderError::NoUncertainty);
    (mesh.sigmas, mesh.measured) = (vec![0.1; 3], vec![true; 3]);
    let precise = drawn(&mesh).unwrap();
    mesh.sigmas = vec![0.9; 3];
    let vague = drawn(&mesh).unwrap();
    mesh.measured = vec![false; 3];
    let unknown = drawn(&mesh).unwrap();
    assert!(precise != vague && vague != unknown && unknown != precise);
    let [r, g, b] = unknown.at(30, 45);
    assert!(r.abs_diff(g) < 6 && g.abs_diff(b) < 6, "{r} {g} {b}");
}
