//! Matches the lattice region by region, the best supported first.

use super::decision::{Decision, drop_doubtful_components};
use super::evidence::{Evidence, SIMILAR};
use super::lattice_matches::LatticeMatches;
use super::pairs::DotPair;
use super::params::LatticeParams;
use super::proposal::{Proposal, proposals, support};
use super::region::largest_region;
use crate::observer::Observer;
use crate::stages::correspond::error::CorrespondError;
use crate::stages::correspond::matches::IndexedMatch;

/// Most rounds: a face consists of a handful of regions, a wall of some more.
const MAX_ROUNDS: usize = 24;

/// Matches regions of one shift each. Regions whose shift is not certain (a bare wall) are left out;
/// if there is no other, the capture is refused.
pub(super) fn match_regions(
    evidence: &Evidence<'_>,
    params: &LatticeParams,
    observer: &dyn Observer,
) -> Result<LatticeMatches, CorrespondError> {
    let mut search = RegionSearch {
        evidence,
        params,
        free: [0, 1].map(|side| vec![true; evidence.dots[side].len()]),
        found: LatticeMatches::new(),
        refused: None,
        subject_found: false,
    };
    for _ in 0..MAX_ROUNDS {
        observer.check()?;
        if !search.next_region() {
            break;
        }
    }
    search.finish()
}

struct RegionSearch<'a> {
    evidence: &'a Evidence<'a>,
    params: &'a LatticeParams,
    /// Dots that are neither matched nor refused, `[left, right]`.
    free: [Vec<bool>; 2],
    found: LatticeMatches,
    /// Error of the first region that was refused.
    refused: Option<CorrespondError>,
    /// First the large regions are sought, among them the subject; then its parts, near it in depth.
    subject_found: bool,
}

impl RegionSearch<'_> {
    /// Accepts or refuses one region; false when there is none.
    fn next_region(&mut self) -> bool {
        let (evidence, params) = (self.evidence, self.params);
        let first = self.found.matches.is_empty();
        let row_offset = (!first).then_some(&self.found.row_offset);
        let disparities = if self.subject_found {
            self.found.subject_range(evidence, params)
        } else {
            f64::NEG_INFINITY..=f64::INFINITY
        };
        let proposals = proposals(evidence, params, &self.free, row_offset, disparities);
        // Beside a subject only what looks similar in the plain pair counts: the labels of a neck
        // may be connected with those of the bare wall behind.
        let min_similarity = if first { 0.0 } else { SIMILAR };
        let best = self.best_supported(&proposals, min_similarity);
        let size = best.as_ref().map_or(0, |b| b.1.len());
        if !self.subject_found && !first && !self.found.is_large(size) {
            self.subject_found = true;
            return true;
        }
        let Some((best, best_region)) = best else {
            return false;
        };
        let decision = Decision::new(evidence, params, best, &best_region, &proposals);
        let region = if decision.chosen.shift == best.shift {
            best_region.clone()
        } else {
            largest_region(evidence, &decision.chosen, min_similarity)
        };
        if decision.is_certain && region.len() >= params.min_component {
            self.accept(&region, &decision, &proposals);
        } else if self.refused.is_none() {
            self.refused = Some(decision.ambiguous(evidence));
        }
        // No dot is searched twice.
        best_region.iter().chain(&region).for_each(|(i, _)| self.free[0][*i] = false);
        true
    }

    /// The proposal with the best supported region, and that region.
    fn best_supported<'p>(
        &self,
        proposals: &'p [Proposal],
        min_similarity: f64,
    ) -> Option<(&'p Proposal, Vec<DotPair>)> {
        let mut best: Option<(f64, (&Proposal, Vec<DotPair>))> = None;
        for proposal in proposals {
            // The support of a region cannot exceed that of its proposal.
            if best.as_ref().is_some_and(|b| b.0 >= proposal.support) {
                continue;
            }
            let region = largest_region(self.evidence, proposal, min_similarity);
            let support = support(self.evidence, &region, &proposal.row_offset);
            let better = best.as_ref().is_none_or(|b| support > b.0);
            if better && region.len() >= self.params.min_component {
                best = Some((support, (proposal, region)));
            }
        }
        best.map(|b| b.1)
    }

    /// Adds the pairs of a region to the matches.
    fn accept(&mut self, region: &[DotPair], decision: &Decision, proposals: &[Proposal]) {
        let (evidence, chosen) = (self.evidence, &decision.chosen);
        if self.found.matches.is_empty() {
            self.found.row_offset = chosen.row_offset;
        }
        let pairs = drop_doubtful_components(evidence, self.params, region, chosen, proposals);
        self.found.regions.push(pairs.iter().map(|p| evidence.disparity(p)).collect());
        let score = 1.0 - 1.0 / (1.0 + decision.confidence);
        for (left, right) in pairs {
            self.free[0][left] = false;
            self.free[1][right] = false;
            self.found.matches.push(IndexedMatch { left, right, score });
        }
    }

    /// The matches, or why there are none.
    fn finish(self) -> Result<LatticeMatches, CorrespondError> {
        if self.found.matches.is_empty() {
            let [left, right] = self.evidence.dots.map(<[_]>::len);
            let needed = self.params.min_component;
            let too_few =
                CorrespondError::TooFewMatches { candidates: "dots", got: 0, needed, left, right };
            return Err(self.refused.unwrap_or(too_few));
        }
        Ok(self.found)
    }
}
