//! Stage texture: colour the head from the photos without the pattern (thesis chapter 5).

mod projective;
mod scanline;
mod scanline_boundary;

use crate::camera::Pinhole;
use crate::data::{Gray, Mesh, MeshError, Raster, Rgb};
use crate::math::{Similarity, Vec2, Vec3};
use crate::observer::{Artifact, Cancelled, Observer};

use crate::settings::{SettingsError, Value};
pub use projective::{HeadMotion, ProjectiveParams};

crate::choices! {
    /// How the texture is made.
    pub enum TextureMethod {
        /// Lines of the photos, spread or narrowed to fit (thesis chapter 5); needs no cameras.
        Scanline = "scanline",
        /// All photos projected through their cameras and blended.
        Projective = "projective",
    }
}

crate::choices! {
    /// The region the scan-line method copies.
    pub enum Boundary {
        /// The box around the four extreme dots (thesis Fig. 5.2).
        Rectangle = "rectangle",
        /// The box with its four corners cut, as the face lies in it (thesis Fig. 5.3, 5.4).
        Hexagon = "hexagon",
    }
}

crate::choices! {
    /// Which photo the scan-line method takes its lines from.
    pub enum Source {
        /// The left half of the face from the left photo, the right half from the right one.
        Halves = "halves",
        /// The left photo alone.
        Left = "left",
        /// The right photo alone.
        Right = "right",
    }
}

crate::choices! {
    /// The colour of what no photo gave.
    pub enum Rest {
        /// The median colour of the face.
        Skin = "skin",
        /// The template's own texture, where it has one; else the median colour.
        Template = "template",
    }
}

crate::settings! {
    /// Making the texture.
    pub struct TextureParams {
        /// How the texture is made.
        method: TextureMethod = TextureMethod::Scanline;
        /// Edge of the square texture; the thesis starts with 1024.
        size: usize = 1024, range 16.0..=8192.0, unit "px";
        /// Scan-line: the region that is copied.
        boundary: Boundary = Boundary::Hexagon;
        /// Scan-line: which photo the lines come from.
        source: Source = Source::Halves;
        /// Scan-line: how many stretches a line is spread in, each between dots that lie along it;
        /// 1 spreads the whole line evenly from edge to edge, as the thesis does.
        stretches: usize = 10, range 1.0..=64.0;
        /// Colour of what no photo gave.
        rest: Rest = Rest::Skin;
        /// The projective method's own parameters.
        projective: ProjectiveParams = ProjectiveParams::default();
    }
}

/// A photo without the pattern, and where the dots and the head lie in it.
#[derive(Clone, Copy, Debug)]
pub struct TexturePhoto<'a> {
    /// The photo.
    pub image: &'a Rgb,
    /// Its camera with `camera_from_mesh`, where known.
    pub camera: Option<(Pinhole, Similarity)>,
    /// The photo with the pattern from the same camera, where there is one: it shows where the head
    /// was when it was measured.
    pub patterned: Option<&'a Gray>,
    /// Matched dots.
    pub dots: &'a [TextureDot],
}

/// A matched dot on the mesh and in a photo.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureDot {
    /// The nearest vertex of the mesh.
    pub vertex: usize,
    /// Where the dot was measured, in the mesh's frame.
    pub point: Vec3,
    /// Position in the photo, original pixels.
    pub pixel: Vec2,
}

/// What the texture is made of.
#[derive(Clone, Copy, Debug)]
pub struct TextureInput<'a> {
    /// The head, with texture coordinates; in the frame `camera_from_mesh` starts from.
    pub mesh: &'a Mesh,
    /// The photos: left, right, then any others.
    pub photos: &'a [TexturePhoto<'a>],
    /// The template's own texture.
    pub template_texture: Option<&'a Rgb>,
}

/// A texture image.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// The colours; row 0 is at v = 1.
    pub image: Rgb,
    /// For each texel the photos it was seen by, as a sum of [`SEEN_LEFT`], [`SEEN_RIGHT`] and
    /// [`SEEN_EXTRA`]; [`FILLED`] where its colour was made up.
    pub coverage: Raster<u8>,
    /// How the head moved between the measured and these photos, where that was found.
    pub head_motion: Option<HeadMotion>,
}

/// Coverage: seen by the first (left) photo.
pub const SEEN_LEFT: u8 = 1;
/// Coverage: seen by the second (right) photo.
pub const SEEN_RIGHT: u8 = 2;
/// Coverage: seen by a further photo.
pub const SEEN_EXTRA: u8 = 4;
/// Coverage: in no photo, filled in.
pub const FILLED: u8 = 128;

/// A texture that cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TextureError {
    /// A mesh that cannot be used.
    #[error("the mesh cannot be textured: {0}")]
    Mesh(#[from] MeshError),
    /// A mesh without texture coordinates.
    #[error("the mesh has no texture coordinates; take a template that has them")]
    NoUv,
    /// Not enough photos.
    #[error(
        "{got} photos without the pattern were given, but {needed} are needed; add left_plain and right_plain to the capture, or set texture.source"
    )]
    Photos {
        /// Given.
        got: usize,
        /// Needed.
        needed: usize,
    },
    /// An image without pixels.
    #[error("photo {index} (from 0) has no pixels")]
    EmptyPhoto {
        /// Its number.
        index: usize,
    },
    /// Dots that do not fit together.
    #[error(
        "photo {photo} (from 0): dot {dot} names vertex {vertex} of {count}, or its position is not finite"
    )]
    Dot {
        /// Number of the photo.
        photo: usize,
        /// Number of the dot.
        dot: usize,
        /// Vertex it names.
        vertex: usize,
        /// Vertices there are.
        count: usize,
    },
    /// Not enough dots.
    #[error(
        "{got} matched dots lie in the photo and on the texture map, but at least {needed} are needed to bound the face; check the matches"
    )]
    TooFewDots {
        /// Found.
        got: usize,
        /// Needed.
        needed: usize,
    },
    /// A boundary without area.
    #[error(
        "the extreme dots enclose {width:.1} x {height:.1} texels on the texture map; the template's texture coordinates do not unfold the face, or the texture is too small"
    )]
    Boundary {
        /// Width of the region.
        width: f64,
        /// Its height.
        height: f64,
    },
    /// A parameter outside its range.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// A photo without a camera whose dots do not give one.
    #[error(
        "photo {photo} (from 0) has no camera, and its {dots} dots do not give one: they miss their vertices by {rms:.1} px, at most {limit:.1} px is usable and 12 dots are needed; add a calibration"
    )]
    NoCamera {
        /// Number of the photo.
        photo: usize,
        /// Dots it has.
        dots: usize,
        /// Robust RMS miss, pixels.
        rms: f64,
        /// Allowed.
        limit: f64,
    },
    /// The renderer refused.
    #[error("the head cannot be seen through the camera: {0}")]
    Draw(String),
    /// Cancelled by the observer.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

crate::stage_error!(TextureError, "texture");

/// Makes the texture of a head.
///
/// # Errors
/// [`TextureError`] when mesh, photos or dots cannot be used.
pub fn texture(
    input: &TextureInput<'_>,
    params: &TextureParams,
    observer: &dyn Observer,
) -> Result<Texture, TextureError> {
    params.check("texture", None)?;
    check(input)?;
    observer.check()?;
    let made = match params.method {
        TextureMethod::Scanline => scanline::texture(input, params, observer)?,
        TextureMethod::Projective => projective::texture(input, params, observer)?,
    };
    observer.artifact("texture", "texture", Artifact::Rgb(&made.image));
    Ok(made)
}

fn check(input: &TextureInput<'_>) -> Result<(), TextureError> {
    input.mesh.validate()?;
    if !input.mesh.has_uv() {
        return Err(TextureError::NoUv);
    }
    let count = input.mesh.vertices.len();
    for (photo, p) in input.photos.iter().enumerate() {
        if p.image.data().is_empty() {
            return Err(TextureError::EmptyPhoto { index: photo });
        }
        let bad = |d: &TextureDot| {
            let numbers = d.pixel.iter().chain(d.point.iter());
            d.vertex >= count || !numbers.into_iter().all(|c| c.is_finite())
        };
        if let Some(dot) = p.dots.iter().position(bad) {
            return Err(TextureError::Dot { photo, dot, vertex: p.dots[dot].vertex, count });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
