//! Lattices projected onto surfaces of known shape, photographed by two level cameras.

use super::*;
use crate::camera::{Rectification, RectifiedRig, StereoRig};
use crate::data::{Dot, Gray, Pattern, PatternKind};
use crate::math::Vec3;
use crate::observer::WarningCollector;

/// A projector above the cameras, a surface `z(x, y)`, and its brightness `texture(x, y)`.
struct Scene {
    depth: fn(f64, f64) -> f64,
    texture: fn(f64, f64) -> f64,
    projector: Vec3,
    rotation: f64,
    /// Columns and rows of dots that are projected.
    size: (i32, i32),
}

const FOCAL: f64 = 2000.0;
const BASELINE: f64 = 150.0;
const SIZE: (usize, usize) = (560, 460);

fn head(x: f64, y: f64) -> f64 {
    1000.0 + 0.006 * x * x + 0.003 * y * y - 22.0 * (-(x * x + (y - 10.0).powi(2)) / 300.0).exp()
}

/// Spots of a few millimetres that do not repeat.
fn freckles(x: f64, y: f64) -> f64 {
    let wave = |a: f64, b: f64, c: f64| (a * x + b * y + c).sin();
    let coarse = wave(0.113, 0.071, 0.0) + wave(-0.087, 0.149, 1.0) + wave(0.191, -0.053, 2.0);
    let fine = wave(0.337, 0.219, 0.5) + wave(-0.283, 0.401, 1.5) + wave(0.467, -0.131, 2.5);
    90.0 + 9.0 * coarse + 7.0 * fine
}

fn uniform(_: f64, _: f64) -> f64 {
    90.0
}

struct View {
    rig: RectifiedRig,
    dots: [Vec<Dot>; 2],
    /// Cell of every dot.
    cells: [Vec<[i32; 2]>; 2],
    plain: [Gray; 2],
}

fn render(scene: &Scene) -> View {
    let shift = FOCAL * BASELINE / 1000.0 / 2.0;
    let centre =
        |sign: f64| Vec2::new(SIZE.0 as f64 / 2.0 - 0.5 - sign * shift, SIZE.1 as f64 / 2.0 - 0.5);
    // The left camera is at the origin, the subject in front of the midpoint of both.
    let rig = StereoRig::parallel(BASELINE, FOCAL, centre(1.0), centre(-1.0));
    let rig = Rectification::from_rig(&rig, SIZE).rig.unwrap();
    let middle = BASELINE / 2.0;
    let surface = |p: &Vec3| (scene.depth)(p.x - middle, p.y);
    let spacing = 5.0 / 1000.0;
    let (sin, cos) = scene.rotation.sin_cos();
    let (mut dots, mut cells) = ([Vec::new(), Vec::new()], [Vec::new(), Vec::new()]);
    for row in -scene.size.1 / 2..=scene.size.1 / 2 {
        for column in -scene.size.0 / 2..=scene.size.0 / 2 {
            let (u, v) = (f64::from(column) * spacing, f64::from(row) * spacing);
            // aimed at the centre of the subject from the height of the projector
            let aim = -scene.projector.y / 1000.0;
            let ray = Vec3::new(cos * u - sin * v, sin * u + cos * v + aim, 1.0);
            let start = scene.projector + Vec3::new(middle, 0.0, 0.0);
            let (mut near, mut far) = (500.0, 1800.0);
            for _ in 0..60 {
                let t = 0.5 * (near + far);
                let p = start + ray * t;
                if p.z < surface(&p) { near = t } else { far = t }
            }
            let p = start + ray * near;
            let (l, r) = rig.pixels(&p).unwrap();
            let amplitude = (scene.texture)(p.x - middle, p.y);
            for (side, q) in [l, r].into_iter().enumerate() {
                let inside = q.x > 3.0
                    && q.y > 3.0
                    && q.x < SIZE.0 as f64 - 4.0
                    && q.y < SIZE.1 as f64 - 4.0;
                // the surface does not occlude the point
                let camera = Vec3::new(side as f64 * BASELINE, 0.0, 0.0);
                let visible = (60..100).all(|k| {
                    let on_ray = camera + (p - camera) * (f64::from(k) / 100.0);
                    on_ray.z < surface(&on_ray) + 1.0
                });
                if inside && visible {
                    // a few hundredths of a pixel of noise, different in both photos
                    let jitter = 0.05 * (37.0 * q.x + 91.0 * q.y).sin();
                    let position = q + Vec2::new(jitter, -jitter);
                    dots[side].push(Dot { position, sigma_px: 1.5, amplitude, score: 1.0 });
                    cells[side].push([column, row]);
                }
            }
        }
    }
    let photo = |side: usize| {
        Gray::from_fn(SIZE.0, SIZE.1, |x, y| {
            let (mut z, pixel) = (1000.0, Vec2::new(x as f64, y as f64));
            let mut p = Vec3::zeros();
            for _ in 0..8 {
                let (principal, camera) = match side {
                    0 => (rig.principal_left, 0.0),
                    _ => (rig.principal_right, BASELINE),
                };
                let d = (pixel - principal) * z / FOCAL;
                p = Vec3::new(d.x + camera, d.y, z);
                z = surface(&p);
            }
            (scene.texture)(p.x - middle, p.y) as f32
        })
    };
    View { rig, dots, cells, plain: [photo(0), photo(1)] }
}

fn run(view: &View, rotation: f64, plain: bool) -> Result<Vec<Match>, CorrespondError> {
    run_observed(view, rotation, plain, &())
}

fn run_observed(
    view: &View,
    rotation: f64,
    plain: bool,
    observer: &dyn Observer,
) -> Result<Vec<Match>, CorrespondError> {
    let pattern = Pattern { kind: PatternKind::Dots, columns: 85, rows: 64, rotation };
    let input = CorrespondInput {
        left: &view.dots[0],
        right: &view.dots[1],
        spacing_px: 10.0,
        plain: plain.then_some([&view.plain[0], &view.plain[1]]),
        pattern: &pattern,
        seeds: None,
        rig: Some(&view.rig),
    };
    match_by_lattice(&input, &LatticeParams::default(), observer)
}

/// Share of the dots visible in both photos that are matched, and number of wrong matches.
fn recall_and_errors(view: &View, found: &[Match]) -> (f64, usize) {
    let cell = |side: usize, p: Vec2| {
        let i = view.dots[side].iter().position(|d| d.position == p).unwrap();
        view.cells[side][i]
    };
    let right = found.iter().filter(|m| cell(0, m.left) == cell(1, m.right)).count();
    let both = view.cells[0].iter().filter(|c| view.cells[1].contains(c)).count();
    (right as f64 / both as f64, found.len() - right)
}

const FACE: Scene = Scene {
    depth: head,
    texture: freckles,
    projector: Vec3::new(0.0, -130.0, 0.0),
    rotation: 0.0,
    size: (40, 36),
};

#[test]
fn a_curved_face_is_matched_without_seeds() {
    let view = render(&FACE);
    for plain in [true, false] {
        let (recall, wrong) = recall_and_errors(&view, &run(&view, 0.0, plain).unwrap());
        assert!(recall > 0.98 && wrong == 0, "plain {plain}: recall {recall}, {wrong} wrong");
    }
}

#[test]
fn missing_and_false_dots_cause_no_wrong_matches() {
    let mut view = render(&FACE);
    for side in 0..2 {
        let keep: Vec<bool> = view.dots[side]
            .iter()
            .enumerate()
            .map(|(i, d)| {
                let p = d.position;
                let hole = (p - Vec2::new(260.0, 200.0)).norm() < 25.0;
                !hole && (i * 7919 + side * 31) % 23 != 0
            })
            .collect();
        let mut k = keep.iter();
        view.dots[side].retain(|_| *k.next().unwrap());
        let mut k = keep.iter();
        view.cells[side].retain(|_| *k.next().unwrap());
        for i in 0..60 {
            let t = f64::from(i + 100 * side as i32);
            let position =
                Vec2::new(280.0 + 150.0 * (t * 1.7).sin(), 230.0 + 150.0 * (t * 2.3).cos());
            view.dots[side].push(Dot { position, sigma_px: 1.5, amplitude: 20.0, score: 0.5 });
            view.cells[side].push([1000 + i, 1000 * (1 + side as i32)]);
        }
    }
    let (recall, wrong) = recall_and_errors(&view, &run(&view, 0.0, true).unwrap());
    assert!(recall > 0.95 && wrong <= 2, "recall {recall}, {wrong} wrong");
}

#[test]
fn labels_off_by_one_beyond_a_step_of_depth_are_not_matched() {
    fn stepped(x: f64, y: f64) -> f64 {
        head(x, y) + if y > 45.0 { 38.0 } else { 0.0 }
    }
    let view = render(&Scene { depth: stepped, ..FACE });
    let (recall, wrong) = recall_and_errors(&view, &run(&view, 0.0, true).unwrap());
    assert!(recall > 0.93 && wrong <= 2, "recall {recall}, {wrong} wrong");
}

#[test]
fn a_level_textured_wall_needs_the_plain_pair_and_a_uniform_one_is_refused() {
    // A projector at the height of the cameras and a plane: every shift has level rows.
    fn flat(_: f64, _: f64) -> f64 {
        1000.0
    }
    let level = Vec3::new(0.0, 0.0, 0.0);
    let wall = Scene { depth: flat, projector: level, ..FACE };
    let view = render(&wall);
    let (recall, wrong) = recall_and_errors(&view, &run(&view, 0.0, true).unwrap());
    assert!(recall > 0.95 && wrong == 0, "recall {recall}, {wrong} wrong");

    let view = render(&Scene { texture: uniform, ..wall });
    for plain in [true, false] {
        let error = run(&view, 0.0, plain).unwrap_err();
        assert!(matches!(error, CorrespondError::Ambiguous { .. }), "{error}");
        assert!(error.to_string().contains("mm of depth"), "{error}");
    }
}

#[test]
fn a_wall_behind_the_face_is_left_out() {
    fn face_and_wall(x: f64, y: f64) -> f64 {
        if x * x / 3600.0 + y * y / 6400.0 < 1.0 { head(x, y) } else { 1400.0 }
    }
    let view = render(&Scene { depth: face_and_wall, size: (60, 60), ..FACE });
    let warnings = WarningCollector::new(&());
    let found = run_observed(&view, 0.0, true, &warnings).unwrap();
    let warnings = warnings.into_warnings();
    assert!(warnings.iter().all(|w| w.contains("probably a wall")) && warnings.len() <= 1);
    let near = view.rig.disparity_px(1150.0);
    let behind = found.iter().filter(|m| m.disparity() < near).count();
    let (_, wrong) = recall_and_errors(&view, &found);
    let faces = (0..view.dots[0].len())
        .filter(|i| {
            let partner = view.cells[1].iter().position(|c| *c == view.cells[0][*i]);
            let x = view.dots[0][*i].position.x;
            partner.is_some_and(|j| x - view.dots[1][j].position.x > near)
        })
        .count();
    let matched = found.len() - behind;
    // the silhouette, where a patch of the plain pair shows face and wall and the labels continue
    // into the wall, may be lost
    assert!(matched * 100 > 75 * faces && faces > 300, "{matched} of {faces}");
    assert!(behind * 50 < faces && wrong * 50 < faces, "{behind} behind, {wrong} wrong");
}

#[test]
fn rotated_lattices_are_matched() {
    for rotation in [(1.0_f64 / 3.0).atan(), -0.2] {
        let view = render(&Scene { rotation, ..FACE });
        let (recall, wrong) = recall_and_errors(&view, &run(&view, rotation, true).unwrap());
        assert!(recall > 0.97 && wrong == 0, "{rotation}: recall {recall}, {wrong} wrong");
    }
}

#[test]
fn dots_without_a_lattice_are_refused() {
    let scatter = |seed: f64| -> Vec<Dot> {
        (0..8)
            .map(|i| {
                let t = f64::from(i) * 12.9898 + seed;
                let position = Vec2::new(200.0 + 150.0 * t.sin(), 200.0 + 150.0 * (t * 1.7).cos());
                Dot { position, sigma_px: 1.5, amplitude: 50.0, score: 1.0 }
            })
            .collect()
    };
    let mut view = render(&Scene { size: (2, 2), ..FACE });
    view.dots = [scatter(0.3), scatter(0.8)];
    let error = run(&view, 0.0, false).unwrap_err();
    assert!(matches!(error, CorrespondError::NoLattice { photo: "left", .. }), "{error}");
}
