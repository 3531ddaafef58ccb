//! What reading a calibration gives.

use crate::camera::StereoRig;

/// A stereo calibration and the warnings of its reading.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibration {
    /// The rig, millimetres.
    pub rig: StereoRig,
    /// Warnings: a missing distortion, a skew, an unusual baseline.
    pub warnings: Vec<String>,
}
