//! The result of the stage.

use crate::data::{Gray, Match};
use crate::math::Vec2;

/// Refined matches and the dense disparity.
#[derive(Clone, Debug, PartialEq)]
pub struct Refined {
    /// The matches in the order given, with refined disparity (`right.x` moved) and its standard
    /// deviation. Matches that contradict the surface are removed.
    pub matches: Vec<Match>,
    /// Disparity `xl - xr` at every pixel of the rectified left photo, pixels; NaN in holes.
    pub disparity: Gray,
    /// Standard deviation of the disparity, pixels; NaN in holes.
    pub sigma_px: Gray,
    /// Distance between neighbouring dots or stripes, pixels.
    pub pitch_px: f64,
    /// Number of matches removed.
    pub dropped: usize,
    /// Root mean square of the residuals over their expected noise, each cut at 3 (about 1 for a
    /// good fit).
    pub misfit: f64,
    /// Standard deviation by which the sharper photo was smoothed to the sharpness of the other one,
    /// in pitches: positive for the left photo, negative for the right one, 0 where both are alike.
    pub blur_difference: f64,
}

impl Refined {
    /// Disparity and standard deviation at a position of the rectified left photo, pixels; `None`
    /// beside and in holes.
    pub(super) fn measured_at(&self, position: Vec2) -> Option<(f64, f64)> {
        let disparity =
            self.disparity.bilinear(position.x, position.y).filter(|d| d.is_finite())?;
        let (x, y) = (position.x.round() as isize, position.y.round() as isize);
        let sigma = self.sigma_px.get(x, y).filter(|s| s.is_finite())?;
        Some((f64::from(disparity), f64::from(sigma)))
    }
}
