//! Convolution with the sharpening kernel of Eq. 2.1.

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
    let (width, height) = image.size();
    Ok(Gray::par_from_fn(width, height, |x, y| {
        let (x, y) = (x as isize, y as isize);
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
