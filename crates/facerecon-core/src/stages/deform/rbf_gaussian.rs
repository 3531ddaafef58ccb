//! Gaussian radial basis functions (thesis section 4.2.1).

use faer::Mat;
use rayon::prelude::*;

use super::rbf::{Centre, centres, displacements, finish, row, solve, spacings};
use super::{DeformError, DeformInput, DeformMethod, DeformParams, Deformed, MAX_SOLVE_ERROR};
use crate::math::Vec3;

/// At this exponent a Gaussian (3e-20) is below the rounding error of what it is added to.
const NEGLIGIBLE_EXPONENT: f64 = 45.0;

/// Bends the head so that every centre reaches its target (Eq. 4.3-4.7).
pub fn deform(input: &DeformInput<'_>, params: &DeformParams) -> Result<Deformed, DeformError> {
    let centres = centres(input, params);
    let Some(rates) = rates(&centres, params.neighbour_value) else {
        return Err(DeformError::TooFew { got: centres.len(), needed: 2 });
    };
    let n = centres.len();
    // Eq. 4.5: row i is the displacement of centre i, column j the function of centre j
    let matrix = Mat::from_fn(n, n, |i, j| {
        value(rates[j], (centres[i].position - centres[j].position).norm_squared())
    });
    let (coefficients, error) = solve(&matrix, &displacements(&centres, n)); // Eq. 4.7
    if !(error < MAX_SOLVE_ERROR) {
        let method = DeformMethod::GaussianRbf;
        return Err(DeformError::Singular { method, centres: n, error });
    }
    let weights: Vec<Vec3> = (0..n).map(|i| row(&coefficients, i)).collect();
    let vertices = input
        .template
        .vertices
        .par_iter()
        .map(|x| {
            // Eq. 4.3
            let moved: Vec3 = (0..n)
                .map(|j| weights[j] * value(rates[j], (x - centres[j].position).norm_squared()))
                .sum();
            x + moved
        })
        .collect();
    Ok(finish(input, vertices, n))
}

/// The Gaussian of Eq. 4.4 with the one coefficient of `x^2`.
#[inline]
fn value(rate: f64, distance_squared: f64) -> f64 {
    let exponent = rate * distance_squared;
    if exponent > NEGLIGIBLE_EXPONENT { 0.0 } else { (-exponent).exp() }
}

/// The coefficient of each centre: its function is `neighbour_value` at the nearest other centre.
/// `None` with fewer than two centres.
pub(super) fn rates(centres: &[Centre], neighbour_value: f64) -> Option<Vec<f64>> {
    let spacing = spacings(centres)?;
    Some(spacing.iter().map(|s| -neighbour_value.ln() / (s * s)).collect())
}
