//! What no photo shows, painted in from its surroundings on the texture map.

use super::blend::Blending;
use super::texels::Texels;
use crate::data::Raster;

/// Push-pull (Gortler et al. 1996): colours are averaged upward through ever coarser grids and
/// carried back down into the gaps. Every texel gets a colour, off the islands too, so that no
/// seam shows however the texture is filtered. Without any colour at all: grey.
pub(super) fn push_pull(texels: &Texels<'_>, blending: &Blending) -> Raster<[f32; 3]> {
    let size = blending.size;
    let start = Raster::par_from_fn(size, size, |x, y| {
        let index = y * size + x;
        let weight = if texels.corners(index).is_some() { blending.seen.at(x, y) } else { 0.0 };
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
    let grey = [128.0f32; 3];
    let mut filled = Raster::filled(1, 1, grey);
    for level in levels.iter().rev() {
        let (w, h) = level.size();
        let below = filled;
        filled = Raster::par_from_fn(w, h, |x, y| {
            let v = level.at(x, y);
            let known = v[3].min(1.0);
            let guess = enlarged(&below, x, y);
            std::array::from_fn(|c| {
                let own = if v[3] > 1e-6 { v[c] / v[3] } else { 0.0 };
                own * known + guess[c] * (1.0 - known)
            })
        });
    }
    filled
}

/// Sums over 2x2, weights capped at 1 so that a full area does not outvote its rim later.
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

/// The value of a coarser grid at a pixel of the finer one, bilinear.
fn enlarged(coarse: &Raster<[f32; 3]>, x: usize, y: usize) -> [f32; 3] {
    let (w, h) = coarse.size();
    let place = |v: usize, n: usize| {
        let t = (v as f32 * 0.5 - 0.25).clamp(0.0, (n - 1) as f32);
        (t as usize, ((t as usize) + 1).min(n - 1), t - t.floor())
    };
    let ((x0, x1, fx), (y0, y1, fy)) = (place(x, w), place(y, h));
    let (a, b) = (coarse.at(x0, y0), coarse.at(x1, y0));
    let (c, d) = (coarse.at(x0, y1), coarse.at(x1, y1));
    std::array::from_fn(|i| {
        let top = a[i] + (b[i] - a[i]) * fx;
        let bottom = c[i] + (d[i] - c[i]) * fx;
        top + (bottom - top) * fy
    })
}
