//! Resampling of a photo through a view.

use rayon::prelude::*;

use crate::camera::View;
use crate::data::{Gray, Rgb};
use crate::math::Vec2;

/// The photo resampled by a view, on a canvas of `size` (width, height), by cubic convolution (Catmull-Rom; Keys
/// 1981). Pixels outside the photo are 0. An identity view of the photo's size copies it.
pub fn warp(photo: &Gray, view: &View, size: (usize, usize)) -> Gray {
    if view.is_identity() && size == photo.size() {
        return photo.clone();
    }
    let (width, height) = size;
    let mut out = Gray::filled(width, height, 0.0);
    out.data_mut().par_chunks_mut(width.max(1)).enumerate().for_each(|(y, row)| {
        for (x, value) in row.iter_mut().enumerate() {
            let p = view.to_photo(Vec2::new(x as f64, y as f64));
            *value = cubic(photo, p).unwrap_or(0.0);
        }
    });
    out
}

/// [`warp`] of each colour channel, 8 bit.
pub fn warp_rgb(photo: &Rgb, view: &View, size: (usize, usize)) -> Rgb {
    let [r, g, b] = [0, 1, 2].map(|c| warp(&photo.map(|p| f32::from(p[c])), view, size).to_u8());
    Rgb::from_fn(size.0, size.1, |x, y| [r.at(x, y), g.at(x, y), b.at(x, y)])
}

/// Cubic sample, clipped to 0..255; `None` more than half a pixel beyond the border centres.
fn cubic(photo: &Gray, p: Vec2) -> Option<f32> {
    let (w, h) = (photo.width() as f64, photo.height() as f64);
    if !(p.x >= -0.5 && p.y >= -0.5 && p.x <= w - 0.5 && p.y <= h - 0.5) {
        return None;
    }
    let (x0, y0) = (p.x.floor(), p.y.floor());
    let (wx, wy) = (weights(p.x - x0), weights(p.y - y0));
    let (x0, y0) = (x0 as isize, y0 as isize);
    let mut sum = 0.0;
    for (j, b) in wy.iter().enumerate() {
        for (i, a) in wx.iter().enumerate() {
            let v = photo.clamped(x0 + i as isize - 1, y0 + j as isize - 1);
            sum += a * b * f64::from(v);
        }
    }
    Some(sum.clamp(0.0, 255.0) as f32)
}

/// Weights of the four pixels around a fraction `t` (Catmull-Rom).
fn weights(t: f64) -> [f64; 4] {
    [
        ((2.0 - t) * t - 1.0) * t / 2.0,
        ((3.0 * t - 5.0) * t * t + 2.0) / 2.0,
        ((4.0 - 3.0 * t) * t + 1.0) * t / 2.0,
        (t - 1.0) * t * t / 2.0,
    ]
}
