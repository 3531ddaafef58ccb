//! Adds matches next to those found: dots that no region explains follow the disparity of their
//! matched neighbours.

use std::collections::HashMap;

use super::disparity_surface::DisparitySurface;
use super::evidence::{DISSIMILAR, Evidence};
use super::lattice_matches::LatticeMatches;
use super::pairs::Shift;
use super::params::LatticeParams;
use super::pieces::in_unmatched_piece;
use crate::math::Vec2;
use crate::spatial::PointIndex;
use crate::stages::correspond::matches::IndexedMatch;

/// Rounds of growing outward, one lattice step each.
const ROUNDS: usize = 3;
/// Largest distance of a right dot from its expected position, in spacings.
const RADIUS: f64 = 0.3;
/// Weight of dissimilarity (0 to 1) against the distances over their limits.
const DISSIMILARITY_WEIGHT: f64 = 4.0;
/// Bonus of a candidate with the most common shift of its component. A dot beside a depth
/// discontinuity may fit the surface on either side, but its whole column fits only one.
const COMMON_SHIFT_BONUS: f64 = 3.0;
/// A piece of unmatched lattice is that of a wall when it has this many times the fewest dots of a
/// component. Smaller ones are parts of the subject (beside the nose, at an ear).
const LARGE_PIECE: usize = 5;
/// Score of a match added here: its shift was not decided by the cues.
const SCORE: f64 = 0.5;

/// A match that may be added.
struct Candidate {
    /// Sum of the deviations from what is expected; below 0 with the bonus.
    cost: f64,
    left: usize,
    right: usize,
}

/// Adds matches: the disparity of each unmatched left dot is expected on the plane through its
/// matched neighbours, and the right photo must have an unmatched dot there. Dots in a piece of the
/// lattice that no region matched are left out: one that lies a period off would fit as well.
/// Returns the number of left dots left out for that reason.
pub(super) fn extend(
    evidence: &Evidence<'_>,
    params: &LatticeParams,
    found: &mut LatticeMatches,
) -> usize {
    let right: Vec<Vec2> = evidence.dots[1].iter().map(|d| d.position).collect();
    let Some(right_index) = PointIndex::<2>::new(&right) else {
        return 0;
    };
    let matched = matched_dots(evidence, found);
    let in_piece = [0, 1].map(|s| {
        in_unmatched_piece(&evidence.graphs[s], &matched[s], LARGE_PIECE * params.min_component)
    });
    // as seen in both photos: in one, labels may join the subject's border to the wall
    let is_ambiguous = |left: usize, right: usize| in_piece[0][left] && in_piece[1][right];
    let mut left_out = vec![false; evidence.dots[0].len()];
    for _ in 0..ROUNDS {
        let mut used = matched_dots(evidence, found);
        let mut candidates = candidates(evidence, found, &used, &right_index);
        prefer_common_shifts(evidence, &found.matches, &mut candidates);
        // Lowest cost first: a right dot goes to the left dot it fits best.
        candidates.sort_by(|a, b| {
            a.cost.total_cmp(&b.cost).then(a.left.cmp(&b.left)).then(a.right.cmp(&b.right))
        });
        let before = found.matches.len();
        for Candidate { left, right, .. } in candidates {
            if used[0][left] || used[1][right] {
                continue;
            }
            left_out[left] = is_ambiguous(left, right);
            if !left_out[left] {
                used[0][left] = true;
                used[1][right] = true;
                found.matches.push(IndexedMatch { left, right, score: SCORE });
            }
        }
        if found.matches.len() == before {
            break;
        }
    }
    left_out.iter().filter(|l| **l).count()
}

/// Whether each dot is matched, `[left, right]`.
fn matched_dots(evidence: &Evidence<'_>, found: &LatticeMatches) -> [Vec<bool>; 2] {
    let mut matched = [0, 1].map(|side| vec![false; evidence.dots[side].len()]);
    for m in &found.matches {
        matched[0][m.left] = true;
        matched[1][m.right] = true;
    }
    matched
}

/// All pairs of unmatched dots at an expected position.
fn candidates(
    evidence: &Evidence<'_>,
    found: &LatticeMatches,
    used: &[Vec<bool>; 2],
    right_index: &PointIndex<2>,
) -> Vec<Candidate> {
    let surface = DisparitySurface::new(evidence, &found.matches);
    let radius = RADIUS * evidence.spacing_px;
    let mut candidates = Vec::new();
    for (left, dot) in evidence.dots[0].iter().enumerate().filter(|(i, _)| !used[0][*i]) {
        let p = dot.position;
        let least = least_similarity(evidence, &used[0], left);
        for disparity in surface.expected(p, evidence.spacing_px) {
            let at = p + Vec2::new(-disparity, found.row_offset.at(&p));
            for n in right_index.within(&[at.x, at.y], radius) {
                let dy = (evidence.dots[1][n.index].position - at).y.abs();
                let similarity = evidence.similarity(&(left, n.index));
                if !used[1][n.index] && dy < evidence.tolerance_px && similarity > least {
                    let cost = n.distance / radius
                        + dy / evidence.tolerance_px
                        + DISSIMILARITY_WEIGHT * (1.0 - similarity);
                    candidates.push(Candidate { cost, left, right: n.index });
                }
            }
        }
    }
    candidates
}

/// Least similarity of a match of a left dot. At a depth discontinuity the patches of the plain pair
/// show both sides, so they count only for dots with more unmatched (a wall) than matched lattice
/// neighbours.
fn least_similarity(evidence: &Evidence<'_>, matched: &[bool], dot: usize) -> f64 {
    let neighbours = || evidence.graphs[0].neighbours(dot);
    let count = neighbours().filter(|n| matched[*n]).count();
    if 2 * count < neighbours().count() { DISSIMILAR } else { 0.0 }
}

/// Lowers the cost of candidates whose shift is common among the matches and candidates of their
/// component.
fn prefer_common_shifts(
    evidence: &Evidence<'_>,
    matches: &[IndexedMatch],
    candidates: &mut [Candidate],
) {
    let shift = |left: usize, right: usize| Shift::of(evidence.graphs, &(left, right));
    let mut votes: HashMap<Shift, f64> = HashMap::new();
    let mut most: HashMap<usize, f64> = HashMap::new();
    let certain = matches.iter().map(|m| (1.0, m.left, m.right));
    let possible = candidates.iter().map(|c| (1.0 / (1.0 + c.cost), c.left, c.right));
    for (weight, left, right) in certain.chain(possible) {
        if let Some(shift) = shift(left, right) {
            let sum = votes.entry(shift).or_default();
            *sum += weight;
            let most = most.entry(shift.left).or_default();
            *most = most.max(*sum);
        }
    }
    for Candidate { cost, left, right } in candidates {
        if let Some((shift, sum)) = shift(*left, *right).and_then(|s| Some((s, votes.get(&s)?))) {
            *cost -= COMMON_SHIFT_BONUS * sum / most.get(&shift.left).copied().unwrap_or(*sum);
        }
    }
}
