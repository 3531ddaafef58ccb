//! Parameters of the stripes.

use crate::settings::settings;

settings! {
    /// Correspondence of stripes (captures of kind "stripes").
    pub struct StripesParams {
        /// Distance between the rows that are matched.
        row_step_px: usize = 3, range 1.0..=64.0, unit "px";
        /// Smoothing along the row before edges are detected (standard deviation).
        smooth_px: f64 = 1.2, range 0.3..=10.0, unit "px";
        /// Least step of brightness (sum of the colour channels) at an edge, per pixel.
        min_step: f64 = 5.0, range 0.1..=200.0, unit "grey levels";
        /// Share of the neighbouring rows that must agree on the match of an edge.
        min_votes: f64 = 0.6, range 0.1..=1.0;
        /// Step of depth between the subject and its background, as a share of its depth; without a
        /// calibrated rig, step of disparity as a share of the width of the photo.
        gap: f64 = 0.03, range 0.001..=1.0;
    }
}
