//! Software z-buffer renderer: visibility for the texture, the simulator and all preview pictures.
//! It needs no display or graphics card, and the same input gives the same bytes.

mod error;
mod font;
mod heat;
mod light;
mod occlusion;
mod photograph;
mod picture;
mod ramp;
mod sheet;
mod surface;
mod view;
mod zbuffer;

#[cfg(test)]
mod tests;

pub use error::{LARGEST_SIDE, RenderError};
pub use font::{GLYPH_HEIGHT, draw_text, text_width};
pub use heat::{Heat, nice_ceiling};
pub(crate) use light::linear_table;
pub use light::{encode_srgb, linear_from_srgb, sample_texture, srgb_from_linear};
pub use occlusion::ambient_openness;
pub use photograph::photograph;
pub use picture::{Mode, Scene, Studio, picture};
pub(crate) use ramp::disparity_color;
pub use ramp::heat_color;
pub use sheet::{contact_sheet, tile};
pub use view::{Frame, View};
pub use zbuffer::{Buffers, NO_FACE, rasterize, supersampled};
