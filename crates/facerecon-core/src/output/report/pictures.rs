//! Pictures for the page: meshes drawn, photographs scaled down, data URLs.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

use crate::data::{Mesh, Rgb};
use crate::io;
use crate::render::{Mode, Scene, Studio, View};

/// Photographs are shown no wider than this, pixels: half the page on a screen of double density.
pub(super) const MAX_PHOTO_WIDTH: usize = 1024;
/// Width and height of a drawn mesh, pixels: a third of the page's width.
const MESH_SIZE: usize = 370;
/// Quality of embedded JPEG pictures, 1 to 100: no artefacts visible at the size shown.
const JPEG_QUALITY: u8 = 90;

/// A picture as a data URL: as PNG, or where that takes more than a byte a pixel, as photographs
/// do, as JPEG. `None` for a picture without pixels.
pub(super) fn data_url(image: &Rgb) -> Option<String> {
    let png = io::encode_png(image).ok()?;
    let (kind, bytes) = if png.len() > image.data().len() {
        ("jpeg", io::encode_jpeg(image, JPEG_QUALITY).ok()?)
    } else {
        ("png", png)
    };
    Some(format!("data:image/{kind};base64,{}", STANDARD.encode(bytes)))
}

/// A mesh ready to be drawn without its texture.
pub(super) fn shaded(mesh: &Mesh) -> Option<Studio<'_>> {
    Studio::new(&Scene::new(mesh), Mode::Shaded).ok()
}

/// A view of a mesh; grey for a mesh that cannot be drawn.
pub(super) fn drawn(studio: Option<&Studio<'_>>, view: View) -> Rgb {
    studio
        .and_then(|s| s.picture(view, None, (MESH_SIZE, MESH_SIZE)).ok())
        .unwrap_or_else(|| Rgb::filled(MESH_SIZE, MESH_SIZE, [230, 230, 230]))
}

/// A picture at most `width` wide, by averaging whole blocks.
pub(super) fn scaled_down(image: &Rgb, width: usize) -> Rgb {
    let k = block_size(image.width(), width);
    if k == 1 {
        return image.clone();
    }
    image.block_sums(k).map(|sum| sum.map(|s| (s / (k * k) as u32) as u8))
}

/// Side of the block of pixels that becomes one pixel in a picture at most `shown` wide.
pub(super) fn block_size(width: usize, shown: usize) -> usize {
    width.div_ceil(shown).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scaling_down_averages_blocks() {
        let image = Rgb::from_fn(4, 2, |x, _| [if x < 2 { 0 } else { 200 }, 10, 20]);
        assert_eq!(scaled_down(&image, 2).data(), [[0, 10, 20], [200, 10, 20]]);
    }
}
