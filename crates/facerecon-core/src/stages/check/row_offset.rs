//! Row offset between the dots of both photos, without knowing which dot matches which.

use crate::math::Vec2;

/// Bins of the histogram over one dot spacing.
const BINS: usize = 48;
/// Kernel that smooths the histogram, centred.
const KERNEL: [f64; 5] = [1.0, 2.0, 3.0, 2.0, 1.0];
/// Minimum height of the histogram's peak over its mean. Set by hand: scattered dots stay below it
/// (see the test), dots in rows exceed it.
const MIN_PEAK: f64 = 1.3;

/// Pixels that the dots of the right photo are lower than those of the left, between minus and plus
/// half a spacing: the peak of the histogram of row differences modulo the spacing. `None` when no
/// peak is distinct.
pub(super) fn offset(left: &[Vec2], right: &[Vec2], spacing_px: f64) -> Option<f64> {
    let histogram = smoothed(&row_differences(left, right, spacing_px));
    let (best, top) = histogram.iter().copied().enumerate().max_by(|a, b| a.1.total_cmp(&b.1))?;
    let mean = histogram.iter().sum::<f64>() / BINS as f64;
    if !(top > MIN_PEAK * mean) {
        return None;
    }
    // to a fraction of a bin, by the vertex of the parabola through the peak
    let at = |k: usize| histogram[k % BINS];
    let (before, after) = (at(best + BINS - 1), at(best + 1));
    let bend = before - 2.0 * top + after;
    let shift = if bend < 0.0 { (0.5 * (before - after) / bend).clamp(-0.5, 0.5) } else { 0.0 };
    Some(((best as f64 + 0.5 + shift) / BINS as f64 - 0.5) * spacing_px)
}

/// Histogram of the row differences of all pairs less than half a spacing apart in rows. A lattice
/// tilts and curves over the face, so only dots of about the same height are compared.
fn row_differences(left: &[Vec2], right: &[Vec2], spacing_px: f64) -> [f64; BINS] {
    let mut counts = [0.0_f64; BINS];
    let mut ys: Vec<f64> = right.iter().map(|d| d.y).collect();
    ys.sort_by(f64::total_cmp);
    for dot in left {
        let y = dot.y;
        let from = ys.partition_point(|v| *v < y - spacing_px / 2.0);
        for v in ys[from..].iter().take_while(|v| **v < y + spacing_px / 2.0) {
            let t = ((v - y) / spacing_px + 0.5) * BINS as f64;
            counts[(t as usize).min(BINS - 1)] += 1.0;
        }
    }
    counts
}

/// The histogram smoothed as a ring: a shift by one spacing gives the same rows.
fn smoothed(counts: &[f64; BINS]) -> Vec<f64> {
    let half = KERNEL.len() / 2;
    (0..BINS)
        .map(|i| {
            let terms = KERNEL.iter().enumerate();
            terms.map(|(k, weight)| counts[(i + BINS + k - half) % BINS] * weight).sum()
        })
        .collect()
}
