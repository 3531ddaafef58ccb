//! Linear radial basis functions within a radius (thesis section 4.2.2).

use rayon::prelude::*;

use super::rbf::{centres, finish, spacings};
use super::{DeformError, DeformInput, DeformParams, Deformed};
use crate::math::Vec3;
use crate::spatial::PointIndex;

/// Moves every vertex inside the radius of a centre along that centre's direction.
///
/// `r(x) = a + b x` with `b = -1`, so that the function ends at its radius `a`, and `a = s / (1 - v)`
/// for a nearest other centre at `s`, so that `r(s) / r(0) = v`. A vertex within several radii takes
/// the sum of its shares, at most their weighted mean, and a centre itself takes its known
/// displacement: no system is solved, which is this variant's purpose in the thesis.
pub fn deform(input: &DeformInput<'_>, params: &DeformParams) -> Result<Deformed, DeformError> {
    let centres = centres(input, params);
    let Some(spacing) = spacings(&centres) else {
        return Err(DeformError::TooFew { got: centres.len(), needed: 2 });
    };
    let radius: Vec<f64> = spacing.iter().map(|s| s / (1.0 - params.neighbour_value)).collect();
    let widest = radius.iter().copied().fold(0.0, f64::max);
    let positions: Vec<Vec3> = centres.iter().map(|c| c.position).collect();
    let Some(index) = PointIndex::<3>::new(&positions) else {
        return Err(DeformError::TooFew { got: 0, needed: 2 });
    };
    let vertices = input
        .template
        .vertices
        .par_iter()
        .map(|x| {
            let (mut moved, mut total) = (Vec3::zeros(), 0.0);
            for near in index.within(&[x.x, x.y, x.z], widest) {
                let (centre, a) = (&centres[near.index], radius[near.index]);
                if near.distance == 0.0 {
                    return x + centre.displacement;
                }
                if near.distance < a {
                    let share = (a - near.distance) / a;
                    let length = centre.displacement.norm();
                    let direction = centre.displacement.try_normalize(1e-300).unwrap_or_default(); // Eq. 4.8
                    moved += direction * (length * share);
                    total += share;
                }
            }
            x + moved / f64::max(total, 1.0)
        })
        .collect();
    Ok(finish(input, vertices, centres.len()))
}
