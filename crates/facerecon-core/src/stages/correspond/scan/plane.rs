//! A damped plane of disparity over the photo.

use crate::math::Vec2;

/// Value at the origin of a plane fitted to `(offset, value, weight)`; slopes are damped, so that few
/// or collinear points give their weighted mean.
pub(super) fn plane_at_origin(values: &[(Vec2, f64, f64)], spacing: f64) -> f64 {
    let total: f64 = values.iter().map(|v| v.2).sum();
    let mean_at: Vec2 = values.iter().map(|v| v.0 * v.2).sum::<Vec2>() / total;
    let mean: f64 = values.iter().map(|v| v.1 * v.2).sum::<f64>() / total;
    // slopes as a ridge regression: rounding and wrong neighbours must not tip the plane
    let mut normal = nalgebra::Matrix2::identity() * (0.3 * spacing * spacing);
    let mut right = Vec2::zeros();
    for (at, value, weight) in values {
        let d = at - mean_at;
        normal += d * d.transpose() * *weight;
        right += d * (value - mean) * *weight;
    }
    let slope = normal.try_inverse().map_or_else(Vec2::zeros, |inverse| inverse * right);
    mean - slope.dot(&mean_at)
}
