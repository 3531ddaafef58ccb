//! The matches found so far, and where in depth the subject is.

use std::ops::RangeInclusive;

use super::evidence::Evidence;
use super::params::LatticeParams;
use super::row_offset::RowOffset;
use crate::math::{median, percentile};
use crate::stages::correspond::matches::IndexedMatch;

/// Regions of at least this share of the largest one may be the subject, percent.
pub(super) const LARGE_PERCENT: usize = 15;
/// Percentiles of the subject's disparities that count as its range: single outliers must not
/// extend it.
const RANGE: [f64; 2] = [0.02, 0.98];
/// The range of depth in front of a subject never reaches closer than this share of its depth.
const NEAREST_SHARE: f64 = 0.5;

/// The matches found so far.
pub(super) struct LatticeMatches {
    pub matches: Vec<IndexedMatch>,
    pub row_offset: RowOffset,
    /// Disparities of every region, pixels.
    pub regions: Vec<Vec<f64>>,
}

impl LatticeMatches {
    /// No matches, level rows.
    pub(super) fn new() -> Self {
        Self { matches: Vec::new(), row_offset: RowOffset::zero(), regions: Vec::new() }
    }

    /// Whether a region of `size` matches may be the subject.
    pub(super) fn is_large(&self, size: usize) -> bool {
        let largest = self.regions.iter().map(Vec::len).max().unwrap_or(0);
        100 * size >= LARGE_PERCENT * largest
    }

    /// Disparities of the region that is the subject: the nearest of the large ones, as a wall
    /// behind a face may be larger than the face.
    fn subject(&self) -> &[f64] {
        let middle = |r: &[f64]| median(r).unwrap_or(f64::NEG_INFINITY);
        self.regions
            .iter()
            .filter(|r| self.is_large(r.len()))
            .max_by(|a, b| middle(a).total_cmp(&middle(b)))
            .map_or(&[], Vec::as_slice)
    }

    /// Disparities that parts of the subject may have: at most `params.behind_mm` behind or in front
    /// of it where calibrated, else at most its own range of disparity more or less.
    pub(super) fn subject_range(
        &self,
        evidence: &Evidence<'_>,
        params: &LatticeParams,
    ) -> RangeInclusive<f64> {
        let subject = self.subject();
        let [low, high] = RANGE.map(|q| percentile(subject, q));
        let (Some(low), Some(high)) = (low, high) else {
            return f64::NEG_INFINITY..=f64::INFINITY;
        };
        let margin = (high - low).max(evidence.spacing_px);
        let metric = evidence.rig.and_then(|rig| {
            let (far, near) = (rig.depth_mm(low)?, rig.depth_mm(high)?);
            let nearest = (near - params.behind_mm).max(NEAREST_SHARE * near);
            Some(rig.disparity_px(far + params.behind_mm)..=rig.disparity_px(nearest))
        });
        metric.unwrap_or(low - margin..=high + margin)
    }
}
