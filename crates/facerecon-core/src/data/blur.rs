//! Smoothing of images.
//!
//! The variants differ in cut-off, precision or kernel, and results are kept to the bit: each has a
//! name of its own. Beyond the border the nearest pixel counts, except in [`gaussian_sums`].

use rayon::prelude::*;

use super::{Gray, Raster};

impl Gray {
    /// The image smoothed by a Gaussian of standard deviation `sigma_px`, cut off at 3 sigma;
    /// weights are normalised in single precision. A sigma of 0 or less changes nothing.
    pub fn blurred(&self, sigma_px: f64) -> Gray {
        let (width, height) = self.size();
        if !(sigma_px > 0.0) || !sigma_px.is_finite() || width == 0 || height == 0 {
            return self.clone();
        }
        let radius = ((3.0 * sigma_px).ceil() as usize).clamp(1, width.max(height));
        let mut kernel: Vec<f32> = gaussian(sigma_px, radius).map(|k| k as f32).collect();
        let sum: f32 = kernel.iter().sum();
        kernel.iter_mut().for_each(|k| *k /= sum);
        convolved(self, &kernel, 0.0, |sum, weight, value| *sum += weight * value)
    }

    /// As [`Gray::blurred`], cut off at `cutoff` sigma and with weights normalised in double
    /// precision.
    pub(crate) fn blurred_to(&self, sigma_px: f64, cutoff: f64) -> Gray {
        if !(sigma_px > 0.0) {
            return self.clone();
        }
        let kernel = normalised(sigma_px, cutoff);
        convolved(self, &kernel, 0.0, |sum, weight, value| *sum += weight * value)
    }

    /// As [`Gray::blurred`], with sums in double precision: for values that are compared with a
    /// threshold. A sigma below 0.001 changes nothing.
    pub(crate) fn blurred_f64(&self, sigma_px: f64) -> Gray {
        if !(sigma_px > 1e-3) || self.data().is_empty() {
            return self.clone();
        }
        let radius = (3.0 * sigma_px).ceil() as isize;
        let weights: Vec<f64> = gaussian(sigma_px, radius as usize).collect();
        let total: f64 = weights.iter().sum();
        let pass = |image: &Gray, along_x: bool| {
            Gray::par_from_fn(image.width(), image.height(), |x, y| {
                let sum: f64 = (-radius..=radius)
                    .zip(&weights)
                    .map(|(d, weight)| {
                        let (dx, dy) = if along_x { (d, 0) } else { (0, d) };
                        weight * f64::from(image.clamped(x as isize + dx, y as isize + dy))
                    })
                    .sum();
                (sum / total) as f32
            })
        };
        pass(&pass(self, true), false)
    }
}

impl<const N: usize> Raster<[f32; N]> {
    /// As [`Gray::blurred_to`], for every channel.
    pub(crate) fn blurred_to(&self, sigma_px: f64, cutoff: f64) -> Self {
        if !(sigma_px > 0.0) {
            return self.clone();
        }
        convolved(self, &normalised(sigma_px, cutoff), [0.0; N], |sum, weight, value| {
            (0..N).for_each(|i| sum[i] += weight * value[i]);
        })
    }

    /// Two box blurs in each direction, close to a Gaussian of sigma `0.82 radius`: the time does
    /// not depend on the radius.
    pub(crate) fn box_blurred(&self, radius: usize) -> Self {
        let once = |image: &Self| box_columns(&box_rows(image, radius), radius);
        once(&once(self))
    }
}

/// Gaussian weights at `-radius..=radius`, 1 in the middle.
fn gaussian(sigma: f64, radius: usize) -> impl Iterator<Item = f64> {
    (0..=2 * radius).map(move |i| (-0.5 * ((i as f64 - radius as f64) / sigma).powi(2)).exp())
}

/// Gaussian weights with sum 1, cut off at `cutoff` sigma.
fn normalised(sigma: f64, cutoff: f64) -> Vec<f32> {
    let radius = (cutoff * sigma).ceil() as usize;
    let total: f64 = gaussian(sigma, radius).sum();
    gaussian(sigma, radius).map(|k| (k / total) as f32).collect()
}

/// Convolves with a symmetric kernel of odd length along rows, then along columns. `add` adds a
/// weighted pixel to a sum.
fn convolved<T: Copy + Send + Sync>(
    image: &Raster<T>,
    kernel: &[f32],
    zero: T,
    add: impl Fn(&mut T, f32, T) + Sync,
) -> Raster<T> {
    let (width, height) = image.size();
    if width == 0 || height == 0 {
        return image.clone();
    }
    let radius = kernel.len() / 2;
    // Both passes add whole shifted rows, which the compiler turns into vector code.
    let mut across = Raster::filled(width, height, zero);
    across.data_mut().par_chunks_mut(width).enumerate().for_each(|(y, out)| {
        let row = image.row(y);
        let mut padded = Vec::with_capacity(width + 2 * radius);
        padded.resize(radius, row[0]);
        padded.extend_from_slice(row);
        padded.resize(width + 2 * radius, row[width - 1]);
        for (t, k) in kernel.iter().enumerate() {
            out.iter_mut().zip(&padded[t..t + width]).for_each(|(o, v)| add(o, *k, *v));
        }
    });
    let mut down = Raster::filled(width, height, zero);
    down.data_mut().par_chunks_mut(width).enumerate().for_each(|(y, out)| {
        for (t, k) in kernel.iter().enumerate() {
            let source = (y + t).saturating_sub(radius).min(height - 1);
            out.iter_mut().zip(across.row(source)).for_each(|(o, v)| add(o, *k, *v));
        }
    });
    down
}

fn box_rows<const N: usize>(image: &Raster<[f32; N]>, radius: usize) -> Raster<[f32; N]> {
    let (w, h) = image.size();
    let mut out = Raster::filled(w, h, [0.0f32; N]);
    let scale = 1.0 / (2 * radius + 1) as f64;
    out.data_mut().par_chunks_mut(w.max(1)).enumerate().for_each(|(y, out)| {
        let row = image.row(y);
        let at = |x: isize| row[x.clamp(0, w as isize - 1) as usize];
        // f64: a running sum in f32 drifts along the row
        let mut sum = [0.0f64; N];
        for x in -(radius as isize)..=radius as isize {
            let v = at(x);
            (0..N).for_each(|i| sum[i] += f64::from(v[i]));
        }
        for x in 0..w {
            out[x] = std::array::from_fn(|i| (sum[i] * scale) as f32);
            let (enter, leave) = (at((x + radius + 1) as isize), at(x as isize - radius as isize));
            (0..N).for_each(|i| sum[i] += f64::from(enter[i]) - f64::from(leave[i]));
        }
    });
    out
}

/// Along the columns, all columns of a row at once; each task sums its own first window.
fn box_columns<const N: usize>(image: &Raster<[f32; N]>, radius: usize) -> Raster<[f32; N]> {
    let (w, h) = image.size();
    let mut out = Raster::filled(w, h, [0.0f32; N]);
    let scale = 1.0 / (2 * radius + 1) as f64;
    let band = (4 * radius).max(64);
    out.data_mut().par_chunks_mut(w.max(1) * band).enumerate().for_each(|(task, out)| {
        let row = |y: isize| image.row(y.clamp(0, h as isize - 1) as usize);
        let (first, reach) = ((task * band) as isize, radius as isize);
        let mut sums = vec![[0.0f64; N]; w];
        for y in first - reach..=first + reach {
            for (sum, v) in sums.iter_mut().zip(row(y)) {
                (0..N).for_each(|i| sum[i] += f64::from(v[i]));
            }
        }
        for (y, out) in (first..).zip(out.chunks_mut(w)) {
            let (enter, leave) = (row(y + reach + 1), row(y - reach));
            for (((out, sum), enter), leave) in out.iter_mut().zip(&mut sums).zip(enter).zip(leave)
            {
                *out = std::array::from_fn(|i| (sum[i] * scale) as f32);
                (0..N).for_each(|i| sum[i] += f64::from(enter[i]) - f64::from(leave[i]));
            }
        }
    });
    out
}

/// Gaussian-weighted sums over a row-major grid of sums, cut off at 3 sigma. Weights are 1 in the
/// middle, not normalised, and nothing counts beyond the border: a ratio of two sums is a mean.
pub(crate) fn gaussian_sums<const N: usize>(
    grid: &[[f64; N]],
    columns: usize,
    rows: usize,
    sigma: f64,
) -> Vec<[f64; N]> {
    let reach = (3.0 * sigma).ceil() as isize;
    // not `gaussian`: the exponent is rounded otherwise
    let weight = |i: isize| (-(i * i) as f64 / (2.0 * sigma * sigma)).exp();
    let kernel: Vec<f64> = (-reach..=reach).map(weight).collect();
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

#[cfg(test)]
mod tests {
    use super::*;

    fn point(value: f32) -> Gray {
        let mut image = Gray::filled(41, 37, 0.0);
        image.set(20, 18, value);
        image
    }

    #[test]
    fn a_point_becomes_a_gaussian_and_its_sum_stays() {
        let smooth = point(100.0).blurred(2.0);
        assert!((smooth.data().iter().sum::<f32>() - 100.0).abs() < 1e-3);
        let expected = 100.0 / (2.0 * std::f32::consts::PI * 4.0);
        assert!((smooth.at(20, 18) - expected).abs() < 0.02, "{}", smooth.at(20, 18));
        let ratio = smooth.at(22, 18) / smooth.at(20, 18);
        assert!((ratio - (-0.5_f32).exp()).abs() < 1e-3);
    }

    #[test]
    fn flat_stays_flat_up_to_the_border() {
        let smooth = Gray::filled(9, 5, 7.0).blurred(3.0);
        assert!(smooth.data().iter().all(|v| (v - 7.0).abs() < 1e-4));
    }

    #[test]
    fn smoothing_keeps_the_sum() {
        let image = Gray::from_fn(9, 9, |x, y| if (x, y) == (4, 4) { 100.0 } else { 0.0 });
        let total: f32 = image.blurred_to(0.7, 3.5).data().iter().sum();
        assert!((total - 100.0).abs() < 0.1, "{total}");
    }

    #[test]
    fn the_variants_agree_on_a_point() {
        let wide = point(100.0).blurred_to(2.0, 3.0);
        let others = [
            point(100.0).blurred(2.0),
            point(100.0).blurred_f64(2.0),
            point(100.0).map(|v| [v]).blurred_to(2.0, 3.0).map(|[v]| v),
        ];
        for other in others {
            let difference = wide.data().iter().zip(other.data()).map(|(a, b)| (a - b).abs());
            assert!(difference.fold(0.0, f32::max) < 1e-5);
        }
        let boxes = point(100.0).map(|v| [v]).box_blurred(2).map(|[v]| v);
        assert!((boxes.at(20, 18) - 100.0 / 25.0).abs() < 1e-4, "{}", boxes.at(20, 18));
    }

    #[test]
    fn the_ratio_of_two_gaussian_sums_is_a_mean_up_to_the_border() {
        let grid: Vec<[f64; 2]> = (0..12).map(|_| [2.0, 6.0]).collect();
        for [count, sum] in gaussian_sums(&grid, 4, 3, 1.5) {
            assert!((sum / count - 3.0).abs() < 1e-12);
        }
    }
}
