//! The photos laid on the head through their cameras and blended into one seamless picture.
//!
//! A texel takes its fine detail from the photo that sees it best and its broad shading from a
//! soft mixture of all that see it (multi-band blending, Burt and Adelson 1983). What none sees is
//! taken from the mirrored side of the face, and the rest is painted in from its surroundings.

mod bands;
mod blend;
mod exposure;
mod fill;
mod motion;
mod photo;
mod reduce;
mod subject;
mod texels;

use rayon::prelude::*;

use super::{Texture, TextureError, TextureInput, TextureParams};
use crate::observer::{Event, Observer};

use photo::Photo;
use reduce::Reduced;
use texels::Texels;

crate::settings! {
    /// Texture from photos with cameras.
    pub struct ProjectiveParams {
        /// Whether a movement of the head between the patterned and the plain photos is looked for
        /// and corrected.
        motion: bool = true;
        /// Whether the photos' exposures are brought to that of the first.
        exposure: bool = true;
        /// Whether what no photo sees is taken from the other side of the face where that is seen.
        mirror: bool = true;
        /// A point counts as hidden when it lies this much behind what the camera sees.
        bias_mm: f64 = 0.5, range 0.0..=100.0, unit "mm";
        /// Pixels this near to an edge in depth are not used, for edges are never exactly in place;
        /// three times as near to the outline of the head, behind which the background shows.
        edge_px: f64 = 3.0, range 0.0..=5.0, unit "px";
        /// Surfaces seen at a flatter angle than this cosine are not used.
        least_cosine: f64 = 0.15, range 0.0..=0.99;
    }
}

/// Projects the photos.
pub(super) fn texture(
    input: &TextureInput<'_>,
    params: &TextureParams,
    obs: &dyn Observer,
) -> Result<Texture, TextureError> {
    let own = &params.projective;
    if input.photos.is_empty() {
        return Err(TextureError::Photos { got: 0, needed: 1 });
    }
    let kept = photo::usable(input, obs);
    let input = &TextureInput { photos: &kept, ..*input };
    let mut views = photo::views(input)?;
    let small: Vec<Option<Reduced>> = (views.iter_mut().zip(input.photos))
        .map(|(view, photo)| Reduced::new(input.mesh, photo, view, params.size))
        .collect();
    let lent: Vec<_> = (small.iter().zip(input.photos))
        .map(|(small, photo)| small.as_ref().map_or(*photo, |s| s.lend(photo)))
        .collect();
    let input = &TextureInput { photos: &lent, ..*input };
    let mut head_motion = None;
    if own.motion
        && views.len() > 1
        && let Some(found) = motion::between_photos(input, &views, own)?
    {
        views.iter_mut().for_each(|v| v.follow(&found));
        let message = found.in_words();
        obs.event(&Event::Warning { stage: "texture", message: &message });
        head_motion = Some(found);
    }
    stop(obs)?;
    let measured: Vec<_> = input.photos.iter().flat_map(|p| p.dots).map(|d| d.point).collect();
    let mut photos = views
        .par_iter()
        .zip(input.photos)
        .map(|(view, given)| Photo::new(input.mesh, view, given.image, own.edge_px, &measured))
        .collect::<Result<Vec<_>, _>>()?;
    stop(obs)?;
    // Weights and everything smooth are worked out on a grid four times as coarse.
    let coarse = Texels::new(input.mesh, (params.size / 4).max(16))?;
    let weights = blend::weights(&coarse, &photos, own);
    if own.exposure {
        exposure::equalise(&coarse, &mut photos, &weights);
    }
    stop(obs)?;
    let bands: Vec<_> = photos.iter().map(bands::Bands::new).collect();
    let blending = blend::Blending::new(&coarse, &photos, &bands, &weights);
    let surroundings = fill::push_pull(&coarse, &blending);
    stop(obs)?;
    let fine = Texels::new(input.mesh, params.size)?;
    let sharp: Vec<_> = bands.iter().map(|b| &b.levels[0]).collect();
    let (image, coverage) = blend::paint(&fine, &photos, &sharp, &blending, &surroundings);
    Ok(Texture { image, coverage, head_motion })
}

fn stop(obs: &dyn Observer) -> Result<(), TextureError> {
    obs.check()?;
    Ok(())
}

pub use motion::HeadMotion;

#[cfg(test)]
mod tests;
