//! Thresholds of the scan in pixels.

use super::params::ScanParams;
use crate::data::Pattern;
use crate::stages::correspond::error::CorrespondError;
use crate::stages::correspond::input::CorrespondInput;

/// Thresholds of the scan, all in rectified pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// Greatest difference of rows between the dots of a match.
    pub rows: f64,
    /// Greatest difference between the distances to the nearest matched dot in both photos.
    pub distance: f64,
    /// Greatest distance of a dot from the nearest matched dot to be searched.
    pub reach: f64,
    /// Greatest distance of a seed from the nearest dot.
    pub seed: f64,
    /// Measured spacing.
    pub spacing: f64,
}

impl Limits {
    /// The thesis sets its threshold by "the pixel difference between any two neighbour points at
    /// x-coordinate" and leaves other patterns open. Here the measured spacing is converted to the
    /// x direction by the aspect ratio of a cell of the pattern.
    pub(super) fn new(
        input: &CorrespondInput<'_>,
        params: &ScanParams,
    ) -> Result<Self, CorrespondError> {
        let Pattern { columns, rows, .. } = *input.pattern;
        let spacing = input.spacing_px;
        if columns == 0 || rows == 0 || !(spacing > 0.0 && spacing.is_finite()) {
            return Err(CorrespondError::Pattern { columns, rows, spacing_px: spacing });
        }
        // width over height; the measured spacing is the shorter of the two
        let cell_aspect = params.picture_aspect * rows as f64 / columns as f64;
        let along_x = spacing * cell_aspect.max(1.0);
        Ok(Self {
            rows: params.row_tolerance_px,
            distance: params.distance_tolerance * along_x,
            reach: params.reach * along_x,
            seed: params.seed_tolerance * spacing,
            spacing,
        })
    }
}
