//! One data point for each vertex: the elimination of multiple matches (thesis section 3.2).

use rayon::prelude::*;

use super::PointIndex;
use crate::math::Vec3;

/// Matches every point to its closest vertex (Eq. 3.1) and averages the points that share one, so
/// that each vertex keeps a single data point: `(vertex, mean of its points)`, by vertex number.
/// Pairs farther apart than `max_distance` are left out. Empty without vertices, or when a vertex
/// is not finite; points that are not finite are left out.
///
/// ```
/// use facerecon_core::{math::Vec3, spatial::eliminate_multiple};
/// let vertices = [Vec3::zeros(), Vec3::x() * 10.0];
/// let points = [Vec3::x() * 9.0, Vec3::x() * 12.0];
/// let assignments = eliminate_multiple(&points, &vertices, None);
/// assert_eq!(assignments, [(1, Vec3::x() * 10.5)]);
/// ```
pub fn eliminate_multiple(
    points: &[Vec3],
    vertices: &[Vec3],
    max_distance: Option<f64>,
) -> Vec<(usize, Vec3)> {
    let Some(index) = PointIndex::<3>::new(vertices) else {
        return Vec::new();
    };
    let limit = max_distance.unwrap_or(f64::INFINITY);
    let mut pairs: Vec<(usize, usize)> = points
        .par_iter()
        .enumerate()
        .filter_map(|(i, p)| {
            let found = index.nearest(&[p.x, p.y, p.z])?;
            (found.distance <= limit).then_some((found.index, i))
        })
        .collect();
    pairs.sort_unstable();
    pairs
        .chunk_by(|a, b| a.0 == b.0)
        .map(|group| {
            let sum: Vec3 = group.iter().map(|&(_, i)| points[i]).sum();
            (group[0].0, sum / group.len() as f64)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_of_one_vertex_are_averaged() {
        let vertices = [Vec3::zeros(), Vec3::new(10.0, 0.0, 0.0), Vec3::new(0.0, 10.0, 0.0)];
        let points = [
            Vec3::new(9.0, 1.0, 0.0),
            Vec3::new(1.0, 0.0, 0.0),
            Vec3::new(11.0, 0.0, 3.0),
            Vec3::new(0.0, 90.0, 0.0),
        ];
        let all = eliminate_multiple(&points, &vertices, None);
        assert_eq!(all, vec![(0, points[1]), (1, Vec3::new(10.0, 0.5, 1.5)), (2, points[3])]);
        assert_eq!(eliminate_multiple(&points, &vertices, Some(20.0)).len(), 2);
        assert!(eliminate_multiple(&points, &[], None).is_empty());
    }
}
