//! The template in the subject's size, before it bends.

use super::super::{DeformError, LandmarkTarget};
use super::NicpParams;
use super::matching::{MatchLimits, Matcher, max_local_spread_mm, require_matches};
use super::measured_points::{MeasuredPoint, thin_over_list};
use super::surface_match::plane_pairs;
use crate::data::Mesh;
use crate::math::{PlanePair, Similarity, Vec3, fit_to_planes, median};
use crate::spatial::{IcpStep, iterate_closest_points};

/// Number of steps: the bending corrects what they leave.
const MAX_STEPS: usize = 12;
/// Points used: enough for the seven unknowns of a similarity.
const MAX_POINTS: usize = 1500;
/// Weight of the distance to the closest point relative to that to its plane.
const POINT_WEIGHT: f64 = 0.02;
/// Scales of the template relative to the data: those of small children's heads and of the largest
/// adult ones, and no others.
const SCALE_RANGE: std::ops::Range<f64> = 0.7..1.4;
/// One coordinate of a landmark weighs as much as this share of all points: the differences
/// between the shapes of two heads are alike over some centimetres, so that all points are worth
/// some forty independent ones.
const LANDMARK_SHARE: f64 = 1.0 / 40.0;
/// Standard deviation of a landmark's position on a head of the same size, mm.
const SHAPE_SIGMA_MM: f64 = 3.0;
/// Width of the Geman-McClure weights of landmarks, median distances, and at least mm.
const LANDMARK_WIDTH: f64 = 2.5;
const MIN_LANDMARK_WIDTH_MM: f64 = 10.0;

/// The motion and scale of the template to the data: point-to-plane ICP with scale, from data to
/// template, then inverted so that the data stay where they are. Landmarks are pairs of points.
pub(super) fn match_size(
    template: &Mesh,
    points: &[MeasuredPoint],
    landmarks: &[LandmarkTarget],
    limits: &MatchLimits,
    params: &NicpParams,
) -> Result<Similarity, DeformError> {
    let matcher = Matcher::new(template, limits)?;
    let few = thin_over_list(points, MAX_POINTS);
    let max_spread_mm = max_local_spread_mm(params.reach_mm);
    let find_matches = |pose: &Similarity| {
        let moved: Vec<MeasuredPoint> = few.iter().map(|p| p.transformed(pose)).collect();
        matcher.find(&moved, params.reach_mm, max_spread_mm)
    };
    let start = Similarity::identity();
    let found = iterate_closest_points(
        start,
        MAX_STEPS,
        find_matches,
        |iteration| -> Result<_, DeformError> {
            require_matches(iteration.pairs)?;
            let mut pairs = plane_pairs(iteration.pairs);
            pairs.extend(landmark_pairs(template, landmarks, iteration.pose, &pairs));
            let step = fit_to_planes(&pairs, POINT_WEIGHT, true);
            let next = step.map(|step| step.compose(iteration.pose));
            let plausible = next.filter(|pose| SCALE_RANGE.contains(&pose.scale));
            Ok(plausible.map(|pose| IcpStep { pose, pairs: None, converged: false }))
        },
    );
    Ok(found?.pose.inverse())
}

/// Each landmark as three planes through its vertex, weighted against the pairs of the points.
fn landmark_pairs(
    template: &Mesh,
    landmarks: &[LandmarkTarget],
    template_from_data: &Similarity,
    pairs: &[PlanePair],
) -> Vec<PlanePair> {
    let total: f64 = pairs.iter().map(|p| p.weight).sum();
    let moved: Vec<(Vec3, Vec3)> = landmarks
        .iter()
        .map(|l| (template_from_data.apply(&l.position), template.vertices[l.vertex]))
        .collect();
    let distances: Vec<f64> = moved.iter().map(|(p, q)| (p - q).norm()).collect();
    let typical = median(&distances).unwrap_or_default();
    let width = (LANDMARK_WIDTH * typical).max(MIN_LANDMARK_WIDTH_MM);
    let of_landmark = |((l, &(point, vertex)), distance): ((&LandmarkTarget, _), &f64)| {
        let variance = 1.0 + (l.sigma_mm / SHAPE_SIGMA_MM).powi(2);
        let robust = (1.0 + (distance / width).powi(2)).powi(-2);
        let weight = LANDMARK_SHARE * total * robust / variance;
        [Vec3::x(), Vec3::y(), Vec3::z()].map(|normal| PlanePair {
            point,
            closest_point: vertex,
            normal,
            weight,
        })
    };
    landmarks.iter().zip(&moved).zip(&distances).flat_map(of_landmark).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::Cloud;
    use crate::template::head;
    use nalgebra::Rotation3;

    /// The front of the built-in head, scaled.
    fn scaled_front(scale: f64) -> Vec<MeasuredPoint> {
        let mesh = head().mesh;
        let normals = mesh.vertex_normals();
        let mut cloud = Cloud::default();
        for (p, n) in mesh.vertices.iter().zip(&normals).filter(|(p, n)| n.z > 0.3 && p.z > 0.0) {
            cloud.points.push(p * scale);
            cloud.normals.push(*n);
        }
        MeasuredPoint::from_cloud(&cloud, 0.2)
    }

    #[test]
    fn the_head_takes_the_size_of_the_data() {
        let template = head().mesh;
        let params = NicpParams::default();
        let limits = MatchLimits::new(&template, &params);
        for scale in [0.93, 1.06] {
            let found = match_size(&template, &scaled_front(scale), &[], &limits, &params).unwrap();
            assert!((found.scale - scale).abs() < 0.02, "{scale}: {}", found.scale);
        }
    }

    #[test]
    fn landmarks_correct_what_a_turned_registration_left() {
        let head = head();
        let turned = Similarity::rigid(
            Rotation3::from_euler_angles(0.1, 0.0, 0.15).into_inner(),
            Vec3::y() * 9.0,
        );
        let points: Vec<_> = scaled_front(1.0).iter().map(|p| p.transformed(&turned)).collect();
        let landmarks: Vec<LandmarkTarget> = head
            .landmarks
            .values()
            .map(|&vertex| LandmarkTarget {
                vertex,
                position: turned.apply(&head.mesh.vertices[vertex]),
                sigma_mm: 1.0,
            })
            .collect();
        let params = NicpParams::default();
        let limits = MatchLimits::new(&head.mesh, &params);
        let found = match_size(&head.mesh, &points, &landmarks, &limits, &params).unwrap();
        for l in &landmarks {
            let off = (found.apply(&head.mesh.vertices[l.vertex]) - l.position).norm();
            assert!(off < 0.3, "{off}");
        }
    }

    #[test]
    fn too_few_matches_are_refused() {
        let template = head().mesh;
        let params = NicpParams::default();
        let limits = MatchLimits::new(&template, &params);
        let few = scaled_front(1.0)[..30].to_vec();
        let error = match_size(&template, &few, &[], &limits, &params).unwrap_err();
        assert!(matches!(error, DeformError::TooFew { needed: 50, .. }), "{error}");
    }
}
