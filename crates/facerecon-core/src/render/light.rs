//! Light and colour: sRGB coding, texture sampling, the studio's lamps.

use crate::data::{Raster, Rgb};
use crate::math::Vec3;

/// Linear light (0 to 1) of an sRGB value (IEC 61966-2-1).
pub fn linear_from_srgb(value: u8) -> f64 {
    let v = f64::from(value) / 255.0;
    if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

/// sRGB value, 0 to 255 and not rounded, of linear light; clipped to what can be shown.
pub fn srgb_from_linear(light: f64) -> f64 {
    let l = light.clamp(0.0, 1.0);
    255.0 * if l <= 0.003_130_8 { 12.92 * l } else { 1.055 * l.powf(1.0 / 2.4) - 0.055 }
}

/// A picture in linear light (0 to 1) as 8 bit sRGB, for use as a texture.
pub fn encode_srgb(linear: &Raster<[f32; 3]>) -> Rgb {
    linear.map(|p| p.map(|l| srgb_from_linear(f64::from(l)).round() as u8))
}

/// Table of [`linear_from_srgb`] for all 256 values.
pub(crate) fn linear_table() -> [f64; 256] {
    std::array::from_fn(|v| linear_from_srgb(v as u8))
}

pub(crate) fn to_rgb(light: &Vec3) -> [u8; 3] {
    [light.x, light.y, light.z].map(|l| srgb_from_linear(l).round() as u8)
}

pub(crate) fn from_rgb(color: [u8; 3], table: &[f64; 256]) -> Vec3 {
    Vec3::new(table[color[0] as usize], table[color[1] as usize], table[color[2] as usize])
}

/// Bilinear sample of a texture as sRGB values 0 to 255 (not rounded); `u` right, `v` up, (0, 0)
/// the lower left corner of the picture. Outside, the border goes on.
pub fn sample_texture(texture: &Rgb, uv: [f64; 2]) -> [f64; 3] {
    let (w, h) = texture.size();
    if w == 0 || h == 0 || !uv.iter().all(|c| c.is_finite()) {
        return [0.0; 3];
    }
    // texel centres at integers, the corner of the picture at -0.5
    let x = (uv[0] * w as f64 - 0.5).clamp(0.0, (w - 1) as f64);
    let y = ((1.0 - uv[1]) * h as f64 - 0.5).clamp(0.0, (h - 1) as f64);
    let (x0, y0) = (x as usize, y as usize);
    let (x1, y1) = ((x0 + 1).min(w - 1), (y0 + 1).min(h - 1));
    let (fx, fy) = (x - x0 as f64, y - y0 as f64);
    let (a, b) = (texture.at(x0, y0), texture.at(x1, y0));
    let (c, d) = (texture.at(x0, y1), texture.at(x1, y1));
    [0, 1, 2].map(|i| {
        let top = f64::from(a[i]) * (1.0 - fx) + f64::from(b[i]) * fx;
        let bottom = f64::from(c[i]) * (1.0 - fx) + f64::from(d[i]) * fx;
        top * (1.0 - fy) + bottom * fy
    })
}

/// Light that a matt surface sends back in the studio, of white albedo. `normal` is in the camera
/// frame (y down, z away) and faces the camera; `openness` is the unblocked part of the sky.
pub(crate) fn studio(normal: &Vec3, toward_camera: &Vec3, openness: f64) -> (f64, f64) {
    let lamp = |x: f64, y: f64, z: f64, wrap: f64| {
        let direction = Vec3::new(x, y, z) / (x * x + y * y + z * z).sqrt();
        (((normal.dot(&direction) + wrap) / (1.0 + wrap)).max(0.0), direction)
    };
    let (key, key_direction) = lamp(-0.55, -0.65, -0.75, 0.15);
    let (fill, _) = lamp(0.85, -0.05, -0.6, 0.3);
    let (rim, _) = lamp(0.7, -0.5, 0.55, 0.0);
    let sky = 0.5 - 0.5 * normal.y;
    let ambient = (0.13 + 0.17 * sky) * openness * openness;
    // large lamps are dimmed in hollows too, only less
    let open = 0.35 + 0.65 * openness;
    let matt = ambient + (0.62 * key + 0.13 * fill + 0.16 * rim) * open;
    let half = (key_direction + toward_camera).try_normalize(1e-12).unwrap_or_default();
    let gloss = 0.05 * normal.dot(&half).max(0.0).powi(24) * open;
    (matt, gloss)
}
