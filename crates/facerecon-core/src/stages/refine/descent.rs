//! The descent: Gauss-Newton steps of the surface against the photographs and its own stiffness.

use super::bending::{Bending, Shape};
use super::normal::Normal;
use super::photometry::{Linearised, Scene};
use super::surface::Surface;
use super::{RefineError, RefineParams, stop};
use crate::math::percentile;
use crate::observer::{Event, Observer};

/// How the surface resists.
pub(super) struct Sheet {
    /// Depth in pixels across per pixel of disparity.
    pub(super) relief: f64,
    /// The bending energy of one cell.
    pub(super) bending: Bending,
    /// Weight of the squared bending in space.
    pub(super) stiffness: f64,
    /// Bending at which the surface counts as creased, 1/px.
    pub(super) crease: f64,
}

impl Sheet {
    /// Weight of every cell's bending: that of the surface in space (not of its picture, which
    /// exaggerates the bending of tilted skin), less where it is creased.
    fn weights(&self, surface: &Surface) -> Vec<f64> {
        let weight = |shape: &Shape| {
            let tilt = (self.relief * shape.tilt).powi(2);
            let in_space = (1.0 + tilt).powf(-1.5);
            let curvature = (self.relief * shape.bend).powi(2) * (1.0 + tilt).powi(-3);
            let soft = (1.0 + curvature / self.crease.powi(2)).sqrt();
            self.stiffness * self.relief.powi(2) * in_space / soft + 1e-9
        };
        self.bending.shapes(surface).iter().map(weight).collect()
    }
}

/// Gauss-Newton until the surface rests; returns the last linearisation.
pub(super) fn descend(
    scene: &Scene,
    surface: &mut Surface,
    sheet: &Sheet,
    params: &RefineParams,
    observer: &dyn Observer,
) -> Result<Linearised, RefineError> {
    let mut now = scene.linearise(surface);
    for step in 1..=params.iterations {
        stop(observer)?;
        let mut normal = Normal::photometric(surface, &scene.domain, &now.information, &now.drive);
        normal.add_bending(surface, &sheet.bending, &sheet.weights(surface));
        let change = normal.solve(0.02, 150);
        for (c, d) in surface.control.iter_mut().zip(&change) {
            // a step beyond a fraction of a dot would leave what the linearisation knows
            *c += d.clamp(-1.0, 1.0);
        }
        let sizes: Vec<f64> = change.iter().map(|d| d.abs()).collect();
        now = scene.linearise(surface);
        observer.event(&Event::Iteration { stage: "refine", step, error: now.misfit });
        if percentile(&sizes, 0.95).unwrap_or(0.0) < 0.01 {
            break;
        }
    }
    Ok(now)
}
