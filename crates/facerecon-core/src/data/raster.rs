//! Images as row-major arrays. Pixel centres lie at integer coordinates, (0, 0) the top-left one.

use rayon::prelude::*;

/// A `height` x `width` array in row-major order.
#[derive(Clone, Debug, PartialEq)]
pub struct Raster<T> {
    width: usize,
    height: usize,
    data: Vec<T>,
}

/// A grey image, 0 to 255 (16-bit sources keep their fractions).
pub type Gray = Raster<f32>;
/// A colour image, 8 bit sRGB.
pub type Rgb = Raster<[u8; 3]>;

impl<T: Copy> Raster<T> {
    /// An image of one value.
    pub fn filled(width: usize, height: usize, value: T) -> Self {
        Self { width, height, data: vec![value; width * height] }
    }

    /// Wraps row-major data; `None` when its length is not `width * height`.
    pub fn from_vec(width: usize, height: usize, data: Vec<T>) -> Option<Self> {
        (width.checked_mul(height) == Some(data.len())).then_some(Self { width, height, data })
    }

    /// Computes every pixel from its coordinates `(x, y)`.
    pub fn from_fn(width: usize, height: usize, mut value: impl FnMut(usize, usize) -> T) -> Self {
        let data = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        Self { width, height, data: data.map(|(x, y)| value(x, y)).collect() }
    }

    /// As [`Raster::from_fn`], the work shared among the threads.
    pub fn par_from_fn(
        width: usize,
        height: usize,
        value: impl Fn(usize, usize) -> T + Sync + Send,
    ) -> Self
    where
        T: Send,
    {
        let pixels = (0..width * height).into_par_iter();
        Self { width, height, data: pixels.map(|i| value(i % width, i / width)).collect() }
    }

    /// Columns.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// `(width, height)`.
    pub fn size(&self) -> (usize, usize) {
        (self.width, self.height)
    }

    /// All pixels, row-major.
    pub fn data(&self) -> &[T] {
        &self.data
    }

    /// All pixels, row-major.
    pub fn data_mut(&mut self) -> &mut [T] {
        &mut self.data
    }

    /// The pixels as a vector, row-major.
    pub fn into_data(self) -> Vec<T> {
        self.data
    }

    /// One row.
    pub fn row(&self, y: usize) -> &[T] {
        &self.data[y * self.width..(y + 1) * self.width]
    }

    /// The pixel at `(x, y)`, which must lie inside.
    #[inline]
    pub fn at(&self, x: usize, y: usize) -> T {
        self.data[y * self.width + x]
    }

    /// The pixel at `(x, y)`, or `None` outside.
    #[inline]
    pub fn get(&self, x: isize, y: isize) -> Option<T> {
        (x >= 0 && y >= 0 && (x as usize) < self.width && (y as usize) < self.height)
            .then(|| self.at(x as usize, y as usize))
    }

    /// The pixel at `(x, y)`, or the nearest one on the border.
    #[inline]
    pub fn clamped(&self, x: isize, y: isize) -> T {
        let x = x.clamp(0, self.width as isize - 1) as usize;
        let y = y.clamp(0, self.height as isize - 1) as usize;
        self.at(x, y)
    }

    /// Sets the pixel at `(x, y)`, which must lie inside.
    #[inline]
    pub fn set(&mut self, x: usize, y: usize, value: T) {
        self.data[y * self.width + x] = value;
    }

    /// Applies a function to every pixel.
    pub fn map<U: Copy>(&self, f: impl FnMut(T) -> U) -> Raster<U> {
        Raster {
            width: self.width,
            height: self.height,
            data: self.data.iter().copied().map(f).collect(),
        }
    }
}

impl Gray {
    /// Bilinear sample; `None` outside the pixel centres' hull.
    #[inline]
    pub fn bilinear(&self, x: f64, y: f64) -> Option<f32> {
        let (w, h) = (self.width as f64, self.height as f64);
        if !(x >= 0.0 && y >= 0.0 && x <= w - 1.0 && y <= h - 1.0) {
            return None;
        }
        let (x0, y0) =
            ((x as usize).min(self.width.max(2) - 2), (y as usize).min(self.height.max(2) - 2));
        let (x1, y1) = ((x0 + 1).min(self.width - 1), (y0 + 1).min(self.height - 1));
        let (fx, fy) = ((x - x0 as f64) as f32, (y - y0 as f64) as f32);
        let top = self.at(x0, y0) * (1.0 - fx) + self.at(x1, y0) * fx;
        let bottom = self.at(x0, y1) * (1.0 - fx) + self.at(x1, y1) * fx;
        Some(top * (1.0 - fy) + bottom * fy)
    }

    /// As 8 bit, rounded and clipped.
    pub fn to_u8(&self) -> Raster<u8> {
        self.map(|v| v.round().clamp(0.0, 255.0) as u8)
    }
}

impl Rgb {
    /// Luma (Rec. 601), 0 to 255.
    pub fn to_gray(&self) -> Gray {
        self.map(|[r, g, b]| 0.299 * f32::from(r) + 0.587 * f32::from(g) + 0.114 * f32::from(b))
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
        assert!(Gray::from_vec(2, 2, vec![0.0; 3]).is_none());
    }
}
