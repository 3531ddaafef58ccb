//! How level the rows of both photos are, without knowing which dot is which.

use crate::math::Vec2;

/// Bins of a spacing.
const BINS: usize = 48;

/// Pixels that the right photo's dots lie lower than the left's, between minus and plus half a
/// spacing: the shift at which the photos' dots, looked at along rows in bands of the picture, fall
/// on each other best. `None` when no shift stands out.
pub(super) fn offset(left: &[Vec2], right: &[Vec2], spacing_px: f64) -> Option<f64> {
    // A lattice leans or curves over the face: only dots of about the same height are compared, and
    // of those how far each right dot is above or below each left one.
    let mut votes = [0.0_f64; BINS];
    let mut ys: Vec<f64> = right.iter().map(|d| d.y).collect();
    ys.sort_by(f64::total_cmp);
    for dot in left {
        let y = dot.y;
        let from = ys.partition_point(|v| *v < y - spacing_px / 2.0);
        for v in ys[from..].iter().take_while(|v| **v < y + spacing_px / 2.0) {
            let t = ((v - y) / spacing_px + 0.5) * BINS as f64;
            votes[(t as usize).min(BINS - 1)] += 1.0;
        }
    }
    // smooth around the ring, for a spacing later is the same again
    let smooth: Vec<f64> = (0..BINS)
        .map(|i| {
            (0..5).map(|k| votes[(i + BINS + k - 2) % BINS] * [1.0, 2.0, 3.0, 2.0, 1.0][k]).sum()
        })
        .collect();
    let (best, top) = smooth.iter().copied().enumerate().max_by(|a, b| a.1.total_cmp(&b.1))?;
    let mean = smooth.iter().sum::<f64>() / BINS as f64;
    if !(top > 1.3 * mean) {
        return None;
    }
    // to a fraction of a bin, by the parabola through the top
    let at = |k: usize| smooth[k % BINS];
    let (before, after) = (at(best + BINS - 1), at(best + 1));
    let bend = before - 2.0 * top + after;
    let shift = if bend < 0.0 { (0.5 * (before - after) / bend).clamp(-0.5, 0.5) } else { 0.0 };
    Some(((best as f64 + 0.5 + shift) / BINS as f64 - 0.5) * spacing_px)
}
