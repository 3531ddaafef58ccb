use super::*;
use crate::data::test_meshes::dummy_head;
use crate::data::{Gray, Landmarks, Mesh};
use crate::math::{Similarity, Vec2, Vec3, median};
use crate::render::linear_from_srgb;
use crate::synthetic::pattern::PatternParams;

/// A flat square facing the viewer, model frame, mm; fine, as edges between its vertices stay straight
/// in a distorted photo.
fn plate(half: f64) -> Mesh {
    let n = 60u32;
    let mut mesh = Mesh::default();
    for y in 0..=n {
        for x in 0..=n {
            let at = |k: u32| (2.0 * f64::from(k) / f64::from(n) - 1.0) * half;
            mesh.vertices.push(Vec3::new(at(x), at(y), 0.0));
        }
    }
    for y in 0..n {
        for x in 0..n {
            let i = y * (n + 1) + x;
            mesh.faces.push([i, i + 1, i + n + 1]);
            mesh.faces.push([i + 1, i + n + 2, i + n + 1]);
        }
    }
    mesh
}

/// An ellipsoid with a nose.
fn head() -> Mesh {
    dummy_head(60, 80)
}

fn bare(mesh: &Mesh) -> Subject<'_> {
    Subject { mesh, texture: None, landmarks: None, face: None }
}

fn small() -> SimulateParams {
    SimulateParams {
        width_px: 384,
        height_px: 288,
        focal_px: 1383.0,
        dot_mm: 9.0,
        pattern: PatternParams { columns: 43, rows: 32, ..PatternParams::default() },
        ..SimulateParams::default()
    }
}

fn linear(photo: &Photo) -> Gray {
    photo.rgb.map(|p| linear_from_srgb(p[1]) as f32)
}

/// Centroid of the light above the darkest of a window around a dot.
fn centroid(image: &Gray, at: Vec2, reach: isize) -> Vec2 {
    let (x0, y0) = (at.x.round() as isize, at.y.round() as isize);
    let mut floor = f32::INFINITY;
    for y in y0 - reach..=y0 + reach {
        for x in x0 - reach..=x0 + reach {
            floor = floor.min(image.clamped(x, y));
        }
    }
    let (mut sum, mut place) = (0.0, Vec2::zeros());
    for y in y0 - reach..=y0 + reach {
        for x in x0 - reach..=x0 + reach {
            let light = f64::from(image.clamped(x, y) - floor);
            sum += light;
            place += Vec2::new(x as f64, y as f64) * light;
        }
    }
    place / sum
}

#[test]
fn dots_on_a_flat_plate_are_where_the_truth_says() {
    let mesh = plate(90.0);
    let rigs = [
        SimulateParams { sensor_shift: 1.0, ..SimulateParams::default() },
        SimulateParams {
            toe_in_deg: 3.3,
            distortion_k1: -0.12,
            distortion_k2: 0.2,
            focal_ratio: 1.01,
            row_offset_px: 1.5,
            row_roll_deg: 0.2,
            yaw_deg: 12.0,
            ..SimulateParams::default()
        },
    ];
    for params in rigs {
        let params = SimulateParams {
            full_well_e: 0.0,
            gloss: 0.0,
            soft_light: 0.0,
            ambient_light: 0.0,
            exposure: 0.5,
            ..params
        };
        let made = simulate(&bare(&mesh), &params, &()).unwrap();
        let photos = [linear(&made.capture.left), linear(&made.capture.right)];
        for side in 0..2 {
            let errors: Vec<Vec2> = made
                .truth
                .dots
                .iter()
                .filter(|d| d.lit && d.visible == [true; 2])
                .filter(|d| {
                    // clear of the border of the plate
                    let p = made.truth.camera_from_model.inverse().apply(&d.point);
                    p.x.abs() < 84.0 && p.y.abs() < 84.0
                })
                .map(|d| centroid(&photos[side], d.pixel[side], 4) - d.pixel[side])
                .collect();
            assert!(errors.len() > 1000, "{}", errors.len());
            let worst = errors.iter().map(|e| e.norm()).fold(0.0, f64::max);
            let mean = errors.iter().sum::<Vec2>() / errors.len() as f64;
            let sizes: Vec<f64> = errors.iter().map(|e| e.norm()).collect();
            let middle = median(&sizes).unwrap();
            assert!(mean.norm() < 0.004, "side {side}: mean {mean}");
            assert!(middle < 0.01 && worst < 0.05, "side {side}: median {middle} worst {worst}");
        }
    }
}

#[test]
fn truth_agrees_with_the_rig_and_hidden_dots_are_not_visible() {
    let mesh = head();
    let params = SimulateParams { toe_in_deg: 3.0, ..small() };
    let made = simulate(&bare(&mesh), &params, &()).unwrap();
    let (rig, truth) = (made.capture.rig.unwrap(), &made.truth);
    let surface = crate::spatial::SurfaceIndex::new(&truth.mesh).unwrap();
    let (mut seen, mut hidden) = (0, 0);
    for dot in truth.dots.iter().filter(|d| d.lit) {
        assert!(surface.closest(&dot.point).unwrap().distance < 1e-3);
        let right = rig.right_from_left.apply(&dot.point);
        assert!((rig.left.project(&dot.point).unwrap() - dot.pixel[0]).norm() < 1e-9);
        assert!((rig.right.project(&right).unwrap() - dot.pixel[1]).norm() < 1e-9);
        for (side, eye) in [(0, Vec3::zeros()), (1, rig.right_centre())] {
            // walk from the camera to the dot: nothing may be in the way of a visible one
            let toward = eye - dot.point;
            let clear = (2..60).all(|k| {
                let p = dot.point + toward.normalize() * f64::from(k) * 3.0;
                inside(&p, &truth.camera_from_model) < 1.0
            });
            if dot.visible[side] {
                seen += 1;
                assert!(clear, "{dot:?}");
            } else {
                hidden += 1;
            }
        }
    }
    assert!(seen > 500 && hidden > 3, "{seen} seen, {hidden} hidden");
    // depth is that of the mesh, and only the subject has one
    let depths = truth.depth_mm.data().iter().filter(|z| z.is_finite()).count();
    assert!(depths > 10_000 && depths < 60_000, "{depths}");
    let centre = truth.depth_mm.at(192 + 30, 144);
    assert!(centre.is_nan() || centre > 1280.0);
}

/// How deep a point lies in the ellipsoid under the nose, mm (negative outside).
fn inside(point: &Vec3, camera_from_model: &Similarity) -> f64 {
    let p = camera_from_model.inverse().apply(point);
    let r = Vec3::new(p.x / 75.0, p.y / 110.0, p.z / 90.0).norm();
    (1.0 - r) * 75.0
}

#[test]
fn the_subject_casts_a_shadow_on_the_wall() {
    let mesh = plate(60.0);
    let params =
        SimulateParams { wall_mm: 250.0, projector_above_mm: 300.0, full_well_e: 0.0, ..small() };
    let made = simulate(&bare(&mesh), &params, &()).unwrap();
    let image = linear(&made.capture.left);
    let rig = made.capture.rig.unwrap();
    // of a point on the wall: is the plate between it and the projector?
    let projector = Vec3::new(75.0, -300.0, -20.0);
    let (mut dark, mut bright) = (Vec::new(), Vec::new());
    for y in (4..284).step_by(2) {
        for x in (4..380).step_by(2) {
            let ray = rig.left.ray(Vec2::new(f64::from(x), f64::from(y)));
            let point = ray * 1550.0;
            if made.truth.depth_mm.at(x as usize, y as usize).is_finite() {
                continue;
            }
            let t = (1300.0 - projector.z) / (point.z - projector.z);
            let hit = projector + (point - projector) * t;
            let (u, v) = (hit.x - 75.0, hit.y);
            let peak = (-4..=4)
                .flat_map(|dy| (-4..=4).map(move |dx| (dx, dy)))
                .map(|(dx, dy)| image.clamped(x as isize + dx, y as isize + dy))
                .fold(0.0f32, f32::max);
            if u.abs() < 45.0 && v.abs() < 45.0 {
                dark.push(f64::from(peak));
            } else if u.abs() < 100.0 && v < -75.0 && v > -110.0 {
                bright.push(f64::from(peak));
            }
        }
    }
    assert!(dark.len() > 50 && bright.len() > 50, "{} {}", dark.len(), bright.len());
    assert!(median(&bright).unwrap() > 3.0 * median(&dark).unwrap());
}

#[test]
fn noise_has_the_given_strength_and_bytes_do_not_depend_on_threads() {
    let mesh = plate(200.0);
    let params = SimulateParams {
        wall: false,
        projector_light: 0.0,
        ambient_light: 1.0,
        soft_light: 0.0,
        gloss: 0.0,
        exposure: 0.25,
        ..small()
    };
    let run = || simulate(&bare(&mesh), &params, &()).unwrap().capture;
    let pool = |n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
    let (one, three) = (pool(1).install(run), pool(3).install(run));
    assert!(one == three);
    // skin is brightest in red
    let image = one.left.rgb.map(|p| linear_from_srgb(p[0]) as f32);
    let (x, y) = (220, 140);
    let window: Vec<f64> =
        (0..2500).map(|i| f64::from(image.at(x - 25 + i % 50, y - 25 + i / 50))).collect();
    let mean = window.iter().sum::<f64>() / 2500.0;
    let deviation = (window.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 2500.0).sqrt();
    let expected = (0.25f64 * 9000.0 + 9.0).sqrt() / 9000.0;
    assert!((mean - 0.25).abs() < 0.01, "{mean}");
    assert!((deviation / expected - 1.0).abs() < 0.1, "{deviation} {expected}");
    let other = SimulateParams { seed: 2, ..params };
    assert!(simulate(&bare(&mesh), &other, &()).unwrap().capture.left != one.left);
}

#[test]
fn the_head_moves_between_the_pairs_if_set() {
    let mesh = head();
    let params = SimulateParams { plain_motion_mm: 3.0, plain_motion_deg: 1.0, ..small() };
    let made = simulate(&bare(&mesh), &params, &()).unwrap();
    let motion = &made.truth.plain_from_dots;
    assert!((motion.angle().to_degrees() - 1.0).abs() < 1e-6);
    let centre = made.truth.camera_from_model.apply(&Vec3::zeros());
    let shift = (motion.apply(&centre) - centre).norm();
    assert!((2.7..3.3).contains(&shift), "{shift}");
    let still = simulate(&bare(&mesh), &small(), &()).unwrap();
    assert_eq!(still.capture.left, made.capture.left);
    assert_ne!(still.capture.plain, made.capture.plain);
}

#[test]
fn impossible_simulations_are_refused() {
    let mesh = head();
    let refuse = |subject: &Subject<'_>, params: &SimulateParams| {
        simulate(subject, params, &()).unwrap_err().to_string()
    };
    let far = SimulateParams { shift_x_mm: 480.0, ..small() };
    assert!(refuse(&bare(&mesh), &far).contains("sees no part"));
    let wild = SimulateParams { baseline_mm: -3.0, ..small() };
    assert!(refuse(&bare(&mesh), &wild).contains("simulate.baseline_mm"));
    let mask = [true; 3];
    let subject = Subject { face: Some(&mask), ..bare(&mesh) };
    assert!(refuse(&subject, &small()).contains("face mask of the subject has 3 entries"));
    let landmarks: Landmarks = [("chin".to_owned(), usize::MAX)].into();
    let subject = Subject { landmarks: Some(&landmarks), ..bare(&mesh) };
    assert!(refuse(&subject, &small()).contains("chin"));
    assert!(refuse(&bare(&Mesh::default()), &small()).contains("vertices"));
}

#[test]
fn a_written_capture_reads_back_with_its_truth() {
    let mesh = head();
    let landmarks: Landmarks = [("nose_tip".to_owned(), 2400usize)].into();
    let subject = Subject { landmarks: Some(&landmarks), ..bare(&mesh) };
    let made = simulate(&subject, &small(), &()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = write_simulated(folder.path(), &made).unwrap();
    let read = crate::io::read_capture(&path).unwrap().capture;
    assert!(read.left == made.capture.left && read.plain == made.capture.plain);
    assert_eq!(read.pattern, made.capture.pattern);
    let (read_rig, written) = (read.rig.unwrap(), made.capture.rig.unwrap());
    assert!(
        (read_rig.right_from_left.translation - written.right_from_left.translation).norm() < 1e-9
    );
    let dots = std::fs::read_to_string(folder.path().join("truth_dots.csv")).unwrap();
    assert_eq!(dots.lines().count(), 1 + 43 * 32);
    let lit = dots.lines().skip(1).filter(|l| !l.contains("nan")).count();
    assert_eq!(lit, made.truth.dots.iter().filter(|d| d.lit).count());
    let truth = std::fs::read_to_string(folder.path().join("truth.json")).unwrap();
    let truth: serde_json::Value = serde_json::from_str(&truth).unwrap();
    let z = truth["features"]["nose_tip"]["xyz"][2].as_f64().unwrap();
    assert!((z - made.truth.mesh.vertices[2400].z).abs() < 1e-9);
    let depth = std::fs::read(folder.path().join("truth_depth.npy")).unwrap();
    assert_eq!(depth.len(), 128 + 4 * 384 * 288);
}
