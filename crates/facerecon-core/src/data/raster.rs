//! Images as row-major arrays. Pixel centres are at integer coordinates, (0, 0) the top-left one.

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

    /// As [`Raster::from_fn`], on all threads.
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

    /// Applies a function to every pixel and its counterpart in another image of the same size;
    /// beyond the smaller of two sizes pixels are left out.
    pub(crate) fn zip_map<U: Copy, V: Copy>(
        &self,
        other: &Raster<U>,
        mut f: impl FnMut(T, U) -> V,
    ) -> Raster<V> {
        let (width, height) = (self.width.min(other.width), self.height.min(other.height));
        Raster::from_fn(width, height, |x, y| f(self.at(x, y), other.at(x, y)))
    }
}

impl<A: Copy, B: Copy> Raster<(A, B)> {
    /// The image of the first values and that of the second ones.
    pub(crate) fn unzip(self) -> (Raster<A>, Raster<B>) {
        let (width, height) = self.size();
        let (first, second) = self.data.into_iter().unzip();
        (Raster { width, height, data: first }, Raster { width, height, data: second })
    }
}

impl Gray {
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
    fn data_of_the_wrong_length_is_no_raster() {
        assert!(Gray::from_vec(2, 2, vec![0.0; 3]).is_none());
        assert!(Gray::from_vec(2, 2, vec![0.0; 4]).is_some());
    }

    #[test]
    fn pairs_come_apart_in_place() {
        let pairs = Raster::par_from_fn(3, 2, |x, y| (x, 10 * y));
        let (columns, rows) = pairs.unzip();
        assert_eq!((columns.at(2, 1), rows.at(2, 1)), (2, 10));
        assert_eq!(columns.zip_map(&rows, |a, b| a + b).data(), [0, 1, 2, 10, 11, 12]);
    }
}
