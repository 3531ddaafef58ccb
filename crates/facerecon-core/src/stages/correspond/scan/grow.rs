//! Growing from the marked pairs.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use super::plane::plane_at_origin;
use super::seeds::Window;
use super::{CorrespondError, Limits, Marked};
use crate::math::Vec2;
use crate::observer::{Cancelled, Observer};
use crate::spatial::PointIndex;

/// A left dot that waits for its turn, with the dot of the right photo that would be its match.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    cost: f64,
    left: usize,
    right: usize,
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
    // the heap gives its greatest: cheapest first, then the dots' order
    fn cmp(&self, other: &Self) -> Ordering {
        other
            .cost
            .total_cmp(&self.cost)
            .then(other.left.cmp(&self.left))
            .then(other.right.cmp(&self.right))
    }
}

/// The photos' dots and which of them are marked ("red" in the thesis).
struct Scan<'a> {
    left: &'a [Vec2],
    right: &'a [Vec2],
    left_index: PointIndex<2>,
    right_index: PointIndex<2>,
    /// For each left dot its marked correspondent.
    of_left: Vec<Option<usize>>,
    /// For each right dot its marked correspondent.
    of_right: Vec<Option<usize>>,
    window: &'a Window,
    limits: &'a Limits,
}

/// Grows the marked pairs over both photos, the best candidate first: after each pair is marked, the
/// left photo offers the white dots around it, and the right photo answers with the dot at the same
/// distance from the marked correspondent.
pub(super) fn grow(
    left: &[Vec2],
    right: &[Vec2],
    seeds: &[Marked],
    window: &Window,
    limits: &Limits,
    observer: &dyn Observer,
) -> Result<Vec<Marked>, CorrespondError> {
    let no_dots = |photo| CorrespondError::NoDots { photo };
    let mut scan = Scan {
        left,
        right,
        left_index: PointIndex::<2>::new(left).ok_or(no_dots("left"))?,
        right_index: PointIndex::<2>::new(right).ok_or(no_dots("right"))?,
        of_left: vec![None; left.len()],
        of_right: vec![None; right.len()],
        window,
        limits,
    };
    let mut grown: Vec<Marked> = Vec::new();
    let mut waiting = BinaryHeap::new();
    for seed in seeds {
        scan.of_left[seed.left] = Some(seed.right);
        scan.of_right[seed.right] = Some(seed.left);
        grown.push(*seed);
    }
    for seed in seeds {
        scan.offer_around(seed.left, &mut waiting);
    }
    while let Some(candidate) = waiting.pop() {
        if grown.len().is_multiple_of(256) && observer.cancelled() {
            return Err(Cancelled.into());
        }
        if scan.of_left[candidate.left].is_some() {
            continue;
        }
        if scan.of_right[candidate.right].is_some() {
            // taken meanwhile: the left dot may still find another
            waiting.extend(scan.search(candidate.left).filter(|c| c.cost > candidate.cost));
            continue;
        }
        scan.of_left[candidate.left] = Some(candidate.right);
        scan.of_right[candidate.right] = Some(candidate.left);
        let score = 1.0 - candidate.residual / limits.distance;
        grown.push(Marked { left: candidate.left, right: candidate.right, score });
        scan.offer_around(candidate.left, &mut waiting);
    }
    Ok(grown)
}

impl Scan<'_> {
    /// Offers the white left dots around a newly marked one.
    fn offer_around(&self, marked: usize, waiting: &mut BinaryHeap<Candidate>) {
        let p = self.left[marked];
        for near in self.left_index.within(&[p.x, p.y], self.limits.reach) {
            if self.of_left[near.index].is_none() && self.window.holds(self.left[near.index]) {
                waiting.extend(self.search(near.index));
            }
        }
    }

    /// The turn of the right photo: the white dot there that stands to the marked dots as the left
    /// dot does to theirs.
    fn search(&self, dot: usize) -> Option<Candidate> {
        let p = self.left[dot];
        let marked = self.marked_around(p, dot);
        let nearest = *marked.first()?;
        let correspondent = self.right[self.of_left[nearest.0]?];
        // step 1 and 2 of the thesis: distance to the nearest marked dot in the left photo
        let distance_left = nearest.1;
        let expected = p.x - self.disparity(p, &marked);
        let mut best: Option<(f64, usize)> = None;
        let reach = self.limits.distance + self.limits.rows;
        for near in self.right_index.within(&[expected, p.y], reach) {
            let q = self.right[near.index];
            if self.of_right[near.index].is_some() || (q.y - p.y).abs() > self.limits.rows {
                continue;
            }
            // step 3 and 4: the same distance to the correspondent in the right photo
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
        // near and unsurprising first; few marked neighbours are a surprise too
        let lonely = self.limits.spacing / marked.len() as f64;
        Some(Candidate {
            cost: distance_left + 3.0 * residual + lonely,
            left: dot,
            right,
            residual,
        })
    }

    /// Marked left dots around a place, nearest first, without the dot itself.
    fn marked_around(&self, p: Vec2, dot: usize) -> Vec<(usize, f64)> {
        let near = self.left_index.within(&[p.x, p.y], self.limits.reach);
        near.iter()
            .filter(|n| n.index != dot && self.of_left[n.index].is_some())
            .map(|n| (n.index, n.distance))
            .collect()
    }

    /// Disparity expected at a place: a line of disparity over x and y through the marked dots
    /// around it, held close to the nearest ones' values.
    fn disparity(&self, p: Vec2, marked: &[(usize, f64)]) -> f64 {
        let values: Vec<(Vec2, f64, f64)> = marked
            .iter()
            .filter_map(|&(i, distance)| {
                let q = self.right[self.of_left[i]?];
                let weight = (-(distance / self.limits.spacing).powi(2) / 2.0).exp() + 1e-6;
                Some((self.left[i] - p, self.left[i].x - q.x, weight))
            })
            .collect();
        plane_at_origin(&values, self.limits.spacing)
    }
}
