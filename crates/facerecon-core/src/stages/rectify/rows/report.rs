//! What the measurement of the rows gives.

use crate::camera::Rectification;

/// How level the rows are and whether they were corrected.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RowReport {
    /// Rows that the right photo is lower than the left, pixels.
    pub offset_px: f64,
    /// Roll of the right photo against the left, degrees, clockwise.
    pub roll_deg: f64,
    /// Vertical scale of the right photo relative to the left, minus 1.
    pub scale: f64,
    /// Median row difference after the correction, pixels; `None` when not measured.
    pub residual_px: Option<f64>,
    /// Whether the views were corrected by these figures.
    pub corrected: bool,
}

/// Measured rows and the views corrected by them.
pub(in crate::stages::rectify) struct RowCorrection {
    /// Corrected views; `None` where the rows stay as they are.
    pub rectification: Option<Rectification>,
    pub report: RowReport,
    /// What the user should know.
    pub warning: Option<String>,
}
