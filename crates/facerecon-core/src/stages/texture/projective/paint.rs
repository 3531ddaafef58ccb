//! The texture at full size.

use super::super::output::{FILLED, SEEN_EXTRA, SEEN_LEFT, SEEN_RIGHT};
use super::bands::Bands;
use super::blend::Blending;
use super::photo::Photo;
use super::texels::Texels;
use crate::data::sampling::Cell;
use crate::data::{Raster, Rgb};

/// Sources with a smaller share are not sampled: less than a tenth of a grey level.
const NEGLIGIBLE_SHARE: f32 = 1e-4;
/// Share from which a photo counts as showing a texel (coverage).
const COVERAGE_SHARE: f32 = 0.02;
/// Texels to which the sources give less than this in all are filled in.
const LEAST_TOTAL: f32 = 0.5;

/// Paints the texture and codes by which photos each texel is seen.
pub(super) fn paint(
    texels: &Texels<'_>,
    photos: &[Photo<'_>],
    bands: &[Bands],
    blending: &Blending,
    surroundings: &Raster<[f32; 3]>,
) -> (Rgb, Raster<u8>) {
    let size = texels.size;
    let ratio = blending.size as f64 / size as f64;
    let texel = |x: usize, y: usize| -> ([u8; 3], u8) {
        let to_coarse = |v: usize| (v as f64 + 0.5) * ratio - 0.5;
        let coarse = CoarseSample::new(to_coarse(x), to_coarse(y), blending.size);
        let around = coarse.color(surroundings);
        let Some(point) = texels.position(y * size + x) else {
            return (around.map(byte), 0);
        };
        let visible = coarse.value(&blending.visible);
        let (mut color, mut total, mut code) = ([0.0f32; 3], 0.0f32, 0u8);
        if visible > 0.0 {
            for (source, shares) in blending.sources.iter().zip(&blending.fine) {
                let share = coarse.value(shares);
                if share <= NEGLIGIBLE_SHARE {
                    continue;
                }
                let photo = source.photo;
                let Some((pixel, _)) = photos[photo].camera.project(&source.side(&point)) else {
                    continue;
                };
                let value = bands[photo].levels[0].bicubic_clamped(pixel.x, pixel.y);
                (0..3).for_each(|c| color[c] += share * value[c]);
                total += share;
                if !source.mirrored && share > COVERAGE_SHARE {
                    code |= [SEEN_LEFT, SEEN_RIGHT, SEEN_EXTRA][photo.min(2)];
                }
            }
        }
        if total < LEAST_TOTAL {
            return (around.map(byte), FILLED);
        }
        // interpolated shares sum to a little less than 1 where a photo's view ends
        let smooth = coarse.color(&blending.smooth);
        let color: [f32; 3] = std::array::from_fn(|c| {
            let value = (color[c] + smooth[c] * total) / total;
            around[c] + (value - around[c]) * visible
        });
        (color.map(byte), if code == 0 { FILLED } else { code })
    };
    Raster::par_from_fn(size, size, texel).unzip()
}

fn byte(value: f32) -> u8 {
    (value + 0.5) as u8 // the cast clips
}

/// Interpolates several rasters of the coarse grid at one position.
struct CoarseSample {
    cell: Cell,
    weights: [f32; 4],
}

impl CoarseSample {
    fn new(x: f64, y: f64, size: usize) -> Self {
        let cell = Cell::clamped(x, y, (size, size));
        Self { cell, weights: cell.weights() }
    }

    fn value(&self, raster: &Raster<f32>) -> f32 {
        let corners = self.cell.corners(|x, y| raster.at(x, y));
        (0..4).map(|k| self.weights[k] * corners[k]).sum()
    }

    fn color(&self, raster: &Raster<[f32; 3]>) -> [f32; 3] {
        let corners = self.cell.corners(|x, y| raster.at(x, y));
        std::array::from_fn(|c| (0..4).map(|k| self.weights[k] * corners[k][c]).sum())
    }
}
