//! Sums and means over square blocks of pixels: smaller images without aliasing. A last block that
//! is not complete is left out.

use super::{Gray, Raster, Rgb};

impl Gray {
    /// Means of `side` x `side` pixels: pixel `x` of the result has its centre at
    /// `side x + (side - 1) / 2` of this image, and likewise `y`.
    pub(crate) fn block_means(&self, side: usize) -> Gray {
        let scale = 1.0 / (side * side) as f32;
        Gray::from_fn(self.width() / side, self.height() / side, |x, y| {
            let rows = (0..side).map(|j| &self.row(y * side + j)[x * side..(x + 1) * side]);
            rows.flatten().sum::<f32>() * scale
        })
    }

    /// The image at half the size: pixel `(x, y)` has its centre at `(2 x + 0.5, 2 y + 0.5)` of the
    /// full image.
    pub fn halved(&self) -> Gray {
        self.block_means(2)
    }
}

impl Rgb {
    /// Sums of `side` x `side` pixels, channel by channel. How a mean is rounded is the caller's.
    pub(crate) fn block_sums(&self, side: usize) -> Raster<[u32; 3]> {
        Raster::par_from_fn(self.width() / side, self.height() / side, |x, y| {
            let mut sum = [0u32; 3];
            for j in 0..side {
                for p in &self.row(y * side + j)[x * side..(x + 1) * side] {
                    (0..3).for_each(|c| sum[c] += u32::from(p[c]));
                }
            }
            sum
        })
    }

    /// The image at half the size, rounded; see [`Gray::halved`].
    pub fn halved(&self) -> Rgb {
        self.block_sums(2).map(|sum| sum.map(|s| ((s + 2) / 4) as u8))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_averaged_and_the_incomplete_last_one_is_left_out() {
        assert_eq!(Gray::filled(9, 5, 7.0).halved().size(), (4, 2));
        let ramp = Gray::from_fn(7, 6, |x, y| (x + 10 * y) as f32);
        assert_eq!(ramp.block_means(3).data(), [11.0, 14.0, 41.0, 44.0]);
        let color = Rgb::from_fn(3, 2, |x, y| [x as u8, y as u8, 200]);
        assert_eq!(color.halved().data(), [[1, 1, 200]]);
        assert_eq!(color.block_sums(1).at(2, 1), [2, 1, 200]);
    }
}
