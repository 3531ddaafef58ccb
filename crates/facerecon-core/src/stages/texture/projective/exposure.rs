//! Equal exposure: gain and offset of each channel, in linear light, from what two photos share.

use rayon::prelude::*;

use super::blend::Weights;
use super::photo::{Photo, bilinear};
use super::texels::Texels;
use crate::data::Raster;
use crate::math::{mad, median};
use crate::render::srgb_from_linear;

/// Texels that two photos must share before one follows the other.
const LEAST_SHARED: usize = 300;

/// Brings all photos to the exposure of the first, or of one already brought to it.
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

/// Colours of both photos at texels that both see well.
fn shared(
    texels: &Texels<'_>,
    photos: &[Photo<'_>],
    weights: &Weights,
    pair: [usize; 2],
) -> Vec<[[f32; 3]; 2]> {
    let light = pair.map(|p| photos[p].looked_up(&photos[p].tones));
    let seen = |i: usize| pair.iter().all(|&p| weights.sharp[p].data()[i] > 0.05);
    (0..texels.size * texels.size)
        .into_par_iter()
        .filter(|i| i % 3 == 0 && seen(*i))
        .filter_map(|i| {
            let point = texels.position(i)?;
            let color = |k: usize| Some(bilinear(&light[k], photos[pair[k]].project(&point)?.0));
            Some([color(0)?, color(1)?])
        })
        .collect()
}

/// Gain and offset that bring the second photo to the first. By spread and middle, not by
/// regression: noise in either photo would flatten a regression's slope.
fn fit(shared: &[[[f32; 3]; 2]], channel: usize) -> (f32, f32) {
    let list =
        |side: usize| -> Vec<f64> { shared.iter().map(|s| f64::from(s[side][channel])).collect() };
    let (a, b) = (list(0), list(1));
    let (Some(ma), Some(mb), Some(sa), Some(sb)) = (median(&a), median(&b), mad(&a), mad(&b))
    else {
        return (1.0, 0.0);
    };
    if !(mb > 1e-4 && sb > 1e-4) {
        return (1.0, 0.0);
    }
    // the spread may suggest a third more or less contrast than the middle, but not another photo
    let by_middle = ma / mb;
    let gain = (sa / sb).clamp(by_middle / 1.3, by_middle * 1.3);
    (gain as f32, (ma - gain * mb) as f32)
}

/// A photo's sRGB values, 0 to 255, in its new exposure.
pub(super) fn encode(photo: &Photo<'_>) -> Raster<[f32; 3]> {
    photo.looked_up(&photo.tones.map(|t| t.map(|v| srgb_from_linear(f64::from(v)) as f32)))
}
