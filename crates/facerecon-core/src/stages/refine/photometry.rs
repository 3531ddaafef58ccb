//! How well the right picture, warped by a surface, explains the left one, and which way the
//! surface should move: one Gauss-Newton linearisation, per pixel.

use rayon::prelude::*;

use super::image::RowSpline;
use super::surface::Surface;
use crate::data::{Gray, Raster};

/// Classes of brightness in which noise is measured.
const CLASSES: usize = 8;
/// Brightness is taken about this grey level so that its squares stay small.
const MIDDLE: f32 = 100.0;
/// Least noise assumed, grey levels (quantisation of 8 bit pictures).
const QUIET: f32 = 0.3;

/// The pair as the matching sees it.
pub(super) struct Scene {
    /// The left picture, lightly smoothed.
    pub(super) left: Gray,
    /// The right picture, smoothed alike.
    pub(super) right: RowSpline,
    /// Pixels to explain.
    pub(super) domain: Raster<bool>,
    /// Spread of the windows that gain and offset come from, pixels.
    pub(super) gain_sigma_px: f64,
    /// Residuals beyond this many standard deviations lose their say.
    pub(super) robust: f64,
    /// Independent measurements per pixel, less than 1 for smoothed pictures.
    pub(super) independence: f64,
}

/// One linearisation about a surface; 0 outside the domain.
pub(super) struct Linearised {
    /// `w (dr/dd)^2`, one over pixels squared.
    pub(super) information: Gray,
    /// `-w r dr/dd`: the pull on the disparity.
    pub(super) drive: Gray,
    /// Residual over its expected noise.
    pub(super) chi: Gray,
    /// The part of the information that both pictures' slopes agree on.
    pub(super) agreed: Gray,
    /// Root mean square of `chi` with outliers cut at 3.
    pub(super) misfit: f64,
}

/// Sums over one cell of pixels: count, left, right, their squares.
type Sums = [f64; 5];

impl Scene {
    /// Residuals, noise and weights about a surface.
    pub(super) fn linearise(&self, surface: &Surface) -> Linearised {
        let (width, height) = self.left.size();
        let (disparity, tilt) = surface.sampled(&self.domain);
        let (value, slope) = self.warped(&disparity);
        let cells = Cells::new(self, &value);
        let mut residual = Raster::filled(width, height, f32::NAN);
        let mut lever = Raster::filled(width, height, [0.0f32; 2]);
        residual
            .data_mut()
            .par_chunks_mut(width)
            .zip(lever.data_mut().par_chunks_mut(width))
            .enumerate()
            .for_each(|(y, (residual, lever))| {
                let (left, value, slope) = (self.left.row(y), value.row(y), slope.row(y));
                for x in (1..width.saturating_sub(1)).filter(|&x| value[x].is_finite()) {
                    let [mean_left, mean_right, gain] = cells.at(x, y);
                    residual[x] = (left[x] - mean_left) - gain * (value[x] - mean_right);
                    let own = 0.5 * (left[x + 1] - left[x - 1]) / (1.0 - tilt.at(x, y)).max(0.3);
                    lever[x] = [gain * slope[x], own];
                }
            });
        let noise = self.noise(&residual);
        let mut information = Raster::filled(width, height, 0.0f32);
        let mut drive = information.clone();
        let mut chi = information.clone();
        let mut agreed = information.clone();
        let (independence, robust) = (self.independence as f32, self.robust as f32);
        information
            .data_mut()
            .par_chunks_mut(width)
            .zip(drive.data_mut().par_chunks_mut(width))
            .zip(chi.data_mut().par_chunks_mut(width))
            .zip(agreed.data_mut().par_chunks_mut(width))
            .enumerate()
            .for_each(|(y, (((information, drive), chi), agreed))| {
                let (r, lever, left) = (residual.row(y), lever.row(y), self.left.row(y));
                for x in (0..width).filter(|&x| r[x].is_finite()) {
                    let sigma = noise_at(&noise, left[x]);
                    chi[x] = r[x] / sigma;
                    let u = chi[x] / robust;
                    // Geman-McClure
                    let w = independence / (sigma * sigma) / (1.0 + u * u).powi(2);
                    // both pictures' slopes, each with its own noise, say how r grows with d
                    let j = 0.5 * (lever[x][0] + lever[x][1]);
                    information[x] = w * j * j;
                    drive[x] = -w * j * r[x];
                    agreed[x] = w * lever[x][0] * lever[x][1];
                }
            });
        let (mut squares, mut count) = (0.0, 0usize);
        for (c, r) in chi.data().iter().zip(residual.data()) {
            if r.is_finite() {
                squares += f64::from(*c).powi(2).min(9.0);
                count += 1;
            }
        }
        let misfit = (squares / count.max(1) as f64).sqrt();
        Linearised { information, drive, chi, agreed, misfit }
    }

    /// The right picture and its slope where the surface points; NaN where that leaves it.
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

    /// Noise of a residual by brightness: shot noise, rendering noise and what the model leaves
    /// out all grow with it. Median absolute residuals, one a class; classes with few pixels take
    /// the next one's.
    fn noise(&self, residual: &Gray) -> [f32; CLASSES] {
        const STEPS: usize = 512;
        let step = 0.125f32;
        let mut counts = vec![[0u32; STEPS]; CLASSES];
        for (r, v) in residual.data().iter().zip(self.left.data()).filter(|(r, _)| r.is_finite()) {
            counts[class(*v).0][((r.abs() / step) as usize).min(STEPS - 1)] += 1;
        }
        let median = |counts: &[u32; STEPS]| {
            let total: u32 = counts.iter().sum();
            let mut seen = 0;
            let middle = counts.iter().position(|c| {
                seen += c;
                2 * seen >= total
            });
            (total >= 200).then(|| {
                let at = middle.map_or(0.0, |i| (i as f32 + 0.5) * step);
                (1.4826 * at).max(QUIET)
            })
        };
        let known: Vec<Option<f32>> = counts.iter().map(median).collect();
        std::array::from_fn(|k| {
            let below = known[..=k].iter().rev().flatten().next();
            let above = known[k..].iter().flatten().next();
            below.or(above).copied().unwrap_or(1.0)
        })
    }
}

/// The class a brightness lies in, and where in it (0 to 1).
fn class(brightness: f32) -> (usize, f32) {
    let t = brightness.clamp(0.0, 255.0) * CLASSES as f32 / 256.0;
    (t as usize, t - t.floor())
}

/// Noise between the middles of the classes.
fn noise_at(noise: &[f32; CLASSES], brightness: f32) -> f32 {
    let (k, t) = class(brightness);
    let (other, share) =
        if t < 0.5 { (k.saturating_sub(1), 0.5 - t) } else { ((k + 1).min(CLASSES - 1), t - 0.5) };
    noise[k] + (noise[other] - noise[k]) * share
}

/// Local means and gain on a coarse grid.
struct Cells {
    size: f64,
    columns: usize,
    rows: usize,
    /// Mean left, mean right, gain (left over right).
    values: Vec<[f32; 3]>,
}

impl Cells {
    fn new(scene: &Scene, warped: &Gray) -> Self {
        let (width, height) = warped.size();
        let size = (0.5 * scene.gain_sigma_px).round().max(2.0) as usize;
        let (columns, rows) = (width.div_ceil(size), height.div_ceil(size));
        let mut sums: Vec<Sums> = vec![[0.0; 5]; columns * rows];
        sums.par_chunks_mut(columns).enumerate().for_each(|(j, sums)| {
            for y in j * size..((j + 1) * size).min(height) {
                for (x, (l, r)) in scene.left.row(y).iter().zip(warped.row(y)).enumerate() {
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
        let sums = blurred(&sums, columns, rows, scene.gain_sigma_px / size as f64);
        let values = sums
            .iter()
            .map(|s| {
                let n = s[0].max(1e-9);
                let (l, r) = (s[1] / n, s[2] / n);
                // a little variance on both sides keeps the gain near 1 where there is no pattern
                let (vl, vr) =
                    ((s[3] / n - l * l).max(0.0) + 4.0, (s[4] / n - r * r).max(0.0) + 4.0);
                let gain = (vl / vr).sqrt().clamp(0.3, 3.0);
                [l as f32 + MIDDLE, r as f32 + MIDDLE, gain as f32]
            })
            .collect();
        Self { size: size as f64, columns, rows, values }
    }

    /// Bilinear between the cells' middles.
    fn at(&self, x: usize, y: usize) -> [f32; 3] {
        let along = |v: usize, n: usize| {
            let c = ((v as f64 + 0.5) / self.size - 0.5).clamp(0.0, (n - 1) as f64);
            let i = (c as usize).min(n.max(2) - 2);
            (i, (i + 1).min(n - 1), (c - i as f64) as f32)
        };
        let ((i, i2, s), (j, j2, t)) = (along(x, self.columns), along(y, self.rows));
        let v = |i: usize, j: usize| &self.values[j * self.columns + i];
        let (a, b, c, d) = (v(i, j), v(i2, j), v(i, j2), v(i2, j2));
        std::array::from_fn(|k| {
            (a[k] * (1.0 - s) + b[k] * s) * (1.0 - t) + (c[k] * (1.0 - s) + d[k] * s) * t
        })
    }
}

/// Gaussian blur of a grid of sums, nothing beyond its border; weights are 1 in the middle, not
/// normalised.
pub(super) fn blurred<const N: usize>(
    grid: &[[f64; N]],
    columns: usize,
    rows: usize,
    sigma: f64,
) -> Vec<[f64; N]> {
    let reach = (3.0 * sigma).ceil() as isize;
    let bell = |i: isize| (-(i * i) as f64 / (2.0 * sigma * sigma)).exp();
    let kernel: Vec<f64> = (-reach..=reach).map(bell).collect();
    let pass = |source: &[[f64; N]], dx: isize, dy: isize| -> Vec<[f64; N]> {
        (0..columns * rows)
            .into_par_iter()
            .map(|k| {
                let (i, j) = ((k % columns) as isize, (k / columns) as isize);
                let mut sum = [0.0; N];
                for (w, o) in kernel.iter().zip(-reach..=reach) {
                    let (u, v) = (i + dx * o, j + dy * o);
                    if u >= 0 && v >= 0 && u < columns as isize && v < rows as isize {
                        let s = &source[v as usize * columns + u as usize];
                        sum.iter_mut().zip(s).for_each(|(a, b)| *a += w * b);
                    }
                }
                sum
            })
            .collect()
    };
    pass(&pass(grid, 1, 0), 0, 1)
}
