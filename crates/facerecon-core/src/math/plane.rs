//! A robust plane through values in the plane of the photo.

use super::{Mat3, Vec2, Vec3, median};

/// Added to the diagonal of the normal equations (offset, slopes): keeps them solvable, and the
/// slopes of few or collinear samples near 0. In units of the number of samples and of pixels
/// squared.
const DAMPING: [f64; 3] = [1e-9, 1.0, 1.0];

/// Fits `value = c[0] + c[1] x + c[2] y` to `((x, y), value)` by iteratively reweighted least
/// squares with Cauchy weights, from the median of the values.
///
/// `widths` are the widths of the weights, one for each round, in the unit of the values. The
/// median has no slope, so the first widths must be large enough to admit slopes.
///
/// Returns `None` without samples or when the equations have no solution.
///
/// ```
/// use facerecon_core::math::{Vec2, fit_plane_robust};
/// let samples: Vec<_> = (0..100)
///     .map(|i| Vec2::new(f64::from(i % 10) - 4.5, f64::from(i / 10) - 4.5) * 20.0)
///     .map(|p| (p, 3.0 + 0.1 * p.x - 0.2 * p.y))
///     .collect();
/// let plane = fit_plane_robust(&samples, &[50.0, 5.0, 0.5]).unwrap();
/// assert!((plane[0] - 3.0).abs() < 1e-3 && (plane[2] + 0.2).abs() < 1e-3);
/// ```
pub fn fit_plane_robust(samples: &[(Vec2, f64)], widths: &[f64]) -> Option<[f64; 3]> {
    let values: Vec<f64> = samples.iter().map(|s| s.1).collect();
    let mut plane = [median(&values)?, 0.0, 0.0];
    for width in widths {
        let (mut normal, mut right) = (Mat3::zeros(), Vec3::zeros());
        for (at, value) in samples {
            let residual = value - (plane[0] + plane[1] * at.x + plane[2] * at.y);
            let weight = 1.0 / (1.0 + (residual / width).powi(2));
            let row = Vec3::new(1.0, at.x, at.y);
            normal += weight * row * row.transpose();
            right += weight * *value * row;
        }
        for (k, damping) in DAMPING.into_iter().enumerate() {
            normal[(k, k)] += damping;
        }
        let solved = normal.try_inverse()? * right;
        plane = [solved.x, solved.y, solved.z];
    }
    Some(plane)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_outlier_does_not_tilt_the_plane() {
        let mut samples: Vec<(Vec2, f64)> = (0..64)
            .map(|i| Vec2::new(f64::from(i % 8) - 3.5, f64::from(i / 8) - 3.5) * 10.0)
            .map(|p| (p, 7.0 + 0.02 * p.x - 0.01 * p.y))
            .collect();
        samples[5].1 += 40.0;
        let plane = fit_plane_robust(&samples, &[3.0, 0.5, 0.5, 0.5]).unwrap();
        assert!((plane[0] - 7.0).abs() < 1e-2, "{plane:?}");
        assert!((plane[1] - 0.02).abs() < 1e-3 && (plane[2] + 0.01).abs() < 1e-3, "{plane:?}");
    }

    #[test]
    fn no_sample_gives_no_plane_and_one_gives_its_value() {
        assert_eq!(fit_plane_robust(&[], &[1.0]), None);
        let plane = fit_plane_robust(&[(Vec2::zeros(), 4.0)], &[1.0, 1.0]).unwrap();
        assert!((plane[0] - 4.0).abs() < 1e-6 && plane[1] == 0.0 && plane[2] == 0.0);
    }
}
