//! Barycentric interpolation.

use std::ops::{Add, Mul};

/// The value inside a triangle whose corners have `values`, at barycentric weights that sum to 1.
/// The terms are added in the order of the corners.
///
/// ```
/// use facerecon_core::math::interpolate;
/// assert_eq!(interpolate([2.0, 4.0, 8.0], [0.5, 0.25, 0.25]), 4.0);
/// ```
#[inline]
pub fn interpolate<T>(values: [T; 3], barycentric: [f64; 3]) -> T
where
    T: Mul<f64, Output = T> + Add<Output = T>,
{
    let [a, b, c] = values;
    a * barycentric[0] + b * barycentric[1] + c * barycentric[2]
}
