//! Dots found in a photo and their correspondences.

use crate::math::Vec2;

/// A projected dot found in one photo.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dot {
    /// Centre, pixels of the image it was found in.
    pub position: Vec2,
    /// Standard deviation of its profile, pixels; 0 where the method does not measure it.
    pub sigma_px: f64,
    /// Height above the surroundings, grey levels; 0 where the method does not measure it.
    pub amplitude: f64,
    /// Confidence, 0 to 1.
    pub score: f64,
}

/// A point seen in both photos.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Match {
    /// Position in the rectified left image, pixels.
    pub left: Vec2,
    /// Position in the rectified right image, pixels.
    pub right: Vec2,
    /// Place in the projected pattern as `[column, row]`, relative to any origin unless the
    /// correspondence stage says it found the pattern's border; `None` where unknown.
    pub lattice: Option<[i32; 2]>,
    /// Standard deviation of the disparity, pixels; 0 where the method does not measure it.
    pub sigma_px: f64,
    /// Confidence, 0 to 1.
    pub score: f64,
}

impl Match {
    /// Disparity `xl - xr`, rectified pixels.
    pub fn disparity(&self) -> f64 {
        self.left.x - self.right.x
    }
}

/// The same point in both photos, pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    /// Position in the left photo.
    pub left: Vec2,
    /// Position in the right photo.
    pub right: Vec2,
}
