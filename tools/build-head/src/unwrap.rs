//! Texture coordinates of the half head: it is flattened with a straight front midline and a seam
//! down the back. The other half is the mirror image.
//!
//! The start is an embedding by mean-value weights inside a convex outline, which cannot overlap
//! (Tutte; Floater 2003). Then the symmetric Dirichlet energy is minimised. It is infinite for a
//! degenerate triangle, so that no triangle turns over (Smith & Schaefer 2015).

use crate::mesher::Half;
use facerecon_core::math::Vec3;
use facerecon_core::template::build::smoothstep;
use nalgebra::{Matrix2, Vector2};

/// Texture scale outside the face, relative to the face: chosen so that the face has more than a
/// quarter of the texture.
const OUTSIDE_SCALE: f64 = 0.38;
/// Weight of the shape of triangles outside the face, relative to the face.
const OUTSIDE_WEIGHT: f64 = 0.04;
/// Relaxation passes of the start, set by experiment on both heads.
const EMBED_PASSES: usize = 6000;
/// Steps of the minimisation.
const STEPS: usize = 600;
/// Steps after which conjugate gradients restart.
const RESTART: usize = 30;
/// Free margin at the edge of the texture, as a fraction of its side.
const MARGIN: f64 = 0.012;
/// Regularisation of the preconditioner, which is singular without it: no v is fixed.
const REGULARISATION: f64 = 1e-5;

type Uv = Vector2<f64>;

/// A triangle of the surface and its weight.
struct RestTriangle {
    corners: [usize; 3],
    /// Inverse of its edge matrix in its own plane.
    inverse: Matrix2<f64>,
    weight: f64,
}

struct Flattening {
    triangles: Vec<RestTriangle>,
    /// Whether the u of a vertex is fixed (front midline).
    fixed_u: Vec<bool>,
    /// Neighbours with weights, for the preconditioner.
    stiffness: Vec<Vec<(usize, f64)>>,
}

/// Weight of the face at a point: 1 in the face, 0 far from it, 0.25 at the ears.
fn facial(p: &Vec3) -> f64 {
    let ear = 0.25
        * smoothstep(30.0, 18.0, (p.x.abs() - 84.0).hypot(p.z + 12.0))
        * smoothstep(42.0, 34.0, p.y.abs());
    let face =
        smoothstep(5.0, 55.0, p.z) * smoothstep(-115.0, -80.0, p.y) * smoothstep(120.0, 75.0, p.y);
    ear.max(face)
}

/// Texture coordinates of the vertices of the half x >= 0. u is 0.5 on the front midline, which
/// ranges from the first midline vertex to vertex `seam`.
pub(crate) fn unwrap(half: &Half, points: &[Vec3], midline: usize, seam: usize) -> Vec<[f64; 2]> {
    let faces: Vec<[usize; 3]> =
        half.faces.iter().map(|f| [f[0], f[2], f[1]].map(|i| i as usize)).collect();
    let mut uv = embed(&faces, points, midline, seam);
    let flattening = Flattening::new(&faces, points, seam);
    flattening.descend(&mut uv);
    // Into the unit square: one scale for both axes, the midline in the middle.
    let (mut low, mut high, mut right) = (f64::MAX, f64::MIN, f64::MIN);
    for p in &uv {
        (low, high, right) = (low.min(p.y), high.max(p.y), right.max(p.x));
    }
    let room = 1.0 - 2.0 * MARGIN;
    let scale = (room / (high - low)).min(0.5 * room / right);
    let bottom = 0.5 - 0.5 * scale * (high - low);
    uv.iter().map(|p| [0.5 + scale * p.x, bottom + scale * (p.y - low)]).collect()
}

/// Mean-value embedding: the front midline on a straight line, seam and neck border on a half circle.
fn embed(faces: &[[usize; 3]], points: &[Vec3], midline: usize, seam: usize) -> Vec<Uv> {
    let n = points.len();
    let mut weights = vec![Vec::new(); n];
    for f in faces {
        for k in 0..3 {
            let [i, j, l] = [f[k], f[(k + 1) % 3], f[(k + 2) % 3]];
            let (a, b) = (points[j] - points[i], points[l] - points[i]);
            let half_tangent = (0.5 * a.angle(&b)).tan().clamp(0.02, 20.0);
            weights[i].push((j, half_tangent / a.norm()));
            weights[i].push((l, half_tangent / b.norm()));
        }
    }
    let (mut uv, pinned) = embed_outline(&outline(faces, n, midline), points, seam);
    for _ in 0..EMBED_PASSES {
        for i in 0..n {
            if !pinned[i] {
                let total: f64 = weights[i].iter().map(|w| w.1).sum();
                let mean = weights[i].iter().fold(Uv::zeros(), |s, &(j, w)| s + uv[j] * w) / total;
                let step = mean - uv[i];
                uv[i] += step;
            }
        }
    }
    // To about the size of the head (mm), so that the minimisation starts near its end.
    uv.iter().map(|p| p * 100.0).collect()
}

/// Boundary loop of the half: the midline, then the neck border back to the start.
fn outline(faces: &[[usize; 3]], vertices: usize, midline: usize) -> Vec<usize> {
    let mut next = vec![Vec::new(); vertices];
    for f in faces {
        for k in 0..3 {
            next[f[k]].push((f[(k + 1) % 3], f[(k + 2) % 3]));
        }
    }
    let mut border: Vec<usize> = Vec::new();
    let mut at = midline - 1;
    // An edge of the outline occurs in one direction only.
    while let Some(&(_, to)) = next[at].iter().find(|&&(_, l)| {
        let in_chain = border.contains(&l) || (l < midline && l != 0);
        !in_chain && !next[at].iter().any(|&(j, _)| j == l)
    }) {
        if to == 0 {
            break;
        }
        border.push(to);
        at = to;
    }
    (0..midline).chain(border).collect()
}

/// Positions of the vertices of the outline (others get a start value), and which those are.
fn embed_outline(outline: &[usize], points: &[Vec3], seam: usize) -> (Vec<Uv>, Vec<bool>) {
    let length = |list: &[usize]| -> Vec<f64> {
        let mut sum = vec![0.0];
        for w in list.windows(2) {
            sum.push(sum[sum.len() - 1] + (points[w[1]] - points[w[0]]).norm());
        }
        sum
    };
    let front = length(&outline[..=seam]);
    let mut rest: Vec<usize> = outline[seam..].to_vec();
    rest.push(0);
    let back = length(&rest);
    let mut uv = vec![Uv::new(0.5, 0.0); points.len()];
    let mut pinned = vec![false; points.len()];
    for (k, &i) in outline[..=seam].iter().enumerate() {
        uv[i] = Uv::new(0.0, -1.0 + 2.0 * front[k] / front[seam]);
        pinned[i] = true;
    }
    for (k, &i) in rest.iter().enumerate().skip(1) {
        if i != 0 {
            let a = std::f64::consts::PI * (0.5 - back[k] / back[back.len() - 1]);
            uv[i] = Uv::new(a.cos(), a.sin());
            pinned[i] = true;
        }
    }
    (uv, pinned)
}

impl Flattening {
    fn new(faces: &[[usize; 3]], points: &[Vec3], seam: usize) -> Self {
        let mut stiffness = vec![Vec::new(); points.len()];
        let mut triangles = Vec::with_capacity(faces.len());
        for f in faces {
            let [a, b, c] = f.map(|i| points[i]);
            let w = facial(&((a + b + c) / 3.0));
            let scale = OUTSIDE_SCALE + (1.0 - OUTSIDE_SCALE) * w;
            let (u, v) = ((b - a) * scale, (c - a) * scale);
            let length = u.norm();
            let edges = Matrix2::new(length, u.dot(&v) / length, 0.0, u.cross(&v).norm() / length);
            let area = 0.5 * edges.determinant();
            let Some(inverse) = edges.try_inverse() else { continue };
            let weight = area * (OUTSIDE_WEIGHT + (1.0 - OUTSIDE_WEIGHT) * w);
            triangles.push(RestTriangle { corners: *f, inverse, weight });
            for k in 0..3 {
                let (i, j) = (f[k], f[(k + 1) % 3]);
                let stiff = weight / (points[j] - points[i]).norm_squared() / (scale * scale);
                stiffness[i].push((j, stiff));
                stiffness[j].push((i, stiff));
            }
        }
        let fixed_u = (0..points.len()).map(|i| i <= seam).collect();
        Self { triangles, fixed_u, stiffness }
    }

    /// Symmetric Dirichlet energy; infinite if a triangle has turned over.
    fn energy(&self, uv: &[Uv]) -> f64 {
        let mut sum = 0.0;
        for r in &self.triangles {
            let j = Self::jacobian(r, uv);
            let det = j.determinant();
            if det <= 0.0 {
                return f64::INFINITY;
            }
            sum += r.weight * j.norm_squared() * (1.0 + 1.0 / (det * det));
        }
        sum
    }

    fn jacobian(r: &RestTriangle, uv: &[Uv]) -> Matrix2<f64> {
        let [a, b, c] = r.corners.map(|i| uv[i]);
        Matrix2::from_columns(&[b - a, c - a]) * r.inverse
    }

    fn gradient(&self, uv: &[Uv]) -> Vec<Uv> {
        let mut g = vec![Uv::zeros(); uv.len()];
        for r in &self.triangles {
            let j = Self::jacobian(r, uv);
            let det = j.determinant();
            let square = j.norm_squared();
            let cofactor = Matrix2::new(j[(1, 1)], -j[(1, 0)], -j[(0, 1)], j[(0, 0)]);
            let p = j * (2.0 * (1.0 + 1.0 / (det * det)))
                - cofactor * (2.0 * square / (det * det * det));
            let edges = p * r.inverse.transpose() * r.weight;
            let (b, c) = (edges.column(0).into_owned(), edges.column(1).into_owned());
            g[r.corners[1]] += b;
            g[r.corners[2]] += c;
            g[r.corners[0]] -= b + c;
        }
        self.constrain(&mut g);
        g
    }

    fn constrain(&self, g: &mut [Uv]) {
        for (v, fixed) in g.iter_mut().zip(&self.fixed_u) {
            if *fixed {
                v.x = 0.0;
            }
        }
    }

    /// The preconditioned gradient: solves with the stiffness matrix by conjugate gradients.
    fn smoothed(&self, g: &[Uv]) -> Vec<Uv> {
        let apply = |x: &[Uv]| -> Vec<Uv> {
            let mut y: Vec<Uv> = (0..x.len())
                .map(|i| {
                    self.stiffness[i]
                        .iter()
                        .fold(x[i] * REGULARISATION, |s, &(j, w)| s + (x[i] - x[j]) * w)
                })
                .collect();
            self.constrain(&mut y);
            y
        };
        let dot = |a: &[Uv], b: &[Uv]| a.iter().zip(b).map(|(p, q)| p.dot(q)).sum::<f64>();
        let diagonal: Vec<f64> = self
            .stiffness
            .iter()
            .map(|s| REGULARISATION + s.iter().map(|w| w.1).sum::<f64>())
            .collect();
        let scaled =
            |r: &[Uv]| -> Vec<Uv> { r.iter().zip(&diagonal).map(|(v, d)| v / *d).collect() };
        let mut x = vec![Uv::zeros(); g.len()];
        let mut r = g.to_vec();
        let mut z = scaled(&r);
        let mut p = z.clone();
        let mut rz = dot(&r, &z);
        let stop = 1e-6 * rz;
        for _ in 0..200 {
            if rz <= stop {
                break;
            }
            let ap = apply(&p);
            let alpha = rz / dot(&p, &ap);
            for i in 0..x.len() {
                x[i] += p[i] * alpha;
                r[i] -= ap[i] * alpha;
            }
            z = scaled(&r);
            let new = dot(&r, &z);
            let beta = new / rz;
            rz = new;
            for i in 0..p.len() {
                p[i] = z[i] + p[i] * beta;
            }
        }
        x
    }

    /// Minimises by preconditioned nonlinear conjugate gradients with backtracking.
    fn descend(&self, uv: &mut Vec<Uv>) {
        let dot = |a: &[Uv], b: &[Uv]| a.iter().zip(b).map(|(p, q)| p.dot(q)).sum::<f64>();
        let mut energy = self.energy(uv);
        let mut direction: Vec<Uv> = vec![Uv::zeros(); uv.len()];
        let (mut last_g, mut last_gz) = (Vec::new(), 0.0);
        let mut step = 1.0;
        for round in 0..STEPS {
            let g = self.gradient(uv);
            let z = self.smoothed(&g);
            let gz = dot(&g, &z);
            let beta = if round % RESTART == 0 || last_gz == 0.0 {
                0.0
            } else {
                ((gz - dot(&last_g, &z)) / last_gz).max(0.0)
            };
            for (d, z) in direction.iter_mut().zip(&z) {
                *d = *d * beta - z;
            }
            let mut slope = dot(&g, &direction);
            if slope >= 0.0 {
                direction = z.iter().map(|v| -v).collect();
                slope = -gz;
            }
            step = f64::min(2.0 * step, 1.0);
            let mut moved = false;
            for _ in 0..60 {
                let trial: Vec<Uv> = uv.iter().zip(&direction).map(|(p, d)| p + d * step).collect();
                let e = self.energy(&trial);
                if e < energy + 1e-4 * step * slope {
                    *uv = trial;
                    energy = e;
                    moved = true;
                    break;
                }
                step *= 0.5;
            }
            if !moved {
                if beta == 0.0 {
                    break;
                }
                last_gz = 0.0;
                continue;
            }
            last_g = g;
            last_gz = gz;
        }
    }
}
