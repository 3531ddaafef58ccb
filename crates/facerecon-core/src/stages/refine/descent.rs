//! Gauss-Newton steps of the spline's control values against residuals and bending.

use super::normal_equations::NormalEquations;
use super::photometry::{Linearisation, PhotometricModel};
use super::spline::Spline;
use super::stiffness::Stiffness;
use crate::math::percentile;
use crate::observer::{Cancelled, Event, Observer};

/// Relative residual at which the linear solver stops. The next Gauss-Newton step corrects what
/// remains.
const SOLVER_TOLERANCE: f64 = 0.02;
/// Most steps of the linear solver.
const MAX_SOLVER_STEPS: usize = 150;
/// Longest step of a control value, in pitches of disparity: the linearisation holds for a fraction
/// of a dot.
const MAX_STEP: f64 = 0.11;
/// The descent ends when this share of the control values ...
const CONVERGED_SHARE: f64 = 0.95;
/// ... moves by less than this, in pitches: a quarter of the median error (docs/accuracy.md).
const CONVERGED: f64 = 0.0011;

/// Gauss-Newton steps until the spline converges, at most `max_steps`. `pitch` is in working pixels.
/// Returns the last linearisation.
pub(super) fn descend(
    model: &PhotometricModel,
    spline: &mut Spline,
    stiffness: &Stiffness,
    pitch: f64,
    max_steps: usize,
    observer: &dyn Observer,
) -> Result<Linearisation, Cancelled> {
    let mut current = model.linearise(spline);
    for step in 1..=max_steps {
        observer.check()?;
        let mut equations = NormalEquations::photometric(
            spline,
            &model.domain,
            &current.information,
            &current.gradient,
        );
        equations.add_bending(spline, &stiffness.bending, &stiffness.weights(spline));
        let change = equations.solve(SOLVER_TOLERANCE, MAX_SOLVER_STEPS);
        for (c, d) in spline.control.iter_mut().zip(&change) {
            *c += d.clamp(-MAX_STEP * pitch, MAX_STEP * pitch);
        }
        let sizes: Vec<f64> = change.iter().map(|d| d.abs()).collect();
        current = model.linearise(spline);
        observer.event(&Event::Iteration { stage: "refine", step, error: current.misfit });
        if percentile(&sizes, CONVERGED_SHARE).unwrap_or(0.0) < CONVERGED * pitch {
            break;
        }
    }
    Ok(current)
}
