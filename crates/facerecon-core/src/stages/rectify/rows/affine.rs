//! Row differences of a calibrated rig whose right camera has moved slightly.

use super::corners::CornerPair;
use crate::math::{Vec2, fit_plane_robust, median};

/// Rounds of reweighting; the first [`WIDE_ROUNDS`] of them with the wide weights.
const ROUNDS: usize = 12;
/// Rounds with wide weights: the start, a median, has no slope.
const WIDE_ROUNDS: usize = 4;
/// Scale of the Cauchy weights, pixels: wide, then narrow. Set by hand.
const WEIGHT_PX: [f64; 2] = [1.5, 0.25];

/// Row difference `yr - yl = offset + roll (xr - cx) + scale (yr - cy)`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct RowAffine {
    pub centre: Vec2,
    pub offset: f64,
    pub roll: f64,
    pub scale: f64,
}

impl RowAffine {
    /// Row difference at a pixel of the right picture.
    pub(super) fn at(&self, right: Vec2) -> f64 {
        let d = right - self.centre;
        self.offset + self.roll * d.x + self.scale * d.y
    }

    /// Robust fit (Cauchy weights) about a centre. Roll and scale are kept only when they change
    /// the row of any corner by at least `least_px`; otherwise noise would tilt the rows.
    pub(super) fn fit(corners: &[CornerPair], centre: Vec2, least_px: f64) -> Option<Self> {
        let differences: Vec<f64> = corners.iter().map(|s| s.right.y - s.left.y).collect();
        let sample = |s: &CornerPair| (s.right - centre, s.right.y - s.left.y);
        let samples: Vec<(Vec2, f64)> = corners.iter().map(sample).collect();
        let width = |round: usize| WEIGHT_PX[usize::from(round >= WIDE_ROUNDS)];
        let widths: [f64; ROUNDS] = std::array::from_fn(width);
        let [offset, roll, scale] = fit_plane_robust(&samples, &widths)?;
        let mut fit = Self { centre, offset, roll, scale };
        let extent = |f: &dyn Fn(&CornerPair) -> f64| corners.iter().map(f).fold(0.0, f64::max);
        let across = extent(&|s| (s.right.x - centre.x).abs()) * fit.roll.abs();
        let down = extent(&|s| (s.right.y - centre.y).abs()) * fit.scale.abs();
        if across.max(down) < least_px {
            fit.offset = median(&differences)?;
            (fit.roll, fit.scale) = (0.0, 0.0);
        }
        Some(fit)
    }

    /// Median absolute residual of the row differences, pixels.
    pub(super) fn residual(&self, corners: &[CornerPair]) -> f64 {
        let residuals: Vec<f64> =
            corners.iter().map(|s| (s.right.y - s.left.y - self.at(s.right)).abs()).collect();
        median(&residuals).unwrap_or(f64::INFINITY)
    }
}
