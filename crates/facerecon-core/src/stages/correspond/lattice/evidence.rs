//! What the photos say about a pair of dots.

use super::graph::Graph;
use super::pairs::{DotPair, Partners};
use super::patches::PlainPatches;
use crate::camera::RectifiedRig;
use crate::data::{Dot, Seeds};
use crate::math::{Vec2, median};

/// Similarity of dots that show the same skin: a correlation of 0.5 in the plain pair.
pub(super) const SIMILAR: f64 = 0.325;
/// Step of disparity between neighbouring dots that counts as a depth discontinuity, dot spacings.
pub(super) const MAX_STEP: f64 = 0.35;
/// Similarity up to which dots show different skin: a correlation of 0.3 in the plain pair.
pub(super) const DISSIMILAR: f64 = 0.18;
/// Similarity without any correlation, or where the plain pair has no contrast: not 0, so that
/// other cues still count.
const MIN_SIMILARITY: f64 = 0.1;
/// Least height of a dot that is compared, grey levels: keeps the logarithm finite.
const MIN_AMPLITUDE: f64 = 1.0;
/// Greatest logarithm of a relative brightness that counts (a factor of 2): highlights must not
/// decide.
const MAX_LOG_BRIGHTNESS: f64 = 0.7;
/// Fewest lattice neighbours that define a relative brightness.
const MIN_NEIGHBOURS: f64 = 2.0;

/// The dots of both photos and all that is known about them.
pub(super) struct Evidence<'a> {
    /// `[left, right]`.
    pub dots: [&'a [Dot]; 2],
    /// Labels of the dots.
    pub graphs: &'a [Graph; 2],
    /// Surroundings of the dots in the plain pair.
    pub plain: Option<PlainPatches>,
    /// Marked pairs, rectified pixels.
    pub seeds: Option<Seeds>,
    /// The rectified pair, where calibrated.
    pub rig: Option<&'a RectifiedRig>,
    /// Usual distance between neighbouring dots, pixels.
    pub spacing_px: f64,
    /// Greatest row difference of a match, pixels.
    pub tolerance_px: f64,
}

impl Evidence<'_> {
    /// Similarity of the surroundings of two dots in the plain pair, 0 to 1; 1 without a plain pair.
    pub(super) fn similarity(&self, (left, right): &DotPair) -> f64 {
        self.plain.as_ref().map_or(1.0, |plain| {
            plain.correlation(*left, *right).map_or(MIN_SIMILARITY, |(z, _)| {
                MIN_SIMILARITY + (1.0 - MIN_SIMILARITY) * z.max(0.0).powi(2)
            })
        })
    }

    /// Logarithms of the heights of two dots over those of their paired lattice neighbours. The
    /// ratio removes shading and exposure. `None` with too few neighbours.
    pub(super) fn relative_brightness(
        &self,
        pair: &DotPair,
        partners: &Partners,
    ) -> Option<(f64, f64)> {
        let log = |side: usize, i: usize| self.dots[side][i].amplitude.max(MIN_AMPLITUDE).ln();
        let (mut a, mut b, mut count) = (0.0, 0.0, 0.0);
        let neighbours = self.graphs[0].neighbours(pair.0);
        for (k, m) in neighbours.filter_map(|k| Some((k, partners.of(k)?))) {
            a += log(0, k);
            b += log(1, m);
            count += 1.0;
        }
        let relative =
            |own: f64, sum: f64| (own - sum / count).clamp(-MAX_LOG_BRIGHTNESS, MAX_LOG_BRIGHTNESS);
        (count >= MIN_NEIGHBOURS)
            .then(|| (relative(log(0, pair.0), a), relative(log(1, pair.1), b)))
    }

    /// Left position of a pair, and its row difference `yr - yl`, pixels.
    pub(super) fn row_difference(&self, pair: &DotPair) -> (Vec2, f64) {
        let (l, r) = self.positions(pair);
        (l, r.y - l.y)
    }

    /// Disparity of a pair, pixels.
    pub(super) fn disparity(&self, pair: &DotPair) -> f64 {
        let (l, r) = self.positions(pair);
        l.x - r.x
    }

    /// Median disparity of pairs, pixels; 0 without any.
    pub(super) fn median_disparity(&self, pairs: &[DotPair]) -> f64 {
        median(&pairs.iter().map(|p| self.disparity(p)).collect::<Vec<_>>()).unwrap_or(0.0)
    }

    fn positions(&self, (i, j): &DotPair) -> (Vec2, Vec2) {
        (self.dots[0][*i].position, self.dots[1][*j].position)
    }
}
