//! Pictures made ready for matching: shifted along columns, interpolated along rows.

use rayon::prelude::*;

use crate::data::Gray;
use crate::data::sampling::catmull_rom;

/// The picture with every pixel fetched from `shift(x, y)` pixels further down (Catmull-Rom).
pub(super) fn shifted_down(image: &Gray, shift: impl Fn(f64, f64) -> f64 + Sync) -> Gray {
    let mut out = image.clone();
    out.data_mut().par_chunks_mut(image.width().max(1)).enumerate().for_each(|(y, row)| {
        for (x, out) in row.iter_mut().enumerate() {
            let source = y as f64 + shift(x as f64, y as f64);
            let (base, t) = (source.floor(), (source - source.floor()) as f32);
            let v = |k: isize| image.clamped(x as isize, base as isize + k);
            *out = catmull_rom([v(-1), v(0), v(1), v(2)], t);
        }
    });
    out
}

/// Pixels from which the first coefficient of a row is computed. The pole is about -0.27, so the
/// rest is below the precision of `f64`.
const START_PIXELS: usize = 30;

/// A photo as a cubic spline along each row: exact at the pixels, smooth between them.
pub(super) struct RowSpline {
    coefficients: Gray,
}

impl RowSpline {
    /// Prefilters the rows (Unser 1999).
    pub(super) fn new(image: &Gray) -> Self {
        let pole = 3f64.sqrt() - 2.0;
        let mut coefficients = image.clone();
        coefficients.data_mut().par_chunks_mut(image.width().max(1)).for_each(|row| {
            let n = row.len();
            if n < 2 {
                return;
            }
            let mut c: Vec<f64> = row.iter().map(|&v| f64::from(v)).collect();
            let mut power = 1.0;
            let mut start = 0.0;
            for v in c.iter().take(START_PIXELS) {
                start += power * v;
                power *= pole;
            }
            c[0] = start;
            for i in 1..n {
                c[i] += pole * c[i - 1];
            }
            c[n - 1] = pole / (pole * pole - 1.0) * (c[n - 1] + pole * c[n - 2]);
            for i in (0..n - 1).rev() {
                c[i] = pole * (c[i + 1] - c[i]);
            }
            for (out, v) in row.iter_mut().zip(&c) {
                *out = (6.0 * v) as f32;
            }
        });
        Self { coefficients }
    }

    /// Value and derivative at `(x, y)`; `None` within two pixels of the row's ends.
    #[inline]
    pub(super) fn sample(&self, x: f64, y: usize) -> Option<(f32, f32)> {
        let width = self.coefficients.width();
        if !(x >= 1.0 && x < width as f64 - 2.0) {
            return None;
        }
        let i = x as usize;
        let t = (x - i as f64) as f32;
        let row = &self.coefficients.row(y)[i - 1..i + 3];
        let u = 1.0 - t;
        let value = (u * u * u * row[0]
            + (4.0 - 6.0 * t * t + 3.0 * t * t * t) * row[1]
            + (4.0 - 6.0 * u * u + 3.0 * u * u * u) * row[2]
            + t * t * t * row[3])
            / 6.0;
        let slope = 0.5
            * (-u * u * row[0]
                + (3.0 * t * t - 4.0 * t) * row[1]
                + (4.0 * u - 3.0 * u * u) * row[2]
                + t * t * row[3]);
        Some((value, slope))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_row_spline_interpolates_a_band_limited_row() {
        let wave = |x: f64| 100.0 + 50.0 * (x * 0.7).sin();
        let image = Gray::from_fn(60, 2, |x, _| wave(x as f64) as f32);
        let spline = RowSpline::new(&image);
        for k in 0..400 {
            let x = 12.0 + 0.09 * f64::from(k);
            let (v, g) = spline.sample(x, 1).unwrap();
            assert!((f64::from(v) - wave(x)).abs() < 0.05, "{x}: {v}");
            assert!((f64::from(g) - 35.0 * (x * 0.7).cos()).abs() < 0.3, "{x}: {g}");
        }
        assert!(spline.sample(0.5, 0).is_none() && spline.sample(58.5, 0).is_none());
        assert!(spline.sample(f64::NAN, 0).is_none());
    }

    #[test]
    fn a_vertical_shift_is_undone() {
        let wave = |y: f64| (100.0 + 40.0 * (0.5 * y).sin()) as f32;
        let low = Gray::from_fn(4, 40, |_, y| wave(y as f64 - 0.3));
        let level = shifted_down(&low, |_, _| 0.3);
        for y in 5..35 {
            assert!((level.at(2, y) - wave(y as f64)).abs() < 0.2);
        }
    }
}
