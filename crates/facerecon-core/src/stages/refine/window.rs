//! Least-squares matching of one window: affine disparity, gain and offset (Gruen 1985).

use nalgebra::{SMatrix, SVector};
use rayon::prelude::*;

use super::image::RowSpline;
use super::samples::Sample;
use crate::data::Gray;

/// Standard deviation of the window's Gaussian weights, as a share of its half width.
const WEIGHT_SIGMA: f64 = 0.6;
/// Most Gauss-Newton steps.
const MAX_STEPS: usize = 12;
/// Longest step of the disparity, as a share of the window's half width: the linearisation holds
/// for a fraction of a dot.
const MAX_STEP: f64 = 0.13;
/// Longest step of the disparity's slopes, pixels per pixel.
const MAX_SLOPE_STEP: f64 = 0.3;
/// Steps of the disparity shorter than this end the fit, pixels: a tenth of its noise or less.
const CONVERGED_PX: f64 = 1e-3;
/// Plausible gain of the left photo over the right; beyond this the window has no pattern.
const GAIN: std::ops::Range<f64> = 0.2..5.0;

/// Disparity measured by one window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct WindowFit {
    /// Disparity at the sample's position, pixels.
    pub(super) disparity: f64,
    /// Its standard deviation from the fit's covariance, pixels.
    pub(super) sigma_px: f64,
}

/// Matches a window of `half_width` pixels around every sample. `None` where the fit does not
/// converge within `max_shift` pixels of the sample's disparity.
pub(super) fn match_windows(
    left: &Gray,
    right: &RowSpline,
    samples: &[Sample],
    half_width: f64,
    max_shift: f64,
) -> Vec<Option<WindowFit>> {
    samples.par_iter().map(|s| match_window(left, right, s, half_width, max_shift)).collect()
}

fn match_window(
    left: &Gray,
    right: &RowSpline,
    sample: &Sample,
    half_width: f64,
    max_shift: f64,
) -> Option<WindowFit> {
    let (width, height) = left.size();
    let inside = sample.x - half_width >= 0.0
        && sample.y - half_width >= 0.0
        && sample.x + half_width <= width as f64 - 1.0
        && sample.y + half_width <= height as f64 - 1.0;
    if !inside {
        return None;
    }
    // disparity, its slopes across and down, gain and offset of the right window
    let mut p = SVector::<f64, 5>::new(sample.disparity, 0.0, 0.0, 1.0, 0.0);
    let max_step = MAX_STEP * half_width;
    for _ in 0..MAX_STEPS {
        let sums = Sums::new(left, right, sample, half_width, &p)?;
        let inverse = sums.normal.cholesky()?.inverse();
        let step = inverse * sums.right_side;
        p += SVector::<f64, 5>::new(
            step[0].clamp(-max_step, max_step),
            step[1].clamp(-MAX_SLOPE_STEP, MAX_SLOPE_STEP),
            step[2].clamp(-MAX_SLOPE_STEP, MAX_SLOPE_STEP),
            step[3],
            step[4],
        );
        if (p[0] - sample.disparity).abs() > max_shift || !GAIN.contains(&p[3]) {
            return None;
        }
        if step[0].abs() < CONVERGED_PX {
            // The weights are not inverse variances: to first order, the variance of a weighted
            // mean has the factor sum(w^2) / sum(w).
            let variance =
                sums.squares / sums.weights * inverse[(0, 0)] * sums.squared_weights / sums.weights;
            return Some(WindowFit { disparity: p[0], sigma_px: variance.sqrt() });
        }
    }
    None
}

/// The normal equations of one Gauss-Newton step.
struct Sums {
    normal: SMatrix<f64, 5, 5>,
    right_side: SVector<f64, 5>,
    /// Weighted sum of the squared residuals, grey levels squared.
    squares: f64,
    weights: f64,
    squared_weights: f64,
}

impl Sums {
    /// Sums over the window about the parameters `p`; `None` where it leaves the right photo.
    fn new(
        left: &Gray,
        right: &RowSpline,
        sample: &Sample,
        half_width: f64,
        p: &SVector<f64, 5>,
    ) -> Option<Self> {
        let columns = (sample.x - half_width).ceil() as usize..=(sample.x + half_width) as usize;
        let rows = (sample.y - half_width).ceil() as usize..=(sample.y + half_width) as usize;
        let spread = 2.0 * (WEIGHT_SIGMA * half_width).powi(2);
        let mut sums = Self {
            normal: SMatrix::zeros(),
            right_side: SVector::zeros(),
            squares: 0.0,
            weights: 0.0,
            squared_weights: 0.0,
        };
        for y in rows {
            for x in columns.clone() {
                let (dx, dy) = (x as f64 - sample.x, y as f64 - sample.y);
                let d = p[0] + p[1] * dx + p[2] * dy;
                let (value, slope) = right.sample(x as f64 - d, y)?;
                let (value, slope) = (f64::from(value), f64::from(slope));
                let r = f64::from(left.at(x, y)) - (p[3] * value + p[4]);
                let j = -p[3] * slope;
                let row = SVector::<f64, 5>::new(j, j * dx, j * dy, value, 1.0);
                let w = (-(dx * dx + dy * dy) / spread).exp();
                sums.normal += row * row.transpose() * w;
                sums.right_side += row * (w * r);
                sums.squares += w * r * r;
                sums.weights += w;
                sums.squared_weights += w * w;
            }
        }
        Some(sums)
    }
}
