//! Which shift the cues prefer for a region, and how clearly.

use super::components::connected_components;
use super::cues::ShiftCost;
use super::evidence::{Evidence, MAX_STEP};
use super::pairs::DotPair;
use super::params::LatticeParams;
use super::proposal::Proposal;
use super::region::{dots_with_border, pairs_in_similar_surroundings};
use crate::stages::correspond::error::CorrespondError;

/// Greatest confidence that is reported: greater ratios are not more certain.
const MAX_CONFIDENCE: f64 = 10.0;
/// Confidence that suffices where neither photos nor seeds are informative. With level rows and no
/// contrast all shifts cost about the same, and the best of many is better by chance.
const ROWS_ONLY_CONFIDENCE: f64 = 0.5 * MAX_CONFIDENCE;

/// The shift chosen for a region.
pub(super) struct Decision {
    pub chosen: Proposal,
    second: Option<Proposal>,
    /// Cost of the second-best shift over that of the chosen one.
    pub confidence: f64,
    /// Confidence needed.
    needed: f64,
    /// Whether the confidence suffices.
    pub is_certain: bool,
}

impl Decision {
    /// Chooses the shift of the lowest cost for a region of the proposal `best`.
    pub(super) fn new(
        evidence: &Evidence<'_>,
        params: &LatticeParams,
        best: &Proposal,
        region: &[DotPair],
        proposals: &[Proposal],
    ) -> Self {
        let ranked = rank(evidence, &dots_with_border(evidence, region, best), proposals);
        let (chosen, cost) =
            ranked.first().map_or_else(|| (best.clone(), None), |r| (r.1.clone(), Some(r.0)));
        let second = ranked.get(1).map(|r| r.1.clone());
        let confidence = match (cost, ranked.get(1)) {
            (Some(own), Some((other, _))) => other.total() / own.total(),
            _ => params.min_confidence,
        };
        let informative = cost.is_some_and(|c| c.is_informative());
        let needed = if informative {
            params.min_confidence
        } else {
            params.min_confidence.max(ROWS_ONLY_CONFIDENCE)
        };
        let is_certain = confidence >= needed;
        Self { chosen, second, confidence: confidence.min(MAX_CONFIDENCE), needed, is_certain }
    }

    /// The error for a capture in which no decision is certain.
    pub(super) fn ambiguous(&self, evidence: &Evidence<'_>) -> CorrespondError {
        let own = evidence.median_disparity(&self.chosen.pairs);
        let other = self.second.as_ref().map_or(own, |p| evidence.median_disparity(&p.pairs));
        let depth = |d: f64| evidence.rig.and_then(|rig| rig.depth_mm(d));
        let difference = match (depth(own), depth(other)) {
            (Some(a), Some(b)) => format!("+-{:.0} mm of depth", (a - b).abs()),
            _ => format!("+-{:.1} px of disparity", (own - other).abs()),
        };
        let (confidence, needed) = (self.confidence, self.needed);
        CorrespondError::Ambiguous { difference, confidence, needed }
    }
}

/// The proposals that pair at least half of the left dots `candidates`, with their costs, lowest
/// cost first.
fn rank<'p>(
    evidence: &Evidence<'_>,
    candidates: &[usize],
    proposals: &'p [Proposal],
) -> Vec<(ShiftCost, &'p Proposal)> {
    let mut is_candidate = vec![false; evidence.dots[0].len()];
    candidates.iter().for_each(|i| is_candidate[*i] = true);
    let mut ranked: Vec<(ShiftCost, &Proposal)> = proposals
        .iter()
        .filter_map(|p| {
            let pairs: Vec<_> = p.pairs.iter().filter(|q| is_candidate[q.0]).copied().collect();
            (2 * pairs.len() >= candidates.len())
                .then(|| (ShiftCost::new(evidence, candidates, &pairs, &p.row_offset), p))
        })
        .collect();
    ranked.sort_by(|a, b| a.0.total().total_cmp(&b.0.total()).then(a.1.shift.cmp(&b.1.shift)));
    ranked
}

/// A region without the components beyond a depth discontinuity for which the photos are not
/// informative or another shift is clearly better: labels that crossed a discontinuity may be off by
/// one there. The largest component is always kept.
pub(super) fn drop_doubtful_components(
    evidence: &Evidence<'_>,
    params: &LatticeParams,
    region: &[DotPair],
    chosen: &Proposal,
    proposals: &[Proposal],
) -> Vec<DotPair> {
    let step_px = MAX_STEP * evidence.spacing_px;
    let similar = pairs_in_similar_surroundings(evidence, region);
    let mut components = connected_components(evidence, &similar, step_px);
    components.sort_by_key(|c| std::cmp::Reverse(c.len()));
    let is_confirmed = |component: &Vec<DotPair>| {
        let candidates: Vec<usize> = component.iter().map(|p| p.0).collect();
        let ranked = rank(evidence, &candidates, proposals);
        let own = ranked.iter().find(|r| r.1.shift == chosen.shift).map(|r| r.0);
        match (own, ranked.first()) {
            (Some(own), Some((best, _))) => {
                own.total() < params.min_confidence * best.total() && own.is_informative()
            }
            _ => false,
        }
    };
    components
        .into_iter()
        .enumerate()
        .filter(|(n, c)| *n == 0 || (c.len() >= params.min_component && is_confirmed(c)))
        .flat_map(|(_, component)| component)
        .collect()
}
