//! A capture: the photographs of one session, the projected pattern, the rig and the marks.

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

crate::settings::choices! {
    /// The kind of a projected pattern.
    pub enum PatternKind {
        /// A regular lattice of dots.
        Dots = "dots",
        /// Parallel vertical stripes of varying width and colour.
        Stripes = "stripes",
    }
}

/// The projected pattern.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pattern {
    /// Dots or stripes.
    pub kind: PatternKind,
    /// Dots in a row, or number of stripes (0 where unknown: stripes are identified without it).
    pub columns: usize,
    /// Dots in a column; 0 for stripes.
    pub rows: usize,
    /// Rotation of the lattice, radians, clockwise as seen in the picture.
    pub rotation: f64,
}

/// The three seeds: pairs marked by hand (thesis section 2.3), pixels of the photos.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seeds {
    /// A dot on the head.
    pub head: Pair,
    /// A dot at the ear at the left of the picture.
    pub left_ear: Pair,
    /// A dot at the ear at the right of the picture.
    pub right_ear: Pair,
}

/// An extra photo for the texture, with its camera.
#[derive(Clone, Debug, PartialEq)]
pub struct ExtraPhoto {
    /// The photo.
    pub photo: Photo,
    /// Its camera.
    pub camera: Pinhole,
    /// `X_camera = R X_left + T`, millimetres.
    pub camera_from_left: Similarity,
}

/// One capture: the input of a reconstruction. [`Capture::validate`] checks it.
#[derive(Clone, Debug, PartialEq)]
pub struct Capture {
    /// The left dotted photo.
    pub left: Photo,
    /// The right dotted photo, of the same size.
    pub right: Photo,
    /// The plain pair `[left, right]`, of the same size.
    pub plain: Option<[Photo; 2]>,
    /// Extra photos for the texture, of any size.
    pub extra: Vec<ExtraPhoto>,
    /// The projected pattern.
    pub pattern: Pattern,
    /// The nominal rig; without it the result is in model units.
    pub rig: Option<StereoRig>,
    /// Seeds, pixels of the photos.
    pub seeds: Option<Seeds>,
    /// Marked landmarks, pixels of the photos.
    pub landmarks: LandmarkPairs,
}
