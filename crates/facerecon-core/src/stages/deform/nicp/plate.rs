//! The thin plate on a mesh: displacements that bend as little as the data allow.
//!
//! The bending energy is the integral of the squared Laplacian of the displacement, so stiffness
//! is a length: where the data weigh 1 per mm^2, a wave exp(i k x) of the displacement comes out
//! at 1 / (1 + (stiffness k)^4), whatever the mesh's resolution.

use faer::linalg::solvers::Solve;
use faer::sparse::linalg::solvers::{Llt, SymbolicLlt};
use faer::sparse::{SparseColMat, SymbolicSparseColMat};
use faer::{Mat, Side};
use rayon::prelude::*;

use super::super::DeformError;
use super::matching::{Found, area, covered_area};
use crate::data::{Mesh, Topology};
use crate::math::Vec3;

/// The discrete Laplacian of a mesh, scaled so that its squared norm is the bending energy.
pub(super) struct Laplacian {
    /// For each vertex its row: neighbours, itself last.
    pub rows: Vec<Vec<(u32, f64)>>,
    /// Area of each vertex, mm^2.
    pub areas: Vec<f64>,
}

/// How far a displacement may reach beyond the data before it fades, mm.
const FADE_MM: f64 = 80.0;
/// How far a slope of the displacement may reach beyond the data before it levels out, mm: a plate
/// alone would carry the slope at the last data on to the border of the neck.
const LEVEL_MM: f64 = 20.0;

/// Cotangent of the angle of a face at `apex` across the edge `i` `j`: its half weighs the squared
/// difference along that edge in the integral of the squared gradient (Pinkall, Polthier 1993).
/// Bounded below, so that no triangle pushes.
fn cotangent(mesh: &Mesh, i: u32, j: u32, apex: u32) -> f64 {
    let at = |v: u32| mesh.vertices[v as usize];
    let (a, b) = (at(i) - at(apex), at(j) - at(apex));
    (a.dot(&b) / a.cross(&b).norm().max(1e-9)).clamp(0.05, 20.0)
}

impl Laplacian {
    /// Mean value weights (Floater 2003): positive, and exact for linear functions on flat parts,
    /// so that uneven triangles do not bend a plate that is only tilted.
    pub fn new(mesh: &Mesh) -> Self {
        let n = mesh.vertices.len();
        let topology = Topology::new(mesh);
        let mut rows: Vec<Vec<(u32, f64)>> = topology
            .neighbours
            .iter()
            .map(|near| near.iter().map(|&j| (j, 0.0)).collect())
            .collect();
        let mut areas = vec![0.0; n];
        for face in &mesh.faces {
            let third = area(mesh, face) / 3.0;
            for k in 0..3 {
                let [v, a, b] = [face[k], face[(k + 1) % 3], face[(k + 2) % 3]];
                areas[v as usize] += third;
                let (ea, eb) = (
                    mesh.vertices[a as usize] - mesh.vertices[v as usize],
                    mesh.vertices[b as usize] - mesh.vertices[v as usize],
                );
                // tan(angle / 2), bounded for triangles without area
                let (cross, dot) = (ea.cross(&eb).norm(), ea.dot(&eb));
                let half = (cross / (ea.norm() * eb.norm() + dot).max(1e-12)).min(20.0);
                for (j, edge) in [(a, ea), (b, eb)] {
                    if let Ok(at) = rows[v as usize].binary_search_by_key(&j, |r| r.0) {
                        rows[v as usize][at].1 += half / edge.norm().max(1e-6);
                    }
                }
            }
        }
        for (v, row) in rows.iter_mut().enumerate() {
            let total: f64 = row.iter().map(|r| r.1).sum();
            if !(total > 0.0) {
                row.clear();
                continue;
            }
            let centre = mesh.vertices[v];
            let reach: f64 = row
                .iter()
                .map(|r| r.1 / total * (mesh.vertices[r.0 as usize] - centre).norm_squared())
                .sum();
            // mean over the ring - centre = reach / 4 * Laplacian; the open border bends freely
            let free = if topology.border[v] { 0.05 } else { 1.0 };
            let scale = free * 4.0 / reach.max(1e-9) * areas[v].sqrt();
            row.iter_mut().for_each(|r| r.1 *= scale / total);
            row.push((v as u32, -scale));
        }
        Self { rows, areas }
    }

    /// The columns, entries in the places of the rows': whom a vertex neighbours, it is
    /// neighboured by.
    pub fn columns(&self) -> Vec<Vec<f64>> {
        let entry = |row: u32, column: usize| {
            let row = &self.rows[row as usize];
            place(row, column).map_or(0.0, |at| row[at].1)
        };
        let column = |v: usize| self.rows[v].iter().map(|&(j, _)| entry(j, v)).collect();
        (0..self.rows.len()).into_par_iter().map(column).collect()
    }
}

/// Where the entry of a column stands in a row of the Laplacian: neighbours in order, itself last.
pub(super) fn place(row: &[(u32, f64)], column: usize) -> Option<usize> {
    let last = row.len().checked_sub(1)?;
    if row[last].0 as usize == column {
        return Some(last);
    }
    row[..last].binary_search_by_key(&column, |r| r.0 as usize).ok()
}

/// The bending system of one mesh, factored anew for each set of matches.
pub(super) struct Plate {
    symbolic: SymbolicSparseColMat<usize>,
    /// Bending energy, lower triangle, in the order of `symbolic`.
    energy: Vec<f64>,
    order: SymbolicLlt<usize>,
    areas: Vec<f64>,
}

impl Plate {
    pub fn new(mesh: &Mesh) -> Result<Self, DeformError> {
        let laplacian = Laplacian::new(mesh);
        let n = mesh.vertices.len();
        let mut columns: Vec<Vec<(u32, f64)>> = vec![Vec::new(); n];
        for row in &laplacian.rows {
            for &(i, a) in row {
                columns[i as usize]
                    .extend(row.iter().filter(|(j, _)| *j >= i).map(|&(j, b)| (j, a * b)));
            }
        }
        // the edges, which the data's entries need, and the diagonal
        for (v, column) in columns.iter_mut().enumerate() {
            let fade = laplacian.areas[v].max(1e-6) / FADE_MM.powi(4);
            column.push((v as u32, fade));
        }
        for face in &mesh.faces {
            for k in 0..3 {
                let (i, j) = (face[k], face[(k + 1) % 3]);
                let pull = cotangent(mesh, i, j, face[(k + 2) % 3]) / (2.0 * LEVEL_MM.powi(2));
                columns[i as usize].push((i, pull));
                columns[j as usize].push((j, pull));
                columns[i.min(j) as usize].push((i.max(j), -pull));
            }
        }
        let mut starts = vec![0usize];
        let (mut indices, mut energy) = (Vec::new(), Vec::new());
        for column in &mut columns {
            column.sort_by_key(|e| e.0); // stable: equal entries add in one order
            for &(i, value) in column.iter() {
                let begun = indices.len() > starts[starts.len() - 1];
                match energy.last_mut() {
                    Some(last) if begun && indices[indices.len() - 1] == i as usize => {
                        *last += value;
                    }
                    _ => {
                        indices.push(i as usize);
                        energy.push(value);
                    }
                }
            }
            starts.push(indices.len());
        }
        // sorted and in range by construction, which is all that this checks
        let symbolic = SymbolicSparseColMat::new_checked(n, n, starts, None, indices);
        let order = SymbolicLlt::try_new(symbolic.as_ref(), Side::Lower)
            .map_err(|e| unsolved(format!("{e:?}")))?;
        Ok(Self { symbolic, energy, order, areas: laplacian.areas })
    }

    /// One round: moves `moved` (displacements of `rest`) toward the matches.
    ///
    /// The three coordinates are decoupled by letting each match pull toward its tangent plane at
    /// the present place, and repeating that with the same factors: the repeats converge to the
    /// coupled point-to-plane solution at a thirtieth of its price.
    pub fn bend(
        &self,
        rest: &Mesh,
        moved: &mut [Vec3],
        found: &[Found],
        features: &[(usize, Vec3)],
        feature_weight: f64,
        stiffness: f64,
    ) -> Result<(), DeformError> {
        let n = moved.len();
        let share = covered_area(rest, found) / found.len().max(1) as f64;
        let mut values: Vec<f64> = self.energy.iter().map(|e| e * stiffness.powi(4)).collect();
        let starts = self.symbolic.col_ptr();
        let indices = self.symbolic.row_idx();
        let mut add = |i: usize, j: usize, value: f64| {
            let (column, row) = (i.min(j), i.max(j));
            let range = starts[column]..starts[column + 1];
            if let Ok(at) = indices[range.clone()].binary_search(&row) {
                values[range.start + at] += value;
            }
        };
        for f in found {
            for a in 0..3 {
                for b in 0..=a {
                    let value = f.weight * share * f.barycentric[a] * f.barycentric[b];
                    add(f.corners[a], f.corners[b], value);
                }
            }
        }
        // A feature weighs as much as the data on a disc of its vertex' neighbourhood.
        let pull = |v: usize| 10.0 * feature_weight * self.areas[v].max(1.0);
        for &(v, _) in features {
            add(v, v, pull(v));
        }
        let matrix = SparseColMat::new(self.symbolic.clone(), values);
        let factor = Llt::try_new_with_symbolic(self.order.clone(), matrix.as_ref(), Side::Lower)
            .map_err(|e| unsolved(format!("{e:?}")))?;
        for _ in 0..REPEATS {
            let mut right = Mat::<f64>::zeros(n, 3);
            for f in found {
                let here: Vec3 = (0..3).map(|k| moved[f.corners[k]] * f.barycentric[k]).sum();
                let rest_foot: Vec3 =
                    (0..3).map(|k| rest.vertices[f.corners[k]] * f.barycentric[k]).sum();
                let miss = f.data - rest_foot - here;
                // to the plane, and a little toward the point itself
                let target = here + f.normal * f.normal.dot(&miss) * (1.0 - HOLD) + miss * HOLD;
                for k in 0..3 {
                    for axis in 0..3 {
                        right[(f.corners[k], axis)] +=
                            f.weight * share * f.barycentric[k] * target[axis];
                    }
                }
            }
            for &(v, place) in features {
                for axis in 0..3 {
                    right[(v, axis)] += pull(v) * (place[axis] - rest.vertices[v][axis]);
                }
            }
            factor.solve_in_place(right.as_mut());
            for (v, d) in moved.iter_mut().enumerate() {
                *d = Vec3::new(right[(v, 0)], right[(v, 1)], right[(v, 2)]);
            }
        }
        if moved.iter().all(|d| d.iter().all(|c| c.is_finite())) {
            Ok(())
        } else {
            Err(unsolved("the solution is not finite".to_owned()))
        }
    }
}

/// Repeats with one factor.
const REPEATS: usize = 4;
/// Weight of the distance to the point itself against that to the plane.
const HOLD: f64 = 0.03;

fn unsolved(reason: String) -> DeformError {
    DeformError::Plate { reason }
}
