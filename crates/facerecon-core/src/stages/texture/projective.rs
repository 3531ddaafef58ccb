//! The photos projected onto the head through their cameras and blended into one seamless texture.
//!
//! A texel takes its fine detail from the photo that sees it best and its broad shading from a
//! smooth mixture of all that see it (multi-band blending, Burt and Adelson 1983). Texels that no
//! photo shows take the colour of the mirrored side of the face; the rest is filled in from its
//! surroundings.

mod bands;
mod blend;
mod exposure;
mod fill;
mod motion;
mod paint;
mod photo;
mod posed_camera;
mod reduce;
mod subject;
mod texels;
mod visibility;
mod weights;

use rayon::prelude::*;

use super::error::TextureError;
use super::input::{TextureInput, TexturePhoto};
use super::output::Texture;
use super::params::TextureParams;
use crate::observer::Observer;
use bands::Bands;
use blend::Blending;
use photo::Photo;
use posed_camera::PosedCamera;
use reduce::Reduced;
use texels::Texels;

/// Weights and smooth colours are computed on a grid coarser than the texture by this factor: they
/// change slowly, and time and memory fall with its square.
const COARSE: usize = 4;
/// Least size of that grid, texels.
const LEAST_COARSE_SIZE: usize = 16;

/// Projects and blends the photos.
pub(super) fn texture(
    input: &TextureInput<'_>,
    params: &TextureParams,
    observer: &dyn Observer,
) -> Result<Texture, TextureError> {
    let own = &params.projective;
    if input.photos.is_empty() {
        return Err(TextureError::Photos { got: 0, needed: 1 });
    }
    let usable = usable(input, observer);
    let mut cameras = cameras(&usable)?;
    let reduced: Vec<Option<Reduced>> = (cameras.iter_mut().zip(&usable))
        .map(|(camera, photo)| Reduced::new(input.mesh, photo, camera, params.size))
        .collect();
    let given: Vec<_> = (reduced.iter().zip(&usable))
        .map(|(reduced, photo)| reduced.as_ref().map_or(*photo, |r| r.photo(photo)))
        .collect();
    let input = &TextureInput { photos: &given, ..*input };

    let mut head_motion = None;
    if own.motion
        && cameras.len() > 1
        && let Some(found) = motion::between_photos(input, &cameras, own)?
    {
        cameras.iter_mut().for_each(|c| c.follow(&found.moved_from_mesh));
        observer.warn("texture", &found.to_string());
        head_motion = Some(found);
    }
    observer.check()?;

    let measured: Vec<_> = input.photos.iter().flat_map(|p| p.dots).map(|d| d.point).collect();
    let mut photos = (cameras.par_iter().zip(input.photos))
        .map(|(camera, given)| Photo::new(input.mesh, camera, given.image, own.edge_px, &measured))
        .collect::<Result<Vec<_>, _>>()?;
    observer.check()?;

    let coarse = Texels::new(input.mesh, (params.size / COARSE).max(LEAST_COARSE_SIZE))?;
    let weights = weights::weights(&coarse, &photos, own);
    if own.exposure {
        exposure::equalise(&coarse, &mut photos, &weights);
    }
    observer.check()?;

    let bands: Vec<_> = photos.iter().map(Bands::new).collect();
    let blending = Blending::new(&coarse, &photos, &bands, &weights);
    let surroundings = fill::push_pull(&coarse, &blending);
    observer.check()?;

    let fine = Texels::new(input.mesh, params.size)?;
    let (image, coverage) = paint::paint(&fine, &photos, &bands, &blending, &surroundings);
    Ok(Texture { image, coverage, head_motion })
}

/// The photos whose camera is known or can be found: the pair, and further ones with a camera.
fn usable<'a>(input: &TextureInput<'a>, observer: &dyn Observer) -> Vec<TexturePhoto<'a>> {
    let fits = |&(i, p): &(usize, &TexturePhoto<'_>)| i < 2 || p.camera.is_some();
    let kept: Vec<_> = input.photos.iter().enumerate().filter(fits).map(|(_, p)| *p).collect();
    let dropped = input.photos.len() - kept.len();
    if dropped > 0 {
        let message = format!(
            "{dropped} further photo(s) not used for the texture, without a camera in the frame of the mesh; add a calibration of the pair"
        );
        observer.warn("texture", &message);
    }
    kept
}

fn cameras(photos: &[TexturePhoto<'_>]) -> Result<Vec<PosedCamera>, TextureError> {
    photos.iter().enumerate().map(|(index, photo)| PosedCamera::of_photo(index, photo)).collect()
}

#[cfg(test)]
mod tests;
