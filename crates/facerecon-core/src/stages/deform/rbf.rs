//! Shared by the radial basis functions: centres, their spacing, the solver, the result.

use std::collections::BTreeMap;

use faer::Mat;
use faer::prelude::Solve;
use rayon::prelude::*;

use super::{DeformInput, DeformParams, Deformed};
use crate::data::Mesh;
use crate::math::Vec3;
use crate::spatial::PointIndex;

/// A vertex whose displacement is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Centre {
    /// Its position on the template, `X_i^0`.
    pub position: Vec3,
    /// Its displacement, `d_i` (Eq. 4.1).
    pub displacement: Vec3,
}

/// The centres of a deformation. On one vertex a landmark takes precedence over a point. Vertices at
/// the same position are one centre with their mean displacement: no function takes two values
/// there.
pub fn centres(input: &DeformInput<'_>, params: &DeformParams) -> Vec<Centre> {
    let stride = input.assignments.len().div_ceil(params.max_centres.max(1)).max(1);
    let mut targets: BTreeMap<usize, Vec3> =
        input.assignments.iter().step_by(stride).copied().collect();
    if params.use_landmarks {
        targets.extend(input.landmarks.iter().map(|l| (l.vertex, l.position)));
    }
    let mut list: Vec<Centre> = targets
        .iter()
        .map(|(&vertex, target)| {
            let position = input.template.vertices[vertex];
            Centre { position, displacement: target - position } // Eq. 4.1
        })
        .collect();
    list.sort_by(|a, b| {
        a.position
            .iter()
            .zip(b.position.iter())
            .fold(std::cmp::Ordering::Equal, |order, (x, y)| order.then(x.total_cmp(y)))
    });
    list.chunk_by(|a, b| a.position == b.position)
        .map(|group| Centre {
            position: group[0].position,
            displacement: group.iter().map(|c| c.displacement).sum::<Vec3>() / group.len() as f64,
        })
        .collect()
}

/// Distance of each centre from the nearest other one; `None` with fewer than two.
pub fn spacings(centres: &[Centre]) -> Option<Vec<f64>> {
    let positions: Vec<Vec3> = centres.iter().map(|c| c.position).collect();
    let index = PointIndex::<3>::new(&positions).filter(|_| positions.len() >= 2)?;
    let spacing = |p: &Vec3| index.distance_to_next(&[p.x, p.y, p.z]);
    positions.par_iter().map(spacing).collect()
}

/// Coefficients larger than the right-hand side by this factor come from nearly dependent equations:
/// the surface between the centres would oscillate.
const MAX_GROWTH: f64 = 1e6;

/// Solves a dense system for three right-hand sides by LU with partial pivoting; returns the
/// solution and its relative residual (infinite when the solution is unusable).
pub fn solve(matrix: &Mat<f64>, right: &Mat<f64>) -> (Mat<f64>, f64) {
    let solution = matrix.partial_piv_lu().solve(right);
    let residual = matrix * &solution - right;
    let size = |m: &Mat<f64>| m.norm_max();
    let relative = size(&residual) / size(right).max(1e-300);
    let growth = size(&solution) / size(right).max(1e-300);
    let usable = relative.is_finite() && (size(right) == 0.0 || growth < MAX_GROWTH);
    (solution, if usable { relative } else { f64::INFINITY })
}

/// The displacements as an `n x 3` matrix.
pub fn displacements(centres: &[Centre], rows: usize) -> Mat<f64> {
    Mat::from_fn(rows, 3, |i, k| centres.get(i).map_or(0.0, |c| c.displacement[k]))
}

/// One row of a coefficient matrix.
pub fn row(matrix: &Mat<f64>, i: usize) -> Vec3 {
    Vec3::new(matrix[(i, 0)], matrix[(i, 1)], matrix[(i, 2)])
}

/// The result, with the distances of the assigned vertices from their points before and after.
pub fn finish(input: &DeformInput<'_>, vertices: Vec<Vec3>, centres: usize) -> Deformed {
    let mesh = input.template.with_vertices(vertices);
    let rms = |mesh: &Mesh| {
        let n = input.assignments.len().max(1) as f64;
        let sum: f64 = input
            .assignments
            .iter()
            .map(|&(v, target)| (mesh.vertices[v] - target).norm_squared())
            .sum();
        (sum / n).sqrt()
    };
    Deformed { rms_before: rms(input.template), rms_after: rms(&mesh), mesh, centres }
}
