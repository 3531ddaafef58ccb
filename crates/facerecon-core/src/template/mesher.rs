//! Turns a layout into triangles: Delaunay in the chart, then edges flipped and free vertices
//! moved until the triangles are well shaped in space.

use super::layout::{Hold, Layout, edge_length, tangents};
use super::sculpt::Sculpt;
use crate::math::Vec3;
use nalgebra::{Matrix2, Vector2};
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};
use std::collections::{BTreeMap, BTreeSet};

/// Rounds of flipping and moving.
const ROUNDS: usize = 40;

type Edge = (u32, u32);

fn edge(a: u32, b: u32) -> Edge {
    (a.min(b), a.max(b))
}

/// Triangles over a layout.
pub(crate) struct Half {
    pub(crate) layout: Layout,
    pub(crate) faces: Vec<[u32; 3]>,
}

/// Makes the mesh of the half head; moves the layout's free vertices.
pub(crate) fn triangulate(sculpt: &Sculpt, mut layout: Layout, scale: f64) -> Half {
    let (mut faces, kept) = delaunay(&layout);
    let mut points: Vec<Vec3> = layout.q.iter().map(|&q| sculpt.point(q)).collect();
    for _ in 0..ROUNDS {
        for _ in 0..3 {
            flip(&layout, &points, &mut faces, &kept);
        }
        relax(sculpt, &mut layout, &mut points, &faces, scale);
    }
    for _ in 0..6 {
        flip(&layout, &points, &mut faces, &kept);
    }
    Half { layout, faces }
}

fn delaunay(layout: &Layout) -> (Vec<[u32; 3]>, BTreeSet<Edge>) {
    let mut cdt = ConstrainedDelaunayTriangulation::<Point2<f64>>::new();
    let handles: Vec<_> = layout
        .q
        .iter()
        .map(|q| cdt.insert(Point2::new(q.x, q.y)).expect("chart positions are finite"))
        .collect();
    let mut number = BTreeMap::new();
    for (i, h) in handles.iter().enumerate() {
        number.insert(h.index(), i as u32);
    }
    let mut kept = BTreeSet::new();
    for &[a, b] in &layout.edges {
        if handles[a] != handles[b] && cdt.can_add_constraint(handles[a], handles[b]) {
            cdt.add_constraint(handles[a], handles[b]);
            kept.insert(edge(a as u32, b as u32));
        }
    }
    let rim = |i: u32| layout.hold[i as usize] == Hold::Border;
    let corner = |i: u32| layout.hold[i as usize] == Hold::Midline;
    let last_mid = layout.hold.iter().filter(|h| **h == Hold::Midline).count() as u32 - 1;
    let faces = cdt
        .inner_faces()
        .map(|f| f.vertices().map(|v| number[&v.fix().index()]))
        // Slivers between the border and the hull are outside the head.
        .filter(|f| !f.iter().all(|&i| rim(i) || i == 0 || i == last_mid))
        .filter(|f| !f.iter().all(|&i| corner(i)))
        .collect();
    (faces, kept)
}

fn chart_area(layout: &Layout, f: [u32; 3]) -> f64 {
    let [a, b, c] = f.map(|i| layout.q[i as usize]);
    (b - a).perp(&(c - a))
}

/// Cosine of the angle at `a` in the triangle (a, b, c).
fn cosine(a: &Vec3, b: &Vec3, c: &Vec3) -> f64 {
    let (u, v) = (b - a, c - a);
    u.dot(&v) / (u.norm() * v.norm()).max(1e-12)
}

/// Flips every edge whose opposite angles sum to more than half a turn (Delaunay on the
/// surface), where the chart allows it.
fn flip(layout: &Layout, points: &[Vec3], faces: &mut [[u32; 3]], kept: &BTreeSet<Edge>) {
    let mut sides: BTreeMap<Edge, Vec<(usize, u32)>> = BTreeMap::new();
    for (n, f) in faces.iter().enumerate() {
        for k in 0..3 {
            sides.entry(edge(f[k], f[(k + 1) % 3])).or_default().push((n, f[(k + 2) % 3]));
        }
    }
    let mut touched = vec![false; faces.len()];
    for (&(a, b), s) in &sides {
        let [(n, c), (m, d)] = s[..] else { continue };
        if kept.contains(&(a, b)) || touched[n] || touched[m] || sides.contains_key(&edge(c, d)) {
            continue;
        }
        let at = |i: u32| &points[i as usize];
        let now = cosine(at(c), at(a), at(b)).acos() + cosine(at(d), at(a), at(b)).acos();
        if now < std::f64::consts::PI + 1e-6 {
            continue;
        }
        let (mut f, mut g) = ([c, a, d], [c, d, b]);
        if chart_area(layout, f) < 0.0 {
            (f, g) = ([c, d, a], [c, b, d]);
        }
        let normal = |t: [u32; 3]| {
            let [p, q, r] = t.map(|i| points[i as usize]);
            (q - p).cross(&(r - p)).normalize()
        };
        let small = 1e-9;
        if chart_area(layout, f) > small
            && chart_area(layout, g) > small
            && normal(f).dot(&normal(g)) > 0.0
        {
            faces[n] = f;
            faces[m] = g;
            touched[n] = true;
            touched[m] = true;
        }
    }
}

/// Moves free vertices along the surface toward even edges of the wanted length.
fn relax(
    sculpt: &Sculpt,
    layout: &mut Layout,
    points: &mut [Vec3],
    faces: &[[u32; 3]],
    scale: f64,
) {
    let mut around: Vec<Vec<usize>> = vec![Vec::new(); points.len()];
    for (n, f) in faces.iter().enumerate() {
        for &i in f {
            around[i as usize].push(n);
        }
    }
    for i in 0..points.len() {
        if layout.hold[i] != Hold::Free {
            continue;
        }
        let here = points[i];
        let mut force = Vec3::zeros();
        let mut count = 0.0;
        for &n in &around[i] {
            for &j in &faces[n] {
                if j as usize != i {
                    let e = points[j as usize] - here;
                    let length = e.norm().max(1e-9);
                    let wanted = scale * edge_length(&(here + 0.5 * e));
                    // Half a spring toward the wanted length, half a pull to the middle.
                    force += e * (0.5 * (length - wanted) / length + 0.5);
                    count += 1.0;
                }
            }
        }
        let [a, b] = tangents(sculpt, layout.q[i]);
        let m = Matrix2::new(a.dot(&a), a.dot(&b), a.dot(&b), b.dot(&b));
        let Some(inverse) = m.try_inverse() else { continue };
        let step = inverse * Vector2::new(a.dot(&force), b.dot(&force)) * (0.6 / count);
        let old = layout.q[i];
        for share in [1.0, 0.4, 0.1] {
            layout.q[i] = old + step * share;
            let fits = layout.q[i].norm() < 0.9995
                && around[i].iter().all(|&n| chart_area(layout, faces[n]) > 1e-8);
            if fits {
                break;
            }
            layout.q[i] = old;
        }
        points[i] = sculpt.point(layout.q[i]);
    }
}
