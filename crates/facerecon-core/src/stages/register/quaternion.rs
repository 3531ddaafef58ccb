//! The closed-form rotation from a unit quaternion (Horn 1987; Besl and McKay 1992; Eq. 3.2-3.6).

use nalgebra::{Matrix4, Vector4};

use crate::math::{Mat3, Similarity, Vec3};

/// Points lie on one line when their second singular value is below this fraction of the first.
const MIN_SPREAD_RATIO: f64 = 1e-9;

/// The motion that brings `points` closest to the `targets` of the same index in the least-squares
/// sense, by the unit quaternion of the greatest eigenvalue. With `with_scale` also the uniform scale
/// (Umeyama 1991), which the thesis does not estimate.
///
/// `None` with fewer than three pairs, lengths that differ, or points that determine no rotation.
pub fn fit_quaternion(points: &[Vec3], targets: &[Vec3], with_scale: bool) -> Option<Similarity> {
    if points.len() < 3 || points.len() != targets.len() {
        return None;
    }
    let n = points.len() as f64;
    // Eq. 3.2; the mean of the model is that of the matched points Y, as in Besl and McKay
    let mean_p = points.iter().sum::<Vec3>() / n;
    let mean_x = targets.iter().sum::<Vec3>() / n;
    // Eq. 3.3, in the form without cancellation
    let mut sigma = Mat3::zeros();
    let mut variance = 0.0;
    for (p, x) in points.iter().zip(targets) {
        sigma += (p - mean_p) * (x - mean_x).transpose() / n;
        variance += (p - mean_p).norm_squared() / n;
    }
    if !sigma.iter().all(|v| v.is_finite()) {
        return None;
    }
    let singular = sigma.singular_values();
    if !(singular[1] > MIN_SPREAD_RATIO * singular[0]) {
        return None; // the rotation about the line of the points is undetermined
    }
    let rotation = rotation_of(&max_eigenvector(&q_matrix(&sigma)));
    let scale = if with_scale { (rotation * sigma).trace() / variance } else { 1.0 };
    (scale > 0.0 && scale.is_finite()).then(|| Similarity {
        scale,
        rotation,
        translation: mean_x - rotation * mean_p * scale, // Eq. 3.6
    })
}

/// Eq. 3.4.
fn q_matrix(sigma: &Mat3) -> Matrix4<f64> {
    let a = sigma - sigma.transpose();
    let delta = Vec3::new(a[(1, 2)], a[(2, 0)], a[(0, 1)]);
    let trace = sigma.trace();
    let mut q = Matrix4::zeros();
    q[(0, 0)] = trace;
    q.fixed_view_mut::<1, 3>(0, 1).copy_from(&delta.transpose());
    q.fixed_view_mut::<3, 1>(1, 0).copy_from(&delta);
    q.fixed_view_mut::<3, 3>(1, 1)
        .copy_from(&(sigma + sigma.transpose() - Mat3::identity() * trace));
    q
}

fn max_eigenvector(q: &Matrix4<f64>) -> Vector4<f64> {
    let eigen = q.symmetric_eigen();
    let vector: Vector4<f64> = eigen.eigenvectors.column(eigen.eigenvalues.imax()).into_owned();
    vector.try_normalize(1e-300).unwrap_or(Vector4::new(1.0, 0.0, 0.0, 0.0))
}

/// Eq. 3.5.
fn rotation_of(q: &Vector4<f64>) -> Mat3 {
    let [q0, q1, q2, q3] = [q[0], q[1], q[2], q[3]];
    Mat3::new(
        q0 * q0 + q1 * q1 - q2 * q2 - q3 * q3,
        2.0 * (q1 * q2 - q0 * q3),
        2.0 * (q1 * q3 + q0 * q2),
        2.0 * (q1 * q2 + q0 * q3),
        q0 * q0 + q2 * q2 - q1 * q1 - q3 * q3,
        2.0 * (q2 * q3 - q0 * q1),
        2.0 * (q1 * q3 - q0 * q2),
        2.0 * (q2 * q3 + q0 * q1),
        q0 * q0 + q3 * q3 - q1 * q1 - q2 * q2,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::fit_similarity;
    use nalgebra::Rotation3;

    fn cloud() -> Vec<Vec3> {
        (0..40)
            .map(|i| {
                let t = f64::from(i);
                Vec3::new((t * 1.3).sin() * 80.0, (t * 0.7).cos() * 110.0, (t * 2.1).sin() * 60.0)
            })
            .collect()
    }

    #[test]
    fn large_motions_are_recovered_both_ways_and_agree_with_the_svd() {
        for k in 0..60 {
            let t = f64::from(k);
            let truth = Similarity {
                scale: if k % 2 == 0 { 1.0 } else { 0.7 + 0.01 * t },
                rotation: Rotation3::from_euler_angles(t * 1.7, t * 0.9, t * 2.3).into_inner(),
                translation: Vec3::new(t * 30.0, -400.0, 1300.0),
            };
            let source = cloud();
            let target: Vec<_> = source.iter().map(|p| truth.apply(p)).collect();
            let forth = fit_quaternion(&source, &target, k % 2 == 1).unwrap();
            let back = fit_quaternion(&target, &source, k % 2 == 1).unwrap();
            for p in &source {
                assert!((forth.apply(p) - truth.apply(p)).norm() < 1e-8);
                assert!((back.apply(&truth.apply(p)) - p).norm() < 1e-8);
            }
            let noisy: Vec<_> =
                target.iter().zip(&source).map(|(t, s)| t + s.yzx() * 0.05).collect();
            let quaternion = fit_quaternion(&source, &noisy, true).unwrap();
            let svd = fit_similarity(&source, &noisy, &[], true).unwrap();
            assert!((quaternion.rotation - svd.rotation).amax() < 1e-9);
            assert!((quaternion.scale - svd.scale).abs() < 1e-9);
            assert!((quaternion.translation - svd.translation).norm() < 1e-6);
        }
    }

    #[test]
    fn mirrored_points_give_a_rotation_not_a_reflection() {
        let source = cloud();
        let mirrored: Vec<_> = source.iter().map(|p| Vec3::new(-p.x, p.y, p.z)).collect();
        let found = fit_quaternion(&source, &mirrored, false).unwrap();
        assert!((found.rotation.determinant() - 1.0).abs() < 1e-9);
        let line: Vec<_> = (0..9).map(|i| Vec3::new(f64::from(i), 0.0, 0.0)).collect();
        assert!(fit_quaternion(&line, &line, false).is_none());
    }
}
