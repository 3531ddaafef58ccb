//! How well the right photo, warped by a disparity spline, agrees with the left one, and how the
//! disparity should change: one Gauss-Newton linearisation, per pixel.

use rayon::prelude::*;

use super::image::RowSpline;
use super::noise::Noise;
use super::spline::Spline;
use crate::data::blur::gaussian_sums;
use crate::data::sampling::{Cell, bilinear};
use crate::data::{Gray, Raster};

/// Grey levels are taken relative to this one, so that sums of their squares stay small.
const MIDDLE: f32 = 100.0;
/// Standard deviation of the windows for gain and offset, in pitches: a window covers a few dots,
/// so that it has contrast everywhere on the pattern.
const GAIN_SIGMA: f64 = 0.7;
/// Variance added to both photos before the gain is computed, grey levels squared. It keeps the
/// gain near 1 where there is no pattern.
const GAIN_VARIANCE: f64 = 4.0;
/// Plausible gain of the left photo over the right one.
const GAIN_RANGE: (f64, f64) = (0.3, 3.0);
/// Smallest compression of the surface in the right photo, right pixels per left pixel, that the
/// left photo's slope is corrected for.
const MIN_COMPRESSION: f32 = 0.3;
/// Residuals over noise are cut at this value in the misfit.
const MISFIT_LIMIT: f64 = 3.0;

/// The working photos and how their residuals are weighted.
pub(super) struct PhotometricModel {
    /// The left photo, lightly smoothed.
    pub(super) left: Gray,
    /// The right photo, with the same smoothing.
    right: RowSpline,
    /// Pixels to match.
    pub(super) domain: Raster<bool>,
    /// Standard deviation of the windows for gain and offset, pixels.
    gain_sigma_px: f64,
    /// Scale of the Geman-McClure weights, standard deviations.
    robust: f64,
    /// Independent measurements per pixel, less than 1 for smoothed photos.
    independence: f64,
}

/// One linearisation about a spline; 0 outside the domain.
pub(super) struct Linearisation {
    /// `w (dr/dd)^2`, one over pixels squared.
    pub(super) information: Gray,
    /// `-w r dr/dd`, half the negative gradient of the weighted squared residual, one over pixels.
    pub(super) gradient: Gray,
    /// Residual over its expected noise.
    pub(super) normalised: Gray,
    /// The part of the information that the slopes of both photos agree on.
    pub(super) agreed: Gray,
    /// Root mean square of the normalised residuals, each cut at 3.
    pub(super) misfit: f64,
}

/// Residuals and their derivatives about a spline.
struct Residuals {
    /// Left photo minus the warped right one, gain and offset removed; NaN outside the domain.
    value: Gray,
    /// `dr/dd` by the slope of the right photo and by that of the left one.
    derivatives: Raster<[f32; 2]>,
}

/// Sums over one block of pixels: count, left, right, their squares.
type Sums = [f64; 5];

impl PhotometricModel {
    /// The model for photos smoothed by `smooth_px` with a pattern of this pitch, pixels.
    pub(super) fn new(
        left: Gray,
        right: RowSpline,
        domain: Raster<bool>,
        pitch: f64,
        smooth_px: f64,
        robust: f64,
    ) -> Self {
        Self {
            left,
            right,
            domain,
            gain_sigma_px: GAIN_SIGMA * pitch,
            robust,
            // the noise of a Gaussian filter is correlated over an area of 4 pi sigma^2
            independence: 1.0 / (4.0 * std::f64::consts::PI * smooth_px.powi(2)).max(1.0),
        }
    }

    /// Residuals, noise and weights about a spline.
    pub(super) fn linearise(&self, spline: &Spline) -> Linearisation {
        let (width, height) = self.left.size();
        let residuals = self.residuals(spline);
        let noise = Noise::of(&residuals.value, &self.left);
        let mut information = Raster::filled(width, height, 0.0f32);
        let mut gradient = information.clone();
        let mut normalised = information.clone();
        let mut agreed = information.clone();
        let (independence, robust) = (self.independence as f32, self.robust as f32);
        information
            .data_mut()
            .par_chunks_mut(width)
            .zip(gradient.data_mut().par_chunks_mut(width))
            .zip(normalised.data_mut().par_chunks_mut(width))
            .zip(agreed.data_mut().par_chunks_mut(width))
            .enumerate()
            .for_each(|(y, (((information, gradient), normalised), agreed))| {
                let (r, left) = (residuals.value.row(y), self.left.row(y));
                let derivatives = residuals.derivatives.row(y);
                for x in (0..width).filter(|&x| r[x].is_finite()) {
                    let sigma = noise.at(left[x]);
                    normalised[x] = r[x] / sigma;
                    let u = normalised[x] / robust;
                    // Geman-McClure
                    let w = independence / (sigma * sigma) / (1.0 + u * u).powi(2);
                    // the mean of both photos' slopes has less noise than either
                    let j = 0.5 * (derivatives[x][0] + derivatives[x][1]);
                    information[x] = w * j * j;
                    gradient[x] = -w * j * r[x];
                    agreed[x] = w * derivatives[x][0] * derivatives[x][1];
                }
            });
        let misfit = misfit(&normalised, &residuals.value);
        Linearisation { information, gradient, normalised, agreed, misfit }
    }

    fn residuals(&self, spline: &Spline) -> Residuals {
        let (width, height) = self.left.size();
        let (disparity, disparity_slope) = spline.sampled(&self.domain);
        let (warped, warped_slope) = self.warped(&disparity);
        let gain = LocalGain::new(self, &warped);
        let mut value = Raster::filled(width, height, f32::NAN);
        let mut derivatives = Raster::filled(width, height, [0.0f32; 2]);
        value
            .data_mut()
            .par_chunks_mut(width)
            .zip(derivatives.data_mut().par_chunks_mut(width))
            .enumerate()
            .for_each(|(y, (value, derivatives))| {
                let (left, right, slope) = (self.left.row(y), warped.row(y), warped_slope.row(y));
                for x in (1..width.saturating_sub(1)).filter(|&x| right[x].is_finite()) {
                    let [mean_left, mean_right, gain] = gain.at(x, y);
                    value[x] = (left[x] - mean_left) - gain * (right[x] - mean_right);
                    let compression = (1.0 - disparity_slope.at(x, y)).max(MIN_COMPRESSION);
                    let left_slope = 0.5 * (left[x + 1] - left[x - 1]) / compression;
                    derivatives[x] = [gain * slope[x], left_slope];
                }
            });
        Residuals { value, derivatives }
    }

    /// The right photo and its slope at the positions the disparity gives; NaN outside the photo
    /// and the domain.
    fn warped(&self, disparity: &Raster<f64>) -> (Gray, Gray) {
        let (width, height) = self.left.size();
        let mut value = Raster::filled(width, height, f32::NAN);
        let mut slope = value.clone();
        value
            .data_mut()
            .par_chunks_mut(width)
            .zip(slope.data_mut().par_chunks_mut(width))
            .enumerate()
            .for_each(|(y, (value, slope))| {
                let d = disparity.row(y);
                for x in (0..width).filter(|&x| d[x].is_finite()) {
                    if let Some((v, g)) = self.right.sample(x as f64 - d[x], y) {
                        value[x] = v;
                        slope[x] = g;
                    }
                }
            });
        (value, slope)
    }
}

/// Root mean square of the normalised residuals, each cut at [`MISFIT_LIMIT`].
fn misfit(normalised: &Gray, residual: &Gray) -> f64 {
    let (mut squares, mut count) = (0.0, 0usize);
    for (c, r) in normalised.data().iter().zip(residual.data()) {
        if r.is_finite() {
            squares += f64::from(*c).powi(2).min(MISFIT_LIMIT * MISFIT_LIMIT);
            count += 1;
        }
    }
    (squares / count.max(1) as f64).sqrt()
}

/// Local means and gain on a coarse grid.
struct LocalGain {
    /// Width of a block, pixels.
    size: f64,
    columns: usize,
    rows: usize,
    /// Mean of the left photo, mean of the right one, gain (left over right).
    values: Vec<[f32; 3]>,
}

impl LocalGain {
    /// Means and gain of the left photo against the warped right one.
    fn new(model: &PhotometricModel, warped: &Gray) -> Self {
        let (width, height) = warped.size();
        let size = (0.5 * model.gain_sigma_px).round().max(2.0) as usize;
        let (columns, rows) = (width.div_ceil(size), height.div_ceil(size));
        let mut sums: Vec<Sums> = vec![[0.0; 5]; columns * rows];
        sums.par_chunks_mut(columns).enumerate().for_each(|(j, sums)| {
            for y in j * size..((j + 1) * size).min(height) {
                for (x, (l, r)) in model.left.row(y).iter().zip(warped.row(y)).enumerate() {
                    if r.is_finite() {
                        let (l, r) = (f64::from(l - MIDDLE), f64::from(r - MIDDLE));
                        let s = &mut sums[x / size];
                        for (s, v) in s.iter_mut().zip([1.0, l, r, l * l, r * r]) {
                            *s += v;
                        }
                    }
                }
            }
        });
        let sums = gaussian_sums(&sums, columns, rows, model.gain_sigma_px / size as f64);
        let values = sums.iter().map(means_and_gain).collect();
        Self { size: size as f64, columns, rows, values }
    }

    /// Bilinear between the centres of the blocks.
    fn at(&self, x: usize, y: usize) -> [f32; 3] {
        let along = |v: usize| (v as f64 + 0.5) / self.size - 0.5;
        let cell = Cell::clamped(along(x), along(y), (self.columns, self.rows));
        let corners = cell.corners(|i, j| self.values[j * self.columns + i]);
        let fraction = cell.fraction.map(|f| f as f32);
        std::array::from_fn(|k| bilinear(corners.map(|c| c[k]), fraction))
    }
}

fn means_and_gain(sums: &Sums) -> [f32; 3] {
    // an empty window has means of 0
    let n = sums[0].max(1e-9);
    let (l, r) = (sums[1] / n, sums[2] / n);
    let variance_left = (sums[3] / n - l * l).max(0.0) + GAIN_VARIANCE;
    let variance_right = (sums[4] / n - r * r).max(0.0) + GAIN_VARIANCE;
    let gain = (variance_left / variance_right).sqrt().clamp(GAIN_RANGE.0, GAIN_RANGE.1);
    [l as f32 + MIDDLE, r as f32 + MIDDLE, gain as f32]
}
