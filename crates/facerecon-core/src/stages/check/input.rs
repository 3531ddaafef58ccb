//! What the check is given.

use crate::camera::Rectification;
use crate::data::{Capture, Dot};

/// The dots of one photo.
#[derive(Clone, Copy, Debug)]
pub struct PhotoDots<'a> {
    /// The dots, in pixels of the photo as taken.
    pub dots: &'a [Dot],
    /// Median distance from a dot to the nearest other one, pixels.
    pub spacing_px: f64,
}

/// A capture with what earlier stages found in it.
#[derive(Clone, Debug)]
pub struct CheckInput<'a> {
    /// The capture.
    pub capture: &'a Capture,
    /// Dots of the left and the right photo; `None` where no pattern was found. Not used for
    /// stripes.
    pub dots: [Option<PhotoDots<'a>>; 2],
    /// The views after rectification, with rows corrected where that was possible; else why there
    /// are none.
    pub views: Result<&'a Rectification, String>,
    /// Whether rectification corrected the rows by what it measured in the photos.
    pub rows_corrected: bool,
}
