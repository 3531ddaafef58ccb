//! The last step: each measured vertex moves along its normal to where the points around it say.
//!
//! One number a vertex, point-to-plane exactly, the thin plate smoothing over the length that the
//! data's noise asks for. Well conditioned where there is data, so conjugate gradients suffice.

use rayon::prelude::*;

use super::super::DeformError;
use super::matching::{Found, Gate, Matcher, Point, covered_area, plane_rms};
use super::plate::{Laplacian, place};
use super::{NicpParams, layers};
use crate::data::{Mesh, Topology};
use crate::math::Vec3;

/// Smoothing lengths of the rounds, in units of the last one.
const ROUNDS: [f64; 3] = [1.6, 1.0, 1.0];
/// The region that moves reaches so many rings beyond the last measured vertex.
const MARGIN: usize = 4;
/// Points farther than this from the bent surface are outliers by now, mm.
const REACH_MM: f64 = 3.0;

/// Rows of a product that a task works out at least.
const TASK: usize = 2048;

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
    let columns = laplacian.columns();
    let topology = Topology::new(&base);
    let mut height = vec![0.0; base.vertices.len()];
    let (mut rms, mut found) = (0.0, Vec::new());
    for smoothing in ROUNDS {
        found = Matcher::new(mesh, gate)?.find(
            points,
            REACH_MM,
            super::calm(smoothing * params.detail_mm),
        );
        let mut measured = vec![false; base.vertices.len()];
        let counted = found.iter().filter(|f| f.weight > 0.05);
        counted.flat_map(|f| f.corners).for_each(|v| measured[v] = true);
        let active = widened(&measured, &topology, MARGIN);
        let length = smoothing * params.detail_mm;
        let system = System::new(&base, &normals, &laplacian, &columns, &found, &active, length);
        system.solve(&mut height);
        if !height.iter().all(|h| h.is_finite()) {
            return Err(DeformError::Plate { reason: "the detail step is not finite".to_owned() });
        }
        for (v, h) in height.iter().enumerate() {
            mesh.vertices[v] = base.vertices[v] + normals[v] * *h;
        }
        rms = note(plane_rms(&found, mesh))?;
    }
    layers::keep_apart(&base, &normals, &topology, mesh, &found);
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
///
/// The matches couple the corners of a face, the Laplacian a vertex and its ring: both matrices
/// have their entries in the same places, a row for each vertex.
struct System<'a> {
    /// Matrix of the matches, entries as in the Laplacian's rows.
    data: Vec<Vec<f64>>,
    /// See [`Laplacian::columns`].
    columns: &'a [Vec<f64>],
    right: Vec<f64>,
    laplacian: &'a Laplacian,
    active: &'a [bool],
    bend: f64,
}

impl<'a> System<'a> {
    fn new(
        base: &Mesh,
        normals: &[Vec3],
        laplacian: &'a Laplacian,
        columns: &'a [Vec<f64>],
        found: &[Found],
        active: &'a [bool],
        length: f64,
    ) -> Self {
        let share = covered_area(base, found) / found.len().max(1) as f64;
        let rows = &laplacian.rows;
        let mut data: Vec<Vec<f64>> = rows.iter().map(|row| vec![0.0; row.len()]).collect();
        let mut right = vec![0.0; rows.len()];
        for f in found {
            let foot: Vec3 = (0..3).map(|k| base.vertices[f.corners[k]] * f.barycentric[k]).sum();
            let c = [0, 1, 2].map(|k| f.barycentric[k] * f.normal.dot(&normals[f.corners[k]]));
            let (miss, weight) = (f.normal.dot(&(f.data - foot)), f.weight * share);
            for i in 0..3 {
                let v = f.corners[i];
                right[v] += weight * c[i] * miss;
                for j in 0..3 {
                    if let Some(at) = place(&rows[v], f.corners[j]) {
                        data[v][at] += weight * c[i] * c[j];
                    }
                }
            }
        }
        let right = masked(right, active);
        Self { data, columns, right, laplacian, active, bend: length.powi(4) }
    }

    /// The matrix times `x`, which is 0 where nothing moves.
    fn times(&self, x: &[f64]) -> Vec<f64> {
        let rows = &self.laplacian.rows;
        let curved: Vec<f64> = rows
            .par_iter()
            .with_min_len(TASK)
            .map(|row| row.iter().map(|&(j, l)| l * x[j as usize]).sum())
            .collect();
        let one = |v: usize| {
            if !self.active[v] {
                return 0.0;
            }
            let entries = rows[v].iter().zip(&self.data[v]).zip(&self.columns[v]);
            entries
                .map(|((&(j, _), d), t)| d * x[j as usize] + self.bend * t * curved[j as usize])
                .sum()
        };
        (0..x.len()).into_par_iter().with_min_len(TASK).map(one).collect()
    }

    fn diagonal(&self) -> Vec<f64> {
        let one = |v: usize| {
            let own = place(&self.laplacian.rows[v], v).map_or(0.0, |at| self.data[v][at]);
            let bent: f64 = self.columns[v].iter().map(|t| t * t).sum();
            1e-9 + own + self.bend * bent
        };
        (0..self.active.len()).map(one).collect()
    }

    /// Conjugate gradients with a diagonal preconditioner, from the present heights.
    fn solve(&self, height: &mut [f64]) {
        let right = &self.right;
        let x = masked(height.to_vec(), self.active);
        height.copy_from_slice(&x);
        let diagonal = self.diagonal();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        let scaled = |r: &[f64]| r.iter().zip(&diagonal).map(|(r, d)| r / d).collect::<Vec<_>>();
        let product = self.times(height);
        let mut residual: Vec<f64> = right.iter().zip(&product).map(|(b, a)| b - a).collect();
        let mut step = scaled(&residual);
        let mut energy = dot(&residual, &step);
        let stop = 1e-6 * dot(right, &scaled(right));
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

fn masked(mut x: Vec<f64>, active: &[bool]) -> Vec<f64> {
    x.iter_mut().zip(active).filter(|(_, a)| !**a).for_each(|(v, _)| *v = 0.0);
    x
}
