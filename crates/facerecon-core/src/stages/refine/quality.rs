//! What the measured surface is worth, pixel by pixel, and where it is a hole.

use rayon::prelude::*;

use super::photometry::{Linearised, Scene, blurred};
use super::surface::Surface;
use crate::data::{Gray, Raster};

/// Share of a window's random error that the surface's stiffness leaves, and of the bend that it
/// smooths away; both measured on rendered heads with known shape.
const STIFFNESS: f64 = 0.9;
const FLATTENING: f64 = 0.06;

/// What makes a hole.
pub(super) struct Limits {
    /// Largest standard deviation, working pixels.
    pub(super) sigma_px: f64,
    /// Largest local root mean square of residuals over noise.
    pub(super) misfit: f64,
    /// Least share of the information that both pictures agree on.
    pub(super) agreement: f64,
    /// Largest gradient of the disparity.
    pub(super) tilt: f64,
}

/// Standard deviation of the disparity at every pixel, working pixels; NaN in holes: too little
/// pattern, pictures that disagree, grazing or hidden surface.
pub(super) fn sigma(
    scene: &Scene,
    surface: &Surface,
    last: &Linearised,
    pitch: f64,
    limits: &Limits,
) -> Gray {
    let (width, height) = scene.left.size();
    let size = (0.25 * pitch).round().max(1.0) as usize;
    let (columns, rows) = (width.div_ceil(size), height.div_ceil(size));
    let mut sums = vec![[0.0f64; 4]; columns * rows];
    sums.par_chunks_mut(columns).enumerate().for_each(|(j, sums)| {
        for y in j * size..((j + 1) * size).min(height) {
            let (domain, info) = (scene.domain.row(y), last.information.row(y));
            let (chi, agreed) = (last.chi.row(y), last.agreed.row(y));
            for x in (0..width).filter(|&x| domain[x]) {
                let s = &mut sums[x / size];
                s[0] += 1.0;
                s[1] += f64::from(info[x]);
                s[2] += f64::from(chi[x]).powi(2).min(25.0);
                s[3] += f64::from(agreed[x]);
            }
        }
    });
    let window = blurred(&sums, columns, rows, 0.5 * pitch / size as f64);
    let (value, slope) = surface.sampled(&scene.domain);
    let hidden = hidden(&value);
    let mut out = Raster::filled(width, height, f32::NAN);
    out.data_mut().par_chunks_mut(width).enumerate().for_each(|(y, out)| {
        for x in (0..width).filter(|&x| scene.domain.at(x, y) && !hidden.at(x, y)) {
            let [count, info, chi2, agreed] = window[y / size * columns + x / size];
            let misfit2 = chi2 / count.max(1e-9);
            let random2 = STIFFNESS * STIFFNESS * misfit2.max(1.0) / agreed.max(1e-12);
            let d = |i: usize, j: usize| value.at(i, j);
            let (i, j) = (x.clamp(2, width - 3), y.clamp(2, height - 3));
            let down = 0.25 * (d(i, j + 2) - d(i, j - 2));
            let bend = [d(i + 2, j) + d(i - 2, j), d(i, j + 2) + d(i, j - 2)]
                .map(|s| 0.25 * (s - 2.0 * d(i, j)).abs());
            // the border of the domain has no second difference: take it as flat
            let bend = bend.iter().filter(|b| b.is_finite()).sum::<f64>();
            let flattened = FLATTENING * bend * pitch * pitch;
            let down = if down.is_finite() { down } else { 0.0 };
            let tilt = f64::from(slope.at(x, y)).hypot(down);
            let sigma = (random2 + flattened * flattened).sqrt();
            let good = sigma <= limits.sigma_px
                && agreed >= limits.agreement * info
                && misfit2 <= limits.misfit * limits.misfit
                && tilt <= limits.tilt;
            if good {
                out[x] = sigma as f32;
            }
        }
    });
    out
}

/// Pixels whose surface point lies behind a nearer one as the right camera sees it.
fn hidden(value: &Raster<f64>) -> Raster<bool> {
    let (width, height) = value.size();
    let mut hidden = Raster::filled(width, height, false);
    hidden.data_mut().par_chunks_mut(width).enumerate().for_each(|(y, out)| {
        let row = value.row(y);
        // nearer points (larger disparity) right of it that land left of it in the right picture
        let mut leftmost = f64::INFINITY;
        for x in (0..width).rev().filter(|&x| row[x].is_finite()) {
            let lands = x as f64 - row[x];
            out[x] = lands > leftmost + 0.5;
            leftmost = leftmost.min(lands);
        }
    });
    hidden
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_hides_what_lies_behind_it() {
        // a near plate (disparity 20) right of x = 30 before a far wall (disparity 10): the right
        // camera, standing right, does not see the ten pixels of wall left of the plate
        let value = Raster::from_fn(60, 1, |x, _| if x >= 30 { 20.0 } else { 10.0 });
        let hidden = hidden(&value);
        let got: Vec<usize> = (0..60).filter(|&x| hidden.at(x, 0)).collect();
        assert_eq!(got, (21..30).collect::<Vec<_>>());
    }
}
