//! Errors of the renderer.

use crate::data::MeshError;

/// Longest side of a picture, pixels.
pub const LARGEST_SIDE: usize = 16_384;

/// A picture that cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RenderError {
    /// An invalid mesh.
    #[error("cannot draw the mesh: {0}")]
    Mesh(#[from] MeshError),
    /// A size of zero or beyond the limit.
    #[error(
        "cannot draw a picture of {width}x{height} pixels; each side must be 1 to {LARGEST_SIDE}"
    )]
    Size {
        /// Requested width.
        width: usize,
        /// Requested height.
        height: usize,
    },
    /// A camera with an impossible focal length, principal point or distortion.
    #[error(
        "cannot draw: the camera has numbers that are not finite, or a focal length of 0 or less; check the calibration"
    )]
    Camera,
    /// A heat map without a value for every vertex.
    #[error(
        "a heat map needs one value for each of the {expected} vertices, but {got} were given; compare the mesh with another one first"
    )]
    Heat {
        /// Number of values given.
        got: usize,
        /// Number of vertices.
        expected: usize,
    },
    /// A mesh without standard deviations.
    #[error(
        "the mesh has no standard deviations and measured flags of its vertices; use face.glb of a result folder, or a PLY written from it"
    )]
    NoUncertainty,
    /// An unknown view.
    #[error("there is no view {got:?}; the views are: {names}")]
    View {
        /// Name given.
        got: String,
        /// Known names.
        names: String,
    },
    /// No views or pictures.
    #[error("a contact sheet needs at least one view")]
    NoViews,
}
