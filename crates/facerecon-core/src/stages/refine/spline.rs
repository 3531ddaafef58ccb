//! Disparity as one smooth function of the position in the left photo: a uniform bicubic B-spline.

use rayon::prelude::*;

use crate::data::{Gray, Raster};

/// The four cubic B-spline weights at the position `t` (0 to 1) in a cell.
pub(super) fn weights(t: f64) -> [f64; 4] {
    let u = 1.0 - t;
    [
        u * u * u / 6.0,
        (4.0 - 6.0 * t * t + 3.0 * t * t * t) / 6.0,
        (4.0 - 6.0 * u * u + 3.0 * u * u * u) / 6.0,
        t * t * t / 6.0,
    ]
}

/// Their first derivatives, per cell.
pub(super) fn weights_slope(t: f64) -> [f64; 4] {
    let u = 1.0 - t;
    [-u * u / 2.0, (3.0 * t * t - 4.0 * t) / 2.0, (4.0 * u - 3.0 * u * u) / 2.0, t * t / 2.0]
}

/// Their second derivatives, per cell squared.
pub(super) fn weights_bend(t: f64) -> [f64; 4] {
    [1.0 - t, 3.0 * t - 2.0, 1.0 - 3.0 * t, t]
}

/// A disparity surface. Cell `(i, j)` depends on the control values `i..i+4`, `j..j+4`.
#[derive(Clone, Debug)]
pub(super) struct Spline {
    /// Top left corner of cell (0, 0), pixels.
    pub(super) origin: [f64; 2],
    /// Width of a cell, pixels.
    pub(super) cell: f64,
    /// Control values across.
    pub(super) columns: usize,
    /// Control values down.
    pub(super) rows: usize,
    /// Control values, row-major, pixels of disparity.
    pub(super) control: Vec<f64>,
}

impl Spline {
    /// A surface of disparity 0 over the set pixels, with cells of `cell` pixels; `None` when no
    /// pixel is set.
    pub(super) fn over(domain: &Raster<bool>, cell: f64) -> Option<Self> {
        let set = |y: usize| domain.row(y).iter().any(|&p| p);
        let top = (0..domain.height()).find(|&y| set(y))?;
        let bottom = (0..domain.height()).rfind(|&y| set(y))?;
        let (mut first, mut last) = (domain.width(), 0);
        for y in top..=bottom {
            first = first.min(domain.row(y).iter().position(|&p| p).unwrap_or(first));
            last = last.max(domain.row(y).iter().rposition(|&p| p).unwrap_or(last));
        }
        let cells = |length: usize| (length as f64 / cell) as usize + 1;
        let (columns, rows) = (cells(last - first) + 3, cells(bottom - top) + 3);
        let origin = [first as f64, top as f64];
        Some(Self { origin, cell, columns, rows, control: vec![0.0; columns * rows] })
    }

    /// Position of the control value `(i, j)`, pixels.
    pub(super) fn node(&self, i: usize, j: usize) -> [f64; 2] {
        [
            self.origin[0] + (i as f64 - 1.0) * self.cell,
            self.origin[1] + (j as f64 - 1.0) * self.cell,
        ]
    }

    /// Cell column of `x` and the position in it; positions outside use the nearest cell.
    #[inline]
    pub(super) fn cell_column(&self, x: f64) -> (usize, f64) {
        locate((x - self.origin[0]) / self.cell, self.columns - 4)
    }

    /// Cell row of `y` and the position in it; positions outside use the nearest cell.
    #[inline]
    pub(super) fn cell_row(&self, y: f64) -> (usize, f64) {
        locate((y - self.origin[1]) / self.cell, self.rows - 4)
    }

    /// Disparity at a position.
    pub(super) fn value(&self, x: f64, y: f64) -> f64 {
        let ((i, s), (j, t)) = (self.cell_column(x), self.cell_row(y));
        let (wx, wy) = (weights(s), weights(t));
        let mut sum = 0.0;
        for e in 0..4 {
            for f in 0..4 {
                sum += wy[e] * wx[f] * self.control[(j + e) * self.columns + i + f];
            }
        }
        sum
    }

    /// Disparity and its slope along the row at every set pixel; NaN elsewhere.
    pub(super) fn sampled(&self, domain: &Raster<bool>) -> (Raster<f64>, Gray) {
        let (width, height) = domain.size();
        let mut value = Raster::filled(width, height, f64::NAN);
        let mut slope = Raster::filled(width, height, f32::NAN);
        let table: Vec<_> = (0..width)
            .map(|x| {
                let (i, s) = self.cell_column(x as f64);
                (i, weights(s), weights_slope(s).map(|w| w / self.cell))
            })
            .collect();
        value
            .data_mut()
            .par_chunks_mut(width)
            .zip(slope.data_mut().par_chunks_mut(width))
            .enumerate()
            .for_each(|(y, (value, slope))| {
                let mask = domain.row(y);
                if !mask.contains(&true) {
                    return;
                }
                let (j, t) = self.cell_row(y as f64);
                let wy = weights(t);
                let row = |e: usize| &self.control[(j + e) * self.columns..][..self.columns];
                let (a, b, c, d) = (row(0), row(1), row(2), row(3));
                let line: Vec<f64> = (0..self.columns)
                    .map(|i| wy[0] * a[i] + wy[1] * b[i] + wy[2] * c[i] + wy[3] * d[i])
                    .collect();
                for x in (0..width).filter(|&x| mask[x]) {
                    let (i, w, g) = &table[x];
                    let q = &line[*i..*i + 4];
                    value[x] = w[0] * q[0] + w[1] * q[1] + w[2] * q[2] + w[3] * q[3];
                    slope[x] = (g[0] * q[0] + g[1] * q[1] + g[2] * q[2] + g[3] * q[3]) as f32;
                }
            });
        (value, slope)
    }
}

/// Cell of a position in units of cells, and the position in the cell (0 to 1).
#[inline]
fn locate(position: f64, last: usize) -> (usize, f64) {
    let i = (position.max(0.0) as usize).min(last);
    (i, (position - i as f64).clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_linear_control_net_is_a_plane() {
        let domain = Raster::from_fn(50, 40, |x, y| x > 5 && y > 3);
        let mut spline = Spline::over(&domain, 4.3).unwrap();
        let plane = |x: f64, y: f64| 3.0 + 0.2 * x - 0.1 * y;
        for k in 0..spline.control.len() {
            let [x, y] = spline.node(k % spline.columns, k / spline.columns);
            spline.control[k] = plane(x, y);
        }
        let (value, slope) = spline.sampled(&domain);
        for (x, y) in [(6, 4), (20, 30), (49, 39)] {
            assert!((value.at(x, y) - plane(x as f64, y as f64)).abs() < 1e-9);
            assert!((spline.value(x as f64, y as f64) - value.at(x, y)).abs() < 1e-9);
            assert!((slope.at(x, y) - 0.2).abs() < 1e-6);
        }
        assert!(value.at(5, 20).is_nan());
        assert!(Spline::over(&Raster::filled(5, 5, false), 2.0).is_none());
    }
}
