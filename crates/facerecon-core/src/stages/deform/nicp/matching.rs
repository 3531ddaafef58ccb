//! Finds the closest point of the surface for each measured point, and the weight of each match.

use rayon::prelude::*;

use super::super::DeformError;
use super::NicpParams;
use super::measured_points::MeasuredPoint;
use super::small_components::drop_stray_components;
use super::surface_match::SurfaceMatch;
use crate::data::{Mesh, MeshError, Topology};
use crate::math::{Vec3, interpolate, mad, median};
use crate::spatial::SurfaceIndex;

/// At this distance from the surface the limit of the angle between the normals is half as wide,
/// mm. Larger values let a wall beside the head pull the cheeks; smaller ones reject the data of a
/// head that differs much from the template.
const HALF_ANGLE_DISTANCE_MM: f64 = 20.0;
/// Matches with a smaller robust weight are left out. Where there is nothing better to oppose them,
/// they would still pull.
const MIN_ROBUST_WEIGHT: f64 = 0.05;
/// Width of the Geman-McClure weights, standard deviations of the neighbourhood.
const WEIGHT_WIDTH: f64 = 2.5;
/// Least standard deviation of a neighbourhood, mm: below it, points agree by chance.
const MIN_SPREAD_MM: f64 = 0.06;
/// Neighbourhoods with fewer matches use the deviation of all matches.
const MIN_NEIGHBOURHOOD: usize = 7;

/// Fewer matches than this do not determine a head's shape: a dot pattern puts some thousand dots
/// on a face, so fewer mean that the stages before have failed.
const MIN_MATCHES: usize = 50;
/// Least local spread that is allowed, and what is added for each mm of stiffness, mm. Lower values
/// ignore the ears in the stiff rounds, higher ones let hair bend the head.
const BASE_SPREAD_MM: f64 = 1.0;
const SPREAD_PER_STIFFNESS: f64 = 0.25;

/// The largest spread within a neighbourhood that a plate of some stiffness can still resolve, mm.
pub(super) fn max_local_spread_mm(stiffness_mm: f64) -> f64 {
    BASE_SPREAD_MM + SPREAD_PER_STIFFNESS * stiffness_mm
}

/// The number of matches, where there are enough.
pub(super) fn require_matches(matches: &[SurfaceMatch]) -> Result<usize, DeformError> {
    let (got, needed) = (matches.len(), MIN_MATCHES);
    if got < needed { Err(DeformError::TooFew { got, needed }) } else { Ok(got) }
}

/// Which matches are admissible.
pub(super) struct MatchLimits {
    /// For each face whether it may be matched: faces at an open border may not.
    admissible: Vec<bool>,
    max_normal_angle_rad: f64,
}

impl MatchLimits {
    pub fn new(mesh: &Mesh, params: &NicpParams) -> Self {
        let rings = Topology::new(mesh).rings_from_border();
        let inside = |v: &u32| rings[*v as usize] as usize >= params.border_rings;
        Self {
            admissible: mesh.faces.iter().map(|f| f.iter().all(inside)).collect(),
            max_normal_angle_rad: params.normal_gate_deg.to_radians(),
        }
    }

    /// Least cosine between the normals of a point and its closest point; stricter with distance.
    /// Beside the head's silhouette the closest surface faces sideways, while what is measured
    /// there faces the camera.
    fn min_cosine(&self, distance_mm: f64) -> f64 {
        (self.max_normal_angle_rad / (1.0 + distance_mm / HALF_ANGLE_DISTANCE_MM)).cos()
    }
}

/// Finds matches on one state of the mesh.
pub(super) struct Matcher<'a> {
    mesh: &'a Mesh,
    limits: &'a MatchLimits,
    index: SurfaceIndex,
    normals: Vec<Vec3>,
}

impl<'a> Matcher<'a> {
    pub fn new(mesh: &'a Mesh, limits: &'a MatchLimits) -> Result<Self, DeformError> {
        mesh.validate()?;
        let index = SurfaceIndex::new(mesh)
            .ok_or(MeshError::Empty { vertices: mesh.vertices.len(), faces: mesh.faces.len() })?;
        Ok(Self { mesh, limits, index, normals: mesh.vertex_normals() })
    }

    /// The admissible matches no farther apart than `max_distance_mm`, weighted, in the order of
    /// the points. Neighbourhoods with a larger spread than `max_local_spread_mm` count little.
    pub fn find(
        &self,
        points: &[MeasuredPoint],
        max_distance_mm: f64,
        max_local_spread_mm: f64,
    ) -> Vec<SurfaceMatch> {
        let found: Vec<Option<SurfaceMatch>> =
            points.par_iter().map(|p| self.closest(p, max_distance_mm)).collect();
        let mut matches: Vec<SurfaceMatch> = found.into_iter().flatten().collect();
        drop_stray_components(&mut matches);
        weight_by_neighbourhood(&mut matches, max_local_spread_mm);
        matches
    }

    fn closest(&self, point: &MeasuredPoint, max_distance_mm: f64) -> Option<SurfaceMatch> {
        let closest = self.index.closest_within(&point.position, max_distance_mm)?;
        if !self.limits.admissible[closest.face] {
            return None;
        }
        let corners = self.mesh.faces[closest.face].map(|v| v as usize);
        let normal = interpolate(corners.map(|v| self.normals[v]), closest.barycentric);
        let normal = normal.try_normalize(1e-12)?;
        let min_cosine = self.limits.min_cosine(closest.distance);
        if point.normal != Vec3::zeros() && point.normal.dot(&normal) < min_cosine {
            return None;
        }
        Some(SurfaceMatch {
            data: point.position,
            corners,
            barycentric: closest.barycentric,
            closest_point: closest.point,
            normal,
            weight: point.weight,
            cell: point.cell,
            small_component: point.small_component,
        })
    }
}

/// Multiplies the weights by Geman-McClure weights about the median residual of each point's
/// neighbourhood, and drops the matches that hardly count. A point that disagrees with its
/// neighbours is an outlier; a region that disagrees with the surface must move it. A region with a
/// larger spread than `max_local_spread_mm` (ears, hair) does not measure this surface yet, and
/// counts little.
fn weight_by_neighbourhood(matches: &mut Vec<SurfaceMatch>, max_local_spread_mm: f64) {
    let cells = matches.iter().map(|m| m.cell as usize + 1).max().unwrap_or(0);
    let mut residuals = vec![Vec::new(); cells];
    matches.iter().for_each(|m| residuals[m.cell as usize].push(m.residual()));
    let all: Vec<f64> = matches.iter().map(SurfaceMatch::residual).collect();
    let overall_spread = mad(&all).unwrap_or_default();
    let local: Vec<(f64, f64)> = residuals
        .iter()
        .map(|list| match (median(list), mad(list)) {
            (Some(centre), Some(spread)) if list.len() >= MIN_NEIGHBOURHOOD => (centre, spread),
            _ => (0.0, overall_spread),
        })
        .collect();
    matches.retain_mut(|m| {
        let (centre, spread) = local[m.cell as usize];
        let width = WEIGHT_WIDTH * spread.max(MIN_SPREAD_MM);
        let of_region = (1.0 + (spread / max_local_spread_mm).powi(2)).powi(-2);
        let robust = of_region * (1.0 + ((m.residual() - centre) / width).powi(2)).powi(-2);
        m.weight *= robust;
        robust > MIN_ROBUST_WEIGHT
    });
}

#[cfg(test)]
mod tests {
    use super::super::measured_points::thin_over_list;
    use super::super::surface_match::fixtures::sheet;
    use super::*;
    use crate::data::Cloud;

    /// Points 0.5 mm above the vertices of a sheet, with noise up to `noise_mm`.
    fn points_above(mesh: &Mesh, noise_mm: f64) -> Vec<MeasuredPoint> {
        let noise = |i: usize| noise_mm * (i as f64 * 12.9898).sin();
        let lifted = |(i, p): (usize, &Vec3)| p + Vec3::new(0.1, 0.1, 0.5 + noise(i));
        let cloud = Cloud::from_points(mesh.vertices.iter().enumerate().map(lifted).collect());
        thin_over_list(&MeasuredPoint::from_cloud(&cloud, 0.1), 100_000)
    }

    fn find(points: &[MeasuredPoint], params: &NicpParams) -> Vec<SurfaceMatch> {
        let mesh = sheet(30, 1.0);
        let limits = MatchLimits::new(&mesh, params);
        Matcher::new(&mesh, &limits).unwrap().find(points, 10.0, 1.0)
    }

    #[test]
    fn points_at_an_open_border_or_with_another_normal_are_not_matched() {
        let mesh = sheet(30, 1.0);
        let mut points = points_above(&mesh, 0.02);
        let params = NicpParams::default();
        let matches = find(&points, &params);
        assert!(matches.iter().all(|m| m.corners.iter().all(|&v| {
            let p = mesh.vertices[v];
            (3.0..=26.0).contains(&p.x) && (3.0..=26.0).contains(&p.y)
        })));
        assert!(matches.len() > 400, "{}", matches.len());
        assert!(find(&points, &NicpParams { border_rings: 0, ..params.clone() }).len() > 800);

        let tilt = |degrees: f64| {
            let t = degrees.to_radians();
            Vec3::new(t.sin(), 0.0, t.cos())
        };
        points.iter_mut().for_each(|p| p.normal = tilt(50.0));
        assert_eq!(find(&points, &params).len(), matches.len());
        points.iter_mut().for_each(|p| p.normal = tilt(62.0));
        assert!(find(&points, &params).is_empty());
        // at 20 mm the limit is half as wide
        let limits = MatchLimits::new(&mesh, &params);
        assert!((limits.min_cosine(20.0) - 30f64.to_radians().cos()).abs() < 1e-12);
    }

    #[test]
    fn an_outlier_is_dropped_and_a_displaced_region_is_not() {
        let mesh = sheet(30, 1.0);
        let mut points = points_above(&mesh, 0.02);
        let inside = 15 * 30 + 15;
        points[inside].position.z += 4.0;
        let matches = find(&points, &NicpParams::default());
        let at = |p: &Vec3| matches.iter().find(|m| m.data == *p);
        assert!(at(&points[inside].position).is_none());
        // all others lie 0.5 mm above the surface, which is no reason to drop them
        assert!(at(&points[inside + 1].position).unwrap().weight > 0.5);
    }

    #[test]
    fn a_region_without_agreement_counts_little() {
        let mesh = sheet(30, 1.0);
        let weight = |noise_mm: f64| {
            let matches = find(&points_above(&mesh, noise_mm), &NicpParams::default());
            matches.iter().map(|m| m.weight).sum::<f64>() / matches.len().max(1) as f64
        };
        let (firm, loose) = (weight(0.02), weight(1.5));
        assert!(firm > 0.9 && loose < 0.6, "{firm} {loose}");
    }
}
