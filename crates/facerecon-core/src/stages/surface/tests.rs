use std::collections::{BTreeMap, BTreeSet};

use super::manifold::split_shared_nodes;
use super::patch::Node;
use super::*;
use crate::camera::RectifiedRig;
use crate::data::Topology;
use crate::math::Mat3;

const SIZE: (usize, usize) = (320, 240);
const PITCH: f64 = 8.0;

/// Parallel cameras 150 mm apart.
fn rig() -> RectifiedRig {
    RectifiedRig {
        focal_px: 1000.0,
        baseline_mm: 150.0,
        principal_left: Vec2::new(159.5, 119.5),
        principal_right: Vec2::new(159.5, 119.5),
        camera_from_rectified: Mat3::identity(),
        metric: true,
    }
}

/// Disparity of a ball of radius 100 mm with its centre at 1000 mm, where it is tilted by less than
/// about 70 degrees.
fn ball(x: f64, y: f64) -> Option<f64> {
    let (radius, middle) = (100.0, Vec3::new(0.0, 0.0, 1000.0));
    let ray = Vec3::new((x - 159.5) / 1000.0, (y - 119.5) / 1000.0, 1.0).normalize();
    let along = ray.dot(&middle);
    let inside = radius * radius - (middle.norm_squared() - along * along);
    let z = (along - inside.max(0.0).sqrt()) * ray.z;
    (inside > (0.34 * radius).powi(2)).then(|| rig().disparity_px(z))
}

fn raster(value: impl Fn(f64, f64) -> Option<f64>) -> Gray {
    Gray::from_fn(SIZE.0, SIZE.1, |x, y| value(x as f64, y as f64).map_or(f32::NAN, |d| d as f32))
}

/// Dots on a square lattice, where there is a surface.
fn dots(value: impl Fn(f64, f64) -> Option<f64>) -> Vec<Match> {
    let cells = (0..30).flat_map(|j| (0..40).map(move |i| (f64::from(i), f64::from(j))));
    cells
        .map(|(i, j)| Vec2::new(PITCH * i + 0.3 * j + 0.1, PITCH * j - 0.2 * i + 8.0))
        .filter_map(|left| {
            let right = left - Vec2::new(value(left.x, left.y)?, 0.0);
            Some(Match { left, right, lattice: None, sigma_px: 0.0, score: 1.0 })
        })
        .collect()
}

fn built(disparity: Option<&Gray>, matches: &[Match], params: &SurfaceParams) -> Surface {
    let unproject = |p: Vec2, d: f64| rig().point(p, d);
    let input = SurfaceInput { disparity, matches, on_subject: &[], unproject: &unproject };
    surface(&input, params, &()).unwrap()
}

fn refused(disparity: Option<&Gray>, matches: &[Match], params: &SurfaceParams) -> SurfaceError {
    let unproject = |p: Vec2, d: f64| rig().point(p, d);
    let input = SurfaceInput { disparity, matches, on_subject: &[], unproject: &unproject };
    surface(&input, params, &()).unwrap_err()
}

fn area(mesh: &Mesh) -> f64 {
    let one = |[a, b, c]: [Vec3; 3]| 0.5 * (b - a).cross(&(c - a)).norm();
    (0..mesh.faces.len()).map(|f| one(mesh.corners(f))).sum()
}

/// Asserts: no edge has three faces, no vertex has two fans, every face is turned to the camera and
/// has its own area of the texture.
fn assert_sound(mesh: &Mesh) {
    mesh.validate().unwrap();
    assert_eq!(Topology::new(mesh).non_manifold_edges, 0);
    let mut directed = BTreeSet::new();
    let mut at_node: BTreeMap<u32, Vec<(u32, u32)>> = BTreeMap::new();
    for &[a, b, c] in &mesh.faces {
        for (i, j, k) in [(a, b, c), (b, c, a), (c, a, b)] {
            assert!(directed.insert((i, j)), "edge {i} {j} has two faces of opposite orientation");
            at_node.entry(i).or_default().push((j, k));
        }
    }
    assert_eq!(at_node.len(), mesh.vertices.len(), "vertices without faces");
    for (node, spokes) in &at_node {
        // one fan: at most one spoke starts where no other one ends
        let ends: BTreeSet<u32> = spokes.iter().map(|s| s.1).collect();
        let starts = spokes.iter().filter(|s| !ends.contains(&s.0)).count();
        assert!(starts <= 1, "{starts} fans meet in vertex {node}");
    }
    for f in 0..mesh.faces.len() {
        let [a, b, c] = mesh.corners(f);
        assert!((b - a).cross(&(c - a)).dot(&(a + b + c)) < 0.0, "face {f} is turned away");
        let [p, q, r] = mesh.face_uvs[f].map(|i| mesh.uvs[i as usize]);
        let turn = (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
        assert!(turn > 0.0, "face {f} is folded on the texture");
    }
    assert!(mesh.uvs.iter().flatten().all(|c| (0.0..=1.0).contains(c)));
}

#[test]
fn a_ball_keeps_its_shape_and_area() {
    for method in [SurfaceMethod::Auto, SurfaceMethod::Dots] {
        let params = SurfaceParams { method, ..SurfaceParams::default() };
        let dense = raster(ball);
        let found = built(Some(&dense), &dots(ball), &params);
        assert_sound(&found.mesh);
        assert_eq!((found.components, found.dense), (1, method == SurfaceMethod::Auto));
        assert!((found.pitch_px - PITCH).abs() < 0.1, "{}", found.pitch_px);
        let off = |v: &Vec3| ((v - Vec3::new(0.0, 0.0, 1000.0)).norm() - 100.0).abs();
        let border = Topology::new(&found.mesh).border;
        let worst = |on_border: bool| {
            let of = found.mesh.vertices.iter().zip(&border).filter(|v| *v.1 == on_border);
            of.map(|v| off(v.0)).fold(0.0, f64::max)
        };
        // the visible cap: its height is (1 - cos) of the radius
        let cap = |radius_px: f64| {
            let (sine, distance) = (radius_px / 1000.0, 1000.0);
            let turn = (sine * distance / 100.0).min(1.0).asin();
            2.0 * std::f64::consts::PI * 100.0 * 100.0 * (1.0 - turn.cos())
        };
        let edge = (0..160).rfind(|&x| ball(159.5 + f64::from(x), 119.5).is_some()).unwrap();
        let whole = cap(f64::from(edge) * 0.97);
        let share = area(&found.mesh) / whole;
        // the border is smoothed where the ball is tilted by 70 degrees
        let (inside, border) = (worst(false), worst(true));
        let good = match method {
            SurfaceMethod::Dots => inside.max(border) < 1e-3 && share > 0.75,
            _ => inside < 0.03 && border < 0.4 && (0.88..1.1).contains(&share),
        };
        assert!(good, "{inside} {border} {share}");
    }
}

#[test]
fn normals_are_those_of_the_ball() {
    let found = built(Some(&raster(ball)), &dots(ball), &SurfaceParams::default());
    let mesh = &found.mesh;
    let inner = Topology::new(mesh).rings_from_border();
    let normals = mesh.vertex_normals();
    for v in (0..mesh.vertices.len()).filter(|&v| inner[v] > 1) {
        let outward = (mesh.vertices[v] - Vec3::new(0.0, 0.0, 1000.0)).normalize();
        assert!(normals[v].dot(&outward) > 0.999, "vertex {v}: {}", normals[v].dot(&outward));
    }
}

/// A wavy plate with a hole in front of a wall: a depth discontinuity of 300 mm on its right side.
fn plate(x: f64, y: f64) -> Option<f64> {
    let hole = (x - 100.0).hypot(y - 120.0) < 25.0;
    let depth = if x < 200.0 { 1000.0 + 5.0 * (x / 20.0).sin() } else { 1300.0 };
    (!hole).then(|| rig().disparity_px(depth))
}

#[test]
fn depth_discontinuities_are_not_bridged_and_holes_stay() {
    for method in [SurfaceMethod::Auto, SurfaceMethod::Dots] {
        // the wall is kept as well: its dots count as the subject's
        let params = SurfaceParams { method, ..SurfaceParams::default() };
        let unproject = |p: Vec2, d: f64| rig().point(p, d);
        let (dense, matches) = (raster(plate), dots(plate));
        let everywhere: Vec<usize> = (0..matches.len()).collect();
        let input = SurfaceInput {
            disparity: Some(&dense),
            matches: &matches,
            on_subject: &everywhere,
            unproject: &unproject,
        };
        let found = surface(&input, &params, &()).unwrap();
        assert_sound(&found.mesh);
        assert_eq!(found.components, 2);
        for f in 0..found.mesh.faces.len() {
            let corners = found.mesh.corners(f);
            let (low, high) = (corners[0].inf(&corners[1]), corners[0].sup(&corners[1]));
            let depth = high.sup(&corners[2]).z - low.inf(&corners[2]).z;
            assert!(depth < 20.0, "face {f} spans {depth} mm of depth");
            let middle = rig().pixels(&(corners.iter().sum::<Vec3>() / 3.0)).unwrap().0;
            let from_hole = (middle - Vec2::new(100.0, 120.0)).norm();
            let reach = if found.dense { 24.0 } else { 18.0 };
            assert!(from_hole > reach, "face {f} lies in the hole, {from_hole} px from its centre");
        }
        // without dots on the subject the wall is recognised by its depth
        let alone = built(Some(&dense), &matches, &params);
        assert_eq!((alone.components, alone.components_removed >= 1), (1, true));
        assert!(alone.mesh.vertices.iter().all(|v| v.z < 1010.0));
        // with them, the component they lie on is kept
        let wall: Vec<usize> = (0..matches.len()).filter(|&i| matches[i].left.x > 210.0).collect();
        let input = SurfaceInput { on_subject: &wall, ..input };
        let behind = surface(&input, &params, &()).unwrap();
        assert!(behind.mesh.vertices.iter().all(|v| v.z > 1200.0));
    }
}

#[test]
fn a_ragged_border_is_smoothed_and_nothing_folds() {
    // random holes everywhere
    let mut state = 7u64;
    let mut random = move || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 40) as f64 / f64::from(1 << 24)
    };
    let mut dense = raster(ball);
    for value in dense.data_mut() {
        if random() < 0.01 {
            *value = f32::NAN;
        }
    }
    let matches = dots(ball);
    let rough = SurfaceParams { border_steps: 0, spacing: 0.15, ..SurfaceParams::default() };
    let smooth = SurfaceParams { border_steps: 30, ..rough.clone() };
    let (rough, smooth) =
        (built(Some(&dense), &matches, &rough), built(Some(&dense), &matches, &smooth));
    assert_sound(&rough.mesh);
    assert_sound(&smooth.mesh);
    assert_eq!(rough.mesh.faces, smooth.mesh.faces);
    let border = Topology::new(&rough.mesh).border;
    let mut moved = 0;
    for (v, on_border) in border.iter().enumerate() {
        let same = rough.mesh.vertices[v] == smooth.mesh.vertices[v];
        assert!(*on_border || same, "vertex {v} inside moved");
        moved += usize::from(!same);
        let off = (smooth.mesh.vertices[v] - Vec3::new(0.0, 0.0, 1000.0)).norm() - 100.0;
        assert!(off.abs() < 0.5, "vertex {v} lies {off} mm off the ball");
    }
    assert!(moved > 100);
}

#[test]
fn fans_that_share_a_vertex_only_are_split() {
    let node = |x: f64, y: f64| {
        let unproject = |p: Vec2, _: f64| Some(Vec3::new(p.x, p.y, 1.0));
        Node::new(Vec2::new(x, y), 1.0, &unproject).unwrap()
    };
    let nodes = vec![
        node(0.0, 0.0),
        node(1.0, 1.0),
        node(1.0, -1.0),
        node(-1.0, 1.0),
        node(-1.0, -1.0),
        node(9.0, 9.0),
    ];
    let mut patch = Patch { nodes, faces: Vec::new() };
    patch.add([0, 1, 2]);
    patch.add([0, 3, 4]);
    split_shared_nodes(&mut patch);
    assert_eq!(patch.nodes.len(), 6);
    assert_eq!(patch.faces.len(), 2);
    let used: BTreeSet<u32> = patch.faces.iter().flatten().copied().collect();
    assert_eq!(used.len(), 6);
    assert!(patch.faces.iter().all(|f| patch.double_area_px2(*f) > 0.0));
}

#[test]
fn strips_and_what_only_they_connect_are_removed() {
    // a plate, a bridge 8 px wide and a block 24 px wide behind it
    let shape = |x: f64, y: f64| {
        let plate = x < 200.0;
        let bridge = (y - 120.0).abs() < 4.0 && x < 240.0;
        let block = (240.0..264.0).contains(&x) && (y - 120.0).abs() < 12.0;
        (plate || bridge || block).then_some(150.0)
    };
    let (dense, matches) = (raster(shape), dots(shape));
    let farthest = |min_width: f64| {
        let params =
            SurfaceParams { min_width, min_component_share: 0.1, ..SurfaceParams::default() };
        let unproject = |p: Vec2, d: f64| Some(Vec3::new(p.x, p.y, -d));
        let input = SurfaceInput {
            disparity: Some(&dense),
            matches: &matches,
            on_subject: &[],
            unproject: &unproject,
        };
        let mesh = surface(&input, &params, &()).unwrap().mesh;
        mesh.vertices.iter().map(|v| v.x).fold(0.0, f64::max)
    };
    assert!(farthest(0.0) > 260.0, "{}", farthest(0.0));
    assert!((190.0..205.0).contains(&farthest(1.5)), "{}", farthest(1.5));
}

#[test]
fn the_same_input_gives_the_same_mesh() {
    for method in [SurfaceMethod::Auto, SurfaceMethod::Dots] {
        let params = SurfaceParams { method, ..SurfaceParams::default() };
        let (dense, matches) = (raster(plate), dots(plate));
        let first = built(Some(&dense), &matches, &params);
        assert!(first == built(Some(&dense), &matches, &params));
    }
}

#[test]
fn finer_spacing_gives_more_vertices_of_the_same_surface() {
    let at = |spacing: f64| {
        let params = SurfaceParams { spacing, ..SurfaceParams::default() };
        built(Some(&raster(ball)), &dots(ball), &params).mesh
    };
    let (fine, coarse) = (at(0.25), at(0.5));
    let ratio = fine.vertices.len() as f64 / coarse.vertices.len() as f64;
    assert!((3.5..4.5).contains(&ratio), "{ratio}");
    assert!((area(&fine) / area(&coarse) - 1.0).abs() < 0.06);
}

#[test]
fn input_without_a_surface_is_refused_with_figures() {
    let params = SurfaceParams::default();
    let matches = dots(ball);
    let empty = Gray::filled(SIZE.0, SIZE.1, f32::NAN);
    assert_eq!(
        refused(Some(&empty), &matches, &params),
        SurfaceError::TooFewPoints { got: 0, needed: MIN_POINTS }
    );
    assert_eq!(
        refused(None, &matches[..3], &params),
        SurfaceError::TooFewPoints { got: 3, needed: MIN_POINTS }
    );
    assert_eq!(
        refused(None, &[], &params),
        SurfaceError::TooFewPoints { got: 0, needed: MIN_POINTS }
    );
    assert_eq!(
        refused(None, &vec![matches[0]; 20], &params),
        SurfaceError::TooFewPoints { got: 20, needed: MIN_POINTS }
    );
    // dots on one line have no triangles
    let line: Vec<Match> = matches
        .iter()
        .copied()
        .take(1)
        .cycle()
        .take(9)
        .zip(0..)
        .map(|(m, k)| {
            let shift = Vec2::new(PITCH * f64::from(k), 0.0);
            Match { left: m.left + shift, right: m.right + shift, ..m }
        })
        .collect();
    let error = refused(None, &line, &params);
    assert!(matches!(error, SurfaceError::NothingLeft { triangles: 0, .. }), "{error}");
    // every second row far behind the others: depth discontinuities only
    let torn = dots(|x, y| Some(if (y / PITCH) as i32 % 2 == 0 { 150.0 } else { 15.0 + 0.0 * x }));
    let error = refused(None, &torn, &SurfaceParams { max_tilt_deg: 30.0, ..params.clone() });
    assert!(error.to_string().contains("surface.max_tilt_deg (now 30)"), "{error}");
    let mut bad = matches.clone();
    bad[5].right.y = f64::NAN;
    assert_eq!(refused(None, &bad, &params), SurfaceError::NotFinite { index: 5 });
    let unproject = |p: Vec2, d: f64| rig().point(p, d);
    let input = SurfaceInput {
        disparity: None,
        matches: &matches,
        on_subject: &[10_000],
        unproject: &unproject,
    };
    let error = surface(&input, &params, &()).unwrap_err();
    assert_eq!(error, SurfaceError::Index { index: 10_000, count: matches.len() });
    // negative disparities have no position in space
    let swapped: Vec<Match> =
        matches.iter().map(|m| Match { left: m.right, right: m.left, ..*m }).collect();
    assert!(matches!(refused(None, &swapped, &params), SurfaceError::TooFewPoints { got: 0, .. }));
    let wild = SurfaceParams { spacing: 0.0, ..params };
    assert!(matches!(refused(None, &matches, &wild), SurfaceError::Settings(_)));
}

#[test]
fn an_observer_can_cancel_the_stage() {
    struct Stop;
    impl Observer for Stop {
        fn cancelled(&self) -> bool {
            true
        }
    }
    let unproject = |p: Vec2, d: f64| rig().point(p, d);
    let matches = dots(ball);
    let input =
        SurfaceInput { disparity: None, matches: &matches, on_subject: &[], unproject: &unproject };
    let stopped = surface(&input, &SurfaceParams::default(), &Stop);
    assert_eq!(stopped, Err(SurfaceError::Cancelled(Cancelled)));
}
