//! Proposals: candidate shifts with the pairs they make.

use std::ops::RangeInclusive;

use rayon::prelude::*;

use super::candidate_shifts::candidate_shifts;
use super::evidence::Evidence;
use super::pairs::{DotPair, Shift};
use super::params::LatticeParams;
use super::row_offset::RowOffset;
use crate::math::Vec2;

/// A shift with the pairs it makes.
#[derive(Clone)]
pub(super) struct Proposal {
    pub shift: Shift,
    pub pairs: Vec<DotPair>,
    pub row_offset: RowOffset,
    /// See [`support`].
    pub support: f64,
}

/// The proposals among the free dots, with disparities in a range. The row offset is fitted to each
/// proposal where it is not known yet.
pub(super) fn proposals(
    evidence: &Evidence<'_>,
    params: &LatticeParams,
    free: &[Vec<bool>; 2],
    row_offset: Option<&RowOffset>,
    disparities: RangeInclusive<f64>,
) -> Vec<Proposal> {
    let graphs = evidence.graphs;
    let members: Vec<usize> =
        (0..free[0].len()).filter(|i| free[0][*i] && graphs[0].labels[*i].is_some()).collect();
    candidate_shifts(evidence, params, free, &disparities)
        .into_par_iter()
        .map(|shift| {
            let mut pairs = shift.pairs(graphs, &members, free);
            pairs.retain(|p| disparities.contains(&evidence.disparity(p)));
            let row_offset = row_offset.copied().unwrap_or_else(|| fit_rows(evidence, &pairs));
            let support = support(evidence, &pairs, &row_offset);
            Proposal { shift, pairs, row_offset, support }
        })
        .filter(|p| {
            p.pairs.len() >= params.min_component && is_plausible(evidence, params, &p.pairs)
        })
        .collect()
}

fn fit_rows(evidence: &Evidence<'_>, pairs: &[DotPair]) -> RowOffset {
    let samples: Vec<(Vec2, f64)> = pairs.iter().map(|p| evidence.row_difference(p)).collect();
    RowOffset::fit(&samples, evidence.tolerance_px, evidence.spacing_px)
}

/// Sum over pairs of how well they are on one row and look similar, 0 to 1 each.
pub(super) fn support(evidence: &Evidence<'_>, pairs: &[DotPair], row_offset: &RowOffset) -> f64 {
    let on_row = |pair: &DotPair| {
        let (l, dy) = evidence.row_difference(pair);
        (1.0 - ((dy - row_offset.at(&l)) / evidence.tolerance_px).powi(2)).max(0.0)
    };
    pairs.iter().map(|p| on_row(p) * evidence.similarity(p)).sum()
}

/// Whether the depth of the pairs is one a subject may have; always without a calibrated rig.
fn is_plausible(evidence: &Evidence<'_>, params: &LatticeParams, pairs: &[DotPair]) -> bool {
    evidence.rig.is_none_or(|rig| {
        rig.depth_mm(evidence.median_disparity(pairs))
            .is_some_and(|z| (params.nearest_mm..=params.farthest_mm).contains(&z))
    })
}
