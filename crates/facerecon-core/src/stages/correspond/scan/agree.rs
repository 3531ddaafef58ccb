//! What of the grown matches hangs together.

use super::plane::plane_at_origin;
use super::{Limits, Marked};
use crate::math::Vec2;
use crate::spatial::PointIndex;

/// Greatest departure from the plane through the matches around, in distance thresholds.
const TREND: f64 = 0.6;
/// Greatest change of disparity from dot to dot, pixels a pixel: a surface turned by about 70
/// degrees for cameras half an arm apart at two metres.
const SLOPE: f64 = 0.2;
/// Neighbours linked to each other, in spacings.
const LINK: f64 = 1.6;

/// The matches that keep to the trend of those around them and are linked to a marked pair (the
/// first `marks` of the list) from neighbour to neighbour without a step of disparity. Steps are the
/// border of the head against what is behind it, or a match that is one dot off.
pub(super) fn agreeing(
    grown: Vec<Marked>,
    marks: usize,
    left: &[Vec2],
    right: &[Vec2],
    limits: &Limits,
) -> Vec<Marked> {
    let places: Vec<Vec2> = grown.iter().map(|m| left[m.left]).collect();
    let disparities: Vec<f64> = grown.iter().map(|m| left[m.left].x - right[m.right].x).collect();
    let Some(index) = PointIndex::<2>::new(&places) else {
        return Vec::new();
    };
    let around = |i: usize, spacings: f64| {
        let p = places[i];
        let near = index.within(&[p.x, p.y], spacings * limits.spacing);
        near.into_iter().filter(move |n| n.index != i)
    };
    let keeps = |i: usize| {
        let others: Vec<(Vec2, f64, f64)> = around(i, 2.3)
            .map(|n| (places[n.index] - places[i], disparities[n.index], 1.0))
            .collect();
        let trend = plane_at_origin(&others, limits.spacing);
        others.len() >= 3 && (disparities[i] - trend).abs() < TREND * limits.distance
    };
    let keeping: Vec<bool> = (0..grown.len()).map(|i| i < marks || keeps(i)).collect();

    let mut linked = vec![false; grown.len()];
    let mut open: Vec<usize> = (0..marks.min(grown.len())).collect();
    open.iter().for_each(|i| linked[*i] = true);
    while let Some(i) = open.pop() {
        for near in around(i, LINK) {
            let j = near.index;
            // rounded positions may differ by a pixel more
            let step = (disparities[i] - disparities[j]).abs();
            if keeping[j] && !linked[j] && step <= SLOPE * near.distance + 1.0 {
                linked[j] = true;
                open.push(j);
            }
        }
    }
    grown.into_iter().zip(linked).filter(|(_, linked)| *linked).map(|(m, _)| m).collect()
}
