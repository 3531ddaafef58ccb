//! Input of the stage.

use crate::camera::RectifiedRig;
use crate::data::{Dot, Gray, Pattern, Seeds};

/// Input of [`super::correspond`]; all positions in rectified pixels.
#[derive(Clone, Copy, Debug)]
pub struct CorrespondInput<'a> {
    /// Dots of the left photo.
    pub left: &'a [Dot],
    /// Dots of the right photo.
    pub right: &'a [Dot],
    /// Usual distance between neighbouring dots, pixels.
    pub spacing_px: f64,
    /// The rectified plain pair, `[left, right]`, grey levels 0 to 255.
    pub plain: Option<[&'a Gray; 2]>,
    /// The projected pattern.
    pub pattern: &'a Pattern,
    /// The three marked pairs, RECTIFIED pixels.
    pub seeds: Option<Seeds>,
    /// Baseline, focal length and principal points of the rectified pair, where calibrated.
    pub rig: Option<&'a RectifiedRig>,
}
