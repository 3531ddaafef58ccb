//! Texels that no photo shows, filled in from their surroundings on the texture map.

use super::blend::Blending;
use super::texels::Texels;
use crate::data::Raster;

/// Colour of texels without any coloured texel: middle grey.
const GREY: [f32; 3] = [128.0; 3];
/// Weights below this are no colour.
const LEAST_WEIGHT: f32 = 1e-6;

/// Push-pull (Gortler et al. 1996): colours are averaged into ever coarser grids and interpolated
/// back into the gaps. Every texel gets a colour, off the mesh too, so that no seam shows however
/// the texture is filtered.
pub(super) fn push_pull(texels: &Texels<'_>, blending: &Blending) -> Raster<[f32; 3]> {
    let size = blending.size;
    let start = Raster::par_from_fn(size, size, |x, y| {
        let index = y * size + x;
        let weight = if texels.corners(index).is_some() { blending.visible.at(x, y) } else { 0.0 };
        let c = blending.color.at(x, y);
        [c[0] * weight, c[1] * weight, c[2] * weight, weight]
    });
    let mut levels = vec![start];
    while let Some(last) = levels.last() {
        let (w, h) = last.size();
        if w <= 1 && h <= 1 {
            break;
        }
        let coarser = halved(last);
        levels.push(coarser);
    }
    let mut filled = Raster::filled(1, 1, GREY);
    for level in levels.iter().rev() {
        let (w, h) = level.size();
        let coarser = filled;
        filled = Raster::par_from_fn(w, h, |x, y| {
            let v = level.at(x, y);
            let known = v[3].min(1.0);
            let guess = coarser.bilinear_clamped(x as f64 * 0.5 - 0.25, y as f64 * 0.5 - 0.25);
            std::array::from_fn(|c| {
                let own = if v[3] > LEAST_WEIGHT { v[c] / v[3] } else { 0.0 };
                own * known + guess[c] * (1.0 - known)
            })
        });
    }
    filled
}

/// Weighted sums over 2 x 2 texels, the weight limited to 1: a covered area must not count more than
/// its border on the coarser grids.
fn halved(image: &Raster<[f32; 4]>) -> Raster<[f32; 4]> {
    let (w, h) = image.size();
    Raster::par_from_fn(w.div_ceil(2), h.div_ceil(2), |x, y| {
        let mut sum = [0.0f32; 4];
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let v = image.at((2 * x + dx).min(w - 1), (2 * y + dy).min(h - 1));
            (0..4).for_each(|c| sum[c] += v[c]);
        }
        let scale = if sum[3] > 1.0 { 1.0 / sum[3] } else { 1.0 };
        sum.map(|v| v * scale)
    })
}
