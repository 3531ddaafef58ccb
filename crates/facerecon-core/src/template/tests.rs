//! The built-in heads: stored part, topology, symmetry, texture layout, dimensions.

use super::assemble::Template;
use super::built_in::{head, head_coarse, stored_half};
use super::half_head::HalfHead;
use crate::data::LANDMARKS;
use crate::math::Vec3;
use std::collections::BTreeMap;

fn both() -> [(&'static str, Template); 2] {
    [("head", head()), ("head-coarse", head_coarse())]
}

fn vertex_of(t: &Template, name: &str) -> Vec3 {
    t.mesh.vertices[t.landmarks[name]]
}

#[test]
fn encoding_and_decoding_agree() {
    let half = stored_half();
    assert_eq!(HalfHead::decode(&half.encode()), half);
}

#[test]
fn sizes_are_as_named() {
    let [(_, fine), (_, coarse)] = both();
    assert!((5500..6500).contains(&fine.mesh.vertices.len()), "{}", fine.mesh.vertices.len());
    assert!((780..880).contains(&coarse.mesh.vertices.len()), "{}", coarse.mesh.vertices.len());
    for (name, t) in both() {
        assert!(t.mesh.validate().is_ok(), "{name}");
        let mut names: Vec<&str> = t.landmarks.keys().map(String::as_str).collect();
        let mut expected = LANDMARKS.to_vec();
        names.sort_unstable();
        expected.sort_unstable();
        assert_eq!(names, expected, "{name}");
    }
}

#[test]
fn one_manifold_surface_open_at_the_neck() {
    for (name, t) in both() {
        let mut edges: BTreeMap<(u32, u32), u32> = BTreeMap::new();
        for f in &t.mesh.faces {
            for k in 0..3 {
                *edges.entry((f[k], f[(k + 1) % 3])).or_default() += 1;
            }
        }
        assert!(
            edges.values().all(|&n| n == 1),
            "{name}: two faces have an edge in the same direction"
        );
        let open: BTreeMap<u32, u32> =
            edges.keys().filter(|e| !edges.contains_key(&(e.1, e.0))).copied().collect();
        let lowest = t.mesh.vertices.iter().map(|v| v.y).fold(f64::MAX, f64::min);
        let (&start, _) = open.first_key_value().unwrap();
        let (mut at, mut steps) = (start, 0);
        loop {
            assert!(
                t.mesh.vertices[at as usize].y < lowest + 25.0,
                "{name}: a hole above the neck"
            );
            at = open[&at];
            steps += 1;
            if at == start {
                break;
            }
        }
        assert_eq!(steps, open.len(), "{name}: more than one border");
        // A sphere with one hole: V - E + F = 1.
        let undirected = (edges.len() + open.len()) / 2;
        assert_eq!(t.mesh.vertices.len() + t.mesh.faces.len(), undirected + 1, "{name}");
    }
}

#[test]
fn exactly_symmetric() {
    for (name, t) in both() {
        let key = |v: &Vec3| [(v.x + 0.0).to_bits(), v.y.to_bits(), v.z.to_bits()];
        let all: std::collections::BTreeSet<_> = t.mesh.vertices.iter().map(key).collect();
        assert_eq!(all.len(), t.mesh.vertices.len(), "{name}: two vertices at one position");
        for v in &t.mesh.vertices {
            assert!(all.contains(&key(&Vec3::new(-v.x, v.y, v.z))), "{name}: {v:?}");
        }
        for side in ["eye_{}_outer", "ear_{}_lower", "mouth_{}", "ala_{}"] {
            let [left, right] = ["left", "right"].map(|s| vertex_of(&t, &side.replace("{}", s)));
            assert_eq!([left.x, left.y, left.z], [-right.x, right.y, right.z], "{name} {side}");
            assert!(right.x > 0.0);
        }
    }
}

#[test]
fn triangles_are_well_shaped_and_face_outward() {
    for (name, t) in both() {
        let mut volume = 0.0;
        let mut poor = 0;
        for f in 0..t.mesh.faces.len() {
            let [a, b, c] = t.mesh.corners(f);
            volume += a.dot(&b.cross(&c)) / 6.0;
            let edges = [(b - a).norm(), (c - b).norm(), (a - c).norm()];
            let area = 0.5 * (b - a).cross(&(c - a)).norm();
            assert!(area > 1e-3, "{name}: face {f} has no area");
            // Twice the ratio of the inner to the outer circle's radius: 1 is equilateral.
            let half = 0.5 * edges.iter().sum::<f64>();
            let quality = 8.0 * area * area / (half * edges.iter().product::<f64>());
            poor += usize::from(quality < 0.5);
        }
        // The neck is open, so this is the volume of the cone to the origin: about four litres.
        assert!((3.0e6..5.5e6).contains(&volume), "{name}: {volume}");
        assert!(poor * 50 < t.mesh.faces.len(), "{name}: {poor} poor triangles");
    }
}

#[test]
fn texture_layout_does_not_overlap() {
    const N: usize = 512;
    for (name, t) in both() {
        assert!(t.mesh.uvs.iter().flatten().all(|c| (0.0..=1.0).contains(c)), "{name}");
        // Every texel's centre is in one triangle at most.
        let mut owner = vec![u32::MAX; N * N];
        let mut facial = 0;
        for (n, f) in t.mesh.face_uvs.iter().enumerate() {
            let p = f.map(|i| t.mesh.uvs[i as usize].map(|c| c * N as f64));
            let cross = |a: [f64; 2], b: [f64; 2], x: f64, y: f64| {
                (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])
            };
            assert!(cross(p[0], p[1], p[2][0], p[2][1]) > 0.0, "{name}: face {n} is inverted");
            let span = |k: usize| {
                let c = p.map(|q| q[k]);
                (
                    c[0].min(c[1]).min(c[2]).floor() as usize,
                    c[0].max(c[1]).max(c[2]).ceil() as usize,
                )
            };
            let ((x0, x1), (y0, y1)) = (span(0), span(1));
            for y in y0..y1.min(N) {
                for x in x0..x1.min(N) {
                    let (cx, cy) = (x as f64 + 0.5, y as f64 + 0.5);
                    if (0..3).all(|k| cross(p[k], p[(k + 1) % 3], cx, cy) > 1e-9) {
                        assert_eq!(owner[y * N + x], u32::MAX, "{name}: overlap at {x} {y}");
                        owner[y * N + x] = n as u32;
                        let [a, b, c] = t.mesh.corners(n);
                        let m = (a + b + c) / 3.0;
                        facial += usize::from(m.z > 40.0 && m.y.abs() < 90.0);
                    }
                }
            }
        }
        assert!(facial * 4 > N * N, "{name}: the face has only {facial} of {} texels", N * N);
    }
}

#[test]
fn dimensions_are_adult_norms() {
    let t = head();
    let v = &t.mesh.vertices;
    let at = |name: &str| vertex_of(&t, name);
    let width = |a: &str, b: &str| (at(a) - at(b)).norm();
    let extent = |keep: &dyn Fn(&&Vec3) -> bool, read: &dyn Fn(&Vec3) -> f64| {
        let values: Vec<f64> = v.iter().filter(keep).map(read).collect();
        values.iter().copied().fold(f64::MIN, f64::max)
            - values.iter().copied().fold(f64::MAX, f64::min)
    };
    let skull = |p: &&Vec3| p.y > 38.0;
    let cheeks = |p: &&Vec3| p.z > 15.0 && p.y.abs() < 5.0;
    // Above, the ear stands out from the skull; below, from the narrower jaw.
    let ear = |p: &&Vec3| (p.x > 78.0 && p.y < 40.0) || (p.x > 70.5 && p.y < -12.0);
    let vertex = v.iter().map(|p| p.y).fold(f64::MIN, f64::max);
    let checks = [
        ("bizygomatic", extent(&cheeks, &|p| p.x), 137.0, 4.0),
        ("sellion to chin", width("nose_saddle", "chin"), 115.0, 6.0),
        ("nose width", width("ala_left", "ala_right"), 35.0, 3.0),
        ("mouth width", width("mouth_left", "mouth_right"), 52.0, 3.0),
        ("intercanthal", width("eye_left_inner", "eye_right_inner"), 33.0, 2.0),
        ("biocular", width("eye_left_outer", "eye_right_outer"), 90.0, 3.0),
        ("vertex to chin", vertex - at("chin").y + 6.0, 225.0, 8.0),
        ("head breadth", extent(&skull, &|p| p.x), 152.0, 5.0),
        ("head length", extent(&|p| p.x.abs() < 12.0 && p.y > 32.0, &|p| p.z), 195.0, 6.0),
        ("ear length", extent(&ear, &|p| p.y), 60.0, 6.0),
    ];
    for (name, got, norm, tolerance) in checks {
        assert!((got - norm).abs() < tolerance, "{name}: {got:.1} mm, the norm is {norm}");
    }
    assert!(at("nose_tip").z > at("chin").z + 20.0 && at("nose_tip").z > at("forehead").z + 10.0);
    assert!(at("mouth_up").y > at("mouth_down").y && at("forehead").y > at("nose_saddle").y);
}

#[test]
fn both_heads_are_one_surface() {
    let (fine, coarse) = (head(), head_coarse());
    let far = |a: &Vec3, mesh: &crate::data::Mesh| {
        mesh.vertices.iter().map(|b| (a - b).norm_squared()).fold(f64::MAX, f64::min).sqrt()
    };
    let mut distances: Vec<f64> = coarse.mesh.vertices.iter().map(|p| far(p, &fine.mesh)).collect();
    distances.sort_by(f64::total_cmp);
    // To the nearest vertex, so at most about half of the fine head's longest edges.
    assert!(distances[distances.len() - 1] < 7.0, "{}", distances[distances.len() - 1]);
    for name in LANDMARKS {
        let gap = (vertex_of(&fine, name) - vertex_of(&coarse, name)).norm();
        assert!(gap < 0.01, "{name}: {gap}");
    }
}
