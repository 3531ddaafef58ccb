//! What the radial basis functions share: centres, the solver, the result.

use std::collections::BTreeMap;

use faer::Mat;
use faer::prelude::Solve;

use super::{DeformInput, DeformParams, Deformed};
use crate::data::Mesh;
use crate::math::Vec3;

/// A vertex that knows where it goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Centre {
    /// Its place on the template, `X_i^0`.
    pub from: Vec3,
    /// How far it goes, `d_i` (Eq. 4.1).
    pub displacement: Vec3,
}

/// The centres of a deformation: features before points, one for each place on the template (the
/// points of vertices that lie at one place are averaged, or no function could reach them all).
pub fn centres(input: &DeformInput<'_>, params: &DeformParams) -> Vec<Centre> {
    let stride = input.assignments.len().div_ceil(params.max_centres.max(1)).max(1);
    let mut goals: BTreeMap<usize, Vec3> =
        input.assignments.iter().step_by(stride).copied().collect();
    if params.use_features {
        goals.extend(input.features.iter().copied());
    }
    let mut list: Vec<Centre> = goals
        .iter()
        .map(|(&vertex, goal)| {
            let from = input.template.vertices[vertex];
            Centre { from, displacement: goal - from } // Eq. 4.1
        })
        .collect();
    list.sort_by(|a, b| {
        a.from
            .iter()
            .zip(b.from.iter())
            .fold(std::cmp::Ordering::Equal, |order, (x, y)| order.then(x.total_cmp(y)))
    });
    list.chunk_by(|a, b| a.from == b.from)
        .map(|group| Centre {
            from: group[0].from,
            displacement: group.iter().map(|c| c.displacement).sum::<Vec3>() / group.len() as f64,
        })
        .collect()
}

/// Solves a dense system for three right-hand sides by LU with partial pivoting; gives the solution
/// and its relative residual (infinite when there is none).
pub fn solve(matrix: &Mat<f64>, right: &Mat<f64>) -> (Mat<f64>, f64) {
    let solution = matrix.partial_piv_lu().solve(right);
    let residual = matrix * &solution - right;
    let size = |m: &Mat<f64>| m.norm_max();
    let relative = size(&residual) / size(right).max(1e-300);
    let grown = size(&solution) / size(right).max(1e-300);
    let fine = relative.is_finite() && (size(right) == 0.0 || grown < 1e6);
    (solution, if fine { relative } else { f64::INFINITY })
}

/// The displacements as an `n x 3` matrix.
pub fn displacements(centres: &[Centre], rows: usize) -> Mat<f64> {
    Mat::from_fn(rows, 3, |i, k| centres.get(i).map_or(0.0, |c| c.displacement[k]))
}

/// One row of a coefficient matrix.
pub fn row(matrix: &Mat<f64>, i: usize) -> Vec3 {
    Vec3::new(matrix[(i, 0)], matrix[(i, 1)], matrix[(i, 2)])
}

/// Wraps the moved vertices, with the distances of the assigned ones before and after.
pub fn finish(input: &DeformInput<'_>, vertices: Vec<Vec3>, centres: usize) -> Deformed {
    let mesh = input.template.with_vertices(vertices);
    let rms = |mesh: &Mesh| {
        let n = input.assignments.len().max(1) as f64;
        let sum: f64 = input
            .assignments
            .iter()
            .map(|&(v, goal)| (mesh.vertices[v] - goal).norm_squared())
            .sum();
        (sum / n).sqrt()
    };
    Deformed { rms_before: rms(input.template), rms_after: rms(&mesh), mesh, centres }
}
