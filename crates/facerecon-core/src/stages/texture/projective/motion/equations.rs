//! Normal equations of a Gauss-Newton step for a rigid motion.

use nalgebra::{Rotation3, SMatrix, SVector};

use crate::math::{Similarity, Vec3, median};

/// Rotations are counted in mm at this distance from the centre (about the radius of a head), so
/// that all six unknowns have similar sizes.
pub(super) const ARM_MM: f64 = 80.0;
/// Residuals lose weight beyond this many typical residuals.
const BOUND: f64 = 2.0;

/// A derivative by the six unknowns (rotation, translation) and its residual.
pub(super) type Row = (SVector<f64, 6>, f64);

/// Sums over all residuals at one motion.
#[derive(Default)]
pub(super) struct NormalEquations {
    matrix: SMatrix<f64, 6, 6>,
    right: SVector<f64, 6>,
    sum: f64,
    count: f64,
    /// Median absolute residual of each kind of comparison.
    pub typical: Vec<f64>,
}

impl NormalEquations {
    /// Adds one kind of comparison with Geman-McClure weights, residuals in units of their bound.
    /// `bounds`: typical residuals to use instead of those found. The order of the sums does not
    /// depend on the number of threads.
    pub fn add(&mut self, rows: &[Row], bounds: Option<&Vec<f64>>) {
        let kind = self.typical.len();
        let typical = match bounds.and_then(|b| b.get(kind)) {
            Some(given) => *given,
            None => median(&rows.iter().map(|r| r.1.abs()).collect::<Vec<_>>()).unwrap_or(1.0),
        };
        self.typical.push(typical);
        let bound = (BOUND * typical).max(1e-6);
        for (row, residual) in rows {
            let t = (residual / bound).powi(2);
            let weight = (1.0 + t).powi(-2) / bound.powi(2);
            self.matrix += row * row.transpose() * weight;
            self.right += row * (residual * weight);
            self.sum += t / (1.0 + t);
        }
        self.count += rows.len() as f64;
    }

    /// Mean bounded squared residual.
    pub fn cost(&self) -> f64 {
        self.sum / self.count.max(1.0)
    }

    /// The step that lowers the cost, as a motion about `centre`; `None` where the residuals do not
    /// determine one.
    pub fn step(&self, centre: &Vec3, damping: f64) -> Option<Similarity> {
        let mut a = self.matrix;
        for i in 0..6 {
            a[(i, i)] *= 1.0 + damping;
        }
        let s = a.cholesky()?.solve(&self.right);
        if !s.iter().all(|v| v.is_finite()) {
            return None;
        }
        let turn = Vec3::new(s[0], s[1], s[2]) / ARM_MM;
        let rotation = Rotation3::from_scaled_axis(turn).into_inner();
        let shift = Vec3::new(s[3], s[4], s[5]);
        Some(Similarity::rigid(rotation, centre - rotation * centre + shift))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_known_motion_is_found_in_spite_of_outliers() {
        let centre = Vec3::new(1.0, -2.0, 3.0);
        let unknowns = SVector::<f64, 6>::from([0.3, -0.2, 0.1, 1.0, -2.0, 0.5]);
        let rows: Vec<Row> = (0..300)
            .map(|i| {
                let row = SVector::<f64, 6>::from_fn(|k, _| {
                    (f64::from(i) * (0.7 + 0.37 * k as f64)).sin()
                });
                let outlier = if i % 10 == 0 { 500.0 } else { 0.0 };
                (row, row.dot(&unknowns) + outlier)
            })
            .collect();
        let mut equations = NormalEquations::default();
        equations.add(&rows, Some(&vec![10.0]));
        let step = equations.step(&centre, 0.0).unwrap();
        let shift = step.apply(&centre) - centre;
        assert!((shift - Vec3::new(1.0, -2.0, 0.5)).norm() < 0.02, "{shift}");
        assert!((step.angle() - Vec3::new(0.3, -0.2, 0.1).norm() / ARM_MM).abs() < 2e-4);
        assert!(NormalEquations::default().step(&centre, 0.0).is_none());
    }
}
