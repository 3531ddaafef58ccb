//! Posterior of focal length and distance: how square the projector's lattice is, and what is usual.

use crate::math::{Mat2, Vec2, Vec3};

/// Half the number of grid steps along each axis of the search.
const GRID_HALF: i32 = 30;
/// The first grid spans this many prior standard deviations to either side.
const GRID_SIGMAS: f64 = 4.0;
/// Number of grids, each this fraction of the size of the one before: the last step is below 1e-4
/// standard deviations.
const GRIDS: usize = 8;
const GRID_SHRINKAGE: f64 = 0.3;
/// Step of the numerical derivatives, in logarithms.
const DERIVATIVE_STEP: f64 = 1e-4;

/// Posterior of the logarithms `x` of the focal length in pixels and `y` of the distance over the
/// baseline.
pub(super) struct CameraPosterior {
    /// Columns of the projector's matrix: for pixels across and down, for the constant, and for
    /// pixels of disparity beyond the median.
    pub across: Vec3,
    pub down: Vec3,
    pub ahead: Vec3,
    pub parallax: Vec3,
    /// Mean and standard deviation of the prior.
    pub usual: Vec2,
    pub spread: Vec2,
    /// Standard deviation of the squareness.
    pub lattice_error: f64,
}

impl CameraPosterior {
    /// Skew and unequal scale of the projector's pixels, relative. Point `(x, y, f, d - d0)` is
    /// proportional to `(X, Y, Z, B)`, so that the projector's matrix for `(X, Y, Z)` has the
    /// columns `across`, `down` and `(ahead - (d - d0) parallax) / f`; the matrix times its
    /// transpose is the dual image of the absolute conic.
    fn squareness(&self, at: Vec2) -> Vec2 {
        let focal = at.x.exp();
        let parallax_px = focal / at.y.exp();
        let depth = (self.ahead - self.parallax * parallax_px) / focal;
        let outer = |v: &Vec3| v * v.transpose();
        let conic = outer(&self.across) + outer(&self.down) + outer(&depth);
        let scale = conic[(2, 2)];
        let [xx, yy] = [0, 1].map(|i| conic[(i, i)] - conic[(i, 2)].powi(2) / scale);
        let xy = conic[(0, 1)] - conic[(0, 2)] * conic[(1, 2)] / scale;
        Vec2::new(2.0 * xy, xx - yy) / (xx + yy)
    }

    /// Twice the negative logarithm of the posterior, up to a constant.
    fn energy(&self, at: Vec2) -> f64 {
        let lattice = self.squareness(at) / self.lattice_error;
        let usual = (at - self.usual).component_div(&self.spread);
        lattice.norm_squared() + usual.norm_squared()
    }

    /// The mode: a grid over all usual values, then finer ones around the best.
    pub(super) fn mode(&self) -> Vec2 {
        let mut centre = self.usual;
        let mut reach = GRID_SIGMAS * self.spread;
        for _ in 0..GRIDS {
            let range = -GRID_HALF..=GRID_HALF;
            let grid = range.clone().flat_map(|i| range.clone().map(move |j| (i, j)));
            let at = |(i, j): (i32, i32)| {
                let fraction = Vec2::new(f64::from(i), f64::from(j)) / f64::from(GRID_HALF);
                centre + reach.component_mul(&fraction)
            };
            let energies = grid.map(at).map(|p| (self.energy(p), p));
            if let Some((_, p)) = energies.min_by(|a, b| a.0.total_cmp(&b.0)) {
                centre = p;
            }
            reach *= GRID_SHRINKAGE;
        }
        centre
    }

    /// Covariance of the two logarithms from the derivatives of the energy (Gauss-Newton).
    pub(super) fn covariance(&self, at: Vec2) -> Option<Mat2> {
        let step = DERIVATIVE_STEP;
        let slope = [Vec2::x(), Vec2::y()].map(|axis| {
            (self.squareness(at + axis * step) - self.squareness(at - axis * step))
                / (2.0 * step * self.lattice_error)
        });
        let jacobian = Mat2::from_columns(&slope);
        let prior = Mat2::from_diagonal(&self.spread.map(|s| 1.0 / (s * s)));
        (jacobian.transpose() * jacobian + prior).try_inverse()
    }
}
