//! Images of cells: distances, channels, smoothing.

use crate::data::distance::nearest_marked;
use crate::data::{Gray, Raster};

/// Smoothing of the colours and of the evidence, cells: averages the noise, moves no straight line.
const COLOUR_BLUR: f64 = 1.0;

/// Distance to the nearest marked cell, cells.
pub(super) fn distance_to(marked: &Raster<bool>) -> Gray {
    nearest_marked(marked).map(|d| d.0)
}

/// One channel of an image.
pub(super) fn channel(image: &Raster<[f32; 3]>, c: usize) -> Gray {
    image.map(|p| p[c])
}

/// The colours without the finest noise.
pub(super) fn smoothed(image: &Raster<[f32; 3]>) -> Raster<[f32; 3]> {
    let [r, g, b] = [0, 1, 2].map(|c| channel(image, c).blurred(COLOUR_BLUR));
    Raster::from_fn(image.width(), image.height(), |x, y| [r.at(x, y), g.at(x, y), b.at(x, y)])
}
