//! Matches with the measured disparity.

use super::binning::Binning;
use super::samples::Sample;
use super::spline::Spline;
use crate::data::{Gray, Match};

/// A match farther off the measured surface is wrong, in pitches of disparity: nearly half way to a
/// match with the neighbouring dot.
const MAX_RESIDUAL: f64 = 0.4;
/// A match within this of the measured surface takes its disparity, in pitches of disparity.
const ON_SURFACE: f64 = 0.15;

/// The matches with the spline's disparity where it was measured close to theirs. Otherwise a match
/// keeps its own disparity with the standard deviation `max_sigma_px`. Matches that contradict the
/// surface are removed, and so are those off the surface without a lattice label: they were only
/// predicted from their neighbours. `samples` are the matches in working pixels, `pitch` is in
/// working pixels.
pub(super) fn updated_matches(
    matches: &[Match],
    samples: &[Sample],
    binning: Binning,
    spline: &Spline,
    working_sigma: &Gray,
    pitch: f64,
    max_sigma_px: f64,
) -> Vec<Match> {
    let mut updated = Vec::with_capacity(matches.len());
    for (m, s) in matches.iter().zip(samples) {
        let mut m = *m;
        let sigma_px = f64::from(binning.sigma_at(working_sigma, m.left.x, m.left.y));
        let disparity = spline.value(s.x, s.y);
        let residual = (disparity - s.disparity).abs();
        if sigma_px.is_finite() && residual > MAX_RESIDUAL * pitch {
            continue;
        }
        let on_surface = sigma_px.is_finite() && residual < ON_SURFACE * pitch;
        if !on_surface && m.lattice.is_none() {
            continue;
        }
        m.right.x = m.left.x - binning.factor() * if on_surface { disparity } else { s.disparity };
        m.sigma_px = if on_surface { sigma_px } else { max_sigma_px };
        updated.push(m);
    }
    updated
}
