//! Convolutions: the sharpening kernel of Eq. 2.1 and the blur before it.

use rayon::prelude::*;

use super::FilterError;
use crate::data::Gray;

/// Convolves with an odd square kernel given row by row (Eq. 2.1 is the default of the stage). Border
/// pixels are repeated outward; the result is clipped to 0..255.
///
/// # Errors
/// [`FilterError::Kernel`] unless the kernel is an odd square, [`FilterError::KernelEntry`] unless
/// its entries are finite.
pub fn sharpen(image: &Gray, kernel: &[f64]) -> Result<Gray, FilterError> {
    let side = kernel.len().isqrt();
    if side * side != kernel.len() || side.is_multiple_of(2) {
        return Err(FilterError::Kernel { got: kernel.len() });
    }
    if let Some(got) = kernel.iter().find(|k| !k.is_finite()) {
        return Err(FilterError::KernelEntry { got: *got });
    }
    let half = (side / 2) as isize;
    Ok(by_rows(image, |x, y| {
        let mut sum = 0.0;
        for (row, line) in kernel.chunks_exact(side).enumerate() {
            for (column, weight) in line.iter().enumerate() {
                // a convolution rotates the kernel by 180 degrees against the picture
                let (dx, dy) = (half - column as isize, half - row as isize);
                // Eq. 2.1
                sum += weight * f64::from(image.clamped(x + dx, y + dy));
            }
        }
        sum.clamp(0.0, 255.0) as f32
    }))
}

/// Standard deviations below this, pixels, leave the photo as it is.
const MIN_SIGMA_PX: f64 = 1e-3;
/// The Gaussian is cut off at this many standard deviations.
const CUT_OFF: f64 = 3.0;

/// Gaussian blur in double precision with border pixels repeated outward; a deviation of 0 copies.
pub(super) fn blur(image: &Gray, sigma_px: f64) -> Gray {
    if !(sigma_px > MIN_SIGMA_PX) || image.data().is_empty() {
        return image.clone();
    }
    let reach = (CUT_OFF * sigma_px).ceil() as isize;
    let weights: Vec<f64> =
        (-reach..=reach).map(|d| (-0.5 * (d as f64 / sigma_px).powi(2)).exp()).collect();
    let total: f64 = weights.iter().sum();
    let pass = |image: &Gray, along_x: bool| {
        by_rows(image, |x, y| {
            let sum: f64 = (-reach..=reach)
                .zip(&weights)
                .map(|(d, weight)| {
                    let (dx, dy) = if along_x { (d, 0) } else { (0, d) };
                    weight * f64::from(image.clamped(x + dx, y + dy))
                })
                .sum();
            (sum / total) as f32
        })
    };
    pass(&pass(image, true), false)
}

/// Computes every pixel from its coordinates, rows in parallel.
fn by_rows(image: &Gray, pixel: impl Fn(isize, isize) -> f32 + Sync) -> Gray {
    let (width, height) = image.size();
    let mut out = Gray::filled(width, height, 0.0);
    out.data_mut().par_chunks_mut(width.max(1)).enumerate().for_each(|(y, row)| {
        for (x, value) in row.iter_mut().enumerate() {
            *value = pixel(x as isize, y as isize);
        }
    });
    out
}
