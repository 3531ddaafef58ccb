//! From reflected light to a photograph: sampling, lens blur, exposure, noise, coding.

use rayon::prelude::*;

use super::error::SimulateError;
use super::lit_scene::{LitScene, Reflected};
use super::params::SimulateParams;
use super::viewpoint::Viewpoint;
use crate::camera::Pinhole;
use crate::data::{Raster, Rgb};
use crate::math::percentile;
use crate::observer::Observer;
use crate::render::{NO_FACE, srgb_from_linear, supersampled};
use crate::synthetic::random::gaussian;

/// Samples per pixel in each direction.
const SAMPLES: usize = 3;
/// Rows of the photo that are rendered at a time: bounds the memory.
const STRIP: usize = 128;

/// Entries of the table of sRGB codes; linear interpolation between them is exact to 8 bit.
const TABLE: usize = 8192;
/// Percentile of the brightness of the subject that the automatic exposure sets.
const EXPOSED_PERCENTILE: f64 = 0.95;

/// The lens blur is cut off at this many standard deviations.
const BLUR_CUTOFF: f64 = 4.0;

/// A colour image in linear light.
type Linear = Raster<[f32; 3]>;

/// The light that one camera receives, with and without the pattern.
pub(super) struct Received {
    pub(super) dotted: Linear,
    pub(super) plain: Linear,
    /// Whether the centre of each pixel shows the subject.
    pub(super) subject: Vec<bool>,
}

/// The light at every pixel of a camera, blurred by the lens.
pub(super) fn receive(
    scene: &LitScene<'_>,
    viewpoint: &Viewpoint,
    params: &SimulateParams,
    observer: &dyn Observer,
) -> Result<Received, SimulateError> {
    let (width, height) = (params.width_px, params.height_px);
    let camera = viewpoint.camera;
    let eye = viewpoint.camera_from_left.inverse().translation;
    let mut light: Vec<(Reflected, bool)> = Vec::with_capacity(width * height);
    for top in (0..height).step_by(STRIP) {
        observer.check()?;
        let rows = STRIP.min(height - top);
        let strip = Pinhole { cy: camera.cy - top as f64, ..camera };
        let strip = Viewpoint { camera: supersampled(&strip, SAMPLES), ..*viewpoint };
        let size = (width * SAMPLES, rows * SAMPLES);
        let seen = strip.rasterize(&scene.mesh, size)?;
        let part: Vec<(Reflected, bool)> = (0..rows * width)
            .into_par_iter()
            .map(|i| {
                let (x, y) = (i % width * SAMPLES, i / width * SAMPLES);
                let mut sum = Reflected::default();
                for sample in 0..SAMPLES * SAMPLES {
                    let (sx, sy) = (x + sample % SAMPLES, y + sample / SAMPLES);
                    let face = seen.face.at(sx, sy);
                    if face == NO_FACE {
                        continue;
                    }
                    let one = scene.reflected(face as usize, seen.barycentric.at(sx, sy), &eye);
                    for k in 0..3 {
                        sum.dotted[k] += one.dotted[k] / (SAMPLES * SAMPLES) as f32;
                        sum.plain[k] += one.plain[k] / (SAMPLES * SAMPLES) as f32;
                    }
                }
                let middle = seen.face.at(x + SAMPLES / 2, y + SAMPLES / 2);
                (sum, (middle as usize) < scene.subject_faces)
            })
            .collect();
        light.extend(part);
    }
    let image = |value: fn(&Reflected) -> [f32; 3]| {
        let raster = Raster::from_fn(width, height, |x, y| value(&light[y * width + x].0));
        raster.blurred_to(params.blur_px, BLUR_CUTOFF)
    };
    Ok(Received {
        dotted: image(|l| l.dotted),
        plain: image(|l| l.plain),
        subject: light.iter().map(|l| l.1).collect(),
    })
}

/// The factor from light to the fraction of white.
pub(super) struct Exposure {
    factor: f64,
}

impl Exposure {
    /// Sets the 95th percentile of the brightest channel of the subject to `exposure`.
    pub(super) fn automatic(image: &Linear, subject: &[bool], params: &SimulateParams) -> Self {
        let brightest = |p: &[f32; 3]| f64::from(p[0].max(p[1]).max(p[2]));
        let light = image.data().iter().zip(subject);
        let light: Vec<f64> = light.filter(|(_, s)| **s).map(|(p, _)| brightest(p)).collect();
        let bright = percentile(&light, EXPOSED_PERCENTILE).unwrap_or(1.0).max(1e-9);
        Self { factor: params.exposure / bright }
    }

    /// Sets white paper that faces the large light to `exposure_plain`.
    pub(super) fn of_paper(params: &SimulateParams) -> Self {
        Self {
            factor: params.exposure_plain / (params.ambient_plain + params.soft_plain).max(1e-9),
        }
    }

    /// The exposure of a camera with this relative sensitivity.
    pub(super) fn times(&self, gain: f64) -> Self {
        Self { factor: self.factor * gain }
    }
}

/// Exposes, adds noise and codes as 8 bit sRGB. Each photo has its own stream of noise.
pub(super) fn develop(
    image: &Linear,
    exposure: &Exposure,
    noise_stream: usize,
    params: &SimulateParams,
) -> Rgb {
    let (width, height) = image.size();
    let table: Vec<f64> = (0..=TABLE).map(|k| srgb_from_linear(k as f64 / TABLE as f64)).collect();
    let well = params.full_well_e;
    Raster::par_from_fn(width, height, |x, y| {
        let (i, pixel) = (y * width + x, image.at(x, y));
        [0, 1, 2].map(|k| {
            let mut light = f64::from(pixel[k]) * exposure.factor;
            if well > 0.0 {
                let electrons = light * well;
                let deviation =
                    (electrons.max(0.0) + params.read_noise_e * params.read_noise_e).sqrt();
                let draw = gaussian(params.seed, noise_stream as u64, (3 * i + k) as u64);
                light = (electrons + deviation * draw) / well;
            }
            let position = light.clamp(0.0, 1.0) * TABLE as f64;
            let low = (position as usize).min(TABLE - 1);
            let value = table[low] + (table[low + 1] - table[low]) * (position - low as f64);
            value.round() as u8
        })
    })
}
