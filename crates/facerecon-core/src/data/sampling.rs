//! Values between the samples of a regular grid. Sample centres are at integer coordinates.
//!
//! The variants differ in arithmetic or at the border, and results are kept to the bit: each has a
//! name of its own.

use std::ops::{Add, Mul, Sub};

use super::{Gray, Raster};

/// The four samples around a position, and the position between them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cell {
    /// Columns left and right of the position.
    x: [usize; 2],
    /// Rows above and below it.
    y: [usize; 2],
    /// Position between them, 0 to 1, along x and y.
    pub(crate) fraction: [f64; 2],
}

impl Cell {
    /// The cell of a position; positions outside the grid of `size` = (width, height) move to its
    /// border. The grid must have samples.
    #[inline]
    pub(crate) fn clamped(x: f64, y: f64, (width, height): (usize, usize)) -> Self {
        let x = x.clamp(0.0, (width - 1) as f64);
        let y = y.clamp(0.0, (height - 1) as f64);
        let (x0, y0) = (x as usize, y as usize);
        Self {
            x: [x0, (x0 + 1).min(width - 1)],
            y: [y0, (y0 + 1).min(height - 1)],
            fraction: [x - x0 as f64, y - y0 as f64],
        }
    }

    /// The values at the four corners, row by row.
    #[inline]
    pub(crate) fn corners<T>(&self, at: impl Fn(usize, usize) -> T) -> [T; 4] {
        let ([x0, x1], [y0, y1]) = (self.x, self.y);
        [at(x0, y0), at(x1, y0), at(x0, y1), at(x1, y1)]
    }

    /// Bilinear weights of the four corners, for sampling several grids of one size at the same
    /// position.
    #[inline]
    pub(crate) fn weights(&self) -> [f32; 4] {
        let [fx, fy] = self.fraction.map(|f| f as f32);
        [(1.0 - fx) * (1.0 - fy), fx * (1.0 - fy), (1.0 - fx) * fy, fx * fy]
    }
}

/// Bilinear interpolation between four corners (row by row): `a (1 - f) + b f`, exact at both ends.
#[inline]
pub(crate) fn bilinear<T>([a, b, c, d]: [T; 4], [fx, fy]: [T; 2]) -> T
where
    T: Copy + From<u8> + Add<Output = T> + Sub<Output = T> + Mul<Output = T>,
{
    let one = T::from(1);
    let top = a * (one - fx) + b * fx;
    let bottom = c * (one - fx) + d * fx;
    top * (one - fy) + bottom * fy
}

/// Catmull-Rom interpolation between `b` and `c` at `t` (0 to 1), as a polynomial in `t`: the
/// shortest form where only one direction is interpolated.
#[inline]
pub(crate) fn catmull_rom([a, b, c, d]: [f32; 4], t: f32) -> f32 {
    b + 0.5 * t * (c - a + t * (2.0 * a - 5.0 * b + 4.0 * c - d + t * (3.0 * (b - c) + d - a)))
}

/// Catmull-Rom weights of the four samples around a fraction `t`, in double precision for
/// [`Gray::bicubic`].
fn catmull_rom_weights(t: f64) -> [f64; 4] {
    [
        ((2.0 - t) * t - 1.0) * t / 2.0,
        ((3.0 * t - 5.0) * t * t + 2.0) / 2.0,
        ((4.0 - 3.0 * t) * t + 1.0) * t / 2.0,
        (t - 1.0) * t * t / 2.0,
    ]
}

/// The same weights in single precision for [`Raster::bicubic_clamped`], which samples every texel.
fn catmull_rom_weights_f32(t: f32) -> [f32; 4] {
    let (t2, t3) = (t * t, t * t * t);
    [
        0.5 * (-t + 2.0 * t2 - t3),
        0.5 * (2.0 - 5.0 * t2 + 3.0 * t3),
        0.5 * (t + 4.0 * t2 - 3.0 * t3),
        0.5 * (t3 - t2),
    ]
}

impl Gray {
    /// Bilinear sample; `None` outside the pixel centres' hull. The last column and row belong to
    /// the cells before them, so that a hole (NaN) beside them counts.
    #[inline]
    pub fn bilinear(&self, x: f64, y: f64) -> Option<f32> {
        let (width, height) = self.size();
        if !(x >= 0.0 && y >= 0.0 && x <= width as f64 - 1.0 && y <= height as f64 - 1.0) {
            return None;
        }
        let (x0, y0) = ((x as usize).min(width.max(2) - 2), (y as usize).min(height.max(2) - 2));
        let (x1, y1) = ((x0 + 1).min(width - 1), (y0 + 1).min(height - 1));
        let fraction = [(x - x0 as f64) as f32, (y - y0 as f64) as f32];
        let corners = [self.at(x0, y0), self.at(x1, y0), self.at(x0, y1), self.at(x1, y1)];
        Some(bilinear(corners, fraction))
    }

    /// Bicubic sample (Catmull-Rom; Keys 1981) in double precision, clipped to 0..255; `None` more
    /// than half a pixel outside the border's pixel centres, whose values continue outward.
    pub(crate) fn bicubic(&self, x: f64, y: f64) -> Option<f32> {
        let (width, height) = (self.width() as f64, self.height() as f64);
        if !(x >= -0.5 && y >= -0.5 && x <= width - 0.5 && y <= height - 0.5) {
            return None;
        }
        let (x0, y0) = (x.floor(), y.floor());
        let (wx, wy) = (catmull_rom_weights(x - x0), catmull_rom_weights(y - y0));
        let (x0, y0) = (x0 as isize, y0 as isize);
        let mut sum = 0.0;
        for (j, b) in wy.iter().enumerate() {
            for (i, a) in wx.iter().enumerate() {
                let v = self.clamped(x0 + i as isize - 1, y0 + j as isize - 1);
                sum += a * b * f64::from(v);
            }
        }
        Some(sum.clamp(0.0, 255.0) as f32)
    }
}

impl<const N: usize> Raster<[f32; N]> {
    /// Bilinear sample of all channels; the border continues outward. Computed as `a + (b - a) f`,
    /// one multiplication less than [`bilinear`].
    #[inline]
    pub(crate) fn bilinear_clamped(&self, x: f64, y: f64) -> [f32; N] {
        let cell = Cell::clamped(x, y, self.size());
        let [a, b, c, d] = cell.corners(|x, y| self.at(x, y));
        let [fx, fy] = cell.fraction.map(|f| f as f32);
        std::array::from_fn(|i| {
            let top = a[i] + (b[i] - a[i]) * fx;
            let bottom = c[i] + (d[i] - c[i]) * fx;
            top + (bottom - top) * fy
        })
    }

    /// Bicubic sample of all channels (Catmull and Rom 1974) in single precision, not clipped; near
    /// the border bilinear.
    #[inline]
    pub(crate) fn bicubic_clamped(&self, x: f64, y: f64) -> [f32; N] {
        let (width, height) = (self.width() as f64, self.height() as f64);
        if !(x >= 1.0 && y >= 1.0 && x < width - 2.0 && y < height - 2.0) {
            return self.bilinear_clamped(x, y);
        }
        let (x0, y0) = (x as usize, y as usize);
        let wx = catmull_rom_weights_f32((x - x0 as f64) as f32);
        let wy = catmull_rom_weights_f32((y - y0 as f64) as f32);
        let mut sum = [0.0f32; N];
        for (j, wy) in wy.into_iter().enumerate() {
            let row = &self.row(y0 + j - 1)[x0 - 1..x0 + 3];
            for (pixel, wx) in row.iter().zip(wx) {
                for i in 0..N {
                    sum[i] += wy * wx * pixel[i];
                }
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bilinear_reproduces_a_plane_and_refuses_outside() {
        let plane = Gray::from_fn(7, 5, |x, y| 2.0 * x as f32 - 3.0 * y as f32 + 1.0);
        assert_eq!(plane.bilinear(2.25, 3.5), Some(2.0 * 2.25 - 3.0 * 3.5 + 1.0));
        assert_eq!(plane.bilinear(6.0, 4.0), Some(1.0));
        assert_eq!(plane.bilinear(6.01, 4.0), None);
        assert_eq!(plane.bilinear(f64::NAN, 1.0), None);
        assert_eq!(Gray::filled(1, 1, 3.0).bilinear(0.0, 0.0), Some(3.0));
    }

    #[test]
    fn all_variants_agree_on_a_plane() {
        let value = |x: f64, y: f64| 2.0 * x - 3.0 * y + 40.0;
        let plane = Gray::from_fn(9, 8, |x, y| value(x as f64, y as f64) as f32);
        let colors = plane.map(|v| [v, 2.0 * v]);
        for k in 0..40 {
            let (x, y) = (1.1 + 0.14 * f64::from(k), 5.9 - 0.12 * f64::from(k));
            let wanted = value(x, y);
            let cell = Cell::clamped(x, y, plane.size());
            let corners = cell.corners(|x, y| plane.at(x, y));
            let weighted: f32 = (0..4).map(|i| cell.weights()[i] * corners[i]).sum();
            let all = [
                plane.bilinear(x, y).unwrap(),
                plane.bicubic(x, y).unwrap(),
                colors.bilinear_clamped(x, y)[0],
                colors.bicubic_clamped(x, y)[1] / 2.0,
                weighted,
            ];
            assert!(all.iter().all(|v| (f64::from(*v) - wanted).abs() < 1e-4), "{all:?} {wanted}");
        }
        assert_eq!(colors.bicubic_clamped(-3.0, 99.0), colors.at(0, 7));
    }

    #[test]
    fn catmull_rom_passes_through_its_samples() {
        let samples = [3.0, 5.0, -2.0, 8.0];
        assert_eq!((catmull_rom(samples, 0.0), catmull_rom(samples, 1.0)), (5.0, -2.0));
        for t in [0.0f32, 0.25, 0.6, 1.0] {
            let [wide, short] =
                [catmull_rom_weights(f64::from(t)).map(|w| w as f32), catmull_rom_weights_f32(t)];
            let sum = |w: [f32; 4]| (0..4).map(|k| w[k] * samples[k]).sum::<f32>();
            assert!((sum(wide) - catmull_rom(samples, t)).abs() < 1e-5);
            assert!((sum(short) - catmull_rom(samples, t)).abs() < 1e-5);
        }
    }
}
