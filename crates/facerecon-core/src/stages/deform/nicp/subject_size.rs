//! The template in the subject's size, before it bends.

use super::super::DeformError;
use super::NicpParams;
use super::matching::{MatchLimits, Matcher, max_local_spread_mm, require_matches};
use super::measured_points::{MeasuredPoint, thin_over_list};
use super::surface_match::plane_pairs;
use crate::data::Mesh;
use crate::math::{Similarity, fit_to_planes};
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

/// Scales and moves the template to the data: point-to-plane ICP with scale, from data to template,
/// then inverted so that the data stay where they are.
pub(super) fn match_size(
    template: &Mesh,
    points: &[MeasuredPoint],
    limits: &MatchLimits,
    params: &NicpParams,
) -> Result<Mesh, DeformError> {
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
            let step = fit_to_planes(&plane_pairs(iteration.pairs), POINT_WEIGHT, true);
            let next = step.map(|step| step.compose(iteration.pose));
            let plausible = next.filter(|pose| SCALE_RANGE.contains(&pose.scale));
            Ok(plausible.map(|pose| IcpStep { pose, pairs: None, converged: false }))
        },
    );
    let data_from_template = found?.pose.inverse();
    Ok(template.transformed(&data_from_template))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::Cloud;
    use crate::template::head;

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

    fn height(mesh: &Mesh) -> f64 {
        mesh.bounds().map_or(0.0, |(low, high)| high.y - low.y)
    }

    #[test]
    fn the_head_takes_the_size_of_the_data() {
        let template = head().mesh;
        let params = NicpParams::default();
        let limits = MatchLimits::new(&template, &params);
        for scale in [0.93, 1.06] {
            let sized = match_size(&template, &scaled_front(scale), &limits, &params).unwrap();
            let found = height(&sized) / height(&template);
            assert!((found - scale).abs() < 0.02, "{scale}: {found}");
        }
    }

    #[test]
    fn too_few_matches_are_refused() {
        let template = head().mesh;
        let params = NicpParams::default();
        let limits = MatchLimits::new(&template, &params);
        let few = scaled_front(1.0)[..30].to_vec();
        let error = match_size(&template, &few, &limits, &params).unwrap_err();
        assert!(matches!(error, DeformError::TooFew { needed: 50, .. }), "{error}");
    }
}
