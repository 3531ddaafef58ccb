//! A robust plane through weighted points.

use nalgebra::{Matrix3, Vector3};

use crate::math::median;

/// Number of reweighted fits.
const ITERATIONS: usize = 5;
/// Scale of the Geman-McClure weights, in median absolute residuals (two standard deviations of
/// normal data).
const SCALE_MEDIANS: f64 = 3.0;
/// Ridge on the slopes, as a share of the total weight: without points on one side the slope
/// there stays near 0.
const RIDGE: f64 = 1e-3;

/// The plane `c0 + c1 dx + c2 dy` through points `(dx, dy, value, weight)` by iterated
/// least squares with Geman-McClure weights, and the scale of its residuals (at least
/// `min_scale`). `None` with fewer than four points.
pub(super) fn robust_plane(points: &[[f64; 4]], min_scale: f64) -> Option<(Vector3<f64>, f64)> {
    if points.len() < 4 {
        return None;
    }
    let values: Vec<f64> = points.iter().map(|p| p[2]).collect();
    let mut plane = Vector3::new(median(&values)?, 0.0, 0.0);
    let mut scale = f64::INFINITY;
    for _ in 0..ITERATIONS {
        let mut normal = Matrix3::zeros();
        let mut right = Vector3::zeros();
        for &[dx, dy, value, weight] in points {
            let row = Vector3::new(1.0, dx, dy);
            let r = (value - plane.dot(&row)) / scale;
            let w = weight / (1.0 + r * r).powi(2);
            normal += row * row.transpose() * w;
            right += row * (w * value);
        }
        normal[(1, 1)] += RIDGE * normal[(0, 0)];
        normal[(2, 2)] += RIDGE * normal[(0, 0)];
        plane = normal.cholesky()?.solve(&right);
        let residuals: Vec<f64> = points
            .iter()
            .map(|&[dx, dy, value, _]| (value - plane.dot(&Vector3::new(1.0, dx, dy))).abs())
            .collect();
        scale = (SCALE_MEDIANS * median(&residuals)?).max(min_scale);
    }
    Some((plane, scale))
}
