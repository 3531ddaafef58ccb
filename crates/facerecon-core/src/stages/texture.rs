//! Stage texture: colour the head from the plain photos (thesis chapter 5).
//!
//! Two methods: the scan lines of the thesis, which need no cameras, and the projection of all
//! photos through their cameras.

mod error;
mod input;
mod output;
mod params;
mod projective;
mod scanline;

use crate::observer::{Artifact, Observer};
use crate::settings::Value;

pub use error::TextureError;
pub use input::{TextureDot, TextureInput, TexturePhoto};
pub use output::{FILLED, HeadMotion, SEEN_EXTRA, SEEN_LEFT, SEEN_RIGHT, Texture};
pub use params::{Boundary, ProjectiveParams, Rest, Source, TextureMethod, TextureParams};

/// Makes the texture of a head.
///
/// Warns through the observer where photos are left out, and where the head moved between the
/// dotted and the plain photos.
///
/// # Errors
/// [`TextureError`] when parameters, mesh, photos or dots cannot be used.
///
/// # Example
/// A square of 100 mm, 1 m in front of the camera, coloured from one photo:
/// ```
/// use facerecon_core::camera::Pinhole;
/// use facerecon_core::data::{Mesh, Rgb};
/// use facerecon_core::math::{Mat3, Similarity, Vec2, Vec3};
/// use facerecon_core::stages::texture::{
///     TextureInput, TextureMethod, TextureParams, TexturePhoto, texture,
/// };
///
/// let mesh = Mesh {
///     vertices: [(-50.0, -50.0), (50.0, -50.0), (50.0, 50.0), (-50.0, 50.0)]
///         .map(|(x, y)| Vec3::new(x, y, 0.0))
///         .to_vec(),
///     faces: vec![[0, 1, 2], [0, 2, 3]],
///     uvs: vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
///     face_uvs: vec![[0, 1, 2], [0, 2, 3]],
///     ..Mesh::default()
/// };
/// let image = Rgb::filled(100, 100, [200, 150, 120]);
/// // y is up in the mesh and down in the camera
/// let flip = Mat3::from_diagonal(&Vec3::new(1.0, -1.0, -1.0));
/// let pose = Similarity::rigid(flip, Vec3::new(0.0, 0.0, 1000.0));
/// let camera = Some((Pinhole::ideal(700.0, Vec2::new(49.5, 49.5)), pose));
/// let photo = TexturePhoto { image: &image, camera, patterned: None, dots: &[] };
/// let input = TextureInput { mesh: &mesh, photos: &[photo], template_texture: None };
/// let params =
///     TextureParams { method: TextureMethod::Projective, size: 64, ..TextureParams::default() };
/// let made = texture(&input, &params, &())?;
/// assert_eq!(made.image.at(32, 32), [200, 150, 120]);
/// # Ok::<(), facerecon_core::stages::texture::TextureError>(())
/// ```
pub fn texture(
    input: &TextureInput<'_>,
    params: &TextureParams,
    observer: &dyn Observer,
) -> Result<Texture, TextureError> {
    params.check("texture", None)?;
    check_input(input)?;
    observer.check()?;
    let made = match params.method {
        TextureMethod::Scanline => scanline::texture(input, params, observer)?,
        TextureMethod::Projective => projective::texture(input, params, observer)?,
    };
    observer.artifact("texture", "texture", Artifact::Rgb(&made.image));
    Ok(made)
}

fn check_input(input: &TextureInput<'_>) -> Result<(), TextureError> {
    input.mesh.validate()?;
    if !input.mesh.has_uv() {
        return Err(TextureError::NoUv);
    }
    let count = input.mesh.vertices.len();
    for (photo, p) in input.photos.iter().enumerate() {
        if p.image.data().is_empty() {
            return Err(TextureError::EmptyPhoto { index: photo });
        }
        let invalid = |d: &TextureDot| {
            let numbers = d.pixel.iter().chain(d.point.iter());
            d.vertex >= count || !numbers.into_iter().all(|c| c.is_finite())
        };
        if let Some(dot) = p.dots.iter().position(invalid) {
            return Err(TextureError::Dot { photo, dot, vertex: p.dots[dot].vertex, count });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
