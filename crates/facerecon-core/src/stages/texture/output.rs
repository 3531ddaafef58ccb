//! What the stage makes.

use std::fmt;

use crate::data::{Raster, Rgb};
use crate::math::Similarity;

/// A texture image.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// The colours; row 0 is at v = 1.
    pub image: Rgb,
    /// For each texel the photos that show it, as a sum of [`SEEN_LEFT`], [`SEEN_RIGHT`] and
    /// [`SEEN_EXTRA`]; [`FILLED`] where its colour is filled in; the projective method writes 0 off
    /// the mesh.
    pub coverage: Raster<u8>,
    /// How the head moved between the dotted and the plain photos, where that was found.
    pub head_motion: Option<HeadMotion>,
}

/// Coverage: visible in the first (left) photo.
pub const SEEN_LEFT: u8 = 1;
/// Coverage: visible in the second (right) photo.
pub const SEEN_RIGHT: u8 = 2;
/// Coverage: visible in a further photo.
pub const SEEN_EXTRA: u8 = 4;
/// Coverage: visible in no photo, filled in.
pub const FILLED: u8 = 128;

/// Motion of the head between the dotted and the plain photos.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeadMotion {
    /// From the mesh as measured to the head in the plain photos, mesh frame.
    pub moved_from_mesh: Similarity,
    /// Mean displacement of the visible surface, mm.
    pub distance_mm: f64,
    /// Rotation, degrees.
    pub angle_deg: f64,
    /// Difference between the photos that remains, as a fraction of that without correction.
    pub residual: f64,
}

impl fmt::Display for HeadMotion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "the head moved by {:.1} mm and turned by {:.1} degrees between the dotted and the plain photos; the texture is corrected for this",
            self.distance_mm, self.angle_deg
        )
    }
}
