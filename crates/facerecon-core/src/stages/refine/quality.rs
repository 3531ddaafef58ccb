//! Standard deviation of the measured disparity, pixel by pixel, and which pixels become holes.

use rayon::prelude::*;

use super::photometry::{Linearisation, PhotometricModel};
use super::spline::Spline;
use crate::data::blur::gaussian_sums;
use crate::data::{Gray, Raster};

/// Share of a window's random error that remains in the surface, which its stiffness smooths.
/// Measured on rendered heads of known shape.
const REMAINING_NOISE: f64 = 0.9;
/// Share of the bend over a pitch that the surface smooths away. Measured on rendered heads of
/// known shape.
const FLATTENING: f64 = 0.06;
/// Block size of the local sums, in pitches: a quarter of the window.
const BLOCK: f64 = 0.25;
/// Standard deviation of the windows of the local sums, in pitches: one window holds about one
/// dot.
const WINDOW_SIGMA: f64 = 0.5;
/// Residuals over noise are cut at this value in the local sums.
const RESIDUAL_LIMIT: f64 = 5.0;
/// A point is hidden when a nearer one lies this far left of it in the right photo, pixels: more
/// than the rounding of a pixel.
const HIDDEN_PX: f64 = 0.5;

/// What makes a pixel a hole.
pub(super) struct Limits {
    /// Largest standard deviation, working pixels.
    pub(super) sigma_px: f64,
    /// Largest local root mean square of residuals over noise.
    pub(super) misfit: f64,
    /// Smallest share of the information that both photos agree on.
    pub(super) agreement: f64,
    /// Largest gradient of the disparity.
    pub(super) slope: f64,
}

/// Standard deviation of the disparity at every pixel, working pixels. It is NaN in holes: without
/// enough pattern, where the photos disagree, and where the surface is grazing or hidden.
pub(super) fn sigma(
    model: &PhotometricModel,
    spline: &Spline,
    last: &Linearisation,
    pitch: f64,
    limits: &Limits,
) -> Gray {
    let (width, height) = model.left.size();
    let windows = Windows::new(model, last, pitch);
    let (disparity, slope) = spline.sampled(&model.domain);
    let hidden = hidden(&disparity);
    let mut out = Raster::filled(width, height, f32::NAN);
    out.data_mut().par_chunks_mut(width).enumerate().for_each(|(y, out)| {
        for x in (0..width).filter(|&x| model.domain.at(x, y) && !hidden.at(x, y)) {
            let [count, information, squares, agreed] = windows.at(x, y);
            let misfit2 = squares / count.max(1e-9);
            let random2 = REMAINING_NOISE * REMAINING_NOISE * misfit2.max(1.0) / agreed.max(1e-12);
            let (down, bend) = slope_down_and_bend(&disparity, x, y);
            let flattened = FLATTENING * bend * pitch * pitch;
            let slope = f64::from(slope.at(x, y)).hypot(down);
            let sigma = (random2 + flattened * flattened).sqrt();
            let measured = sigma <= limits.sigma_px
                && agreed >= limits.agreement * information
                && misfit2 <= limits.misfit * limits.misfit
                && slope <= limits.slope;
            if measured {
                out[x] = sigma as f32;
            }
        }
    });
    out
}

/// Slope of the disparity down the columns, and the sum of its absolute second differences, at a
/// pixel. The border of the domain has neither and counts as flat.
fn slope_down_and_bend(disparity: &Raster<f64>, x: usize, y: usize) -> (f64, f64) {
    let centre = |v: usize, n: usize| v.min(n.saturating_sub(3)).max(2) as isize;
    let (i, j) = (centre(x, disparity.width()), centre(y, disparity.height()));
    let d = |i: isize, j: isize| disparity.get(i, j).unwrap_or(f64::NAN);
    let down = 0.25 * (d(i, j + 2) - d(i, j - 2));
    let bend = [d(i + 2, j) + d(i - 2, j), d(i, j + 2) + d(i, j - 2)]
        .map(|s| 0.25 * (s - 2.0 * d(i, j)).abs());
    let bend = bend.iter().filter(|b| b.is_finite()).sum::<f64>();
    (if down.is_finite() { down } else { 0.0 }, bend)
}

/// Sums of the linearisation in Gaussian windows.
struct Windows {
    /// Width of a block, pixels.
    size: usize,
    columns: usize,
    sums: Vec<[f64; 4]>,
}

impl Windows {
    fn new(model: &PhotometricModel, last: &Linearisation, pitch: f64) -> Self {
        let (width, height) = model.left.size();
        let size = (BLOCK * pitch).round().max(1.0) as usize;
        let (columns, rows) = (width.div_ceil(size), height.div_ceil(size));
        let mut sums = vec![[0.0f64; 4]; columns * rows];
        sums.par_chunks_mut(columns).enumerate().for_each(|(j, sums)| {
            for y in j * size..((j + 1) * size).min(height) {
                let (domain, information) = (model.domain.row(y), last.information.row(y));
                let (normalised, agreed) = (last.normalised.row(y), last.agreed.row(y));
                for x in (0..width).filter(|&x| domain[x]) {
                    let s = &mut sums[x / size];
                    s[0] += 1.0;
                    s[1] += f64::from(information[x]);
                    s[2] += f64::from(normalised[x]).powi(2).min(RESIDUAL_LIMIT * RESIDUAL_LIMIT);
                    s[3] += f64::from(agreed[x]);
                }
            }
        });
        let sums = gaussian_sums(&sums, columns, rows, WINDOW_SIGMA * pitch / size as f64);
        Self { size, columns, sums }
    }

    /// Pixels, information, squared residuals over noise and agreed information around a pixel.
    fn at(&self, x: usize, y: usize) -> [f64; 4] {
        self.sums[y / self.size * self.columns + x / self.size]
    }
}

/// Pixels whose surface point lies behind a nearer one as seen by the right camera.
fn hidden(disparity: &Raster<f64>) -> Raster<bool> {
    let (width, height) = disparity.size();
    let mut hidden = Raster::filled(width, height, false);
    hidden.data_mut().par_chunks_mut(width).enumerate().for_each(|(y, out)| {
        let row = disparity.row(y);
        // A nearer point (larger disparity) right of it in the left photo hides it when it is left
        // of it in the right one.
        let mut leftmost = f64::INFINITY;
        for x in (0..width).rev().filter(|&x| row[x].is_finite()) {
            let right_x = x as f64 - row[x];
            out[x] = right_x > leftmost + HIDDEN_PX;
            leftmost = leftmost.min(right_x);
        }
    });
    hidden
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_depth_discontinuity_hides_what_lies_behind_it() {
        // a near plate (disparity 20) right of x = 30 before a far wall (disparity 10): the right
        // camera does not see the ten pixels of wall left of the plate
        let disparity = Raster::from_fn(60, 1, |x, _| if x >= 30 { 20.0 } else { 10.0 });
        let hidden = hidden(&disparity);
        let hidden: Vec<usize> = (0..60).filter(|&x| hidden.at(x, 0)).collect();
        assert_eq!(hidden, (21..30).collect::<Vec<_>>());
    }

    #[test]
    fn photos_of_a_few_pixels_have_no_bend() {
        let disparity = Raster::from_fn(3, 2, |x, _| x as f64);
        assert_eq!(slope_down_and_bend(&disparity, 1, 1), (0.0, 0.0));
    }
}
