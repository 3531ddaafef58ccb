//! Histogram equalisation, of the whole photo or of tiles.

use crate::data::Gray;
use crate::data::sampling::{Cell, bilinear};

/// One bin for each 8 bit grey level.
const BINS: usize = 256;

fn bin(value: f32) -> usize {
    value.round().clamp(0.0, 255.0) as usize
}

/// Maps the grey levels so that equal numbers of pixels take equal parts of 0..255.
pub(super) fn equalize_global(image: &Gray) -> Gray {
    let mut histogram = [0.0; BINS];
    for v in image.data() {
        histogram[bin(*v)] += 1.0;
    }
    let map = mapping(&histogram);
    image.map(|v| map[bin(v)])
}

/// Contrast-limited adaptive equalisation (Zuiderveld 1994): `tiles` x `tiles` mappings, interpolated
/// bilinearly between tile centres. Bins are limited to `clip_limit` times the mean bin; the excess is
/// distributed over all bins.
pub(super) fn equalize_clahe(image: &Gray, tiles: usize, clip_limit: f64) -> Gray {
    let (width, height) = image.size();
    if width == 0 || height == 0 {
        return image.clone();
    }
    let (columns, rows) = (tiles.clamp(1, width), tiles.clamp(1, height));
    let maps: Vec<[f32; BINS]> = (0..rows * columns)
        .map(|tile| {
            let (column, row) = (tile % columns, tile / columns);
            let mut histogram = [0.0; BINS];
            let mut count = 0.0;
            for y in row * height / rows..(row + 1) * height / rows {
                for x in column * width / columns..(column + 1) * width / columns {
                    histogram[bin(image.at(x, y))] += 1.0;
                    count += 1.0;
                }
            }
            clip(&mut histogram, clip_limit * count / BINS as f64);
            mapping(&histogram)
        })
        .collect();
    // position of a pixel among the tile centres
    let among =
        |p: usize, size: usize, tiles: usize| (p as f64 + 0.5) * tiles as f64 / size as f64 - 0.5;
    Gray::from_fn(width, height, |x, y| {
        let (tx, ty) = (among(x, width, columns), among(y, height, rows));
        let cell = Cell::clamped(tx, ty, (columns, rows));
        let grey = bin(image.at(x, y));
        let corners = cell.corners(|column, row| maps[row * columns + column][grey]);
        bilinear(corners, cell.fraction.map(|f| f as f32))
    })
}

/// Limits the bins and distributes the excess.
fn clip(histogram: &mut [f64; BINS], limit: f64) {
    let excess: f64 = histogram.iter().map(|n| (n - limit).max(0.0)).sum();
    for n in histogram.iter_mut() {
        *n = n.min(limit) + excess / BINS as f64;
    }
}

/// The mapping of each grey level to the middle of its part of 0..255: a uniform photo becomes a
/// middle grey.
fn mapping(histogram: &[f64; BINS]) -> [f32; BINS] {
    let total: f64 = histogram.iter().sum::<f64>().max(1e-12);
    let mut below = 0.0;
    histogram.map(|n| {
        let fraction = (below + n / 2.0) / total;
        below += n;
        (255.0 * fraction) as f32
    })
}
