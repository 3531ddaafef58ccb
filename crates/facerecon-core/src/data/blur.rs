//! Gaussian smoothing of grey images, and halving.

use rayon::prelude::*;

use super::{Gray, Rgb};

impl Gray {
    /// The image smoothed by a Gaussian of standard deviation `sigma_px`, cut off at 3 sigma;
    /// beyond the border the nearest pixel counts. A sigma of 0 or less changes nothing.
    pub fn blurred(&self, sigma_px: f64) -> Gray {
        let (width, height) = self.size();
        if !(sigma_px > 0.0) || !sigma_px.is_finite() || width == 0 || height == 0 {
            return self.clone();
        }
        let radius = ((3.0 * sigma_px).ceil() as usize).clamp(1, width.max(height));
        let mut kernel: Vec<f32> = (0..=2 * radius)
            .map(|i| (-0.5 * ((i as f64 - radius as f64) / sigma_px).powi(2)).exp() as f32)
            .collect();
        let sum: f32 = kernel.iter().sum();
        kernel.iter_mut().for_each(|k| *k /= sum);

        // Both passes add whole shifted rows, which the compiler turns into vector code.
        let mut across = vec![0.0_f32; width * height];
        across.par_chunks_mut(width).enumerate().for_each(|(y, out)| {
            let row = self.row(y);
            let mut padded = Vec::with_capacity(width + 2 * radius);
            padded.resize(radius, row[0]);
            padded.extend_from_slice(row);
            padded.resize(width + 2 * radius, row[width - 1]);
            for (t, k) in kernel.iter().enumerate() {
                out.iter_mut().zip(&padded[t..t + width]).for_each(|(o, v)| *o += k * v);
            }
        });
        let mut down = vec![0.0_f32; width * height];
        down.par_chunks_mut(width).enumerate().for_each(|(y, out)| {
            for (t, k) in kernel.iter().enumerate() {
                let source = (y + t).saturating_sub(radius).min(height - 1);
                let row = &across[source * width..(source + 1) * width];
                out.iter_mut().zip(row).for_each(|(o, v)| *o += k * v);
            }
        });
        Gray::from_vec(width, height, down).unwrap_or_else(|| self.clone())
    }

    /// The image at half the size, 2x2 means: pixel `(x, y)` has its centre at
    /// `(2 x + 0.5, 2 y + 0.5)` of the full image. A last odd row or column is left out.
    pub fn halved(&self) -> Gray {
        Gray::from_fn(self.width() / 2, self.height() / 2, |x, y| {
            let (x, y) = (2 * x, 2 * y);
            (self.at(x, y) + self.at(x + 1, y) + self.at(x, y + 1) + self.at(x + 1, y + 1)) / 4.0
        })
    }
}

impl Rgb {
    /// The image at half the size; see [`Gray::halved`].
    pub fn halved(&self) -> Rgb {
        Rgb::from_fn(self.width() / 2, self.height() / 2, |x, y| {
            let (x, y) = (2 * x, 2 * y);
            let four = [self.at(x, y), self.at(x + 1, y), self.at(x, y + 1), self.at(x + 1, y + 1)];
            let sum = |c: usize| four.iter().map(|p| u16::from(p[c])).sum::<u16>();
            std::array::from_fn(|c| ((sum(c) + 2) / 4) as u8)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_becomes_a_gaussian_and_its_sum_stays() {
        let mut image = Gray::filled(41, 37, 0.0);
        image.set(20, 18, 100.0);
        let smooth = image.blurred(2.0);
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
        assert_eq!(Gray::filled(9, 5, 7.0).halved().size(), (4, 2));
    }
}
