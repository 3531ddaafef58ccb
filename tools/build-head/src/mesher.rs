//! Triangulates a layout: constrained Delaunay in the chart, then edge flips and moves of the free
//! vertices until the triangles are well shaped in space.

use crate::layout::{Layout, VertexKind, edge_length, metric, tangents};
use facerecon_core::math::Vec3;
use facerecon_core::template::build::Sculpt;
use nalgebra::Vector2;
use spade::{ConstrainedDelaunayTriangulation, InsertionError, Point2, Triangulation};
use std::collections::{BTreeMap, BTreeSet};

/// Rounds of flipping and moving.
const ROUNDS: usize = 40;
/// Passes of flips in each round.
const FLIPS_PER_ROUND: usize = 3;
/// Passes of flips after the last round, when vertices no longer move.
const LAST_FLIPS: usize = 6;
/// Share of the mean force that a vertex moves in a round.
const DAMPING: f64 = 0.6;

/// Least chart area (twice, signed) of a triangle after a flip and after a move: no triangle may turn
/// over in the chart.
const LEAST_FLIPPED_AREA: f64 = 1e-9;
const LEAST_MOVED_AREA: f64 = 1e-8;
/// Largest radius of a free vertex in the chart; the midline lies at 1.
const LARGEST_RADIUS: f64 = 0.9995;

type Edge = (u32, u32);

fn edge(a: u32, b: u32) -> Edge {
    (a.min(b), a.max(b))
}

/// The triangulated half head.
pub(crate) struct Half {
    pub(crate) layout: Layout,
    pub(crate) faces: Vec<[u32; 3]>,
}

/// Triangulates the layout and moves its free vertices.
pub(crate) fn triangulate(
    sculpt: &Sculpt,
    mut layout: Layout,
    scale: f64,
) -> Result<Half, InsertionError> {
    let (mut faces, constraints) = delaunay(&layout)?;
    let mut points: Vec<Vec3> = layout.q.iter().map(|&q| sculpt.point(q)).collect();
    for _ in 0..ROUNDS {
        for _ in 0..FLIPS_PER_ROUND {
            flip(&layout, &points, &mut faces, &constraints);
        }
        relax(sculpt, &mut layout, &mut points, &faces, scale);
    }
    for _ in 0..LAST_FLIPS {
        flip(&layout, &points, &mut faces, &constraints);
    }
    Ok(Half { layout, faces })
}

/// Triangles in the chart, and the constrained edges.
fn delaunay(layout: &Layout) -> Result<(Vec<[u32; 3]>, BTreeSet<Edge>), InsertionError> {
    let mut cdt = ConstrainedDelaunayTriangulation::<Point2<f64>>::new();
    let handles: Vec<_> =
        layout.q.iter().map(|q| cdt.insert(Point2::new(q.x, q.y))).collect::<Result<_, _>>()?;
    let mut number = BTreeMap::new();
    for (i, h) in handles.iter().enumerate() {
        number.insert(h.index(), i as u32);
    }
    let mut constraints = BTreeSet::new();
    for &[a, b] in &layout.edges {
        if handles[a] != handles[b] && cdt.can_add_constraint(handles[a], handles[b]) {
            cdt.add_constraint(handles[a], handles[b]);
            constraints.insert(edge(a as u32, b as u32));
        }
    }
    let on_border = |i: u32| layout.kinds[i as usize] == VertexKind::Border;
    let on_midline = |i: u32| layout.kinds[i as usize] == VertexKind::Midline;
    let last_mid = layout.kinds.iter().filter(|h| **h == VertexKind::Midline).count() as u32 - 1;
    let faces = cdt
        .inner_faces()
        .map(|f| f.vertices().map(|v| number[&v.fix().index()]))
        // Triangles between the border and its convex hull are outside the head.
        .filter(|f| !f.iter().all(|&i| on_border(i) || i == 0 || i == last_mid))
        .filter(|f| !f.iter().all(|&i| on_midline(i)))
        .collect();
    Ok((faces, constraints))
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

/// Flips every edge whose opposite angles sum to more than 180 degrees (Delaunay on the surface),
/// unless triangles would overlap in the chart.
fn flip(layout: &Layout, points: &[Vec3], faces: &mut [[u32; 3]], constraints: &BTreeSet<Edge>) {
    let mut sides: BTreeMap<Edge, Vec<(usize, u32)>> = BTreeMap::new();
    for (n, f) in faces.iter().enumerate() {
        for k in 0..3 {
            sides.entry(edge(f[k], f[(k + 1) % 3])).or_default().push((n, f[(k + 2) % 3]));
        }
    }
    let mut changed = vec![false; faces.len()];
    for (&(a, b), s) in &sides {
        let [(n, c), (m, d)] = s[..] else { continue };
        if constraints.contains(&(a, b))
            || changed[n]
            || changed[m]
            || sides.contains_key(&edge(c, d))
        {
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
        if chart_area(layout, f) > LEAST_FLIPPED_AREA
            && chart_area(layout, g) > LEAST_FLIPPED_AREA
            && normal(f).dot(&normal(g)) > 0.0
        {
            faces[n] = f;
            faces[m] = g;
            changed[n] = true;
            changed[m] = true;
        }
    }
}

/// Moves free vertices along the surface toward even edges of the target length.
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
        if layout.kinds[i] != VertexKind::Free {
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
                    let target = scale * edge_length(&(here + 0.5 * e));
                    // Half a spring toward the target length, half a pull to the centroid.
                    force += e * (0.5 * (length - target) / length + 0.5);
                    count += 1.0;
                }
            }
        }
        let [a, b] = tangents(sculpt, layout.q[i]);
        let Some(inverse) = metric([a, b]).try_inverse() else { continue };
        let step = inverse * Vector2::new(a.dot(&force), b.dot(&force)) * (DAMPING / count);
        let old = layout.q[i];
        for share in [1.0, 0.4, 0.1] {
            layout.q[i] = old + step * share;
            let fits = layout.q[i].norm() < LARGEST_RADIUS
                && around[i].iter().all(|&n| chart_area(layout, faces[n]) > LEAST_MOVED_AREA);
            if fits {
                break;
            }
            layout.q[i] = old;
        }
        points[i] = sculpt.point(layout.q[i]);
    }
}
