//! Landmarks and the measured surface: a landmark's distance from it is an error of the landmark.

use super::super::LandmarkTarget;
use super::measured_points::MeasuredPoint;
use crate::math::Vec3;
use crate::spatial::PointIndex;

/// Measured points that stand for the surface at a landmark, and the distance within which they
/// are, mm: about the spacing of projected dots.
const POINTS: usize = 12;
const REACH_MM: f64 = 4.0;
/// Fewer points do not determine a plane.
const MIN_POINTS: usize = 4;
/// A landmark farther from the surface contradicts it, in standard deviations and at least mm.
const MAX_DEVIATIONS: f64 = 3.0;
const MIN_LIMIT_MM: f64 = 2.0;

/// The landmarks moved along the normals onto the measured surface, where it was measured around
/// them. A landmark too far from it stays, and its standard deviation grows by the distance.
pub(super) fn onto_surface(
    landmarks: &[LandmarkTarget],
    points: &[MeasuredPoint],
) -> Vec<LandmarkTarget> {
    let with_normal: Vec<&MeasuredPoint> =
        points.iter().filter(|p| p.normal != Vec3::zeros()).collect();
    let positions: Vec<Vec3> = with_normal.iter().map(|p| p.position).collect();
    let Some(index) = PointIndex::<3>::new(&positions) else { return landmarks.to_vec() };
    let one = |landmark: &LandmarkTarget| {
        let mut around = index.nearest_n(&landmark.position.into(), POINTS);
        around.retain(|n| n.distance < REACH_MM);
        if around.len() < MIN_POINTS {
            return *landmark;
        }
        let sum: Vec3 = around.iter().map(|n| with_normal[n.index].normal).sum();
        let Some(normal) = sum.try_normalize(1e-9) else { return *landmark };
        let heights = around.iter().map(|n| normal.dot(&(positions[n.index] - landmark.position)));
        let height = heights.sum::<f64>() / around.len() as f64;
        let limit = (MAX_DEVIATIONS * landmark.sigma_mm).max(MIN_LIMIT_MM);
        if height.abs() < limit {
            LandmarkTarget { position: landmark.position + normal * height, ..*landmark }
        } else {
            LandmarkTarget { sigma_mm: landmark.sigma_mm.hypot(height), ..*landmark }
        }
    };
    landmarks.iter().map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::super::surface_match::fixtures::sheet;
    use super::*;
    use crate::data::Cloud;

    #[test]
    fn a_landmark_moves_onto_the_surface_unless_it_contradicts_it() {
        let mut cloud = Cloud::from_points(sheet(30, 1.0).vertices);
        cloud.normals = vec![Vec3::z(); cloud.points.len()];
        let points = MeasuredPoint::from_cloud(&cloud, 0.1);
        let at = |x: f64, z: f64| LandmarkTarget {
            vertex: 0,
            position: Vec3::new(x, 15.2, z),
            sigma_mm: 1.0,
        };
        let found = onto_surface(&[at(12.3, 1.5), at(12.3, 3.5), at(60.0, 1.5)], &points);
        assert!((found[0].position - Vec3::new(12.3, 15.2, 0.0)).norm() < 1e-9);
        assert_eq!(found[0].sigma_mm, 1.0);
        assert_eq!(found[1].position.z, 3.5);
        assert!((found[1].sigma_mm - 1.0f64.hypot(3.5)).abs() < 1e-9, "{}", found[1].sigma_mm);
        assert_eq!(found[2], at(60.0, 1.5));
        assert_eq!(onto_surface(&[at(1.0, 1.0)], &[]), [at(1.0, 1.0)]);
    }
}
