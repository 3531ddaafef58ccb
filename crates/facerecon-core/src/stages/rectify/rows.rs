//! Row errors measured from the photos themselves, and their correction.
//!
//! Corners of the plain pair are matched first: they do not repeat, so that an error of a whole row
//! of dots is detected. Each match is then refined on the dotted pair, whose dots determine the row
//! everywhere on the skin.

mod affine;
mod calibrated;
mod corners;
mod report;
mod rotation;
mod shi_tomasi;
mod uncalibrated;

#[cfg(test)]
mod tests;

pub(super) use report::RowCorrection;
pub use report::RowReport;

use crate::camera::Rectification;
use crate::data::Gray;
use crate::settings::settings;
use corners::find_corners;

settings! {
    /// Measuring and correcting the rows of the photos.
    pub struct RowsParams {
        /// Whether the rows are measured.
        measure: bool = true;
        /// Whether a row error is corrected, or only reported.
        correct: bool = true;
        /// Row error below which a calibrated rig is not corrected.
        least_px: f64 = 0.1, range 0.0..=10.0, unit "px";
        /// Maximum row error of a calibrated rig that is corrected; a larger one means that the
        /// calibration belongs to another rig.
        largest_px: f64 = 12.0, range 0.0..=200.0, unit "px";
        /// Maximum median row difference after a correction for it to be accepted.
        residual_px: f64 = 0.7, range 0.01..=10.0, unit "px";
        /// Maximum roll of the right photo against the left, without calibration.
        roll_deg: f64 = 15.0, range 0.0..=45.0, unit "degrees";
        /// Maximum ratio of the photos' scales (or its inverse), without calibration.
        scale: f64 = 1.25, range 1.0..=2.0;
        /// Maximum offset of the rows, without calibration, as a fraction of the photo's height.
        offset: f64 = 0.2, range 0.0..=0.5;
    }
}

/// Corners of a calibrated rig are searched within this multiple of `rows.largest_px`, so that
/// errors somewhat above the maximum are measured and reported.
const SEARCH_FACTOR: f64 = 1.5;

/// Measures the rows of a pair that `rectification` should make level, and corrects the views.
/// `dots` and `plain` are the dotted and the plain pair as resampled by the views. Stripes along the
/// columns do not determine rows, so for stripes there are no `dots`.
pub(super) fn correct_rows(
    rectification: &Rectification,
    dots: Option<[&Gray; 2]>,
    plain: Option<[&Gray; 2]>,
    params: &RowsParams,
) -> RowCorrection {
    match &rectification.rig {
        Some(rig) => {
            let corners = find_corners(dots, plain, SEARCH_FACTOR * params.largest_px);
            calibrated::correct(rectification, rig.principal_right, &corners, params)
        }
        None => uncalibrated::correct(rectification, dots, plain, params),
    }
}
