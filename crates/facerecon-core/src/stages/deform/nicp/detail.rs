//! The last step: each measured vertex moves along its normal to where the points around it say.
//!
//! One number a vertex, point-to-plane exactly, the thin plate smoothing over the length that the
//! data's noise asks for. Well conditioned where there is data, so conjugate gradients suffice.

use super::super::DeformError;
use super::NicpParams;
use super::matching::{Found, Gate, Matcher, Point, covered_area, plane_rms};
use super::plate::Laplacian;
use crate::data::{Mesh, Topology};
use crate::math::Vec3;

/// Smoothing lengths of the rounds, in units of the last one.
const ROUNDS: [f64; 3] = [1.6, 1.0, 1.0];
/// The region that moves reaches so many rings beyond the last measured vertex.
const MARGIN: usize = 4;
/// Points farther than this from the bent surface are outliers by now, mm.
const REACH_MM: f64 = 3.0;

/// Refines the mesh in place; returns the robust RMS distance along the normals, mm.
pub(super) fn refine(
    mesh: &mut Mesh,
    points: &[Point],
    gate: &Gate,
    params: &NicpParams,
    note: &mut dyn FnMut(f64) -> Result<f64, DeformError>,
) -> Result<f64, DeformError> {
    let base = mesh.clone();
    let normals = base.vertex_normals();
    let laplacian = Laplacian::new(&base);
    let topology = Topology::new(&base);
    let mut height = vec![0.0; base.vertices.len()];
    let mut rms = 0.0;
    for smoothing in ROUNDS {
        let found = Matcher::new(mesh, gate)?.find(
            points,
            REACH_MM,
            super::calm(smoothing * params.detail_mm),
        );
        let mut measured = vec![false; base.vertices.len()];
        let counted = found.iter().filter(|f| f.weight > 0.05);
        counted.flat_map(|f| f.corners).for_each(|v| measured[v] = true);
        let active = widened(&measured, &topology, MARGIN);
        let length = smoothing * params.detail_mm;
        let system = System::new(&base, &normals, &laplacian, &found, &active, length);
        system.solve(&mut height);
        if !height.iter().all(|h| h.is_finite()) {
            return Err(DeformError::Plate { reason: "the detail step is not finite".to_owned() });
        }
        for (v, h) in height.iter().enumerate() {
            mesh.vertices[v] = base.vertices[v] + normals[v] * *h;
        }
        rms = note(plane_rms(&found, mesh))?;
    }
    Ok(rms)
}

fn widened(measured: &[bool], topology: &Topology, rings: usize) -> Vec<bool> {
    let mut wide = measured.to_vec();
    for _ in 0..rings {
        let last = wide.clone();
        for (v, near) in topology.neighbours.iter().enumerate() {
            wide[v] |= near.iter().any(|&n| last[n as usize]);
        }
    }
    wide
}

/// Normal equations of the heights: `sum w (c . h - r)^2 + length^4 |L h|^2`.
struct System<'a> {
    /// For each match its three vertices, coefficients, residual and weight.
    rows: Vec<([usize; 3], [f64; 3], f64, f64)>,
    laplacian: &'a Laplacian,
    active: &'a [bool],
    bend: f64,
}

impl<'a> System<'a> {
    fn new(
        base: &Mesh,
        normals: &[Vec3],
        laplacian: &'a Laplacian,
        found: &[Found],
        active: &'a [bool],
        length: f64,
    ) -> Self {
        let share = covered_area(base, found) / found.len().max(1) as f64;
        let rows = found
            .iter()
            .map(|f| {
                let foot: Vec3 =
                    (0..3).map(|k| base.vertices[f.corners[k]] * f.barycentric[k]).sum();
                let c = [0, 1, 2].map(|k| f.barycentric[k] * f.normal.dot(&normals[f.corners[k]]));
                (f.corners, c, f.normal.dot(&(f.data - foot)), f.weight * share)
            })
            .collect();
        Self { rows, laplacian, active, bend: length.powi(4) }
    }

    fn masked(&self, mut x: Vec<f64>) -> Vec<f64> {
        x.iter_mut().zip(self.active).filter(|(_, a)| !**a).for_each(|(v, _)| *v = 0.0);
        x
    }

    fn times(&self, x: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; x.len()];
        for (v, c, _, w) in &self.rows {
            let s = w * (c[0] * x[v[0]] + c[1] * x[v[1]] + c[2] * x[v[2]]);
            (0..3).for_each(|k| y[v[k]] += c[k] * s);
        }
        for row in &self.laplacian.rows {
            let s: f64 = row.iter().map(|&(j, l)| l * x[j as usize]).sum();
            if s != 0.0 {
                row.iter().for_each(|&(j, l)| y[j as usize] += self.bend * l * s);
            }
        }
        self.masked(y)
    }

    fn diagonal(&self) -> Vec<f64> {
        let mut d = vec![1e-9; self.active.len()];
        for (v, c, _, w) in &self.rows {
            (0..3).for_each(|k| d[v[k]] += w * c[k] * c[k]);
        }
        for &(j, l) in self.laplacian.rows.iter().flatten() {
            d[j as usize] += self.bend * l * l;
        }
        d
    }

    /// Conjugate gradients with a diagonal preconditioner, from the present heights.
    fn solve(&self, height: &mut [f64]) {
        let mut right = vec![0.0; height.len()];
        for (v, c, r, w) in &self.rows {
            (0..3).for_each(|k| right[v[k]] += w * c[k] * r);
        }
        let right = self.masked(right);
        let x = self.masked(height.to_vec());
        height.copy_from_slice(&x);
        let diagonal = self.diagonal();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        let scaled = |r: &[f64]| r.iter().zip(&diagonal).map(|(r, d)| r / d).collect::<Vec<_>>();
        let product = self.times(height);
        let mut residual: Vec<f64> = right.iter().zip(&product).map(|(b, a)| b - a).collect();
        let mut step = scaled(&residual);
        let mut energy = dot(&residual, &step);
        let stop = 1e-6 * dot(&right, &scaled(&right));
        for _ in 0..300 {
            if !(energy > stop) {
                break;
            }
            let product = self.times(&step);
            let rate = energy / dot(&step, &product);
            height.iter_mut().zip(&step).for_each(|(h, s)| *h += rate * s);
            residual.iter_mut().zip(&product).for_each(|(r, p)| *r -= rate * p);
            let next = scaled(&residual);
            let after = dot(&residual, &next);
            let keep = after / energy;
            step.iter_mut().zip(&next).for_each(|(s, n)| *s = n + keep * *s);
            energy = after;
        }
    }
}
