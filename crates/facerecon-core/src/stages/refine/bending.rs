//! How a surface is bent: the energy that resists the descent.

use rayon::prelude::*;

use super::surface::{Surface, weights, weights_bend, weights_slope};

/// The thin-plate bending energy of one cell, `integral of d_xx^2 + 2 d_xy^2 + d_yy^2`, as a
/// quadratic form of its 16 control values.
pub(super) struct Bending {
    pub(super) energy: [[f64; 16]; 16],
}

/// How a cell is bent and tilted.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Shape {
    /// Root mean square of the second derivatives, 1/px.
    pub(super) bend: f64,
    /// Length of the gradient in the middle.
    pub(super) tilt: f64,
}

impl Bending {
    /// For cells of `knot` pixels.
    pub(super) fn new(knot: f64) -> Self {
        // Gauss-Legendre with four points is exact for these products
        let points = [
            (0.069_431_844_202_973_7, 0.173_927_422_568_727),
            (0.330_009_478_207_571_9, 0.326_072_577_431_273),
            (0.669_990_521_792_428_1, 0.326_072_577_431_273),
            (0.930_568_155_797_026_3, 0.173_927_422_568_727),
        ];
        let gram = |f: fn(f64) -> [f64; 4]| {
            let mut g = [[0.0; 4]; 4];
            for (t, w) in points {
                let v = f(t);
                for i in 0..4 {
                    for j in 0..4 {
                        g[i][j] += w * v[i] * v[j];
                    }
                }
            }
            g
        };
        let (value, slope, bend) = (gram(weights), gram(weights_slope), gram(weights_bend));
        let mut energy = [[0.0; 16]; 16];
        for a in 0..16 {
            for b in 0..16 {
                let (y, x) = ((a / 4, b / 4), (a % 4, b % 4));
                energy[a][b] = (bend[y.0][y.1] * value[x.0][x.1]
                    + 2.0 * slope[y.0][y.1] * slope[x.0][x.1]
                    + value[y.0][y.1] * bend[x.0][x.1])
                    / (knot * knot);
            }
        }
        Self { energy }
    }

    /// Bend and tilt of every cell, row-major, `(columns - 3) x (rows - 3)`.
    pub(super) fn shapes(&self, surface: &Surface) -> Vec<Shape> {
        let cells = surface.columns - 3;
        let (middle, slope) = (weights(0.5), weights_slope(0.5));
        let knot = surface.knot;
        let shape = |k: usize| {
            let (i, j) = (k % cells, k / cells);
            let c: [f64; 16] =
                std::array::from_fn(|a| surface.control[(j + a / 4) * surface.columns + i + a % 4]);
            let (mut energy, mut gx, mut gy) = (0.0, 0.0, 0.0);
            for a in 0..16 {
                gx += c[a] * middle[a / 4] * slope[a % 4] / knot;
                gy += c[a] * slope[a / 4] * middle[a % 4] / knot;
                let pull: f64 = self.energy[a].iter().zip(&c).map(|(e, c)| e * c).sum();
                energy += c[a] * pull;
            }
            Shape { bend: (energy.max(0.0)).sqrt() / knot, tilt: gx.hypot(gy) }
        };
        (0..cells * (surface.rows - 3)).into_par_iter().map(shape).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::Raster;

    fn bowl() -> Surface {
        let domain = Raster::filled(37, 29, true);
        let mut surface = Surface::over(&domain, 4.0).unwrap();
        for k in 0..surface.control.len() {
            let [x, y] = surface.node(k % surface.columns, k / surface.columns);
            surface.control[k] = 0.01 * x * x + 0.02 * x * y + 0.3 * y;
        }
        surface
    }

    #[test]
    fn bend_and_tilt_of_a_bowl() {
        let surface = bowl();
        let shapes = Bending::new(4.0).shapes(&surface);
        // d_xx = 0.02, d_xy = 0.02: sqrt(0.02^2 + 2 * 0.02^2)
        for s in &shapes {
            assert!((s.bend - 0.02 * 3f64.sqrt()).abs() < 1e-9, "{s:?}");
        }
        let tilt = (0.08f64).hypot(0.34);
        assert!((shapes[0].tilt - tilt).abs() < 1e-9, "{:?}", shapes[0]);
    }
}
