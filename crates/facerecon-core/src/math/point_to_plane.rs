//! The motion that moves points to tangent planes: one step of point-to-plane ICP.

use nalgebra::{Rotation3, SMatrix, SVector};

use super::{Similarity, Vec3};

/// A point and the tangent plane at its closest point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanePair {
    /// The point to be moved.
    pub point: Vec3,
    /// The closest point of the surface, on the plane.
    pub closest_point: Vec3,
    /// Unit normal of the plane.
    pub normal: Vec3,
    /// Weight, 0 or more.
    pub weight: f64,
}

/// Fewest pairs with a weight: as many as a similarity has unknowns.
const MIN_PAIRS: usize = 7;
/// Added to the diagonal of the normal equations, as a fraction of the sum of the weights: keeps
/// motions solvable that the pairs do not determine.
const DAMPING: f64 = 1e-9;
/// The logarithm of the scale changes by at most this in one step.
const MAX_LOG_SCALE: f64 = 0.2;

/// The small similarity (or rigid motion) that brings the points closest to their planes in the
/// weighted least-squares sense, linearised about the present position (Chen and Medioni 1991).
/// `point_weight` (about 0.01 to 0.1) is the weight of the distance to the closest point relative
/// to that to the plane: it keeps flat or spherical data from sliding.
///
/// Returns the motion to apply after the present one, or `None` with fewer than seven weighted
/// pairs or numbers that are not finite.
///
/// ```
/// use facerecon_core::math::{PlanePair, Vec3, fit_to_planes};
/// // points of the plane z = 0, measured 2 mm too high
/// let pairs: Vec<PlanePair> = (0..9)
///     .map(|i| Vec3::new(f64::from(i % 3), f64::from(i / 3), 0.0))
///     .map(|p| PlanePair { point: p + Vec3::z() * 2.0, closest_point: p, normal: Vec3::z(), weight: 1.0 })
///     .collect();
/// let step = fit_to_planes(&pairs, 0.02, false).unwrap();
/// assert!((step.translation.z + 2.0).abs() < 1e-6);
/// ```
pub fn fit_to_planes(
    pairs: &[PlanePair],
    point_weight: f64,
    with_scale: bool,
) -> Option<Similarity> {
    let total: f64 = pairs.iter().map(|p| p.weight).sum();
    if pairs.iter().filter(|p| p.weight > 0.0).count() < MIN_PAIRS
        || !(total > 0.0 && total.is_finite())
    {
        return None;
    }
    let centre = pairs.iter().map(|p| p.point * p.weight).sum::<Vec3>() / total;
    let spread =
        pairs.iter().map(|p| (p.point - centre).norm_squared() * p.weight).sum::<f64>() / total;
    // In units of the spread all seven unknowns have similar sizes: one damping fits all.
    let unit = spread.sqrt().max(1e-12);
    let mut a = SMatrix::<f64, 7, 7>::zeros();
    let mut b = SVector::<f64, 7>::zeros();
    for pair in pairs {
        let x = (pair.point - centre) / unit;
        let residual = (pair.closest_point - pair.point) / unit;
        let mut row = |n: &Vec3, w: f64| {
            let turn = x.cross(n);
            let scale = if with_scale { x.dot(n) } else { 0.0 };
            let j = SVector::<f64, 7>::from([turn.x, turn.y, turn.z, n.x, n.y, n.z, scale]);
            a += j * j.transpose() * w;
            b += j * (n.dot(&residual) * w);
        };
        row(&pair.normal, pair.weight);
        for axis in 0..3 {
            row(&Vec3::ith(axis, 1.0), pair.weight * point_weight);
        }
    }
    for i in 0..7 {
        a[(i, i)] += total * DAMPING;
    }
    if !with_scale {
        a[(6, 6)] = total;
    }
    let s = a.cholesky()?.solve(&b);
    if !s.iter().all(|v| v.is_finite()) {
        return None;
    }
    let rotation = Rotation3::from_scaled_axis(Vec3::new(s[0], s[1], s[2])).into_inner();
    let scale = s[6].clamp(-MAX_LOG_SCALE, MAX_LOG_SCALE).exp();
    let shift = Vec3::new(s[3], s[4], s[5]) * unit;
    Some(Similarity { scale, rotation, translation: centre + shift - rotation * centre * scale })
}

/// Weighted root mean square distance of the points from their planes.
pub fn plane_rms(pairs: &[PlanePair]) -> f64 {
    let weight: f64 = pairs.iter().map(|p| p.weight).sum();
    let sum: f64 =
        pairs.iter().map(|p| p.weight * p.normal.dot(&(p.closest_point - p.point)).powi(2)).sum();
    (sum / weight.max(1e-300)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_motion_of_an_ellipsoid_is_undone() {
        let truth = Similarity {
            scale: 1.04,
            rotation: Rotation3::from_euler_angles(0.05, -0.08, 0.03).into_inner(),
            translation: Vec3::new(3.0, -5.0, 2.0),
        };
        let radii = Vec3::new(70.0, 110.0, 90.0);
        let surface: Vec<(Vec3, Vec3)> = (0..400)
            .map(|i| {
                let (t, z) = (f64::from(i) * 2.399_963, f64::from(i) / 200.0 - 0.9975);
                let r = (1.0 - z * z).sqrt();
                let unit = Vec3::new(r * t.cos(), r * t.sin(), z);
                (unit.component_mul(&radii), unit.component_div(&radii).normalize())
            })
            .collect();
        let mut found = Similarity::identity();
        for _ in 0..30 {
            // planes through the true points: the correspondences are known here
            let pairs: Vec<PlanePair> = surface
                .iter()
                .map(|(p, n)| PlanePair {
                    point: found.apply(&truth.apply(p)),
                    closest_point: *p,
                    normal: *n,
                    weight: 1.0,
                })
                .collect();
            found = fit_to_planes(&pairs, 0.02, true).unwrap().compose(&found);
        }
        for (p, _) in &surface {
            assert!((found.apply(&truth.apply(p)) - p).norm() < 1e-6);
        }
        let rigid: Vec<PlanePair> = surface
            .iter()
            .map(|(p, n)| PlanePair {
                point: truth.apply(p),
                closest_point: *p,
                normal: *n,
                weight: 1.0,
            })
            .collect();
        assert_eq!(fit_to_planes(&rigid, 0.02, false).unwrap().scale, 1.0);
        assert!(fit_to_planes(&rigid[..6], 0.02, true).is_none());
    }
}
