//! What a capture is read from, and what reading gives.

use std::path::PathBuf;

use crate::data::{Capture, PatternKind};

/// Name of the capture file in its folder.
pub(super) const FILE_NAME: &str = "capture.toml";

/// Files and values given on the command line; they replace those of the capture file, and the
/// files may be in any folder.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CaptureFiles {
    /// Left dotted photo.
    pub left: Option<PathBuf>,
    /// Right dotted photo.
    pub right: Option<PathBuf>,
    /// Left plain photo.
    pub left_plain: Option<PathBuf>,
    /// Right plain photo.
    pub right_plain: Option<PathBuf>,
    /// Stereo calibration.
    pub calibration: Option<PathBuf>,
    /// Columns of the pattern.
    pub columns: Option<usize>,
    /// Rows of the pattern.
    pub rows: Option<usize>,
    /// Rotation of the pattern's lattice, degrees.
    pub rotation_deg: Option<f64>,
    /// Kind of the pattern.
    pub kind: Option<PatternKind>,
}

/// A capture and the files it was read from.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadedCapture {
    /// The capture; it is valid.
    pub capture: Capture,
    /// Warnings: unknown keys, an unusual baseline, assumed values.
    pub warnings: Vec<String>,
    /// Every file that was read, the capture file first.
    pub sources: Vec<PathBuf>,
}
