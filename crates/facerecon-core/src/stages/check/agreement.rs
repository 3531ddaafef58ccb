//! How far two photos show the same.

use crate::data::{Dot, Gray};
use crate::math::{median, percentile};

/// Variance of the difference of two photos relative to the sum of their variances, below which
/// they are one picture; at least 0.16 for photos of two cameras.
const SAME_DIFFERENCE: f64 = 0.02;
/// Variance of the grey levels below which a photo is blank and cannot be compared.
const BLANK_VARIANCE: f64 = 1.0;
/// Photos are reduced until a dot spacing has about this many pixels: enough for structures beyond
/// the dots, whatever the resolution.
const PIXELS_PER_SPACING: f64 = 3.0;
/// Added to the grey levels before the logarithm: noise in dark parts does not count.
const DARK_LEVEL: f32 = 4.0;
/// Parts of the dotted photo that are brighter than this fraction of its lit parts are compared.
const LIT_FRACTION: f64 = 0.3;
/// Percentile of the grey levels that stands for the lit parts.
const LIT_PERCENTILE: f64 = 0.95;
/// Least pixels compared; fewer say nothing.
const LEAST_PIXELS: usize = 100;
/// Least root mean square of the gradients, per pixel of the logarithm: less is a blank photo.
const LEAST_GRADIENT: f64 = 1e-3;
/// Dots whose heights are compared; more give the same median.
const SAMPLES: usize = 2000;

/// Whether two photos are the same picture; blank photos are not compared.
pub(super) fn same_picture(left: &Gray, right: &Gray) -> bool {
    if left.size() != right.size() || left.data().is_empty() {
        return false;
    }
    let variance = |value: &dyn Fn(usize) -> f64| {
        let count = left.data().len() as f64;
        let mean = (0..left.data().len()).map(value).sum::<f64>() / count;
        (0..left.data().len()).map(|i| (value(i) - mean).powi(2)).sum::<f64>() / count
    };
    let (a, b) = (left.data(), right.data());
    let own = variance(&|i| f64::from(a[i])) + variance(&|i| f64::from(b[i]));
    own > BLANK_VARIANCE && variance(&|i| f64::from(a[i]) - f64::from(b[i])) < SAME_DIFFERENCE * own
}

/// Correlation of the brightness gradients of a dotted and a plain photo, -1 to 1, where the dotted
/// photo is lit and beyond the size of the dots. Edges of eyes, lips, hair and head remain where they
/// are, whatever the light. `None` where the photos are blank or of different sizes.
pub(super) fn agreement(dotted: &Gray, plain: &Gray, spacing_px: f64) -> Option<f64> {
    if dotted.size() != plain.size() || !(spacing_px >= 1.0) {
        return None;
    }
    let factor = ((spacing_px / PIXELS_PER_SPACING).round() as usize).max(1);
    let sigma = spacing_px / factor as f64;
    let reduced = |image: &Gray| image.block_means(factor).blurred(sigma);
    let (a, b) = (reduced(dotted), reduced(plain));
    let levels: Vec<f64> = a.data().iter().map(|v| f64::from(*v)).collect();
    let lit = (LIT_FRACTION * percentile(&levels, LIT_PERCENTILE)?) as f32;
    let (mut both, mut first, mut second, mut count) = (0.0, 0.0, 0.0, 0);
    for y in 1..a.height().saturating_sub(1) {
        for x in 1..a.width().saturating_sub(1) {
            if a.at(x, y) <= lit {
                continue;
            }
            let slope = |image: &Gray| {
                let log = |x, y| f64::from((image.at(x, y) + DARK_LEVEL).max(DARK_LEVEL).ln());
                [log(x + 1, y) - log(x - 1, y), log(x, y + 1) - log(x, y - 1)]
            };
            let (p, q) = (slope(&a), slope(&b));
            both += p[0] * q[0] + p[1] * q[1];
            first += p[0] * p[0] + p[1] * p[1];
            second += q[0] * q[0] + q[1] * q[1];
            count += 1;
        }
    }
    let least = LEAST_GRADIENT.powi(2) * count as f64;
    (count >= LEAST_PIXELS && first > least && second > least)
        .then(|| both / (first * second).sqrt())
}

/// Median height of the dots in the plain photo relative to that in the dotted photo, over the
/// brighter half of the dots; `[dotted, plain]`. `None` without such dots.
pub(super) fn pattern_remains(photos: [&Gray; 2], dots: &[Dot], spacing_px: f64) -> Option<f64> {
    if photos[0].size() != photos[1].size() {
        return None;
    }
    let step = dots.len().div_ceil(SAMPLES).max(1);
    let heights = |image: &Gray| -> Vec<f64> {
        dots.iter().step_by(step).map(|dot| height(image, dot, spacing_px)).collect()
    };
    let (dotted, plain) = (heights(photos[0]), heights(photos[1]));
    let middle = median(&dotted)?;
    let bright = |all: &[f64]| -> Vec<f64> {
        all.iter().zip(&dotted).filter(|(_, h)| **h >= middle).map(|(v, _)| *v).collect()
    };
    let (own, other) = (median(&bright(&dotted))?, median(&bright(&plain))?);
    (own > 0.0).then(|| other / own)
}

/// Mean grey level of the pixels at a dot over the median of those half a spacing away.
fn height(image: &Gray, dot: &Dot, spacing_px: f64) -> f64 {
    let radius = (spacing_px / 2.0).round().max(2.0);
    let reach = radius as isize;
    let (cx, cy) = (dot.position.x.round() as isize, dot.position.y.round() as isize);
    let (mut ring, mut middle) = (Vec::new(), 0.0);
    for dy in -reach..=reach {
        for dx in -reach..=reach {
            let value = f64::from(image.clamped(cx + dx, cy + dy));
            let distance = (dx as f64).hypot(dy as f64);
            if (distance - radius).abs() < 0.6 {
                ring.push(value);
            }
            if dx.abs() <= 1 && dy.abs() <= 1 {
                middle += value / 9.0;
            }
        }
    }
    middle - median(&ring).unwrap_or(middle)
}
