//! Curvature of a disparity spline, cell by cell.

use rayon::prelude::*;

use super::spline::{Spline, weights, weights_bend, weights_slope};

/// Nodes and weights of the Gauss-Legendre quadrature with four points on 0 to 1. It is exact for
/// the products of two cubics.
const GAUSS_LEGENDRE: [(f64, f64); 4] = [
    (0.069_431_844_202_973_7, 0.173_927_422_568_727),
    (0.330_009_478_207_571_9, 0.326_072_577_431_273),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273),
    (0.930_568_155_797_026_3, 0.173_927_422_568_727),
];

/// The thin-plate energy of one cell, `integral of d_xx^2 + 2 d_xy^2 + d_yy^2`, as a quadratic
/// form of its 16 control values.
pub(super) struct Bending {
    pub(super) energy: [[f64; 16]; 16],
}

/// Curvature and slope of one cell.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct CellShape {
    /// Root mean square of the second derivatives, 1/px.
    pub(super) bend: f64,
    /// Length of the gradient at the cell's centre, pixels per pixel.
    pub(super) slope: f64,
}

impl Bending {
    /// The energy of cells of `cell` pixels.
    pub(super) fn new(cell: f64) -> Self {
        let (value, slope, bend) = (gram(weights), gram(weights_slope), gram(weights_bend));
        let mut energy = [[0.0; 16]; 16];
        for a in 0..16 {
            for b in 0..16 {
                let (y, x) = ((a / 4, b / 4), (a % 4, b % 4));
                energy[a][b] = (bend[y.0][y.1] * value[x.0][x.1]
                    + 2.0 * slope[y.0][y.1] * slope[x.0][x.1]
                    + value[y.0][y.1] * bend[x.0][x.1])
                    / (cell * cell);
            }
        }
        Self { energy }
    }

    /// Shape of every cell, row-major, `(columns - 3) x (rows - 3)`.
    pub(super) fn shapes(&self, spline: &Spline) -> Vec<CellShape> {
        let cells = spline.columns - 3;
        let (middle, slope) = (weights(0.5), weights_slope(0.5));
        let cell = spline.cell;
        let shape = |k: usize| {
            let (i, j) = (k % cells, k / cells);
            let c: [f64; 16] =
                std::array::from_fn(|a| spline.control[(j + a / 4) * spline.columns + i + a % 4]);
            let (mut energy, mut gx, mut gy) = (0.0, 0.0, 0.0);
            for a in 0..16 {
                gx += c[a] * middle[a / 4] * slope[a % 4] / cell;
                gy += c[a] * slope[a / 4] * middle[a % 4] / cell;
                let product: f64 = self.energy[a].iter().zip(&c).map(|(e, c)| e * c).sum();
                energy += c[a] * product;
            }
            CellShape { bend: (energy.max(0.0)).sqrt() / cell, slope: gx.hypot(gy) }
        };
        (0..cells * (spline.rows - 3)).into_par_iter().map(shape).collect()
    }
}

/// Integrals over a cell of the products of four functions.
fn gram(functions: fn(f64) -> [f64; 4]) -> [[f64; 4]; 4] {
    let mut g = [[0.0; 4]; 4];
    for (t, w) in GAUSS_LEGENDRE {
        let v = functions(t);
        for i in 0..4 {
            for j in 0..4 {
                g[i][j] += w * v[i] * v[j];
            }
        }
    }
    g
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::Raster;

    fn quadratic() -> Spline {
        let domain = Raster::filled(37, 29, true);
        let mut spline = Spline::over(&domain, 4.0).unwrap();
        for k in 0..spline.control.len() {
            let [x, y] = spline.node(k % spline.columns, k / spline.columns);
            spline.control[k] = 0.01 * x * x + 0.02 * x * y + 0.3 * y;
        }
        spline
    }

    #[test]
    fn bend_and_slope_of_a_quadratic_surface() {
        let spline = quadratic();
        let shapes = Bending::new(4.0).shapes(&spline);
        // d_xx = 0.02, d_xy = 0.02: sqrt(0.02^2 + 2 * 0.02^2)
        for s in &shapes {
            assert!((s.bend - 0.02 * 3f64.sqrt()).abs() < 1e-9, "{s:?}");
        }
        let slope = (0.08f64).hypot(0.34);
        assert!((shapes[0].slope - slope).abs() < 1e-9, "{:?}", shapes[0]);
    }
}
