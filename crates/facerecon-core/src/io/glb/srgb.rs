//! sRGB and linear light (IEC 61966-2-1): glTF has vertex colours in linear light.

/// Linear light, 0 to 1, of an sRGB value, 0 to 1.
pub(super) fn to_linear(v: f32) -> f32 {
    if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

/// 8-bit sRGB of linear light, which is clipped to 0 to 1.
pub(super) fn from_linear(v: f64) -> u8 {
    let v = v.clamp(0.0, 1.0);
    let v = if v <= 0.003_130_8 { v * 12.92 } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 };
    (v * 255.0).round() as u8
}
