//! How much each photo gives to each texel, band by band, and the painting itself.

use rayon::prelude::*;

use super::super::{FILLED, SEEN_EXTRA, SEEN_LEFT, SEEN_RIGHT};
use super::ProjectiveParams;
use super::bands::{Bands, LEVELS, blur};
use super::photo::{Photo, bicubic, bilinear};
use super::texels::Texels;
use crate::data::{Raster, Rgb};
use crate::math::Vec3;

/// Raw weights of the photos on the coarse grid of texels, 0 where a photo does not see a texel.
pub(super) struct Weights {
    /// Of the photos themselves.
    pub sharp: Vec<Raster<f32>>,
    /// Of the photos as seen by the mirrored head; empty without mirroring.
    pub mirrored: Vec<Raster<f32>>,
}

/// A mirrored texel may lie this far from the surface: no face is quite symmetric. mm
const MIRROR_BIAS_MM: f64 = 6.0;

/// Weight of every photo at every texel: `max(0, cos - least)^2 (px/mm)^2`, falling to 0 toward
/// depth edges, the photo's border and saturation.
pub(super) fn weights(
    texels: &Texels<'_>,
    photos: &[Photo<'_>],
    params: &ProjectiveParams,
) -> Weights {
    let one = |photo: &Photo<'_>, mirrored: bool| {
        let bias = if mirrored { MIRROR_BIAS_MM } else { params.bias_mm };
        let at = |index: usize| -> Option<f32> {
            let (mut point, mut normal) = texels.point(index)?;
            if mirrored {
                (point.x, normal.x) = (-point.x, -normal.x);
            }
            Some(weight(photo, &point, &normal, bias, params))
        };
        let size = texels.size;
        let data = (0..size * size).into_par_iter().map(|i| at(i).unwrap_or(0.0)).collect();
        Raster::from_vec(size, size, data).unwrap_or_else(|| Raster::filled(size, size, 0.0))
    };
    let sharp = photos.iter().map(|p| one(p, false)).collect();
    let mirrored =
        if params.mirror { photos.iter().map(|p| one(p, true)).collect() } else { Vec::new() };
    Weights { sharp, mirrored }
}

fn weight(
    photo: &Photo<'_>,
    point: &Vec3,
    normal: &Vec3,
    bias: f64,
    params: &ProjectiveParams,
) -> f32 {
    let Some((pixel, depth)) = photo.project(point) else { return 0.0 };
    let Some((behind, edge)) = photo.sight.behind(pixel, depth) else { return 0.0 };
    let toward = photo.centre - point;
    let cosine = normal.dot(&toward) / toward.norm();
    let facing = cosine - params.least_cosine;
    let ramp = ((edge - params.edge_px) / 8.0).clamp(0.0, 1.0);
    // a flat angle makes the depth of a pixel uncertain by its slope
    let slack = bias + 0.5 * depth / photo.view.camera.fx.max(1.0) / cosine.max(0.2);
    if facing <= 0.0 || ramp <= 0.0 || behind.abs() > slack.max(bias) {
        return 0.0;
    }
    let resolution = photo.view.camera.fx / depth;
    (facing.powi(2) * resolution.powi(2) * ramp) as f32
        * photo.unsaturated(pixel)
        * photo.shows_subject(pixel)
}

/// Weights ready for painting, on the coarse grid.
pub(super) struct Blending {
    pub size: usize,
    /// For each texel the share of each photo in the finest band (mirrored photos after the
    /// others).
    pub fine: Vec<Raster<f32>>,
    /// All smoother bands already summed: colour to add to the finest.
    pub smooth: Raster<[f32; 3]>,
    /// How much of a texel is seen, 0 to 1; the rest is filled in.
    pub seen: Raster<f32>,
    /// Colour of the seen part, for filling in from.
    pub color: Raster<[f32; 3]>,
}

impl Blending {
    pub fn new(
        texels: &Texels<'_>,
        photos: &[Photo<'_>],
        bands: &[Bands],
        weights: &Weights,
    ) -> Self {
        let size = texels.size;
        let total = size * size;
        let strongest = strongest(&weights.sharp);
        // Mirrored photos step in where the others fade out.
        let sources: Vec<(usize, bool)> = (0..photos.len())
            .map(|p| (p, false))
            .chain((0..weights.mirrored.len()).map(|p| (p, true)))
            .collect();
        let raw: Vec<Raster<f32>> = sources
            .iter()
            .map(|&(p, mirrored)| {
                let list: Vec<f32> = (0..total)
                    .into_par_iter()
                    .map(|i| {
                        if !mirrored {
                            return weights.sharp[p].data()[i];
                        }
                        let real: f32 = weights.sharp.iter().map(|w| w.data()[i]).sum();
                        let gap = (1.0 - real / (FAINT * strongest)).max(0.0);
                        0.5 * weights.mirrored[p].data()[i] * gap
                    })
                    .collect();
                Raster::from_vec(size, size, list)
                    .unwrap_or_else(|| Raster::filled(size, size, 0.0))
            })
            .collect();
        let shares: Vec<Vec<Raster<f32>>> =
            (0..LEVELS).into_par_iter().map(|level| share(&raw, level)).collect();
        let seen = seen(&raw, strongest);
        let colors: Vec<([f32; 3], [f32; 3])> = (0..total)
            .into_par_iter()
            .map(|i| {
                let (mut smooth, mut color) = ([0.0f32; 3], [0.0f32; 3]);
                let Some(point) = texels.position(i) else { return (smooth, color) };
                for (s, &(p, mirrored)) in sources.iter().enumerate() {
                    if (0..LEVELS).all(|level| shares[level][s].data()[i] <= 0.0) {
                        continue;
                    }
                    let Some((pixel, _)) = photos[p].project(&side(&point, mirrored)) else {
                        continue;
                    };
                    // sum over bands of share * (band - next band), the finest copy left out
                    for level in 0..LEVELS {
                        let own = shares[level][s].data()[i];
                        let finer = if level > 0 { shares[level - 1][s].data()[i] } else { 0.0 };
                        let value = bilinear(&bands[p].levels[level], pixel);
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
            .collect();
        let square = |colors: Vec<[f32; 3]>| {
            Raster::from_vec(size, size, colors)
                .unwrap_or_else(|| Raster::filled(size, size, [0.0; 3]))
        };
        let (smooth, color) = colors.into_iter().unzip();
        let (smooth, color) = (square(smooth), square(color));
        let fine = shares.into_iter().next().unwrap_or_default();
        Self { size, fine, smooth, seen, color }
    }
}

/// Weights below this fraction of the strongest give way to filling in.
const FAINT: f32 = 0.005;

fn strongest(weights: &[Raster<f32>]) -> f32 {
    weights.iter().flat_map(Raster::data).fold(1e-30, |a, b| a.max(*b))
}

fn side(point: &Vec3, mirrored: bool) -> Vec3 {
    if mirrored { Vec3::new(-point.x, point.y, point.z) } else { *point }
}

fn seen(raw: &[Raster<f32>], strongest: f32) -> Raster<f32> {
    let size = raw.first().map_or((0, 0), Raster::size);
    Raster::par_from_fn(size.0, size.1, |x, y| {
        let sum: f32 = raw.iter().map(|w| w.at(x, y)).sum();
        (sum / (FAINT * strongest)).min(1.0)
    })
}

/// Normalised shares in one band: nearly all to the best photo in the finest, ever softer toward
/// the smoothest. A photo never gives to a texel it does not see.
fn share(raw: &[Raster<f32>], level: usize) -> Vec<Raster<f32>> {
    let power = [6, 3, 2, 1][level.min(3)];
    let soft: Vec<Raster<f32>> = raw
        .iter()
        .map(|w| {
            let sharp = w.map(|v| [v]);
            let smooth = if level == 0 { sharp } else { blur(&sharp, 1 << level) };
            let mut out = smooth.map(|v| v[0]);
            let own = w.data();
            out.data_mut().iter_mut().zip(own).for_each(|(s, w)| {
                // falls to 0 where the photo's sight ends
                *s = if *w > 0.0 { s.min(4.0 * w) } else { 0.0 };
            });
            out
        })
        .collect();
    let size = soft.first().map_or((0, 0), Raster::size);
    let totals = Raster::from_fn(size.0, size.1, |x, y| {
        let best = soft.iter().map(|w| w.at(x, y)).fold(0.0, f32::max);
        let sum: f32 = soft.iter().map(|w| (w.at(x, y) / best.max(1e-30)).powi(power)).sum();
        [best, sum]
    });
    soft.iter()
        .map(|w| {
            Raster::from_fn(size.0, size.1, |x, y| {
                let [best, sum] = totals.at(x, y);
                if best > 0.0 { (w.at(x, y) / best).powi(power) / sum } else { 0.0 }
            })
        })
        .collect()
}

/// Paints the texture at full size.
pub(super) fn paint(
    texels: &Texels<'_>,
    photos: &[Photo<'_>],
    sharp: &[&Raster<[f32; 3]>],
    blending: &Blending,
    surroundings: &Raster<[f32; 3]>,
) -> (Rgb, Raster<u8>) {
    let size = texels.size;
    let ratio = blending.size as f64 / size as f64;
    let real = photos.len();
    let texel = |index: usize| -> ([u8; 3], u8) {
        let (x, y) = (index % size, index / size);
        let at =
            Tap::new((x as f64 + 0.5) * ratio - 0.5, (y as f64 + 0.5) * ratio - 0.5, blending.size);
        let around = at.mix3(surroundings);
        let Some(point) = texels.position(index) else {
            return (around.map(byte), 0);
        };
        let seen = at.mix(&blending.seen);
        let (mut color, mut given, mut code) = ([0.0f32; 3], 0.0f32, 0u8);
        if seen > 0.0 {
            for (s, shares) in blending.fine.iter().enumerate() {
                let share = at.mix(shares);
                if share <= 1e-4 {
                    continue;
                }
                let p = s % real;
                let Some((pixel, _)) = photos[p].project(&side(&point, s >= real)) else {
                    continue;
                };
                let value = bicubic(sharp[p], pixel);
                (0..3).for_each(|c| color[c] += share * value[c]);
                given += share;
                if s < real && share > 0.02 {
                    code |= [SEEN_LEFT, SEEN_RIGHT, SEEN_EXTRA][s.min(2)];
                }
            }
        }
        if given < 0.5 {
            return (around.map(byte), FILLED);
        }
        // shares interpolate to a little less than 1 where a photo's sight ends
        let smooth = at.mix3(&blending.smooth);
        let color: [f32; 3] = std::array::from_fn(|c| {
            let value = (color[c] + smooth[c] * given) / given;
            around[c] + (value - around[c]) * seen
        });
        (color.map(byte), if code == 0 { FILLED } else { code })
    };
    let (mut image, mut coverage) = (Vec::new(), Vec::new());
    (0..size * size).into_par_iter().map(texel).unzip_into_vecs(&mut image, &mut coverage);
    (
        Raster::from_vec(size, size, image).unwrap_or_else(|| Raster::filled(size, size, [0; 3])),
        Raster::from_vec(size, size, coverage).unwrap_or_else(|| Raster::filled(size, size, 0)),
    )
}

fn byte(value: f32) -> u8 {
    (value + 0.5) as u8 // the cast clips
}

/// A place between texels of a coarse grid.
struct Tap {
    index: [usize; 4],
    weight: [f32; 4],
}

impl Tap {
    fn new(x: f64, y: f64, size: usize) -> Self {
        let top = (size - 1) as f64;
        let (x, y) = (x.clamp(0.0, top), y.clamp(0.0, top));
        let (x0, y0) = (x as usize, y as usize);
        let (x1, y1) = ((x0 + 1).min(size - 1), (y0 + 1).min(size - 1));
        let (fx, fy) = ((x - x0 as f64) as f32, (y - y0 as f64) as f32);
        Self {
            index: [y0 * size + x0, y0 * size + x1, y1 * size + x0, y1 * size + x1],
            weight: [(1.0 - fx) * (1.0 - fy), fx * (1.0 - fy), (1.0 - fx) * fy, fx * fy],
        }
    }

    fn mix(&self, raster: &Raster<f32>) -> f32 {
        (0..4).map(|k| self.weight[k] * raster.data()[self.index[k]]).sum()
    }

    fn mix3(&self, raster: &Raster<[f32; 3]>) -> [f32; 3] {
        let corners = self.index.map(|i| raster.data()[i]);
        std::array::from_fn(|c| (0..4).map(|k| self.weight[k] * corners[k][c]).sum())
    }
}
