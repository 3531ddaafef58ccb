//! The share of each photo in each texel, band by band, and the mixture of the smooth bands.

use rayon::prelude::*;

use super::bands::{Bands, LEVELS};
use super::photo::Photo;
use super::texels::Texels;
use super::weights::Weights;
use crate::data::Raster;
use crate::math::Vec3;

/// Weights below this fraction of the strongest give way to the mirrored side and to filling in:
/// such texels are seen at grazing angles or next to an edge.
const FAINT: f32 = 0.005;
/// Weight factor of a mirrored photo: any photo that really shows the texel counts more.
const MIRRORED_WEIGHT: f32 = 0.5;
/// Exponent of the weights in each band, finest first. With 6 nearly all detail comes from the best
/// photo, which keeps it sharp; with 1 the shading changes over the whole overlap, which hides
/// seams.
const EXPONENTS: [i32; LEVELS] = [6, 3, 2, 1];
/// A smoothed weight is at most this many times the weight itself, so that it falls to 0 where the
/// photo's view of the surface ends.
const MAX_SMOOTHED: f32 = 4.0;

/// A photo, or a photo as it sees the mirrored head.
#[derive(Clone, Copy)]
pub(super) struct Source {
    pub photo: usize,
    pub mirrored: bool,
}

impl Source {
    /// The point of the head whose colour the source gives to a point.
    pub fn side(self, point: &Vec3) -> Vec3 {
        if self.mirrored { Vec3::new(-point.x, point.y, point.z) } else { *point }
    }
}

/// All that painting needs, on the coarse grid.
pub(super) struct Blending {
    /// Width and height of the grid, texels.
    pub size: usize,
    /// The photos, then the mirrored ones.
    pub sources: Vec<Source>,
    /// Share of each source in the finest band.
    pub fine: Vec<Raster<f32>>,
    /// Sum of all smoother bands: colour to add to the finest.
    pub smooth: Raster<[f32; 3]>,
    /// Degree to which a texel is visible, 0 to 1; the rest is filled in.
    pub visible: Raster<f32>,
    /// Colour of the visible part, from which the rest is filled in.
    pub color: Raster<[f32; 3]>,
}

impl Blending {
    pub fn new(
        texels: &Texels<'_>,
        photos: &[Photo<'_>],
        bands: &[Bands],
        weights: &Weights,
    ) -> Self {
        let direct = (0..weights.direct.len()).map(|photo| Source { photo, mirrored: false });
        let mirrored = (0..weights.mirrored.len()).map(|photo| Source { photo, mirrored: true });
        let sources: Vec<Source> = direct.chain(mirrored).collect();
        let faint = FAINT * strongest(&weights.direct);
        let raw: Vec<_> = sources.iter().map(|s| source_weights(weights, *s, faint)).collect();
        let shares: Vec<_> = (0..LEVELS).into_par_iter().map(|level| shares(&raw, level)).collect();
        let (smooth, color) = mixed(texels, photos, bands, &sources, &shares).unzip();
        let visible = visible(&raw, texels.size, faint);
        let fine = shares.into_iter().next().unwrap_or_default();
        Self { size: texels.size, sources, fine, smooth, visible, color }
    }
}

fn strongest(weights: &[Raster<f32>]) -> f32 {
    weights.iter().flat_map(Raster::data).fold(1e-30, |a, b| a.max(*b))
}

/// The weights of a source; mirrored ones count where the direct ones are faint.
fn source_weights(weights: &Weights, source: Source, faint: f32) -> Raster<f32> {
    if !source.mirrored {
        return weights.direct[source.photo].clone();
    }
    let own = &weights.mirrored[source.photo];
    let (w, h) = own.size();
    Raster::par_from_fn(w, h, |x, y| {
        let direct: f32 = weights.direct.iter().map(|w| w.at(x, y)).sum();
        let gap = (1.0 - direct / faint).max(0.0);
        MIRRORED_WEIGHT * own.at(x, y) * gap
    })
}

fn visible(raw: &[Raster<f32>], size: usize, faint: f32) -> Raster<f32> {
    Raster::par_from_fn(size, size, |x, y| {
        let sum: f32 = raw.iter().map(|w| w.at(x, y)).sum();
        (sum / faint).min(1.0)
    })
}

/// Normalised shares of the sources in one band: nearly all to the best in the finest, a smooth
/// mixture in the smoothest. A source never gives to a texel that it does not see.
fn shares(raw: &[Raster<f32>], level: usize) -> Vec<Raster<f32>> {
    let exponent = EXPONENTS[level];
    let smoothed = |weight: &Raster<f32>| {
        let sharp = weight.map(|v| [v]);
        let smooth = if level == 0 { sharp } else { sharp.box_blurred(1 << level) };
        smooth.zip_map(weight, |[s], w| if w > 0.0 { s.min(MAX_SMOOTHED * w) } else { 0.0 })
    };
    let smooth: Vec<Raster<f32>> = raw.iter().map(smoothed).collect();
    let (w, h) = smooth.first().map_or((0, 0), Raster::size);
    let totals = Raster::par_from_fn(w, h, |x, y| {
        let best = smooth.iter().map(|w| w.at(x, y)).fold(0.0, f32::max);
        let sum: f32 = smooth.iter().map(|w| (w.at(x, y) / best.max(1e-30)).powi(exponent)).sum();
        (best, sum)
    });
    let normalised = |own: &Raster<f32>| {
        own.zip_map(
            &totals,
            |own, (best, sum)| {
                if best > 0.0 { (own / best).powi(exponent) / sum } else { 0.0 }
            },
        )
    };
    smooth.iter().map(normalised).collect()
}

/// Sums over the bands of share * (band - next smoother band), for every texel: without the finest
/// copy of the photos, and with it.
fn mixed(
    texels: &Texels<'_>,
    photos: &[Photo<'_>],
    bands: &[Bands],
    sources: &[Source],
    shares: &[Vec<Raster<f32>>],
) -> Raster<([f32; 3], [f32; 3])> {
    let size = texels.size;
    Raster::par_from_fn(size, size, |x, y| {
        let (mut smooth, mut color) = ([0.0f32; 3], [0.0f32; 3]);
        let Some(point) = texels.position(y * size + x) else { return (smooth, color) };
        for (s, source) in sources.iter().enumerate() {
            if (0..LEVELS).all(|level| shares[level][s].at(x, y) <= 0.0) {
                continue;
            }
            let camera = &photos[source.photo].camera;
            let Some((pixel, _)) = camera.project(&source.side(&point)) else { continue };
            // rearranged by copies of the photo: each enters with the share of its own band less
            // that of the finer one
            for level in 0..LEVELS {
                let own = shares[level][s].at(x, y);
                let finer = if level > 0 { shares[level - 1][s].at(x, y) } else { 0.0 };
                let value = bands[source.photo].levels[level].bilinear_clamped(pixel.x, pixel.y);
                for c in 0..3 {
                    color[c] += (own - finer) * value[c];
                    if level > 0 {
                        smooth[c] += (own - finer) * value[c];
                    }
                }
            }
        }
        (smooth, color)
    })
}
