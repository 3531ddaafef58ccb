//! A photo in octaves: itself and ever smoother copies.

use super::photo::Photo;
use crate::data::Raster;

/// Number of octaves: the last is smooth over about 8 pixels, within which seams of shading hide.
pub(super) const LEVELS: usize = 4;
/// Pixels nearer than this to a depth discontinuity do not enter the smooth copies, pixels.
const EDGE_MARGIN_PX: f32 = 1.0;
/// Smoothed weights below this are no colour.
const LEAST_WEIGHT: f32 = 1e-3;

/// The photo (sRGB values 0 to 255) and its smooth copies, finest first. They are blurred within
/// the head only, so that no background mixes in at the silhouette.
pub(super) struct Bands {
    pub levels: Vec<Raster<[f32; 3]>>,
}

impl Bands {
    pub fn new(photo: &Photo<'_>) -> Self {
        let base = photo.encoded();
        let (w, h) = base.size();
        let visibility = &photo.visibility;
        let inside = |x: usize, y: usize| {
            visibility.shows_mesh(x, y) && visibility.edge_px.at(x, y) > EDGE_MARGIN_PX
        };
        let mut current = Raster::par_from_fn(w, h, |x, y| {
            let c = base.at(x, y);
            if inside(x, y) { [c[0], c[1], c[2], 1.0] } else { [0.0; 4] }
        });
        let mut levels = vec![base];
        for level in 1..LEVELS {
            // each blur starts from the last one: sigma about 2, 4 and 8 px in all
            current = current.box_blurred(1 << level);
            let smooth = Raster::par_from_fn(w, h, |x, y| {
                let c = current.at(x, y);
                let known = c[3] > LEAST_WEIGHT;
                if known { [c[0] / c[3], c[1] / c[3], c[2] / c[3]] } else { levels[0].at(x, y) }
            });
            levels.push(smooth);
        }
        Self { levels }
    }
}
