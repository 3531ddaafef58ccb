//! Region by region: the best shift, its rivals, and what it explains.

use std::ops::RangeInclusive;

use rayon::prelude::*;

use crate::camera::RectifiedRig;
use crate::math::{Vec2, median, percentile};
use crate::observer::Observer;

use super::super::CorrespondError;
use super::LatticeParams;
use super::cues::{Badness, Evidence};
use super::shifts::{Pair, Rows, Shift, candidates, pairs};

/// Two dots that belong together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Paired {
    pub left: usize,
    pub right: usize,
    /// 0 to 1.
    pub confidence: f64,
}

/// The pairs found so far, and how the rows lie.
pub(super) struct Found {
    pub pairs: Vec<Paired>,
    pub rows: Rows,
    /// Disparities of every region, pixels.
    pub regions: Vec<Vec<f64>>,
}

impl Found {
    fn largest(&self) -> usize {
        self.regions.iter().map(Vec::len).max().unwrap_or(0)
    }

    /// Disparities of the region that is the subject: the nearest of the large ones (a papered wall
    /// behind a face may be larger than the face).
    fn subject(&self) -> &[f64] {
        let middle = |r: &[f64]| median(r).unwrap_or(f64::NEG_INFINITY);
        self.regions
            .iter()
            .filter(|r| 100 * r.len() >= LARGE_PERCENT * self.largest())
            .max_by(|a, b| middle(a).total_cmp(&middle(b)))
            .map_or(&[], Vec::as_slice)
    }

    /// Disparities at which parts of the subject may lie: no further before or behind it than
    /// `behind_mm` (calibrated), or than its own range of disparity.
    pub(super) fn subject_range(
        &self,
        rig: Option<&RectifiedRig>,
        params: &LatticeParams,
        spacing_px: f64,
    ) -> RangeInclusive<f64> {
        let subject = self.subject();
        let (Some(low), Some(high)) = (percentile(subject, 0.02), percentile(subject, 0.98)) else {
            return f64::NEG_INFINITY..=f64::INFINITY;
        };
        let free = (high - low).max(spacing_px);
        let metric = rig.and_then(|rig| {
            let (far, near) = (rig.depth_mm(low)?, rig.depth_mm(high)?);
            let nearest = (near - params.behind_mm).max(0.5 * near);
            Some(rig.disparity_px(far + params.behind_mm)..=rig.disparity_px(nearest))
        });
        metric.unwrap_or(low - free..=high + free)
    }
}

/// What the cues say about a region.
struct Verdict {
    chosen: Proposal,
    rival: Option<Proposal>,
    /// Ratio of the rival's badness to that of the chosen shift.
    confidence: f64,
    sure: bool,
}

/// Shifts looked at in one round.
const SHIFTS: usize = 80;
/// Rounds: a face falls into a handful of regions, a wall into some more.
const ROUNDS: usize = 24;
/// Likeness of dots that surely show the same skin (a correlation of one half).
pub(super) const ALIKE: f64 = 0.325;
/// Regions of this share of the largest one's dots may be the subject.
const LARGE_PERCENT: usize = 15;
/// A confidence beyond which more says nothing.
const CERTAIN: f64 = 10.0;

pub(super) struct Matcher<'a> {
    pub(super) evidence: &'a Evidence<'a>,
    rig: Option<&'a RectifiedRig>,
    params: &'a LatticeParams,
}

/// A shift with what it pairs.
#[derive(Clone)]
pub(super) struct Proposal {
    shift: Shift,
    pub(super) pairs: Vec<Pair>,
    pub(super) rows: Rows,
    /// See [`Matcher::support`].
    support: f64,
}

impl<'a> Matcher<'a> {
    pub(super) fn new(
        evidence: &'a Evidence<'a>,
        rig: Option<&'a RectifiedRig>,
        params: &'a LatticeParams,
    ) -> Self {
        Self { evidence, rig, params }
    }

    /// Explains the lattice by regions of one shift each, the best supported first. What the cues
    /// do not place for certain (a bare wall) is left out; if that is all, the capture is refused.
    pub(super) fn regions(&self, observer: &dyn Observer) -> Result<Found, CorrespondError> {
        let dots = self.evidence.dots;
        let mut free = [0, 1].map(|side| vec![true; dots[side].len()]);
        let mut found = Found { pairs: Vec::new(), rows: Rows::level(), regions: Vec::new() };
        let mut refused = None;
        // First the large regions, among them the subject; then its parts, near it in depth.
        let mut large = true;
        for _ in 0..ROUNDS {
            observer.check()?;
            let known = (!found.pairs.is_empty()).then_some(&found.rows);
            let range = if large {
                f64::NEG_INFINITY..=f64::INFINITY
            } else {
                found.subject_range(self.rig, self.params, self.evidence.spacing_px)
            };
            let proposals = self.proposals(&free, known, range);
            // Beside a subject that is found, only what looks alike in the plain pair counts: the
            // labels of a neck may hang together with those of the bare wall behind.
            let alike = if found.pairs.is_empty() { 0.0 } else { ALIKE };
            let best = self.best(&proposals, alike);
            let size = best.as_ref().map_or(0, |b| b.1.len());
            if large && !found.pairs.is_empty() && 100 * size < LARGE_PERCENT * found.largest() {
                large = false;
                continue;
            }
            let Some((best, seen)) = best else {
                break;
            };
            let verdict = self.decide(best, &seen, &proposals);
            let chosen = &verdict.chosen;
            let region = if chosen.shift == best.shift {
                seen.clone()
            } else {
                self.region(chosen, alike).unwrap_or_default()
            };
            if verdict.sure && region.len() >= self.params.min_component {
                let first = found.pairs.is_empty();
                let pairs = self.verified(&region, chosen, &proposals);
                found.regions.push(pairs.iter().map(|p| self.disparity(p)).collect());
                for (left, right) in pairs {
                    free[0][left] = false;
                    free[1][right] = false;
                    let confidence = 1.0 - 1.0 / (1.0 + verdict.confidence);
                    found.pairs.push(Paired { left, right, confidence });
                }
                if first {
                    found.rows = chosen.rows;
                }
            } else if refused.is_none() {
                refused = Some(self.ambiguous(&verdict));
            }
            // What was looked at must not come back in the next round.
            seen.iter().chain(&region).for_each(|(i, _)| free[0][*i] = false);
        }
        if found.pairs.is_empty() {
            let [left, right] = dots.map(<[_]>::len);
            let needed = self.params.min_component;
            let few = CorrespondError::TooFewMatches { got: 0, needed, left, right };
            return Err(refused.unwrap_or(few));
        }
        Ok(found)
    }

    /// The proposal with the best supported region, and that region.
    fn best<'p>(&self, proposals: &'p [Proposal], alike: f64) -> Option<(&'p Proposal, Vec<Pair>)> {
        let mut best: Option<(f64, (&Proposal, Vec<Pair>))> = None;
        for proposal in proposals {
            // A region's support cannot exceed its proposal's.
            if best.as_ref().is_some_and(|b| b.0 >= proposal.support) {
                continue;
            }
            let region = self.region(proposal, alike).unwrap_or_default();
            let support = self.support(&region, &proposal.rows);
            let better = best.as_ref().is_none_or(|b| support > b.0);
            if better && region.len() >= self.params.min_component {
                best = Some((support, (proposal, region)));
            }
        }
        best.map(|b| b.1)
    }

    /// All shifts worth a look, with their pairs.
    fn proposals(
        &self,
        free: &[Vec<bool>; 2],
        rows: Option<&Rows>,
        range: RangeInclusive<f64>,
    ) -> Vec<Proposal> {
        let evidence = self.evidence;
        let graphs = evidence.graphs;
        let slack = self.params.row_slack * evidence.spacing_px;
        let members: Vec<usize> =
            (0..free[0].len()).filter(|i| free[0][*i] && graphs[0].labels[*i].is_some()).collect();
        let least = self.params.min_component;
        candidates(evidence, free, slack, &range, least, SHIFTS)
            .into_par_iter()
            .map(|shift| {
                let mut pairs = pairs(graphs, &members, shift, free);
                pairs.retain(|p| range.contains(&self.disparity(p)));
                self.proposal(shift, pairs, rows)
            })
            .filter(|p| p.pairs.len() >= least && self.plausible(&p.pairs))
            .collect()
    }

    fn proposal(&self, shift: Shift, pairs: Vec<Pair>, rows: Option<&Rows>) -> Proposal {
        let tolerance = self.evidence.tolerance_px;
        let samples: Vec<(Vec2, f64)> = pairs.iter().map(|p| self.row_difference(p)).collect();
        let rows = rows.copied().unwrap_or_else(|| Rows::fit(&samples, tolerance));
        let support = self.support(&pairs, &rows);
        Proposal { shift, pairs, rows, support }
    }

    /// Sum over pairs of how well they lie on one row and look alike, 0 to 1 each.
    fn support(&self, pairs: &[Pair], rows: &Rows) -> f64 {
        let level = |pair: &Pair| {
            let (l, dy) = self.row_difference(pair);
            (1.0 - ((dy - rows.at(&l)) / self.evidence.tolerance_px).powi(2)).max(0.0)
        };
        pairs.iter().map(|p| level(p) * self.evidence.alike(p)).sum()
    }

    pub(super) fn row_difference(&self, pair: &Pair) -> (Vec2, f64) {
        let (l, r) = self.positions(pair);
        (l, r.y - l.y)
    }

    fn positions(&self, (i, j): &Pair) -> (Vec2, Vec2) {
        (self.evidence.dots[0][*i].position, self.evidence.dots[1][*j].position)
    }

    pub(super) fn disparity(&self, pair: &Pair) -> f64 {
        let (l, r) = self.positions(pair);
        l.x - r.x
    }

    fn median_disparity(&self, pairs: &[Pair]) -> f64 {
        median(&pairs.iter().map(|p| self.disparity(p)).collect::<Vec<_>>()).unwrap_or(0.0)
    }

    /// Whether a calibrated rig allows a subject there.
    fn plausible(&self, pairs: &[Pair]) -> bool {
        self.rig.is_none_or(|rig| {
            rig.depth_mm(self.median_disparity(pairs))
                .is_some_and(|z| (self.params.nearest_mm..=self.params.farthest_mm).contains(&z))
        })
    }

    /// The proposals that pair at least half of some left dots, with their badness, best first.
    fn judged<'p>(
        &self,
        asked: &[usize],
        proposals: &'p [Proposal],
    ) -> Vec<(Badness, &'p Proposal)> {
        let mut wanted = vec![false; self.evidence.dots[0].len()];
        asked.iter().for_each(|i| wanted[*i] = true);
        let mut judged: Vec<(Badness, &Proposal)> = proposals
            .iter()
            .filter_map(|p| {
                let pairs: Vec<_> = p.pairs.iter().filter(|q| wanted[q.0]).copied().collect();
                (2 * pairs.len() >= asked.len())
                    .then(|| (self.evidence.badness(asked, &pairs, &p.rows), p))
            })
            .collect();
        judged.sort_by(|a, b| a.0.total().total_cmp(&b.0.total()).then(a.1.shift.cmp(&b.1.shift)));
        judged
    }

    /// The shift the cues prefer for a region. It is sure when it beats its closest rival and the
    /// photos themselves speak for it: with level rows and no contrast all shifts are alike, and
    /// the best of many is only the luckiest.
    fn decide(&self, best: &Proposal, region: &[Pair], proposals: &[Proposal]) -> Verdict {
        let judged = self.judged(&self.with_rim(region, best), proposals);
        let (chosen, badness) =
            judged.first().map_or_else(|| (best.clone(), None), |j| (j.1.clone(), Some(j.0)));
        let rival = judged.get(1).map(|j| j.1.clone());
        let confidence = match (badness, judged.get(1)) {
            (Some(own), Some((other, _))) => other.total() / own.total(),
            _ => self.params.min_confidence,
        };
        let speaks = badness.is_some_and(|b| b.speaks());
        let sure =
            confidence >= self.params.min_confidence && (speaks || confidence >= 0.5 * CERTAIN);
        Verdict { chosen, rival, confidence: confidence.min(CERTAIN), sure }
    }

    /// A region without the pieces beyond a step of depth for which the photos do not speak or
    /// another shift is clearly better: labels that crossed an edge may have lost count there.
    fn verified(&self, region: &[Pair], chosen: &Proposal, proposals: &[Proposal]) -> Vec<Pair> {
        let step = self.params.max_step * self.evidence.spacing_px;
        let mut pieces = self.pieces(&self.convincing(region), step);
        pieces.sort_by_key(|p| std::cmp::Reverse(p.len()));
        let holds = |piece: &Vec<Pair>| {
            let asked: Vec<usize> = piece.iter().map(|p| p.0).collect();
            let judged = self.judged(&asked, proposals);
            let own = judged.iter().find(|j| j.1.shift == chosen.shift).map(|j| j.0);
            match (own, judged.first()) {
                (Some(own), Some((best, _))) => {
                    own.total() < self.params.min_confidence * best.total() && own.speaks()
                }
                _ => false,
            }
        };
        pieces
            .into_iter()
            .enumerate()
            .filter(|(n, p)| *n == 0 || (p.len() >= self.params.min_component && holds(p)))
            .flat_map(|(_, piece)| piece)
            .collect()
    }

    fn ambiguous(&self, verdict: &Verdict) -> CorrespondError {
        let own = self.median_disparity(&verdict.chosen.pairs);
        let other = verdict.rival.as_ref().map_or(own, |r| self.median_disparity(&r.pairs));
        let depth = |d: f64| self.rig.and_then(|rig| rig.depth_mm(d));
        let means = match (depth(own), depth(other)) {
            (Some(a), Some(b)) => format!("+-{:.0} mm of depth", (a - b).abs()),
            _ => format!("+-{:.1} px of disparity", (own - other).abs()),
        };
        let (confidence, needed) = (verdict.confidence, self.params.min_confidence);
        CorrespondError::Ambiguous { means, confidence, needed }
    }
}
