//! Dots that no region explains follow the disparity of their matched neighbours.

use std::collections::HashMap;

use crate::math::{Mat3, Vec2, Vec3, median};
use crate::spatial::PointIndex;

use super::cues::Evidence;
use super::regions::{Found, Paired};
use super::shifts::Shift;

/// Rounds of growing outward.
const ROUNDS: usize = 3;
/// Largest distance of a partner from its expected place, in spacings.
const REACH: f64 = 0.3;
/// Likeness in the plain pair up to which dots do not show the same skin (a correlation of 0.3).
const UNLIKE: f64 = 0.18;

/// Adds matches next to those found: each dot's disparity is expected on the plane through its
/// matched neighbours, and the right photo must have a free dot there.
pub(super) fn extend(evidence: &Evidence<'_>, found: &mut Found) {
    let right: Vec<Vec2> = evidence.dots[1].iter().map(|d| d.position).collect();
    let Some(right_index) = PointIndex::<2>::new(&right) else {
        return;
    };
    for _ in 0..ROUNDS {
        let surface = Surface::new(evidence, &found.pairs);
        let mut used = [0, 1].map(|side| vec![false; evidence.dots[side].len()]);
        for p in &found.pairs {
            used[0][p.left] = true;
            used[1][p.right] = true;
        }
        // (misfit, left, right), best first: a right dot goes to the left dot it fits best.
        let mut offers: Vec<(f64, usize, usize)> = Vec::new();
        for (i, dot) in evidence.dots[0].iter().enumerate().filter(|(i, _)| !used[0][*i]) {
            let p = dot.position;
            // At an edge of depth the plain pair's windows see both sides; it is asked only about
            // dots that hang together with unmatched ones (a wall) more than with matched ones.
            let beside = || evidence.graphs[0].neighbours(i);
            let matched = beside().filter(|n| used[0][*n]).count();
            let least = if 2 * matched < beside().count() { UNLIKE } else { 0.0 };
            for disparity in surface.expected(p, evidence.spacing_px) {
                let at = p + Vec2::new(-disparity, found.rows.at(&p));
                for n in right_index.within(&[at.x, at.y], REACH * evidence.spacing_px) {
                    let dy = (right[n.index] - at).y.abs();
                    let alike = evidence.alike(&(i, n.index));
                    if !used[1][n.index] && dy < evidence.tolerance_px && alike > least {
                        let misfit = n.distance / (REACH * evidence.spacing_px)
                            + dy / evidence.tolerance_px
                            + 4.0 * (1.0 - alike);
                        offers.push((misfit, i, n.index));
                    }
                }
            }
        }
        prefer_common_shifts(evidence, &found.pairs, &mut offers);
        offers.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)).then(a.2.cmp(&b.2)));
        let before = found.pairs.len();
        for (_, left, right) in offers {
            if !used[0][left] && !used[1][right] {
                used[0][left] = true;
                used[1][right] = true;
                found.pairs.push(Paired { left, right, confidence: 0.5 });
            }
        }
        if found.pairs.len() == before {
            break;
        }
    }
}

/// Makes offers better that shift the lattice as most others of their component do: beside an edge
/// of depth a dot may fit the surface on either side, but its whole column fits only one.
fn prefer_common_shifts(
    evidence: &Evidence<'_>,
    pairs: &[Paired],
    offers: &mut [(f64, usize, usize)],
) {
    let shift = |left: usize, right: usize| Shift::of(evidence.graphs, &(left, right));
    let mut votes: HashMap<Shift, f64> = HashMap::new();
    let mut most: HashMap<usize, f64> = HashMap::new();
    let pairs = pairs.iter().map(|p| (1.0, p.left, p.right));
    let weighed = offers.iter().map(|o| (1.0 / (1.0 + o.0), o.1, o.2));
    for (weight, left, right) in pairs.chain(weighed) {
        if let Some(shift) = shift(left, right) {
            let sum = votes.entry(shift).or_default();
            *sum += weight;
            let most = most.entry(shift.left).or_default();
            *most = most.max(*sum);
        }
    }
    for (misfit, left, right) in offers {
        if let Some((shift, sum)) = shift(*left, *right).and_then(|s| Some((s, votes.get(&s)?))) {
            *misfit -= 3.0 * sum / most.get(&shift.left).copied().unwrap_or(*sum);
        }
    }
}

/// The matched dots' disparities over the left photo.
pub(super) struct Surface {
    points: Vec<Vec2>,
    disparities: Vec<f64>,
    index: Option<PointIndex<2>>,
}

impl Surface {
    pub(super) fn new(evidence: &Evidence<'_>, pairs: &[Paired]) -> Self {
        let points: Vec<Vec2> = pairs.iter().map(|p| evidence.dots[0][p.left].position).collect();
        let disparities = pairs
            .iter()
            .map(|p| evidence.dots[0][p.left].position.x - evidence.dots[1][p.right].position.x)
            .collect();
        let index = PointIndex::<2>::new(&points);
        Self { points, disparities, index }
    }

    /// Disparities to expect at a point: on the plane through the neighbours, their median, and
    /// those of the nearest (at an edge the plane overshoots, and either side may be meant). None
    /// with fewer than three neighbours about.
    fn expected(&self, at: Vec2, spacing_px: f64) -> Vec<f64> {
        let near = self.near(at, 8, 2.3 * spacing_px, usize::MAX);
        let values: Vec<f64> = near.iter().map(|n| self.disparities[*n]).collect();
        let mut expected = Vec::new();
        if near.len() >= 3 {
            expected.extend(self.plane(at, &near, 0.1 * spacing_px).map(|p| p[0]));
            expected.extend(median(&values));
            expected.extend(&values[..3]);
        }
        expected
    }

    /// The nearest matches to a point, without one of them.
    pub(super) fn near(&self, at: Vec2, count: usize, radius: f64, but: usize) -> Vec<usize> {
        let Some(index) = &self.index else {
            return Vec::new();
        };
        index
            .nearest_n(&[at.x, at.y], count + 1)
            .iter()
            .filter(|n| n.index != but && n.distance <= radius)
            .take(count)
            .map(|n| n.index)
            .collect()
    }

    /// Disparity of a match.
    pub(super) fn disparity(&self, index: usize) -> f64 {
        self.disparities[index]
    }

    /// Left position of a match.
    pub(super) fn point(&self, index: usize) -> Vec2 {
        self.points[index]
    }

    /// Robust plane through matches about a point: value there, slopes. Weights fall with the
    /// residual over `scale_px` (Cauchy), starting from the median.
    pub(super) fn plane(&self, at: Vec2, near: &[usize], scale_px: f64) -> Option<[f64; 3]> {
        let values: Vec<f64> = near.iter().map(|n| self.disparities[*n]).collect();
        let mut plane = [median(&values)?, 0.0, 0.0];
        for round in 0..5 {
            let (mut normal, mut right) = (Mat3::zeros(), Vec3::zeros());
            for n in near {
                let d = self.points[*n] - at;
                let residual = self.disparities[*n] - (plane[0] + plane[1] * d.x + plane[2] * d.y);
                // The median knows no slope: the first round must let slopes through.
                let scale = if round == 0 { 6.0 * scale_px } else { scale_px };
                let weight = 1.0 / (1.0 + (residual / scale).powi(2));
                let j = Vec3::new(1.0, d.x, d.y);
                normal += weight * j * j.transpose();
                right += weight * self.disparities[*n] * j;
            }
            normal[(0, 0)] += 1e-9;
            normal[(1, 1)] += 1.0;
            normal[(2, 2)] += 1.0;
            let solved = normal.try_inverse()? * right;
            plane = [solved.x, solved.y, solved.z];
        }
        Some(plane)
    }
}
