//! Thresholding: fixed (thesis section 2.2.2), Otsu's and local. White is 255, black 0.

use crate::data::Gray;

/// White where the value is larger than `level`.
pub(super) fn threshold_fixed(image: &Gray, level: f64) -> Gray {
    image.map(|v| if f64::from(v) > level { 255.0 } else { 0.0 })
}

/// The level that separates the histogram into two classes with the greatest variance between them
/// (Otsu 1979); the middle of equal ones.
pub(super) fn otsu_level(image: &Gray) -> f64 {
    let mut histogram = [0_u64; 256];
    for v in image.data() {
        histogram[v.round().clamp(0.0, 255.0) as usize] += 1;
    }
    let total: u64 = histogram.iter().sum();
    let sum: f64 = histogram.iter().enumerate().map(|(g, n)| g as f64 * *n as f64).sum();
    let (mut below, mut sum_below) = (0_u64, 0.0);
    let (mut best, mut first, mut last) = (-1.0, 0, 0);
    for (grey, count) in histogram.iter().enumerate() {
        below += count;
        sum_below += grey as f64 * *count as f64;
        let above = total - below;
        if below == 0 || above == 0 {
            continue;
        }
        let gap = sum_below / below as f64 - (sum - sum_below) / above as f64;
        let between = below as f64 * above as f64 * gap * gap;
        if between > best * (1.0 + 1e-12) {
            (best, first, last) = (between, grey, grey);
        } else if between >= best * (1.0 - 1e-12) {
            last = grey;
        }
    }
    (first + last) as f64 / 2.0 + 0.5
}

/// White where the value exceeds the mean of the `window_px` square around it by more than
/// `deviations` standard deviations of that square and by more than `contrast`. At the border only
/// the part of the square inside the photo counts.
pub(super) fn threshold_local(
    image: &Gray,
    window_px: usize,
    deviations: f64,
    contrast: f64,
) -> Gray {
    let (width, height) = image.size();
    let half = window_px / 2;
    let sums = Sums::new(image);
    Gray::from_fn(width, height, |x, y| {
        let (x0, y0) = (x.saturating_sub(half), y.saturating_sub(half));
        let (x1, y1) = ((x + half + 1).min(width), (y + half + 1).min(height));
        let count = ((x1 - x0) * (y1 - y0)) as f64;
        let (sum, squares) = sums.over(x0, y0, x1, y1);
        let mean = sum / count;
        let deviation = (squares / count - mean * mean).max(0.0).sqrt();
        let level = mean + (deviations * deviation).max(contrast);
        if f64::from(image.at(x, y)) > level { 255.0 } else { 0.0 }
    })
}

/// Summed-area tables of values and squares.
struct Sums {
    stride: usize,
    table: Vec<(f64, f64)>,
}

impl Sums {
    fn new(image: &Gray) -> Self {
        let (width, height) = image.size();
        let stride = width + 1;
        let mut table = vec![(0.0, 0.0); stride * (height + 1)];
        for y in 0..height {
            let mut row = (0.0, 0.0);
            for x in 0..width {
                let v = f64::from(image.at(x, y));
                row = (row.0 + v, row.1 + v * v);
                let above = table[y * stride + x + 1];
                table[(y + 1) * stride + x + 1] = (above.0 + row.0, above.1 + row.1);
            }
        }
        Self { stride, table }
    }

    /// Sums over the pixels `x0 <= x < x1`, `y0 <= y < y1`.
    fn over(&self, x0: usize, y0: usize, x1: usize, y1: usize) -> (f64, f64) {
        let at = |x: usize, y: usize| self.table[y * self.stride + x];
        let (a, b, c, d) = (at(x1, y1), at(x0, y1), at(x1, y0), at(x0, y0));
        (a.0 - b.0 - c.0 + d.0, a.1 - b.1 - c.1 + d.1)
    }
}
