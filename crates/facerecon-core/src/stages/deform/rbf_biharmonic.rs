//! Regularised biharmonic splines with an affine part (Carr et al. 2001).

use faer::Mat;
use rayon::prelude::*;

use super::rbf::{Centre, centres, displacements, finish, row, solve};
use super::{DeformError, DeformInput, DeformMethod, DeformParams, Deformed, MAX_SOLVE_ERROR};
use crate::math::{Vec3, mad, median};
use crate::observer::{Event, Observer};
use crate::spatial::eliminate_multiple;

/// Fewest centres: as many as the affine part has unknowns for each coordinate.
const MIN_CENTRES: usize = 4;
/// Pairs whose distance exceeds the median by more than this many deviations are left out.
const MAX_DEVIATIONS: f64 = 4.0;
/// Added to the affine block's diagonal, relative to the size of the centres: keeps a flat
/// arrangement solvable, which determines no third direction.
const AFFINE_DAMPING: f64 = 1e-9;

/// Bends the head in rounds: fit a smooth displacement to the matched vertices, then match the
/// points to the bent head.
pub fn deform(
    input: &DeformInput<'_>,
    params: &DeformParams,
    observer: &dyn Observer,
) -> Result<Deformed, DeformError> {
    let mut assignments = input.assignments.to_vec();
    let (mut vertices, mut count) = (input.template.vertices.clone(), 0);
    for round in 1..=params.rounds.max(1) {
        observer.check()?;
        let centres = centres(&DeformInput { assignments: &assignments, ..*input }, params);
        vertices = bend(input, &centres, params.stiffness)?;
        count = centres.len();
        let result =
            finish(&DeformInput { assignments: &assignments, ..*input }, vertices.clone(), count);
        observer.event(&Event::Iteration { stage: "deform", step: round, error: result.rms_after });
        if round < params.rounds {
            let next = rematch(input, &vertices);
            if next.len() < MIN_CENTRES {
                break;
            }
            assignments = next;
        }
    }
    Ok(finish(input, vertices, count))
}

/// Every vertex with the mean of the points closest to it now, without outliers.
fn rematch(input: &DeformInput<'_>, vertices: &[Vec3]) -> Vec<(usize, Vec3)> {
    let pairs = eliminate_multiple(&input.data.points, vertices, None);
    let distances: Vec<f64> = pairs.iter().map(|&(v, p)| (vertices[v] - p).norm()).collect();
    let limit = median(&distances).unwrap_or(0.0) + MAX_DEVIATIONS * mad(&distances).unwrap_or(0.0);
    pairs.into_iter().zip(distances).filter(|(_, d)| *d <= limit).map(|(p, _)| p).collect()
}

/// Solves `[A + stiffness I, P; P^T, 0] [c; e] = [d; 0]` with `A_ij = -|x_i - x_j|` and moves all
/// vertices by `sum c_i (-|x - x_i|) + e (1, x)`.
fn bend(
    input: &DeformInput<'_>,
    centres: &[Centre],
    stiffness: f64,
) -> Result<Vec<Vec3>, DeformError> {
    let n = centres.len();
    if n < MIN_CENTRES {
        return Err(DeformError::TooFew { got: n, needed: MIN_CENTRES });
    }
    // The affine columns are scaled to the size of the others, about the mean position.
    let middle = centres.iter().map(|c| c.position).sum::<Vec3>() / n as f64;
    let size = centres.iter().map(|c| (c.position - middle).norm()).fold(0.0, f64::max).max(1e-300);
    let tail = |x: &Vec3, k: usize| if k == 0 { size } else { x[k - 1] - middle[k - 1] };
    let matrix = Mat::from_fn(n + 4, n + 4, |i, j| match (i < n, j < n) {
        (true, true) if i == j => stiffness,
        (true, true) => -(centres[i].position - centres[j].position).norm(),
        (true, false) => tail(&centres[i].position, j - n),
        (false, true) => tail(&centres[j].position, i - n),
        (false, false) if i == j => -AFFINE_DAMPING * size,
        (false, false) => 0.0,
    });
    let (coefficients, error) = solve(&matrix, &displacements(centres, n + 4));
    if !(error < MAX_SOLVE_ERROR) {
        let method = DeformMethod::BiharmonicRbf;
        return Err(DeformError::Singular { method, centres: n, error });
    }
    let weights: Vec<Vec3> = (0..n + 4).map(|i| row(&coefficients, i)).collect();
    Ok(input
        .template
        .vertices
        .par_iter()
        .map(|x| {
            let bent: Vec3 = (0..n).map(|j| weights[j] * -(x - centres[j].position).norm()).sum();
            let affine: Vec3 = (0..4).map(|k| weights[n + k] * tail(x, k)).sum();
            x + bent + affine
        })
        .collect())
}
