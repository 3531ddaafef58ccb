//! Software z-buffer renderer: visibility for the texture, the simulator and all preview pictures.
//! Floor 2. No display or graphics card is needed, and the same input gives the same bytes.

mod font;
mod heat;
mod light;
mod occlusion;
mod picture;
mod sheet;
mod view;
mod zbuffer;

#[cfg(test)]
mod tests;

pub use font::{GLYPH_HEIGHT, draw_text, text_width};
pub use heat::{Heat, heat_color, nice_ceiling};
pub use light::{encode_srgb, linear_from_srgb, sample_texture, srgb_from_linear};
pub use occlusion::ambient_openness;
pub use picture::{Mode, Scene, Studio, photograph, picture};
pub use sheet::{contact_sheet, tile};
pub use view::{Frame, View};
pub use zbuffer::{Buffers, NO_FACE, rasterize, supersampled};

use crate::data::MeshError;

/// Longest side of a picture, pixels.
pub const LARGEST_SIDE: usize = 16_384;

/// A picture that cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RenderError {
    /// The mesh is not one.
    #[error("cannot draw the mesh: {0}")]
    Mesh(#[from] MeshError),
    /// A size of zero or beyond all measure.
    #[error(
        "cannot draw a picture of {width}x{height} pixels; each side must be 1 to {LARGEST_SIDE}"
    )]
    Size {
        /// Width asked for.
        width: usize,
        /// Height asked for.
        height: usize,
    },
    /// A camera without focal length.
    #[error("cannot draw: the camera's numbers are not those of a camera")]
    Camera,
    /// A heat map without a value for every vertex.
    #[error(
        "a heat map needs one value for each of the {expected} vertices, but got {got}; compare the mesh with another one first"
    )]
    Heat {
        /// Values given.
        got: usize,
        /// Vertices there are.
        expected: usize,
    },
    /// A view that has no name here.
    #[error("there is no view {got:?}; the views are: {names}")]
    View {
        /// Name given.
        got: String,
        /// Names there are.
        names: String,
    },
    /// No view at all.
    #[error("a contact sheet needs at least one view")]
    NoViews,
}
