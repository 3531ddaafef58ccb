//! Which of the grown matches are consistent with each other.

use super::limits::Limits;
use super::plane::plane_at_origin;
use crate::math::Vec2;
use crate::spatial::{Neighbour, PointIndex};
use crate::stages::correspond::matches::IndexedMatch;

/// Greatest deviation from the plane through the neighbouring matches, in distance thresholds.
const MAX_DEVIATION: f64 = 0.6;
/// Radius of the neighbourhood of that plane, in spacings: holds two rings of lattice neighbours.
const PLANE_RADIUS: f64 = 2.3;
/// Fewest neighbours that define that plane.
const MIN_NEIGHBOURS: usize = 3;
/// Greatest change of disparity between linked matches, pixels per pixel: a surface turned by about
/// 70 degrees for cameras half a metre apart at two metres.
const MAX_SLOPE: f64 = 0.2;
/// Added to that change, pixels: positions may be rounded to whole pixels.
const ROUNDING_PX: f64 = 1.0;
/// Greatest distance of linked matches, in spacings: holds the diagonal lattice neighbours.
const LINK_RADIUS: f64 = 1.6;

/// Keeps the matches that are on the plane of their neighbours and are linked to a seed (the first
/// `seeds` of the list) from neighbour to neighbour without a step of disparity. A step is the
/// silhouette of the head against the background, or a match that is one dot off.
pub(super) fn keep_consistent(
    grown: Vec<IndexedMatch>,
    seeds: usize,
    left: &[Vec2],
    right: &[Vec2],
    limits: &Limits,
) -> Vec<IndexedMatch> {
    let positions: Vec<Vec2> = grown.iter().map(|m| left[m.left]).collect();
    let disparities: Vec<f64> = grown.iter().map(|m| left[m.left].x - right[m.right].x).collect();
    let Some(index) = PointIndex::<2>::new(&positions) else {
        return Vec::new();
    };
    let around = |i: usize, spacings: f64| {
        let p = positions[i];
        let near = index.within(&[p.x, p.y], spacings * limits.spacing);
        near.into_iter().filter(move |n| n.index != i)
    };
    let on_plane = |i: usize| {
        let others: Vec<(Vec2, f64, f64)> = around(i, PLANE_RADIUS)
            .map(|n| (positions[n.index] - positions[i], disparities[n.index], 1.0))
            .collect();
        let expected = plane_at_origin(&others, limits.spacing);
        others.len() >= MIN_NEIGHBOURS
            && (disparities[i] - expected).abs() < MAX_DEVIATION * limits.distance
    };
    let accepted: Vec<bool> = (0..grown.len()).map(|i| i < seeds || on_plane(i)).collect();
    let smooth = |i: usize, n: &Neighbour| {
        let step = (disparities[i] - disparities[n.index]).abs();
        step <= MAX_SLOPE * n.distance + ROUNDING_PX
    };

    let mut linked = vec![false; grown.len()];
    let mut open: Vec<usize> = (0..seeds.min(grown.len())).collect();
    open.iter().for_each(|i| linked[*i] = true);
    while let Some(i) = open.pop() {
        for near in around(i, LINK_RADIUS) {
            let j = near.index;
            if accepted[j] && !linked[j] && smooth(i, &near) {
                linked[j] = true;
                open.push(j);
            }
        }
    }
    grown.into_iter().zip(linked).filter(|(_, linked)| *linked).map(|(m, _)| m).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: Limits =
        Limits { rows: 2.0, distance: 4.0, reach: 25.0, seed: 6.0, spacing: 10.0 };

    /// The matches kept from a lattice of 12 x 12 dots with the given disparities.
    fn kept(disparity: impl Fn(usize, usize) -> f64) -> Vec<usize> {
        let position = |i: usize| Vec2::new((10 * (i % 12)) as f64, (10 * (i / 12)) as f64);
        let left: Vec<Vec2> = (0..144).map(position).collect();
        let right: Vec<Vec2> =
            (0..144).map(|i| left[i] - Vec2::new(disparity(i % 12, i / 12), 0.0)).collect();
        let grown = (0..144).map(|i| IndexedMatch { left: i, right: i, score: 1.0 }).collect();
        keep_consistent(grown, 1, &left, &right, &LIMITS).iter().map(|m| m.left).collect()
    }

    #[test]
    fn a_slope_is_kept_and_a_wall_beyond_a_step_is_dropped() {
        assert_eq!(kept(|x, _| 2.0 * x as f64).len(), 144);
        let face = kept(|x, _| if x < 7 { 30.0 } else { 10.0 });
        assert!(face.iter().all(|i| i % 12 < 7), "{face:?}");
        // the two columns beside the step have the wall in their planes
        assert!(face.len() >= 5 * 12, "{}", face.len());
    }

    #[test]
    fn a_match_that_is_one_dot_off_is_dropped() {
        let found = kept(|x, y| if (x, y) == (5, 6) { 40.0 } else { 30.0 });
        assert!(!found.contains(&(6 * 12 + 5)) && found.len() == 143, "{}", found.len());
    }
}
