//! The distance of the points from the model, for comparing poses.

use crate::math::{Vec3, percentile};
use crate::spatial::PointIndex;

/// Share of the points that counts, the closest ones: hair and wrong matches are farther.
const COUNTED_SHARE: f64 = 0.8;

/// Root mean square distance of the closest 80 % of the points from their closest vertices.
pub(super) fn trimmed_rms(points: &[Vec3], index: &PointIndex<3>) -> f64 {
    let distances: Vec<f64> =
        points.iter().filter_map(|p| index.nearest(&[p.x, p.y, p.z])).map(|n| n.distance).collect();
    let Some(limit) = percentile(&distances, COUNTED_SHARE) else {
        return f64::INFINITY;
    };
    let near: Vec<f64> = distances.into_iter().filter(|d| *d <= limit).collect();
    (near.iter().map(|d| d * d).sum::<f64>() / near.len() as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_farthest_fifth_does_not_count() {
        let vertices: Vec<Vec3> = (0..10).map(|i| Vec3::x() * f64::from(i) * 10.0).collect();
        let index = PointIndex::<3>::new(&vertices).unwrap();
        let off = |i: usize| if i < 8 { 2.0 } else { 500.0 };
        let points: Vec<Vec3> =
            vertices.iter().enumerate().map(|(i, v)| v + Vec3::y() * off(i)).collect();
        // the percentile lies between the ranks, above the eighth distance
        assert!((trimmed_rms(&points, &index) - 2.0).abs() < 1e-12);
        assert_eq!(trimmed_rms(&[], &index), f64::INFINITY);
    }
}
