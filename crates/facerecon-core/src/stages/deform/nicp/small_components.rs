//! Small connected components of the data: an ear's edge, a collar, the wall beside a cheek.
//!
//! No surrounding points confirm them, so they count only where they agree with the head as the
//! large components have bent it.

use std::collections::BTreeMap;

use super::measured_points::{MeasuredPoint, cell_size, grid_key};
use super::surface_match::SurfaceMatch;
use crate::math::median;

/// Points of a grid cell, on average; cells that touch belong to one component.
const POINTS_PER_CELL: f64 = 4.0;
/// Components with a smaller share of all points are small. The skin of a face is one
/// large component; smaller parts of it are still large enough at this share.
pub(super) const SMALL_SHARE: f64 = 0.1;
/// The same where the outline has shown that all points are the subject's: the neck below the chin
/// counts, the edge of an ear does not.
pub(super) const SMALL_SHARE_OF_SUBJECT: f64 = 0.02;
/// A small component is dropped when the median distance of its points from the surface is larger
/// than this, mm: more than the head is still wrong by after the stiff rounds.
const MAX_MEDIAN_DISTANCE_MM: f64 = 4.0;

/// Numbers the small components and labels their points.
pub(super) fn label_small_components(points: &mut [MeasuredPoint], small_share: f64) {
    let cell = cell_size(points, POINTS_PER_CELL);
    let mut members: BTreeMap<[i64; 3], Vec<usize>> = BTreeMap::new();
    for (i, p) in points.iter().enumerate() {
        members.entry(grid_key(&p.position, cell)).or_default().push(i);
    }
    let small = (small_share * points.len() as f64) as usize;
    let mut number = 0;
    while let Some((start, first)) = members.pop_first() {
        let component = flood(start, first, &mut members);
        if component.len() < small {
            component.iter().for_each(|&i| points[i].small_component = Some(number));
            number += 1;
        }
    }
}

/// The points of the cells connected to the first one; their cells are removed from `members`.
fn flood(
    start: [i64; 3],
    first: Vec<usize>,
    members: &mut BTreeMap<[i64; 3], Vec<usize>>,
) -> Vec<usize> {
    let mut open = vec![start];
    let mut component = first;
    while let Some([x, y, z]) = open.pop() {
        for step in 0..27 {
            let near = [x + step % 3 - 1, y + step / 3 % 3 - 1, z + step / 9 - 1];
            if let Some(more) = members.remove(&near) {
                component.extend(more);
                open.push(near);
            }
        }
    }
    component
}

/// Drops the matches of small components that lie far from the surface.
pub(super) fn drop_stray_components(matches: &mut Vec<SurfaceMatch>) {
    let mut distances: BTreeMap<u32, Vec<f64>> = BTreeMap::new();
    for m in matches.iter() {
        if let Some(component) = m.small_component {
            distances.entry(component).or_default().push((m.data - m.closest_point).norm());
        }
    }
    let is_stray = |list: &Vec<f64>| median(list).is_none_or(|d| d > MAX_MEDIAN_DISTANCE_MM);
    distances.retain(|_, list| is_stray(list));
    matches.retain(|m| m.small_component.is_none_or(|c| !distances.contains_key(&c)));
}

#[cfg(test)]
mod tests {
    use super::super::surface_match::fixtures::{match_at, sheet};
    use super::*;
    use crate::data::Cloud;
    use crate::math::Vec3;

    /// A large sheet and two small ones, 20 mm apart from it and from each other.
    fn three_sheets() -> Vec<MeasuredPoint> {
        let mut positions = sheet(30, 1.0).vertices;
        for x in [50.0, 80.0] {
            positions.extend(sheet(6, 1.0).vertices.iter().map(|p| p + Vec3::x() * x));
        }
        MeasuredPoint::from_cloud(&Cloud::from_points(positions), 0.1)
    }

    #[test]
    fn only_small_components_are_labelled() {
        let mut points = three_sheets();
        label_small_components(&mut points, SMALL_SHARE);
        assert!(points[..900].iter().all(|p| p.small_component.is_none()));
        let labels = [&points[900..936], &points[936..]]
            .map(|sheet| sheet.iter().map(|p| p.small_component).collect::<Vec<_>>());
        assert!(labels.iter().all(|l| l[0].is_some() && l.iter().all(|c| *c == l[0])));
        assert_ne!(labels[0][0], labels[1][0]);
        label_small_components(&mut [], SMALL_SHARE);
    }

    #[test]
    fn a_small_component_far_from_the_surface_is_dropped_as_a_whole() {
        let mesh = sheet(10, 1.0);
        let mut matches: Vec<SurfaceMatch> =
            (0..100).map(|v| match_at(&mesh, v, mesh.vertices[v] + Vec3::z() * 9.0)).collect();
        // of the two small components, one is near the surface
        for m in &mut matches[..10] {
            m.small_component = Some(0);
        }
        for m in &mut matches[10..20] {
            (m.small_component, m.data.z) = (Some(1), 1.0);
        }
        matches[10].data.z = 30.0;
        drop_stray_components(&mut matches);
        assert_eq!(matches.len(), 90);
        assert_eq!(matches.iter().filter(|m| m.small_component == Some(1)).count(), 10);
        assert!(matches.iter().all(|m| m.small_component != Some(0)));
    }
}
