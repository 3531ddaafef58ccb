//! Dots found in a photo and their correspondences.

use crate::math::Vec2;

/// A projected dot found in one photo.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dot {
    /// Centre, pixels of the image.
    pub position: Vec2,
    /// Standard deviation of its profile, pixels; 0 where the method does not measure it.
    pub sigma_px: f64,
    /// Brightness above the surroundings, grey levels; 0 where the method does not measure it.
    pub amplitude: f64,
    /// Confidence, 0 to 1.
    pub score: f64,
}

/// One dot, or other point, seen in both photos.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Match {
    /// Position in the rectified left image, pixels.
    pub left: Vec2,
    /// Position in the rectified right image, pixels.
    pub right: Vec2,
    /// `[column, row]` of the dot in the projected pattern; `None` where unknown. The origin is
    /// arbitrary unless the correspond stage reports that it found the pattern's border.
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
