//! The motion that brings points onto tangent planes: one step of point-to-plane ICP.

use nalgebra::{Rotation3, SMatrix, SVector};

use super::{Similarity, Vec3};

/// One point and the plane it should come to lie on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanePair {
    /// The point to be moved.
    pub point: Vec3,
    /// A point of the plane, the closest one.
    pub foot: Vec3,
    /// Unit normal of the plane.
    pub normal: Vec3,
    /// Weight, 0 or more.
    pub weight: f64,
}

/// The small similarity (or rigid motion) that brings the points closest to their planes in the
/// weighted least-squares sense, linearised about the present position (Chen and Medioni 1991).
/// `hold` (about 0.01 to 0.1) is the weight of the distance to the foot itself against that to the
/// plane: it keeps flat or spherical data from sliding.
///
/// Returns the motion to apply after the present one, or `None` with fewer than seven weighted
/// pairs or numbers that are not finite.
pub fn fit_to_planes(pairs: &[PlanePair], hold: f64, with_scale: bool) -> Option<Similarity> {
    let total: f64 = pairs.iter().map(|p| p.weight).sum();
    if pairs.iter().filter(|p| p.weight > 0.0).count() < 7 || !(total > 0.0 && total.is_finite()) {
        return None;
    }
    let centre = pairs.iter().map(|p| p.point * p.weight).sum::<Vec3>() / total;
    let spread =
        pairs.iter().map(|p| (p.point - centre).norm_squared() * p.weight).sum::<f64>() / total;
    // In units of the spread all seven unknowns have like sizes, so one damping suits them all.
    let unit = spread.sqrt().max(1e-12);
    let mut a = SMatrix::<f64, 7, 7>::zeros();
    let mut b = SVector::<f64, 7>::zeros();
    for pair in pairs {
        let x = (pair.point - centre) / unit;
        let miss = (pair.foot - pair.point) / unit;
        let mut row = |n: &Vec3, w: f64| {
            let turn = x.cross(n);
            let scale = if with_scale { x.dot(n) } else { 0.0 };
            let j = SVector::<f64, 7>::from([turn.x, turn.y, turn.z, n.x, n.y, n.z, scale]);
            a += j * j.transpose() * w;
            b += j * (n.dot(&miss) * w);
        };
        row(&pair.normal, pair.weight);
        for axis in 0..3 {
            row(&Vec3::ith(axis, 1.0), pair.weight * hold);
        }
    }
    for i in 0..7 {
        a[(i, i)] += total * 1e-9;
    }
    if !with_scale {
        a[(6, 6)] = total;
    }
    let s = a.cholesky()?.solve(&b);
    if !s.iter().all(|v| v.is_finite()) {
        return None;
    }
    let rotation = Rotation3::from_scaled_axis(Vec3::new(s[0], s[1], s[2])).into_inner();
    let scale = s[6].clamp(-0.2, 0.2).exp();
    let shift = Vec3::new(s[3], s[4], s[5]) * unit;
    Some(Similarity { scale, rotation, translation: centre + shift - rotation * centre * scale })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points of an ellipsoid moved by a small known motion come back onto it.
    #[test]
    fn a_moved_ellipsoid_comes_home() {
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
            // planes through the true feet: the correspondences are known here
            let pairs: Vec<PlanePair> = surface
                .iter()
                .map(|(p, n)| PlanePair {
                    point: found.apply(&truth.apply(p)),
                    foot: *p,
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
            .map(|(p, n)| PlanePair { point: truth.apply(p), foot: *p, normal: *n, weight: 1.0 })
            .collect();
        assert_eq!(fit_to_planes(&rigid, 0.02, false).unwrap().scale, 1.0);
        assert!(fit_to_planes(&rigid[..6], 0.02, true).is_none());
    }
}
