//! Enlarging a smoothed mesh to compensate its shrinkage (thesis section 6.5.2).

use crate::math::{Vec3, percentile};
use crate::spatial::PointIndex;

/// Fraction of the vertices left out at either end of an axis: an outlier at the border that
/// smoothing has removed is not shrinkage. Set by hand.
const TRIMMED: f64 = 0.02;
/// Relative extent below which an axis has no scale to restore.
const MIN_EXTENT: f64 = 1e-9;

/// Scales and shifts each axis so that the vertices nearest to the reference points have the bounds
/// they had before; returns the vertices and the factors. Without reference points all vertices
/// count.
pub(super) fn restore_bounds(
    before: &[Vec3],
    after: Vec<Vec3>,
    reference: &[Vec3],
) -> (Vec<Vec3>, Vec3) {
    let mut chosen: Vec<usize> = match PointIndex::<3>::new(before) {
        Some(index) if !reference.is_empty() => reference
            .iter()
            .filter_map(|p| index.nearest(&[p.x, p.y, p.z]))
            .map(|n| n.index)
            .collect(),
        _ => (0..before.len()).collect(),
    };
    chosen.sort_unstable();
    chosen.dedup();
    let (mut factor, mut shift) = (Vec3::repeat(1.0), Vec3::zeros());
    for axis in 0..3 {
        let (old, new) = (bounds(before, &chosen, axis), bounds(&after, &chosen, axis));
        let (Some((low, high)), Some((new_low, new_high))) = (old, new) else {
            continue;
        };
        let (extent, new_extent) = (high - low, new_high - new_low);
        if new_extent > MIN_EXTENT * extent.abs() && extent > 0.0 {
            factor[axis] = extent / new_extent;
            shift[axis] = low - new_low * factor[axis];
        }
    }
    (after.iter().map(|v| v.component_mul(&factor) + shift).collect(), factor)
}

fn bounds(vertices: &[Vec3], chosen: &[usize], axis: usize) -> Option<(f64, f64)> {
    let values: Vec<f64> = chosen.iter().map(|&i| vertices[i][axis]).collect();
    Some((percentile(&values, TRIMMED)?, percentile(&values, 1.0 - TRIMMED)?))
}

/// Scales about the middle of the mesh.
pub(super) fn by_factors(vertices: Vec<Vec3>, factors: Vec3) -> Vec<Vec3> {
    if factors == Vec3::repeat(1.0) || vertices.is_empty() {
        return vertices;
    }
    let first = vertices[0];
    let (low, high) = vertices.iter().fold((first, first), |(lo, hi), p| (lo.inf(p), hi.sup(p)));
    let middle = (low + high) / 2.0;
    vertices.iter().map(|v| middle + (v - middle).component_mul(&factors)).collect()
}
