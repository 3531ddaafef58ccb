//! Regularised biharmonic splines with an affine part (Carr et al. 2001).

use faer::Mat;
use rayon::prelude::*;

use super::rbf::{Centre, centres, displacements, finish, row, solve};
use super::{DeformError, DeformInput, DeformMethod, DeformParams, Deformed};
use crate::math::{Vec3, mad, median};
use crate::observer::{Event, Observer};
use crate::spatial::eliminate_multiple;

/// Bends the head in rounds: fit a smooth displacement to the matched vertices, match anew.
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
            if next.len() < 4 {
                break;
            }
            assignments = next;
        }
    }
    Ok(finish(input, vertices, count))
}

/// Every vertex with the mean of the points closest to it now; pairs much farther apart than most
/// are left out.
fn rematch(input: &DeformInput<'_>, vertices: &[Vec3]) -> Vec<(usize, Vec3)> {
    let pairs = eliminate_multiple(&input.data.points, vertices, None);
    let distances: Vec<f64> = pairs.iter().map(|&(v, p)| (vertices[v] - p).norm()).collect();
    let limit = median(&distances).unwrap_or(0.0) + 4.0 * mad(&distances).unwrap_or(0.0);
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
    if n < 4 {
        return Err(DeformError::TooFew { got: n, needed: 4 });
    }
    // The affine columns in the size of the others, about the centre.
    let middle = centres.iter().map(|c| c.from).sum::<Vec3>() / n as f64;
    let size = centres.iter().map(|c| (c.from - middle).norm()).fold(0.0, f64::max).max(1e-300);
    let tail = |x: &Vec3, k: usize| if k == 0 { size } else { x[k - 1] - middle[k - 1] };
    let matrix = Mat::from_fn(n + 4, n + 4, |i, j| match (i < n, j < n) {
        (true, true) if i == j => stiffness,
        (true, true) => -(centres[i].from - centres[j].from).norm(),
        (true, false) => tail(&centres[i].from, j - n),
        (false, true) => tail(&centres[j].from, i - n),
        // keeps a flat arrangement, which determines no third direction, solvable
        (false, false) if i == j => -1e-9 * size,
        (false, false) => 0.0,
    });
    let (coefficients, error) = solve(&matrix, &displacements(centres, n + 4));
    if !(error < 1e-8) {
        let method = DeformMethod::BiharmonicRbf;
        return Err(DeformError::Singular { method, centres: n, error });
    }
    let weights: Vec<Vec3> = (0..n + 4).map(|i| row(&coefficients, i)).collect();
    Ok(input
        .template
        .vertices
        .par_iter()
        .map(|x| {
            let bent: Vec3 = (0..n).map(|j| weights[j] * -(x - centres[j].from).norm()).sum();
            let affine: Vec3 = (0..4).map(|k| weights[n + k] * tail(x, k)).sum();
            x + bent + affine
        })
        .collect())
}
