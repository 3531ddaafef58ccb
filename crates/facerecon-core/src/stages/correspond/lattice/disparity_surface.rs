//! The disparities of the matches as a surface over the left photo.

use super::evidence::Evidence;
use crate::math::{Vec2, fit_plane_robust, median};
use crate::spatial::PointIndex;
use crate::stages::correspond::matches::IndexedMatch;

/// Matches that predict a disparity: the lattice neighbours and the diagonal ones.
const PREDICTORS: usize = 8;
/// Fewest matches that predict a disparity.
const MIN_PREDICTORS: usize = 3;
/// Greatest distance of these matches, in spacings: two rings of lattice neighbours.
const PREDICTOR_RADIUS: f64 = 2.3;
/// Scale of the residuals in the predicting plane, in spacings.
const PREDICTION_SCALE: f64 = 0.1;
/// Rounds of the reweighted fit of a plane.
const ROUNDS: usize = 5;
/// Scale of the residuals in the first round over that of the others: it starts from the median,
/// which has no slope.
const FIRST_ROUND_SCALE: f64 = 6.0;

/// The disparities of the matches over the left photo.
pub(super) struct DisparitySurface {
    points: Vec<Vec2>,
    disparities: Vec<f64>,
    index: Option<PointIndex<2>>,
}

impl DisparitySurface {
    pub(super) fn new(evidence: &Evidence<'_>, matches: &[IndexedMatch]) -> Self {
        let points: Vec<Vec2> = matches.iter().map(|m| evidence.dots[0][m.left].position).collect();
        let disparities = matches.iter().map(|m| evidence.disparity(&(m.left, m.right))).collect();
        let index = PointIndex::<2>::new(&points);
        Self { points, disparities, index }
    }

    /// Disparities to expect at a point: on the plane through the neighbours, their median, and
    /// those of the nearest. At a depth discontinuity the plane overshoots, and the point may be on
    /// either side. Empty with fewer than three neighbours.
    pub(super) fn expected(&self, at: Vec2, spacing_px: f64) -> Vec<f64> {
        let near = self.near(at, PREDICTORS, PREDICTOR_RADIUS * spacing_px, usize::MAX);
        let values: Vec<f64> = near.iter().map(|n| self.disparities[*n]).collect();
        let mut expected = Vec::new();
        if near.len() >= MIN_PREDICTORS {
            expected.extend(self.plane_at(at, &near, PREDICTION_SCALE * spacing_px));
            expected.extend(median(&values));
            expected.extend(&values[..MIN_PREDICTORS]);
        }
        expected
    }

    /// The `count` nearest matches within a radius of a point, without the match `except`.
    pub(super) fn near(&self, at: Vec2, count: usize, radius: f64, except: usize) -> Vec<usize> {
        let Some(index) = &self.index else {
            return Vec::new();
        };
        index
            .nearest_n(&[at.x, at.y], count + 1)
            .iter()
            .filter(|n| n.index != except && n.distance <= radius)
            .take(count)
            .map(|n| n.index)
            .collect()
    }

    /// Disparity of a match.
    pub(super) fn disparity(&self, index: usize) -> f64 {
        self.disparities[index]
    }

    /// Left position of a match.
    pub(super) fn point(&self, index: usize) -> Vec2 {
        self.points[index]
    }

    /// Value at a point of a robust plane through matches. Weights fall with the residual over
    /// `scale_px` (Cauchy), starting from the median.
    pub(super) fn plane_at(&self, at: Vec2, near: &[usize], scale_px: f64) -> Option<f64> {
        let sample = |n: &usize| (self.points[*n] - at, self.disparities[*n]);
        let samples: Vec<(Vec2, f64)> = near.iter().map(sample).collect();
        let mut widths = [scale_px; ROUNDS];
        widths[0] *= FIRST_ROUND_SCALE;
        fit_plane_robust(&samples, &widths).map(|plane| plane[0])
    }
}
