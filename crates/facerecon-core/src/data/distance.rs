//! The nearest marked pixel of every pixel: exact Euclidean distances in linear time (Felzenszwalb
//! and Huttenlocher 2012).

use rayon::prelude::*;

use super::Raster;

/// No marked pixel.
pub(crate) const NONE: u32 = u32::MAX;

/// For each pixel the distance to the nearest marked one, pixels, and its number (row-major); of
/// equal distances the one found first in a fixed order. Without marked pixels the distance is
/// infinite and the number [`NONE`].
pub(crate) fn nearest_marked(marked: &Raster<bool>) -> Raster<(f32, u32)> {
    let (width, height) = marked.size();
    // the nearest marked row in each column, from above and from below
    let mut rows = vec![NONE; width * height];
    for x in 0..width {
        let mut last = NONE;
        for y in 0..height {
            if marked.at(x, y) {
                last = y as u32;
            }
            rows[y * width + x] = last;
        }
        last = NONE;
        for y in (0..height).rev() {
            if marked.at(x, y) {
                last = y as u32;
            }
            let above = rows[y * width + x];
            let is_nearer = above == NONE || (y as u32).abs_diff(above) > last.abs_diff(y as u32);
            if last != NONE && is_nearer {
                rows[y * width + x] = last;
            }
        }
    }
    let found: Vec<Vec<(f32, u32)>> = (0..height)
        .into_par_iter()
        .map(|y| nearest_in_row(y, &rows[y * width..(y + 1) * width]))
        .collect();
    Raster::from_fn(width, height, |x, y| found[y][x])
}

/// The lower envelope of the parabolas `(x - column)^2 + (y - row)^2` along one row.
fn nearest_in_row(y: usize, rows: &[u32]) -> Vec<(f32, u32)> {
    let width = rows.len();
    let square = |v: f64| v * v;
    let height = |column: usize| square(f64::from(rows[column]) - y as f64);
    let mut columns: Vec<usize> = Vec::new();
    let mut starts: Vec<f64> = Vec::new();
    for column in (0..width).filter(|&c| rows[c] != NONE) {
        let mut start = f64::NEG_INFINITY;
        while let (Some(&last), Some(&last_start)) = (columns.last(), starts.last()) {
            let difference =
                height(column) + square(column as f64) - height(last) - square(last as f64);
            start = difference / (2.0 * (column - last) as f64);
            if start > last_start {
                break;
            }
            columns.pop();
            starts.pop();
            start = f64::NEG_INFINITY;
        }
        columns.push(column);
        starts.push(start);
    }
    let mut at = 0;
    let one = |x: usize| {
        while at + 1 < columns.len() && starts[at + 1] < x as f64 {
            at += 1;
        }
        let Some(&column) = columns.get(at) else { return (f32::INFINITY, NONE) };
        let distance = (square(x as f64 - column as f64) + height(column)).sqrt();
        (distance as f32, rows[column] * width as u32 + column as u32)
    };
    (0..width).map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_those_of_a_search_over_all_marked_pixels() {
        let marked = Raster::from_fn(31, 23, |x, y| (x * 7 + y * 13 + x * y) % 41 == 3);
        let found = nearest_marked(&marked);
        for y in 0..23usize {
            for x in 0..31usize {
                let to =
                    |i: usize| ((i % 31).abs_diff(x).pow(2) + (i / 31).abs_diff(y).pow(2)) as f32;
                let expected = (0..31 * 23).filter(|&i| marked.data()[i]).map(to);
                let expected = expected.fold(f32::INFINITY, f32::min).sqrt();
                let (distance, index) = found.at(x, y);
                assert!((distance - expected).abs() < 1e-5, "{x} {y}: {distance} {expected}");
                assert!((to(index as usize).sqrt() - expected).abs() < 1e-5);
            }
        }
        let none = nearest_marked(&Raster::filled(4, 3, false));
        assert!(none.data().iter().all(|d| d.0.is_infinite() && d.1 == NONE));
    }
}
