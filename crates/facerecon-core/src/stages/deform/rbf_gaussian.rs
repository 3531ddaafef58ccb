//! Gaussian radial basis functions (thesis section 4.2.1).

use faer::Mat;
use rayon::prelude::*;

use super::rbf::{Centre, centres, displacements, finish, row, solve};
use super::{DeformError, DeformInput, DeformMethod, DeformParams, Deformed};
use crate::math::Vec3;
use crate::spatial::PointIndex;

/// Beyond this exponent a Gaussian is below the rounding error of what it is added to.
const NEGLIGIBLE: f64 = 45.0;

/// Bends the head so that every centre reaches its goal (Eq. 4.3-4.7).
pub fn deform(input: &DeformInput<'_>, params: &DeformParams) -> Result<Deformed, DeformError> {
    let centres = centres(input, params);
    let Some(rates) = rates(&centres, params.neighbour_value) else {
        return Err(DeformError::TooFew { got: centres.len(), needed: 2 });
    };
    let n = centres.len();
    // Eq. 4.5: row i is the displacement of centre i, column j the function of centre j
    let matrix = Mat::from_fn(n, n, |i, j| {
        value(rates[j], (centres[i].from - centres[j].from).norm_squared())
    });
    let (coefficients, error) = solve(&matrix, &displacements(&centres, n)); // Eq. 4.7
    if !(error < 1e-8) {
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
                .map(|j| weights[j] * value(rates[j], (x - centres[j].from).norm_squared()))
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
    if exponent > NEGLIGIBLE { 0.0 } else { (-exponent).exp() }
}

/// The coefficient of each centre: its function is `neighbour_value` at the nearest other centre.
/// `None` with fewer than two centres.
pub(super) fn rates(centres: &[Centre], neighbour_value: f64) -> Option<Vec<f64>> {
    let spacing = spacings(centres)?;
    Some(spacing.iter().map(|s| -neighbour_value.ln() / (s * s)).collect())
}

/// Distance of each centre from the nearest other one; `None` with fewer than two.
pub(super) fn spacings(centres: &[Centre]) -> Option<Vec<f64>> {
    let places: Vec<Vec3> = centres.iter().map(|c| c.from).collect();
    let index = PointIndex::<3>::new(&places).filter(|_| places.len() >= 2)?;
    places.par_iter().map(|p| Some(index.nearest_n(&[p.x, p.y, p.z], 2).get(1)?.distance)).collect()
}
