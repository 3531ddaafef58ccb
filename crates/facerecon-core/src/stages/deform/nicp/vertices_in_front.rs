//! Matches for vertices in front of the measured surface: the photos would have shown them there.
//!
//! Measured points are matched to the nearest surface, so the crest of a ridge higher than the
//! subject's (a nose) has no match, and its sides would be pressed together. Its vertices are
//! matched to the points instead.

use rayon::prelude::*;

use super::measured_points::MeasuredPoint;
use super::surface_match::SurfaceMatch;
use crate::data::Mesh;
use crate::math::Vec3;
use crate::spatial::PointIndex;

/// Least height of a vertex over its nearest point, mm: lower ones are within the range of the
/// points' own matches.
const MIN_HEIGHT_MM: f64 = 1.0;
/// Greatest offset along the surface relative to the height (a tangent): beyond it, the vertex is
/// beside the point, not in front of it.
const MAX_TANGENT: f64 = 0.35;
/// Least cosine between the normals of vertex and point.
const MIN_COSINE: f64 = 0.5;
/// Weight relative to that of the point's own match. Less than 1, since the vertex may also be
/// in front of something that was not measured.
const WEIGHT: f64 = 0.5;

/// The measured points, searchable by position.
pub(super) struct FrontMatcher<'a> {
    points: &'a [MeasuredPoint],
    index: Option<PointIndex<3>>,
}

impl<'a> FrontMatcher<'a> {
    pub fn new(points: &'a [MeasuredPoint]) -> Self {
        let positions: Vec<_> = points.iter().map(|p| p.position).collect();
        Self { points, index: PointIndex::<3>::new(&positions) }
    }

    /// Matches of the vertices less than `max_height_mm` in front of the points.
    pub fn find(&self, mesh: &Mesh, max_height_mm: f64) -> Vec<SurfaceMatch> {
        let Some(index) = &self.index else { return Vec::new() };
        let normals = mesh.vertex_normals();
        let one = |(v, vertex): (usize, &Vec3)| {
            let nearest = index.nearest(&(*vertex).into())?;
            let point = &self.points[nearest.index];
            let offset = vertex - point.position;
            let height = offset.dot(&point.normal);
            let aside = (offset - point.normal * height).norm();
            let is_in_front = height > MIN_HEIGHT_MM
                && height < max_height_mm
                && aside < MAX_TANGENT * height
                && point.small_component.is_none()
                && point.normal.dot(&normals[v]) > MIN_COSINE;
            is_in_front.then_some(SurfaceMatch {
                data: point.position,
                corners: [v; 3],
                barycentric: [1.0, 0.0, 0.0],
                closest_point: *vertex,
                normal: point.normal,
                weight: WEIGHT * point.weight,
                cell: point.cell,
                small_component: None,
            })
        };
        mesh.vertices.par_iter().enumerate().filter_map(one).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::surface_match::fixtures::sheet;
    use super::*;
    use crate::data::Cloud;

    /// Points of the plane z = 0 with normals toward +z.
    fn points() -> Vec<MeasuredPoint> {
        let mut cloud = Cloud::from_points(sheet(30, 1.0).vertices);
        cloud.normals = vec![Vec3::z(); cloud.points.len()];
        MeasuredPoint::from_cloud(&cloud, 0.1)
    }

    fn sheet_at(z: f64) -> Mesh {
        let mesh = sheet(10, 2.0);
        let lifted = mesh.vertices.iter().map(|p| p + Vec3::new(5.0, 5.0, z)).collect();
        mesh.with_vertices(lifted)
    }

    #[test]
    fn only_vertices_in_front_within_the_height_are_matched() {
        let points = points();
        let matcher = FrontMatcher::new(&points);
        for (z, expected) in [(5.0, 100), (0.9, 0), (-5.0, 0), (12.0, 0)] {
            assert_eq!(matcher.find(&sheet_at(z), 10.0).len(), expected, "{z}");
        }
        let found = matcher.find(&sheet_at(5.0), 10.0);
        assert!(found.iter().all(|m| m.weight == WEIGHT && (m.residual() + 5.0).abs() < 1e-12));
        assert!(FrontMatcher::new(&[]).find(&sheet_at(5.0), 10.0).is_empty());
    }

    #[test]
    fn vertices_beside_the_points_facing_away_or_over_small_components_are_not() {
        let mut points = points();
        let mut beside = sheet_at(5.0);
        beside.vertices.iter_mut().for_each(|v| v.x += 40.0);
        assert!(FrontMatcher::new(&points).find(&beside, 10.0).is_empty());
        let mut turned = sheet_at(5.0);
        turned.faces.iter_mut().for_each(|f| f.swap(1, 2));
        assert!(FrontMatcher::new(&points).find(&turned, 10.0).is_empty());
        points.iter_mut().for_each(|p| p.small_component = Some(0));
        assert!(FrontMatcher::new(&points).find(&sheet_at(5.0), 10.0).is_empty());
    }
}
