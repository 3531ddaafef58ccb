//! What a texture is made from.

use crate::camera::Pinhole;
use crate::data::{Gray, Mesh, Rgb};
use crate::math::{Similarity, Vec2, Vec3};

/// A plain photo with its camera and dots.
#[derive(Clone, Copy, Debug)]
pub struct TexturePhoto<'a> {
    /// The photo.
    pub image: &'a Rgb,
    /// Its camera with `camera_from_mesh`, where known.
    pub camera: Option<(Pinhole, Similarity)>,
    /// The dotted photo from the same camera, where there is one: it shows where the head was when
    /// it was measured.
    pub patterned: Option<&'a Gray>,
    /// Matched dots.
    pub dots: &'a [TextureDot],
}

/// A matched dot on the mesh and in a photo.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureDot {
    /// Index of the nearest vertex of the mesh.
    pub vertex: usize,
    /// Measured position, mesh frame.
    pub point: Vec3,
    /// Position in the photo, original pixels.
    pub pixel: Vec2,
}

/// Input of the stage.
#[derive(Clone, Copy, Debug)]
pub struct TextureInput<'a> {
    /// The head with texture coordinates, in the frame from which the photos' `camera_from_mesh`
    /// leads.
    pub mesh: &'a Mesh,
    /// The photos: left, right, then any others.
    pub photos: &'a [TexturePhoto<'a>],
    /// The template's own texture.
    pub template_texture: Option<&'a Rgb>,
}
