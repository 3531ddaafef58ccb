//! Equal exposure: gain and offset of each channel, in linear light, from texels that two photos
//! share.

use rayon::prelude::*;

use super::photo::Photo;
use super::texels::Texels;
use super::weights::Weights;
use crate::math::{mad, median};

/// Texels that two photos must share before one is matched to the other; fewer leave median and
/// spread uncertain.
const LEAST_SHARED: usize = 300;
/// One texel in this many is compared.
const STRIDE: usize = 3;
/// Weight from which a photo sees a texel well enough.
const LEAST_WEIGHT: f32 = 0.05;
/// Medians and spreads (linear light, 0 to 1) below this are black: there is nothing to match.
const BLACK: f64 = 1e-4;
/// Largest ratio of the gain by spread to the gain by median: exposure changes both alike, and a
/// greater difference comes from shading.
const MAX_CONTRAST: f64 = 1.3;

/// Matches all photos to the exposure of the first, or of one already matched.
pub(super) fn equalise(texels: &Texels<'_>, photos: &mut [Photo<'_>], weights: &Weights) {
    for p in 1..photos.len() {
        for reference in 0..p {
            let shared = shared(texels, photos, weights, [reference, p]);
            if shared.len() >= LEAST_SHARED {
                photos[p].tones.par_iter_mut().enumerate().for_each(|(channel, tones)| {
                    let (gain, offset) = fit(&shared, channel);
                    tones.iter_mut().for_each(|v| *v = (*v * gain + offset).max(0.0));
                });
                break;
            }
        }
    }
}

/// Colours (linear light) of both photos at texels that both see well.
fn shared(
    texels: &Texels<'_>,
    photos: &[Photo<'_>],
    weights: &Weights,
    pair: [usize; 2],
) -> Vec<[[f32; 3]; 2]> {
    let light = pair.map(|p| photos[p].linear());
    let visible = |i: usize| pair.iter().all(|&p| weights.direct[p].data()[i] > LEAST_WEIGHT);
    (0..texels.size * texels.size)
        .into_par_iter()
        .filter(|i| i % STRIDE == 0 && visible(*i))
        .filter_map(|i| {
            let point = texels.position(i)?;
            let color = |k: usize| {
                let (pixel, _) = photos[pair[k]].camera.project(&point)?;
                Some(light[k].bilinear_clamped(pixel.x, pixel.y))
            };
            Some([color(0)?, color(1)?])
        })
        .collect()
}

/// Gain and offset that match the second photo to the first. From spread and median, not by
/// regression: noise in either photo would flatten a regression's slope.
fn fit(shared: &[[[f32; 3]; 2]], channel: usize) -> (f32, f32) {
    let list =
        |side: usize| -> Vec<f64> { shared.iter().map(|s| f64::from(s[side][channel])).collect() };
    let (a, b) = (list(0), list(1));
    let (Some(ma), Some(mb), Some(sa), Some(sb)) = (median(&a), median(&b), mad(&a), mad(&b))
    else {
        return (1.0, 0.0);
    };
    if !(mb > BLACK && sb > BLACK) {
        return (1.0, 0.0);
    }
    let by_median = ma / mb;
    let gain = (sa / sb).clamp(by_median / MAX_CONTRAST, by_median * MAX_CONTRAST);
    (gain as f32, (ma - gain * mb) as f32)
}
