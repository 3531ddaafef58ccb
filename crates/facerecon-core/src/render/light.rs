//! Light and colour: sRGB coding, texture sampling, the studio lights.

use crate::data::sampling::{Cell, bilinear};
use crate::data::{Raster, Rgb};
use crate::math::Vec3;

/// Linear light (0 to 1) of an sRGB value (IEC 61966-2-1).
pub fn linear_from_srgb(value: u8) -> f64 {
    let v = f64::from(value) / 255.0;
    if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

/// sRGB value, 0 to 255 and not rounded, of linear light; clipped to 0..1.
pub fn srgb_from_linear(light: f64) -> f64 {
    let l = light.clamp(0.0, 1.0);
    255.0 * if l <= 0.003_130_8 { 12.92 * l } else { 1.055 * l.powf(1.0 / 2.4) - 0.055 }
}

/// An image in linear light (0 to 1) as 8 bit sRGB, for use as a texture.
pub fn encode_srgb(linear: &Raster<[f32; 3]>) -> Rgb {
    linear.map(|p| p.map(|l| srgb_from_linear(f64::from(l)).round() as u8))
}

/// Table of [`linear_from_srgb`] for all 256 values.
pub(crate) fn linear_table() -> [f64; 256] {
    std::array::from_fn(|v| linear_from_srgb(v as u8))
}

/// Linear light as 8 bit sRGB.
pub(super) fn to_rgb(light: &Vec3) -> [u8; 3] {
    [light.x, light.y, light.z].map(|l| srgb_from_linear(l).round() as u8)
}

/// Linear light of an 8 bit sRGB colour.
pub(super) fn from_rgb(color: [u8; 3], table: &[f64; 256]) -> Vec3 {
    Vec3::new(table[color[0] as usize], table[color[1] as usize], table[color[2] as usize])
}

/// Bilinear sample of a texture as sRGB values 0 to 255 (not rounded); `u` right, `v` up, (0, 0)
/// the lower left corner of the image. The border continues outward.
pub fn sample_texture(texture: &Rgb, uv: [f64; 2]) -> [f64; 3] {
    let (w, h) = texture.size();
    if w == 0 || h == 0 || !uv.iter().all(|c| c.is_finite()) {
        return [0.0; 3];
    }
    // texel centres at integers, the corner of the image at -0.5
    let (x, y) = (uv[0] * w as f64 - 0.5, (1.0 - uv[1]) * h as f64 - 0.5);
    let cell = Cell::clamped(x, y, (w, h));
    let corners = cell.corners(|x, y| texture.at(x, y));
    [0, 1, 2].map(|i| bilinear(corners.map(|c| f64::from(c[i])), cell.fraction))
}

/// A large directional light of the preview pictures.
struct StudioLight {
    /// Toward the light, camera frame (y down, z away from the camera); not normalised.
    toward: [f64; 3],
    /// How far its light reaches around the edge, as a cosine.
    wrap: f64,
    strength: f64,
}

// Three-point lighting; directions and strengths are chosen by eye.
const KEY: StudioLight = StudioLight { toward: [-0.55, -0.65, -0.75], wrap: 0.15, strength: 0.62 };
const FILL: StudioLight = StudioLight { toward: [0.85, -0.05, -0.6], wrap: 0.3, strength: 0.13 };
const RIM: StudioLight = StudioLight { toward: [0.7, -0.5, 0.55], wrap: 0.0, strength: 0.16 };
/// Light from below the horizon, and what the sky adds at the zenith.
const AMBIENT: f64 = 0.13;
const SKY: f64 = 0.17;
/// Fraction of the lights that reaches hollows: large lights are occluded less than the sky.
const OPEN_TO_LIGHTS: f64 = 0.35;
/// Strength and exponent of the highlight (Blinn 1977) of the key light.
const GLOSS: f64 = 0.05;
const GLOSS_EXPONENT: i32 = 24;

impl StudioLight {
    fn direction(&self) -> Vec3 {
        let [x, y, z] = self.toward;
        Vec3::new(x, y, z) / (x * x + y * y + z * z).sqrt()
    }

    /// Its light on a surface, 0 to 1.
    fn on(&self, normal: &Vec3) -> f64 {
        ((normal.dot(&self.direction()) + self.wrap) / (1.0 + self.wrap)).max(0.0)
    }
}

/// Diffuse light and highlight from a white surface in studio light. `normal` is in the camera frame
/// (y down, z away) and faces the camera; `openness` is the unoccluded fraction of the sky.
pub(super) fn studio(normal: &Vec3, toward_camera: &Vec3, openness: f64) -> (f64, f64) {
    let sky = 0.5 - 0.5 * normal.y;
    let ambient = (AMBIENT + SKY * sky) * openness * openness;
    let open = OPEN_TO_LIGHTS + (1.0 - OPEN_TO_LIGHTS) * openness;
    let lights = KEY.strength * KEY.on(normal)
        + FILL.strength * FILL.on(normal)
        + RIM.strength * RIM.on(normal);
    let half = (KEY.direction() + toward_camera).try_normalize(1e-12).unwrap_or_default();
    let gloss = GLOSS * normal.dot(&half).max(0.0).powi(GLOSS_EXPONENT) * open;
    (ambient + lights * open, gloss)
}
