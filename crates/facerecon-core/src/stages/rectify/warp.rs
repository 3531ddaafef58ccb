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
            *value = photo.bicubic(p.x, p.y).unwrap_or(0.0);
        }
    });
    out
}

/// [`warp`] of each colour channel, 8 bit.
pub fn warp_rgb(photo: &Rgb, view: &View, size: (usize, usize)) -> Rgb {
    let [r, g, b] = [0, 1, 2].map(|c| warp(&photo.map(|p| f32::from(p[c])), view, size).to_u8());
    Rgb::from_fn(size.0, size.1, |x, y| [r.at(x, y), g.at(x, y), b.at(x, y)])
}
