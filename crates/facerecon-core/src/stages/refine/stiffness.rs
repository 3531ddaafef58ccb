//! The resistance of the surface to bending.

use super::RefineParams;
use super::bending::{Bending, CellShape};
use super::spline::Spline;
use crate::camera::RectifiedRig;
use crate::data::Match;
use crate::math::median;

/// Depth over baseline without a rig: cameras 15 cm apart and a face at 1.2 m.
const USUAL_DEPTH_RATIO: f64 = 8.0;
/// Plausible depth over baseline; a rig outside this range is limited to it.
const DEPTH_RATIOS: (f64, f64) = (1.0, 50.0);
/// Smallest weight of a cell's bending, so that control values without pixels are determined.
const MIN_WEIGHT: f64 = 1e-9;

/// Depth in pixels across per pixel of disparity, `Z / B`, at the median of the matches.
pub(super) fn depth_ratio(rig: Option<&RectifiedRig>, matches: &[Match]) -> f64 {
    let disparities: Vec<f64> = matches.iter().map(Match::disparity).collect();
    let ratio = |r: &RectifiedRig| r.depth_mm(median(&disparities)?).map(|z| z / r.baseline_mm);
    rig.and_then(ratio)
        .filter(|k| k.is_finite())
        .map_or(USUAL_DEPTH_RATIO, |k| k.clamp(DEPTH_RATIOS.0, DEPTH_RATIOS.1))
}

/// The bending energy and its weights.
pub(super) struct Stiffness {
    /// Depth in pixels across per pixel of disparity.
    pub(super) depth_ratio: f64,
    /// The bending energy of one cell.
    pub(super) bending: Bending,
    /// Weight of the squared bending in space.
    weight: f64,
    /// Curvature in space from which on the surface counts as creased, 1/px.
    crease: f64,
}

impl Stiffness {
    /// The stiffness of a spline with cells of `cell` pixels over a domain of `pixels` pixels.
    pub(super) fn new(cell: f64, pixels: usize, depth_ratio: f64, params: &RefineParams) -> Self {
        Self {
            depth_ratio,
            bending: Bending::new(cell),
            weight: params.stiffness,
            crease: 1.0 / (params.crease_radius * (pixels as f64).sqrt()),
        }
    }

    /// Weight of every cell's bending energy. It measures bending in space, because the disparity
    /// exaggerates the bending of tilted skin, and it is smaller where the surface is creased.
    pub(super) fn weights(&self, spline: &Spline) -> Vec<f64> {
        let weight = |shape: &CellShape| {
            let slope2 = (self.depth_ratio * shape.slope).powi(2);
            // Half of the full correction (1 + slope2)^-3: more accurate on the simulated captures
            // (docs/accuracy.md, "What was tried").
            let in_space = (1.0 + slope2).powf(-1.5);
            let curvature2 = (self.depth_ratio * shape.bend).powi(2) * (1.0 + slope2).powi(-3);
            let crease_factor = (1.0 + curvature2 / self.crease.powi(2)).sqrt();
            self.weight * self.depth_ratio.powi(2) * in_space / crease_factor + MIN_WEIGHT
        };
        self.bending.shapes(spline).iter().map(weight).collect()
    }
}
