//! What one session in front of the cameras gave: photographs, pattern, rig, marks.

use super::{Gray, LandmarkPairs, Pair, Rgb};
use crate::camera::{Pinhole, StereoRig};
use crate::math::Similarity;

/// A photograph, in colour and in grey (16-bit sources keep their fractions in grey).
#[derive(Clone, Debug, PartialEq)]
pub struct Photo {
    /// Colour, 8 bit sRGB.
    pub rgb: Rgb,
    /// Luma, 0 to 255.
    pub gray: Gray,
}

impl Photo {
    /// A photo from colour pixels.
    pub fn from_rgb(rgb: Rgb) -> Self {
        Self { gray: rgb.to_gray(), rgb }
    }

    /// `(width, height)`, pixels.
    pub fn size(&self) -> (usize, usize) {
        self.rgb.size()
    }
}

/// The kind of a projected pattern.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PatternKind {
    /// A regular lattice of dots.
    Dots,
    /// Parallel vertical stripes of varying width and colour.
    Stripes,
}

/// The projected pattern.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pattern {
    /// Dots or stripes.
    pub kind: PatternKind,
    /// Dots a row (or number of stripes).
    pub columns: usize,
    /// Dots a column.
    pub rows: usize,
    /// Rotation of the lattice, radians, clockwise as seen in the picture.
    pub rotation: f64,
}

/// The three pairs marked by hand (thesis section 2.3), original pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seeds {
    /// A dot on the head.
    pub head: Pair,
    /// A dot at the ear at the left of the picture.
    pub left_ear: Pair,
    /// A dot at the ear at the right of the picture.
    pub right_ear: Pair,
}

/// A further photo for the texture, with its camera.
#[derive(Clone, Debug, PartialEq)]
pub struct ExtraPhoto {
    /// The photo.
    pub photo: Photo,
    /// Its camera.
    pub camera: Pinhole,
    /// `X_camera = R X_left + T`, millimetres.
    pub camera_from_left: Similarity,
}

/// One capture, ready to be reconstructed.
#[derive(Clone, Debug, PartialEq)]
pub struct Capture {
    /// The left photo with the pattern.
    pub left: Photo,
    /// The right photo with the pattern, of the same size.
    pub right: Photo,
    /// The pair without the pattern, `[left, right]`.
    pub plain: Option<[Photo; 2]>,
    /// Further photos for the texture.
    pub extra: Vec<ExtraPhoto>,
    /// The projected pattern.
    pub pattern: Pattern,
    /// The cameras; without them the result is in model units.
    pub rig: Option<StereoRig>,
    /// Marked pairs, original pixels.
    pub seeds: Option<Seeds>,
    /// Marked features, original pixels.
    pub landmarks: LandmarkPairs,
}
