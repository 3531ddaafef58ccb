//! A photo in octaves: itself and ever smoother copies.

use rayon::prelude::*;

use super::exposure::encode;
use super::photo::Photo;
use crate::data::Raster;

/// Number of octaves.
pub(super) const LEVELS: usize = 4;

/// The photo (sRGB values 0 to 255) and its smooth copies, blurred within the head only, so that
/// no background creeps in at the outline.
pub(super) struct Bands {
    pub levels: Vec<Raster<[f32; 3]>>,
}

impl Bands {
    pub fn new(photo: &Photo<'_>) -> Self {
        let base = encode(photo);
        let (w, h) = base.size();
        let inside =
            |x: usize, y: usize| photo.shows_head(x, y) && photo.sight.edge_px.at(x, y) > 1.0;
        let mut current = Raster::par_from_fn(w, h, |x, y| {
            let c = base.at(x, y);
            if inside(x, y) { [c[0], c[1], c[2], 1.0] } else { [0.0; 4] }
        });
        let mut levels = vec![base];
        for level in 1..LEVELS {
            // sigma 2, 4, 8 px in all: each blur adds what its predecessors lack
            let radius = 1 << level;
            current = blur(&current, radius);
            let smooth = Raster::par_from_fn(w, h, |x, y| {
                let c = current.at(x, y);
                let known = c[3] > 1e-3;
                if known { [c[0] / c[3], c[1] / c[3], c[2] / c[3]] } else { levels[0].at(x, y) }
            });
            levels.push(smooth);
        }
        Self { levels }
    }
}

/// Two box blurs in each direction, close to a Gaussian of sigma `radius * 0.82`.
pub(super) fn blur<const N: usize>(image: &Raster<[f32; N]>, radius: usize) -> Raster<[f32; N]> {
    let once = |image: &Raster<[f32; N]>| box_columns(&box_rows(image, radius), radius);
    once(&once(image))
}

fn box_rows<const N: usize>(image: &Raster<[f32; N]>, radius: usize) -> Raster<[f32; N]> {
    let (w, h) = image.size();
    let mut out = Raster::filled(w, h, [0.0f32; N]);
    let scale = 1.0 / (2 * radius + 1) as f64;
    out.data_mut().par_chunks_mut(w.max(1)).enumerate().for_each(|(y, out)| {
        let row = image.row(y);
        let at = |x: isize| row[x.clamp(0, w as isize - 1) as usize];
        // f64: a running sum in f32 drifts along the row
        let mut sum = [0.0f64; N];
        for x in -(radius as isize)..=radius as isize {
            let v = at(x);
            (0..N).for_each(|i| sum[i] += f64::from(v[i]));
        }
        for x in 0..w {
            out[x] = std::array::from_fn(|i| (sum[i] * scale) as f32);
            let (enter, leave) = (at((x + radius + 1) as isize), at(x as isize - radius as isize));
            (0..N).for_each(|i| sum[i] += f64::from(enter[i]) - f64::from(leave[i]));
        }
    });
    out
}

/// Down the columns, all columns of a row at once; each task sums up its own first window.
fn box_columns<const N: usize>(image: &Raster<[f32; N]>, radius: usize) -> Raster<[f32; N]> {
    let (w, h) = image.size();
    let mut out = Raster::filled(w, h, [0.0f32; N]);
    let scale = 1.0 / (2 * radius + 1) as f64;
    let band = (4 * radius).max(64);
    out.data_mut().par_chunks_mut(w.max(1) * band).enumerate().for_each(|(task, out)| {
        let row = |y: isize| image.row(y.clamp(0, h as isize - 1) as usize);
        let (first, reach) = ((task * band) as isize, radius as isize);
        let mut sums = vec![[0.0f64; N]; w];
        for y in first - reach..=first + reach {
            for (sum, v) in sums.iter_mut().zip(row(y)) {
                (0..N).for_each(|i| sum[i] += f64::from(v[i]));
            }
        }
        for (y, out) in (first..).zip(out.chunks_mut(w)) {
            let (enter, leave) = (row(y + reach + 1), row(y - reach));
            for (((out, sum), enter), leave) in out.iter_mut().zip(&mut sums).zip(enter).zip(leave)
            {
                *out = std::array::from_fn(|i| (sum[i] * scale) as f32);
                (0..N).for_each(|i| sum[i] += f64::from(enter[i]) - f64::from(leave[i]));
            }
        }
    });
    out
}
