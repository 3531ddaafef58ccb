//! Matches grow from the seeds.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use super::limits::Limits;
use super::plane::plane_at_origin;
use super::window::HeadWindow;
use crate::math::Vec2;
use crate::observer::Observer;
use crate::spatial::PointIndex;
use crate::stages::correspond::error::CorrespondError;
use crate::stages::correspond::matches::IndexedMatch;

/// Matches between two calls of the observer.
const CHECK_EVERY: usize = 256;
/// Weight of a pixel of residual against a pixel of distance in the cost of a candidate.
const RESIDUAL_WEIGHT: f64 = 3.0;
/// Least weight of a matched neighbour in the plane of disparity, however far it is.
const MIN_WEIGHT: f64 = 1e-6;

/// A left dot with the right dot that would be its match.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    cost: f64,
    left: usize,
    right: usize,
    /// Difference from the predicted position in the right photo, pixels.
    residual: f64,
}

impl PartialEq for Candidate {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Candidate {}
impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Candidate {
    // the heap returns its greatest: lowest cost first, then the order of the dots
    fn cmp(&self, other: &Self) -> Ordering {
        other
            .cost
            .total_cmp(&self.cost)
            .then(other.left.cmp(&self.left))
            .then(other.right.cmp(&self.right))
    }
}

/// The dots of both photos and which of them are matched ("red" in the thesis).
struct Growth<'a> {
    left: &'a [Vec2],
    right: &'a [Vec2],
    left_index: PointIndex<2>,
    right_index: PointIndex<2>,
    /// For each left dot its right dot.
    of_left: Vec<Option<usize>>,
    /// For each right dot its left dot.
    of_right: Vec<Option<usize>>,
    window: &'a HeadWindow,
    limits: &'a Limits,
}

/// Grows matches from the seeds, the candidate of the lowest cost first. After each match the
/// unmatched left dots around it are searched, each by its distance to the nearest matched dot.
pub(super) fn grow(
    left: &[Vec2],
    right: &[Vec2],
    seeds: &[IndexedMatch],
    window: &HeadWindow,
    limits: &Limits,
    observer: &dyn Observer,
) -> Result<Vec<IndexedMatch>, CorrespondError> {
    let no_dots = |photo| CorrespondError::NoDots { photo };
    let mut growth = Growth {
        left,
        right,
        left_index: PointIndex::<2>::new(left).ok_or(no_dots("left"))?,
        right_index: PointIndex::<2>::new(right).ok_or(no_dots("right"))?,
        of_left: vec![None; left.len()],
        of_right: vec![None; right.len()],
        window,
        limits,
    };
    let mut grown: Vec<IndexedMatch> = Vec::new();
    let mut candidates = BinaryHeap::new();
    for seed in seeds {
        growth.pair(seed.left, seed.right);
        grown.push(*seed);
    }
    for seed in seeds {
        growth.push_candidates_around(seed.left, &mut candidates);
    }
    while let Some(candidate) = candidates.pop() {
        if grown.len().is_multiple_of(CHECK_EVERY) {
            observer.check()?;
        }
        if growth.of_left[candidate.left].is_some() {
            continue;
        }
        if growth.of_right[candidate.right].is_some() {
            // matched since: the left dot may still find another
            let other = growth.find_candidate(candidate.left);
            candidates.extend(other.filter(|c| c.cost > candidate.cost));
            continue;
        }
        growth.pair(candidate.left, candidate.right);
        let score = 1.0 - candidate.residual / limits.distance;
        grown.push(IndexedMatch { left: candidate.left, right: candidate.right, score });
        growth.push_candidates_around(candidate.left, &mut candidates);
    }
    Ok(grown)
}

impl Growth<'_> {
    /// Marks two dots as matched.
    fn pair(&mut self, left: usize, right: usize) {
        self.of_left[left] = Some(right);
        self.of_right[right] = Some(left);
    }

    /// Searches the unmatched left dots around a newly matched one.
    fn push_candidates_around(&self, matched: usize, candidates: &mut BinaryHeap<Candidate>) {
        let p = self.left[matched];
        for near in self.left_index.within(&[p.x, p.y], self.limits.reach) {
            if self.of_left[near.index].is_none() && self.window.contains(self.left[near.index]) {
                candidates.extend(self.find_candidate(near.index));
            }
        }
    }

    /// The unmatched right dot that is placed to the matched dots of the right photo as the left dot
    /// is to those of the left photo.
    fn find_candidate(&self, dot: usize) -> Option<Candidate> {
        let p = self.left[dot];
        let matched = self.matched_around(p, dot);
        let nearest = *matched.first()?;
        let correspondent = self.right[self.of_left[nearest.0]?];
        // steps 1 and 2 of the thesis: distance to the nearest matched dot in the left photo
        let distance_left = nearest.1;
        let expected = p.x - self.predicted_disparity(p, &matched);
        let mut best: Option<(f64, usize)> = None;
        let radius = self.limits.distance + self.limits.rows;
        for near in self.right_index.within(&[expected, p.y], radius) {
            let q = self.right[near.index];
            if self.of_right[near.index].is_some() || (q.y - p.y).abs() > self.limits.rows {
                continue;
            }
            // steps 3 and 4: the same distance to the correspondent in the right photo
            let distance_right = (q - correspondent).norm();
            let residual = (q.x - expected).abs();
            if (distance_right - distance_left).abs() < self.limits.distance
                && residual < self.limits.distance
                && best.is_none_or(|b| residual < b.0)
            {
                best = Some((residual, near.index));
            }
        }
        let (residual, right) = best?;
        // few matched neighbours predict less reliably
        let isolation = self.limits.spacing / matched.len() as f64;
        let cost = distance_left + RESIDUAL_WEIGHT * residual + isolation;
        Some(Candidate { cost, left: dot, right, residual })
    }

    /// Matched left dots around a position with their distances, nearest first, without `dot`.
    fn matched_around(&self, p: Vec2, dot: usize) -> Vec<(usize, f64)> {
        let near = self.left_index.within(&[p.x, p.y], self.limits.reach);
        near.iter()
            .filter(|n| n.index != dot && self.of_left[n.index].is_some())
            .map(|n| (n.index, n.distance))
            .collect()
    }

    /// Disparity expected at a position: a plane through the matched dots around it, with weights
    /// that fall with the distance (Gaussian of one spacing).
    fn predicted_disparity(&self, p: Vec2, matched: &[(usize, f64)]) -> f64 {
        let values: Vec<(Vec2, f64, f64)> = matched
            .iter()
            .filter_map(|&(i, distance)| {
                let q = self.right[self.of_left[i]?];
                let weight = (-(distance / self.limits.spacing).powi(2) / 2.0).exp() + MIN_WEIGHT;
                Some((self.left[i] - p, self.left[i].x - q.x, weight))
            })
            .collect();
        plane_at_origin(&values, self.limits.spacing)
    }
}
