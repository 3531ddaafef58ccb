//! Least-squares matching of one window: affine disparity, gain and offset (Gruen 1985).

use nalgebra::{SMatrix, SVector};
use rayon::prelude::*;

use super::image::RowSpline;
use super::prior::Sample;
use crate::data::Gray;

/// What a window measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Measured {
    /// Disparity at the sample's position, pixels.
    pub(super) disparity: f64,
    /// Its standard deviation from the fit's covariance, pixels.
    pub(super) sigma_px: f64,
}

/// Matches a window of `half` pixels about every sample; `None` where the fit does not settle
/// within `reach` pixels of where it began.
pub(super) fn match_windows(
    left: &Gray,
    right: &RowSpline,
    samples: &[Sample],
    half: f64,
    reach: f64,
) -> Vec<Option<Measured>> {
    samples.par_iter().map(|s| match_window(left, right, s, half, reach)).collect()
}

fn match_window(
    left: &Gray,
    right: &RowSpline,
    sample: &Sample,
    half: f64,
    reach: f64,
) -> Option<Measured> {
    let (width, height) = left.size();
    let inside = sample.x - half >= 0.0
        && sample.y - half >= 0.0
        && sample.x + half <= width as f64 - 1.0
        && sample.y + half <= height as f64 - 1.0;
    if !inside {
        return None;
    }
    let columns = (sample.x - half).ceil() as usize..=(sample.x + half) as usize;
    let rows = (sample.y - half).ceil() as usize..=(sample.y + half) as usize;
    let spread = 2.0 * (0.6 * half).powi(2);
    // disparity and its slopes across and down; gain and offset of the right window
    let mut p = SVector::<f64, 5>::new(sample.disparity, 0.0, 0.0, 1.0, 0.0);
    for _ in 0..12 {
        let mut normal = SMatrix::<f64, 5, 5>::zeros();
        let mut drive = SVector::<f64, 5>::zeros();
        let (mut squares, mut weights, mut weights2) = (0.0, 0.0, 0.0);
        for y in rows.clone() {
            for x in columns.clone() {
                let (dx, dy) = (x as f64 - sample.x, y as f64 - sample.y);
                let d = p[0] + p[1] * dx + p[2] * dy;
                let (value, slope) = right.sample(x as f64 - d, y)?;
                let (value, slope) = (f64::from(value), f64::from(slope));
                let r = f64::from(left.at(x, y)) - (p[3] * value + p[4]);
                let j = -p[3] * slope;
                let row = SVector::<f64, 5>::new(j, j * dx, j * dy, value, 1.0);
                let w = (-(dx * dx + dy * dy) / spread).exp();
                normal += row * row.transpose() * w;
                drive += row * (w * r);
                squares += w * r * r;
                weights += w;
                weights2 += w * w;
            }
        }
        let inverse = normal.cholesky()?.inverse();
        let step = inverse * drive;
        p += SVector::<f64, 5>::new(
            step[0].clamp(-1.0, 1.0),
            step[1].clamp(-0.3, 0.3),
            step[2].clamp(-0.3, 0.3),
            step[3],
            step[4],
        );
        if (p[0] - sample.disparity).abs() > reach || !(0.2..5.0).contains(&p[3]) {
            return None;
        }
        if step[0].abs() < 1e-3 {
            // weights are no noise model here: the sandwich of a weighted mean, to first order
            let variance = squares / weights * inverse[(0, 0)] * weights2 / weights;
            return Some(Measured { disparity: p[0], sigma_px: variance.sqrt() });
        }
    }
    None
}
