//! Least-squares fits.

use super::{Mat3, Similarity, Vec3};

/// Points lie on one line when their second singular value is below this fraction of the first.
const MIN_SPREAD_RATIO: f64 = 1e-9;

/// The similarity (or rigid motion) that brings `source` closest to `target` in the weighted
/// least-squares sense (Umeyama 1991). Without weights all pairs count the same.
///
/// Returns `target_from_source`, or `None` with fewer than three pairs, lengths that differ, or
/// points that do not determine a rotation (all on one line).
///
/// ```
/// use facerecon_core::math::{Vec3, fit_similarity};
/// let source = [Vec3::x(), Vec3::y(), Vec3::z()];
/// let target = source.map(|p| p * 2.0 + Vec3::new(5.0, 0.0, 0.0));
/// let target_from_source = fit_similarity(&source, &target, &[], true).unwrap();
/// assert!((target_from_source.scale - 2.0).abs() < 1e-9);
/// ```
pub fn fit_similarity(
    source: &[Vec3],
    target: &[Vec3],
    weights: &[f64],
    with_scale: bool,
) -> Option<Similarity> {
    if source.len() < 3
        || source.len() != target.len()
        || !(weights.is_empty() || weights.len() == source.len())
    {
        return None;
    }
    let weight = |i: usize| weights.get(i).copied().unwrap_or(1.0);
    let total: f64 = (0..source.len()).map(weight).sum();
    if !(total > 0.0 && total.is_finite()) {
        return None;
    }
    let mean = |points: &[Vec3]| -> Vec3 {
        points.iter().enumerate().map(|(i, p)| p * weight(i)).sum::<Vec3>() / total
    };
    let (mean_source, mean_target) = (mean(source), mean(target));
    let mut covariance = Mat3::zeros();
    let mut variance = 0.0;
    for (i, (s, t)) in source.iter().zip(target).enumerate() {
        let (a, b) = (s - mean_source, t - mean_target);
        covariance += b * a.transpose() * (weight(i) / total);
        variance += a.norm_squared() * weight(i) / total;
    }
    if !covariance.iter().all(|v| v.is_finite()) {
        return None;
    }
    let svd = covariance.svd(true, true);
    let (u, v_t) = (svd.u?, svd.v_t?);
    // Points on one line leave the rotation about it undetermined.
    if !(svd.singular_values[1] > MIN_SPREAD_RATIO * svd.singular_values[0]) {
        return None;
    }
    let sign = (u * v_t).determinant().signum();
    let flip = Mat3::from_diagonal(&Vec3::new(1.0, 1.0, sign));
    let rotation = u * flip * v_t;
    let scale = if with_scale {
        Vec3::new(1.0, 1.0, sign).dot(&svd.singular_values) / variance
    } else {
        1.0
    };
    (scale > 0.0 && scale.is_finite()).then(|| Similarity {
        scale,
        rotation,
        translation: mean_target - rotation * mean_source * scale,
    })
}

/// Least-squares line `y = intercept + slope x` as `(intercept, slope)`; `None` when `x` does not
/// vary or there are fewer than two samples.
pub fn fit_line(samples: &[(f64, f64)]) -> Option<(f64, f64)> {
    let n = samples.len() as f64;
    if samples.len() < 2 {
        return None;
    }
    let (mx, my) = samples.iter().fold((0.0, 0.0), |(a, b), (x, y)| (a + x / n, b + y / n));
    let (sxx, sxy) = samples
        .iter()
        .fold((0.0, 0.0), |(a, b), (x, y)| (a + (x - mx).powi(2), b + (x - mx) * (y - my)));
    (sxx > 0.0).then(|| (my - sxy / sxx * mx, sxy / sxx))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Rotation3;

    fn cloud() -> Vec<Vec3> {
        (0..30)
            .map(|i| {
                let t = f64::from(i);
                Vec3::new((t * 1.3).sin() * 80.0, (t * 0.7).cos() * 110.0, (t * 2.1).sin() * 60.0)
            })
            .collect()
    }

    #[test]
    fn a_large_known_motion_is_recovered() {
        let truth = Similarity {
            scale: 0.8,
            rotation: Rotation3::from_euler_angles(1.2, -2.0, 0.4).into_inner(),
            translation: Vec3::new(300.0, -120.0, 1300.0),
        };
        let source = cloud();
        let target: Vec<_> = source.iter().map(|p| truth.apply(p)).collect();
        let found = fit_similarity(&source, &target, &[], true).unwrap();
        for p in &source {
            assert!((found.apply(p) - truth.apply(p)).norm() < 1e-9);
        }
        // an outlier of weight 0 does not count
        let mut spoiled = target.clone();
        spoiled[4] += Vec3::new(500.0, 0.0, 0.0);
        let mut weights = vec![1.0; source.len()];
        weights[4] = 0.0;
        let found = fit_similarity(&source, &spoiled, &weights, true).unwrap();
        assert!((found.scale - 0.8).abs() < 1e-9);
    }

    #[test]
    fn points_on_a_line_are_refused() {
        let line: Vec<_> = (0..9).map(|i| Vec3::new(f64::from(i), 0.0, 0.0)).collect();
        assert!(fit_similarity(&line, &line, &[], false).is_none());
        assert!(fit_similarity(&line[..2], &line[..2], &[], false).is_none());
    }
}
