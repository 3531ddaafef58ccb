//! Figures of one photo as a whole.

use crate::data::Gray;
use crate::math::percentile;

/// Grey levels from here up count as saturated. Just below 255: compression changes saturated pixels
/// by a level or two.
const SATURATED: f32 = 253.0;
/// Percentile of the grey levels that stands for the lit parts. Set by hand: the face must fill at
/// least a tenth of the photo.
const LIT_PERCENTILE: f64 = 0.9;
/// Every third pixel is enough for a percentile.
const LIT_STEP: usize = 3;

/// Grey level of the lit parts.
pub(super) fn lit_level(image: &Gray) -> f64 {
    let some: Vec<f64> = image.data().iter().step_by(LIT_STEP).map(|v| f64::from(*v)).collect();
    percentile(&some, LIT_PERCENTILE).unwrap_or(0.0)
}

/// Fraction of saturated pixels.
pub(super) fn saturated_fraction(image: &Gray) -> f64 {
    let count = image.data().iter().filter(|v| **v >= SATURATED).count();
    count as f64 / image.data().len().max(1) as f64
}
