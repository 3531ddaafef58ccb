//! The frontal picture of a face: height, colour and brightness on a grid of the head's frame.

use rayon::prelude::*;

use super::LandmarksInput;
use super::head_frame::HeadFrame;
use crate::data::sampling::{Cell, bilinear};
use crate::data::{Gray, Raster, Rgb};
use crate::math::{Vec2, Vec3};
use crate::render::linear_table;

/// Size of a pixel, mm: about that of a pixel of the photos on a face that fills them.
pub(super) const PIXEL_MM: f64 = 0.5;
/// The picture reaches so far to either side, above and below the tip of the nose, mm.
const HALF_WIDTH_MM: f64 = 85.0;
const HALF_HEIGHT_MM: f64 = 115.0;
/// Points in front of the tip or farther behind it do not belong to the face, mm.
const DEPTH_MM: (f64, f64) = (-110.0, 15.0);
/// Points whose normal has a smaller component toward the viewer of the picture are not seen in it.
const MIN_FACING: f64 = 0.05;
/// Of several layers the foremost counts, with what lies at most this far behind it, mm.
const LAYER_MM: f64 = 4.0;
/// The height is smoothed by these standard deviations, mm: the first where points are dense, the
/// next ones fill gaps and holes.
const SMOOTH_MM: [f64; 5] = [1.0, 2.0, 4.0, 10.0, 30.0];
/// Weight of smoothed points below which the next standard deviation is used.
const MIN_WEIGHT: f32 = 0.02;
/// Pixels whose weight at the second standard deviation is at least this are measured.
const MEASURED_WEIGHT: f32 = 0.03;
/// Smoothing of the colours, mm: noise of the photos, not the lids.
const COLOR_SMOOTH_MM: f64 = 0.75;
/// Added to the linear brightness (0 to 1) before ratios are taken: the darkest colours have no hue.
pub(super) const DARK: f64 = 0.004;
/// Fewest measured pixels of a picture, a square of 30 mm.
const MIN_MEASURED: usize = 3600;

/// Colours of the frontal picture.
pub(super) struct Colors {
    /// Logarithm of red over green: does not depend on the brightness of the light.
    pub redness: Gray,
    /// Logarithm of the brightness.
    pub brightness: Gray,
}

/// Height and colours; all pictures of one size.
pub(super) struct FrontalPicture {
    /// Height above the plane through the tip of the nose, mm; holes are filled smoothly.
    pub height: Gray,
    /// Whether the height is measured.
    pub measured: Raster<bool>,
    /// `None` without photos in colour.
    pub colors: Option<Colors>,
}

/// Pixel of a position of the head's frame, mm.
pub(super) fn pixel(x_mm: f64, y_mm: f64) -> Vec2 {
    Vec2::new((x_mm + HALF_WIDTH_MM) / PIXEL_MM, (HALF_HEIGHT_MM - y_mm) / PIXEL_MM)
}

/// Position in the head's frame of a pixel, mm.
pub(super) fn position(u: f64, v: f64) -> Vec2 {
    Vec2::new(u * PIXEL_MM - HALF_WIDTH_MM, HALF_HEIGHT_MM - v * PIXEL_MM)
}

fn size() -> (usize, usize) {
    let pixels = |half_mm: f64| (2.0 * half_mm / PIXEL_MM) as usize + 1;
    (pixels(HALF_WIDTH_MM), pixels(HALF_HEIGHT_MM))
}

impl FrontalPicture {
    /// Resamples the surface and the photos; `None` where hardly anything is measured.
    pub fn new(input: &LandmarksInput<'_>, frame: &HeadFrame) -> Option<Self> {
        let (height, measured) = resampled_height(input, frame);
        if measured.data().iter().filter(|m| **m).count() < MIN_MEASURED {
            return None;
        }
        let colors = input.plain.and_then(|photos| colors(photos, input, frame, &height));
        Some(Self { height, measured, colors })
    }

    /// The height at a position, mm.
    pub fn height_at(&self, x_mm: f64, y_mm: f64) -> f64 {
        let p = pixel(x_mm, y_mm);
        f64::from(self.height.clamped(p.x.round() as isize, p.y.round() as isize))
    }

    /// Whether the height at a position is measured.
    pub fn measured_at(&self, x_mm: f64, y_mm: f64) -> bool {
        let p = pixel(x_mm, y_mm);
        self.measured.get(p.x.round() as isize, p.y.round() as isize).unwrap_or(false)
    }
}

/// The foremost layer of the surface, smoothed, with holes filled; and where it is measured.
fn resampled_height(input: &LandmarksInput<'_>, frame: &HeadFrame) -> (Gray, Raster<bool>) {
    let (width, height) = size();
    let seen: Vec<(usize, f32)> = input
        .surface
        .points
        .iter()
        .zip(&input.surface.normals)
        .filter(|(_, n)| frame.turn(n).z > MIN_FACING)
        .map(|(p, _)| frame.place(p))
        .filter(|p| (DEPTH_MM.0..DEPTH_MM.1).contains(&p.z))
        .filter_map(|p| {
            let at = pixel(p.x, p.y);
            let (u, v) = (at.x.round(), at.y.round());
            let inside = u >= 0.0 && v >= 0.0 && u < width as f64 && v < height as f64;
            inside.then(|| (v as usize * width + u as usize, p.z as f32))
        })
        .collect();
    let mut front = vec![f32::NEG_INFINITY; width * height];
    for &(cell, z) in &seen {
        front[cell] = front[cell].max(z);
    }
    let front = widened(&front, width);
    let (mut sum, mut weight) =
        (Gray::filled(width, height, 0.0), Gray::filled(width, height, 0.0));
    for &(cell, z) in seen.iter().filter(|(cell, z)| *z > front[*cell] - LAYER_MM as f32) {
        sum.data_mut()[cell] += z;
        weight.data_mut()[cell] += 1.0;
    }
    let mut filled = Gray::filled(width, height, f32::NAN);
    let mut measured = Raster::filled(width, height, false);
    for (level, sigma_mm) in SMOOTH_MM.into_iter().enumerate() {
        let smooth = |image: &Gray| image.blurred(sigma_mm / PIXEL_MM);
        let (s, w) = (smooth(&sum), smooth(&weight));
        for i in 0..width * height {
            if level == 1 {
                measured.data_mut()[i] = w.data()[i] >= MEASURED_WEIGHT;
            }
            let enough = MIN_WEIGHT / (1u32 << (2 * level)) as f32;
            if filled.data()[i].is_nan() && w.data()[i] > enough {
                filled.data_mut()[i] = s.data()[i] / w.data()[i];
            }
        }
    }
    let deepest = DEPTH_MM.0 as f32;
    (filled.map(|z| if z.is_nan() { deepest } else { z }), measured)
}

/// The greatest value of each cell and its eight neighbours.
fn widened(values: &[f32], width: usize) -> Vec<f32> {
    let height = values.len() / width;
    let at = |x: usize, y: usize| {
        let mut greatest = f32::NEG_INFINITY;
        for v in y.saturating_sub(1)..(y + 2).min(height) {
            for u in x.saturating_sub(1)..(x + 2).min(width) {
                greatest = greatest.max(values[v * width + u]);
            }
        }
        greatest
    };
    (0..values.len()).into_par_iter().map(|i| at(i % width, i / width)).collect()
}

/// The colours of both photos, the one that sees the surface less obliquely counting more; `None`
/// where no photo has colour or the cameras are not known.
fn colors(
    photos: [&Rgb; 2],
    input: &LandmarksInput<'_>,
    frame: &HeadFrame,
    height: &Gray,
) -> Option<Colors> {
    let rig = input.rectification.rig.as_ref()?;
    let views = [&input.rectification.left, &input.rectification.right];
    let centres = rig.camera_centres().map(|c| frame.place(&c));
    let (width, rows) = height.size();
    let linear = linear_table();
    let sampled = Raster::par_from_fn(width, rows, |u, v| {
        let p = position(u as f64, v as f64);
        let z = |du: isize, dv: isize| f64::from(height.clamped(u as isize + du, v as isize + dv));
        let slope = |a: f64, b: f64| (b - a) / (4.0 * PIXEL_MM);
        let normal =
            Vec3::new(-slope(z(-2, 0), z(2, 0)), slope(z(0, -2), z(0, 2)), 1.0).normalize();
        let point = Vec3::new(p.x, p.y, z(0, 0));
        let mut sum = [0.0f64; 4];
        if let Some((left, right)) = rig.pixels(&frame.to_camera(&point)) {
            for (i, pixel) in [left, right].into_iter().enumerate() {
                let Some(rgb) = linear_sample(photos[i], &linear, views[i].to_photo(pixel)) else {
                    continue;
                };
                let facing = normal.dot(&(centres[i] - point).normalize()).max(0.05).powi(2);
                rgb.iter().zip(&mut sum).for_each(|(c, s)| *s += facing * c);
                sum[3] += facing;
            }
        }
        let weight = sum[3].max(1e-9);
        [sum[0] / weight, sum[1] / weight, sum[2] / weight].map(|c| c as f32)
    });
    let channel = |k: usize| sampled.map(|c| c[k]).blurred(COLOR_SMOOTH_MM / PIXEL_MM);
    let [red, green, blue] = [channel(0), channel(1), channel(2)];
    let dark = DARK as f32;
    let redness = red.zip_map(&green, |r, g| ((r + dark) / (g + dark)).ln());
    let bright = Gray::from_fn(width, rows, |u, v| {
        (0.3 * red.at(u, v) + 0.6 * green.at(u, v) + 0.1 * blue.at(u, v) + dark).ln()
    });
    Some(Colors { redness, brightness: bright })
}

/// Bilinear sample in linear light, 0 to 1; `None` outside the photo. `linear` is the light of each
/// value of a pixel.
pub(super) fn linear_sample(photo: &Rgb, linear: &[f64; 256], at: Vec2) -> Option<[f64; 3]> {
    let (width, height) = photo.size();
    let inside =
        at.x >= 0.0 && at.y >= 0.0 && at.x <= width as f64 - 1.0 && at.y <= height as f64 - 1.0;
    if !inside {
        return None;
    }
    let cell = Cell::clamped(at.x, at.y, (width, height));
    let corners = cell.corners(|x, y| photo.at(x, y).map(|value| linear[usize::from(value)]));
    Some([0, 1, 2].map(|k| bilinear(corners.map(|c| c[k]), cell.fraction)))
}
