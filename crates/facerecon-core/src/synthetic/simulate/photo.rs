//! From light to a photograph: sampling, lens blur, exposure, noise, coding.

use rayon::prelude::*;

use super::lamps::{Lamps, Light};
use super::noise::gaussian;
use super::{SimulateError, SimulateParams};
use crate::camera::Pinhole;
use crate::data::{Raster, Rgb};
use crate::math::{Similarity, percentile};
use crate::observer::Observer;
use crate::render::{NO_FACE, rasterize, srgb_from_linear, supersampled};

/// Samples a side of a pixel.
const SAMPLES: usize = 3;
/// Rows of the photo drawn at a time: bounds the memory at any resolution.
const STRIP: usize = 128;

/// The lens blur is cut off at this many standard deviations.
const BLUR_CUTOFF: f64 = 4.0;

/// A colour picture in linear light.
pub(super) type Linear = Raster<[f32; 3]>;

/// What one camera receives.
pub(super) struct Exposed {
    pub(super) pattern: Linear,
    pub(super) plain: Linear,
    /// Whether a pixel's middle shows the subject.
    pub(super) subject: Vec<bool>,
}

/// Collects the light of every pixel of a camera, then blurs it as the lens does.
pub(super) fn expose(
    lamps: &Lamps<'_>,
    camera: &Pinhole,
    camera_from_left: &Similarity,
    params: &SimulateParams,
    observer: &dyn Observer,
) -> Result<Exposed, SimulateError> {
    let (width, height) = (params.width_px, params.height_px);
    let eye = camera_from_left.inverse().translation;
    let mut light: Vec<(Light, bool)> = Vec::with_capacity(width * height);
    for top in (0..height).step_by(STRIP) {
        observer.check()?;
        let rows = STRIP.min(height - top);
        let strip = Pinhole { cy: camera.cy - top as f64, ..*camera };
        let size = (width * SAMPLES, rows * SAMPLES);
        let seen = rasterize(&lamps.mesh, &supersampled(&strip, SAMPLES), camera_from_left, size)?;
        let part: Vec<(Light, bool)> = (0..rows * width)
            .into_par_iter()
            .map(|i| {
                let (x, y) = (i % width * SAMPLES, i / width * SAMPLES);
                let mut sum = Light::default();
                for sample in 0..SAMPLES * SAMPLES {
                    let (sx, sy) = (x + sample % SAMPLES, y + sample / SAMPLES);
                    let face = seen.face.at(sx, sy);
                    if face == NO_FACE {
                        continue;
                    }
                    let one = lamps.light(face as usize, seen.barycentric.at(sx, sy), &eye);
                    for k in 0..3 {
                        sum.pattern[k] += one.pattern[k] / (SAMPLES * SAMPLES) as f32;
                        sum.plain[k] += one.plain[k] / (SAMPLES * SAMPLES) as f32;
                    }
                }
                let middle = seen.face.at(x + SAMPLES / 2, y + SAMPLES / 2);
                (sum, (middle as usize) < lamps.subject_faces)
            })
            .collect();
        light.extend(part);
    }
    let picture = |value: fn(&Light) -> [f32; 3]| {
        let raster = Raster::from_fn(width, height, |x, y| value(&light[y * width + x].0));
        raster.blurred_to(params.blur_px, BLUR_CUTOFF)
    };
    Ok(Exposed {
        pattern: picture(|l| l.pattern),
        plain: picture(|l| l.plain),
        subject: light.iter().map(|l| l.1).collect(),
    })
}

/// How much light makes white.
pub(super) struct Exposure {
    factor: f64,
}

impl Exposure {
    /// Puts the 95th percentile of the subject's brightest channel where it was asked for.
    pub(super) fn automatic(image: &Linear, subject: &[bool], params: &SimulateParams) -> Self {
        let brightest = |p: &[f32; 3]| f64::from(p[0].max(p[1]).max(p[2]));
        let light = image.data().iter().zip(subject);
        let light: Vec<f64> = light.filter(|(_, s)| **s).map(|(p, _)| brightest(p)).collect();
        let bright = percentile(&light, 0.95).unwrap_or(1.0).max(1e-9);
        Self { factor: params.exposure / bright }
    }

    /// Puts white paper that faces the lamp where it was asked for.
    pub(super) fn of_paper(params: &SimulateParams) -> Self {
        Self {
            factor: params.exposure_plain / (params.ambient_plain + params.soft_plain).max(1e-9),
        }
    }

    pub(super) fn times(&self, gain: f64) -> Self {
        Self { factor: self.factor * gain }
    }
}

/// Exposes, adds noise and codes as 8 bit sRGB. `number` tells the photos' noise apart.
pub(super) fn develop(
    image: &Linear,
    exposure: &Exposure,
    number: usize,
    params: &SimulateParams,
) -> Rgb {
    let (width, height) = image.size();
    // coded values between the entries of a table; fine enough to leave no trace after rounding
    let table: Vec<f64> = (0..=TABLE).map(|k| srgb_from_linear(k as f64 / TABLE as f64)).collect();
    let well = params.full_well_e;
    Rgb::par_from_fn(width, height, |x, y| {
        let (i, pixel) = (y * width + x, image.at(x, y));
        [0, 1, 2].map(|k| {
            let mut light = f64::from(pixel[k]) * exposure.factor;
            if well > 0.0 {
                let electrons = light * well;
                let deviation =
                    (electrons.max(0.0) + params.read_noise_e * params.read_noise_e).sqrt();
                let draw = gaussian(params.seed, number as u64, (3 * i + k) as u64);
                light = (electrons + deviation * draw) / well;
            }
            let position = light.clamp(0.0, 1.0) * TABLE as f64;
            let low = (position as usize).min(TABLE - 1);
            let value = table[low] + (table[low + 1] - table[low]) * (position - low as f64);
            value.round() as u8
        })
    })
}

const TABLE: usize = 8192;
