//! Errors of the stage.

use crate::data::MeshError;
use crate::observer::Cancelled;
use crate::render::RenderError;
use crate::settings::SettingsError;

/// A texture that cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TextureError {
    /// An invalid mesh.
    #[error("the mesh cannot be textured: {0}")]
    Mesh(#[from] MeshError),
    /// A mesh without texture coordinates.
    #[error("the mesh has no texture coordinates; use a template that has them")]
    NoUv,
    /// Not enough photos.
    #[error(
        "{got} plain photos were given, but {needed} are needed; add left_plain and right_plain to the capture, or set texture.source"
    )]
    Photos {
        /// Number given.
        got: usize,
        /// Number needed.
        needed: usize,
    },
    /// An image without pixels.
    #[error("photo {index} (from 0) has no pixels")]
    EmptyPhoto {
        /// Index of the photo.
        index: usize,
    },
    /// A dot that does not fit the mesh.
    #[error(
        "photo {photo} (from 0): dot {dot} names vertex {vertex}, but the mesh has {count} vertices, or its position is not finite"
    )]
    Dot {
        /// Index of the photo.
        photo: usize,
        /// Index of the dot.
        dot: usize,
        /// Vertex it names.
        vertex: usize,
        /// Number of vertices.
        count: usize,
    },
    /// Not enough dots.
    #[error(
        "{got} matched dots lie inside the photo and on the texture map, but at least {needed} are needed to bound the face; check the matches"
    )]
    TooFewDots {
        /// Number found.
        got: usize,
        /// Number needed.
        needed: usize,
    },
    /// A region without area.
    #[error(
        "the extreme dots enclose {width:.1} x {height:.1} texels on the texture map, but at least 2 x 2 are needed; use a template whose texture coordinates unfold the face, or a larger texture.size"
    )]
    Boundary {
        /// Width of the region, texels.
        width: f64,
        /// Height of the region, texels.
        height: f64,
    },
    /// A parameter outside its range.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// A photo without a camera whose dots do not determine one.
    #[error(
        "photo {photo} (from 0) has no camera, and its {dots} dots do not determine one: the residual is {rms:.1} px (at most {limit:.1} px, from at least 12 dots, is usable); add a calibration"
    )]
    NoCamera {
        /// Index of the photo.
        photo: usize,
        /// Number of its dots.
        dots: usize,
        /// Robust RMS residual, pixels.
        rms: f64,
        /// Largest usable residual, pixels.
        limit: f64,
    },
    /// The renderer refused mesh or camera.
    #[error("the head cannot be drawn through the camera: {0}")]
    Render(#[from] RenderError),
    /// Cancelled by the observer.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

crate::stages::stage_error!(TextureError, "texture");
