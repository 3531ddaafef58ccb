//! The working photos: the given ones, reduced where they are much finer than the pattern.

use super::samples::Sample;
use super::spline::Spline;
use crate::data::{Gray, Raster};

/// Pitch of the pattern that the working photos keep at least, pixels. The dots limit the detail,
/// not the pixels.
const WORKING_PITCH_PX: f64 = 8.0;
/// Largest reduction.
const MAX_FACTOR: usize = 8;

/// Means of `bin` x `bin` blocks; pixels that are not finite count as black.
pub(super) fn binned(image: &Gray, bin: usize) -> Gray {
    let finite = image.map(|v| if v.is_finite() { v.clamp(0.0, 255.0) } else { 0.0 });
    finite.block_means(bin.max(1))
}

/// Coordinates of the given and of the working photos.
#[derive(Clone, Copy, Debug)]
pub(super) struct Binning {
    /// Given pixels per working pixel.
    factor: f64,
}

impl Binning {
    /// The reduction for a pattern of this pitch in given pixels.
    pub(super) fn for_pitch(pitch_px: f64) -> Self {
        let factor = ((pitch_px / WORKING_PITCH_PX) as usize).clamp(1, MAX_FACTOR);
        Self { factor: factor as f64 }
    }

    /// Given pixels per working pixel.
    pub(super) fn factor(self) -> f64 {
        self.factor
    }

    /// The working photo of a given one.
    pub(super) fn reduce(self, image: &Gray) -> Gray {
        binned(image, self.factor as usize)
    }

    /// A coordinate in working pixels.
    fn to_working(self, v: f64) -> f64 {
        (v - 0.5 * (self.factor - 1.0)) / self.factor
    }

    /// A sample in working pixels.
    pub(super) fn working_sample(self, s: &Sample) -> Sample {
        Sample {
            x: self.to_working(s.x),
            y: self.to_working(s.y),
            disparity: s.disparity / self.factor,
        }
    }

    /// Standard deviation, given pixels, at the working pixel nearest to a given position; NaN
    /// outside.
    pub(super) fn sigma_at(self, working_sigma: &Gray, x: f64, y: f64) -> f32 {
        working_sigma
            .get(self.to_working(x).round() as isize, self.to_working(y).round() as isize)
            .map_or(f32::NAN, |s| s * self.factor as f32)
    }

    /// Disparity and standard deviation at the pixels of the given photos.
    pub(super) fn enlarge(
        self,
        spline: &Spline,
        working_sigma: &Gray,
        size: (usize, usize),
    ) -> (Gray, Gray) {
        let sigma = Raster::from_fn(size.0, size.1, |x, y| {
            self.sigma_at(working_sigma, x as f64, y as f64)
        });
        let measured = sigma.map(|s| s.is_finite());
        let enlarged = Spline {
            origin: spline.origin.map(|o| self.factor * o + 0.5 * (self.factor - 1.0)),
            cell: self.factor * spline.cell,
            columns: spline.columns,
            rows: spline.rows,
            control: spline.control.iter().map(|d| self.factor * d).collect(),
        };
        (enlarged.sampled(&measured).0.map(|d| d as f32), sigma)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_averaged_and_coordinates_agree() {
        let small = binned(&Gray::from_fn(5, 4, |x, _| x as f32), 2);
        assert_eq!((small.size(), small.at(1, 1)), ((2, 2), 2.5));
        // the centre of the second block lies between pixels 2 and 3
        let binning = Binning { factor: 2.0 };
        let s = binning.working_sample(&Sample { x: 2.5, y: 0.5, disparity: 3.0 });
        assert_eq!((s.x, s.y, s.disparity), (1.0, 0.0, 1.5));
    }

    #[test]
    fn an_enlarged_surface_keeps_its_shape() {
        let domain = Raster::filled(20, 20, true);
        let mut spline = Spline::over(&domain, 4.0).unwrap();
        for k in 0..spline.control.len() {
            spline.control[k] = 3.0 + 0.1 * spline.node(k % spline.columns, 0)[0];
        }
        let binning = Binning { factor: 3.0 };
        let sigma = Gray::filled(20, 20, 0.1);
        let (disparity, sigma) = binning.enlarge(&spline, &sigma, (60, 60));
        // disparity 3 * (3 + 0.1 * (x - 1) / 3)
        assert!((disparity.at(31, 40) - 12.0).abs() < 1e-5);
        assert!((sigma.at(31, 40) - 0.3).abs() < 1e-6);
    }
}
