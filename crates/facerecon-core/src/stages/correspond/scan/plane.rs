//! A damped plane of disparity over the photo.

use crate::math::Vec2;

/// Damping of the slopes, squared spacings: without it rounded positions and wrong neighbours would
/// tilt the plane. Counts like one neighbour of weight 1 about half a spacing away.
const SLOPE_DAMPING: f64 = 0.3;

/// Value at the origin of a plane fitted to `(offset, value, weight)` by ridge regression of the
/// slopes. Few or collinear points give nearly their weighted mean.
pub(super) fn plane_at_origin(values: &[(Vec2, f64, f64)], spacing: f64) -> f64 {
    let total: f64 = values.iter().map(|v| v.2).sum();
    let mean_at: Vec2 = values.iter().map(|v| v.0 * v.2).sum::<Vec2>() / total;
    let mean: f64 = values.iter().map(|v| v.1 * v.2).sum::<f64>() / total;
    let mut normal = nalgebra::Matrix2::identity() * (SLOPE_DAMPING * spacing * spacing);
    let mut right = Vec2::zeros();
    for (at, value, weight) in values {
        let d = at - mean_at;
        normal += d * d.transpose() * *weight;
        right += d * (value - mean) * *weight;
    }
    let slope = normal.try_inverse().map_or_else(Vec2::zeros, |inverse| inverse * right);
    mean - slope.dot(&mean_at)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plane_seen_from_all_sides_is_met_and_one_point_gives_its_value() {
        let value = |p: Vec2| 30.0 + 0.2 * p.x - 0.1 * p.y;
        let around: Vec<(Vec2, f64, f64)> = (0..8)
            .map(|i| f64::from(i) * std::f64::consts::FRAC_PI_4)
            .map(|a| Vec2::new(a.cos(), a.sin()) * 9.0)
            .map(|p| (p, value(p), 1.0))
            .collect();
        assert!((plane_at_origin(&around, 9.0) - 30.0).abs() < 1e-12);
        // from one side the damped slope is too small, but closer than the mean
        let right: Vec<_> = around.iter().copied().filter(|v| v.0.x > 0.1).collect();
        let mean = right.iter().map(|v| v.1).sum::<f64>() / right.len() as f64;
        let found = plane_at_origin(&right, 9.0);
        assert!((found - 30.0).abs() < (mean - 30.0).abs(), "{found} {mean}");
        assert_eq!(plane_at_origin(&[(Vec2::new(4.0, 2.0), 17.0, 0.5)], 9.0), 17.0);
    }
}
