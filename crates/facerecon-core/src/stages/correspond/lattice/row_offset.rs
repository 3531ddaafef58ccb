//! The row difference of both photos, where the rows are not exactly level.

use crate::math::{Mat3, Vec2, Vec3, median};

/// Rounds of the reweighted fit.
const ROUNDS: usize = 4;
/// Residual from which a sample has no weight (Tukey), in tolerances.
const CUTOFF: f64 = 3.0;
/// Damping of the slopes, squared spacings: a few dots close together must not tilt the rows. Counts
/// like two dots 11 spacings from the centre.
const SLOPE_DAMPING: f64 = 242.0;
/// Damping of the offset, in dots: only keeps the system solvable.
const OFFSET_DAMPING: f64 = 1e-9;

/// Row difference `yr - yl` of the photos: `offset + along * x + down * y` about a centre, pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RowOffset {
    centre: Vec2,
    offset: f64,
    along: f64,
    down: f64,
}

impl RowOffset {
    /// No row difference.
    pub(super) fn zero() -> Self {
        Self { centre: Vec2::zeros(), offset: 0.0, along: 0.0, down: 0.0 }
    }

    /// Row difference expected at a left position.
    pub(super) fn at(&self, left: &Vec2) -> f64 {
        let d = left - self.centre;
        self.offset + self.along * d.x + self.down * d.y
    }

    /// Fits `(left position, row difference)` robustly: iteratively reweighted least squares, with
    /// Tukey weights of scale `tolerance` (pixels), from the median. `spacing` is that of the dots, pixels.
    pub(super) fn fit(samples: &[(Vec2, f64)], tolerance: f64, spacing: f64) -> Self {
        let slope_damping = SLOPE_DAMPING * spacing * spacing;
        let differences: Vec<f64> = samples.iter().map(|s| s.1).collect();
        let n = samples.len().max(1) as f64;
        let centre = samples.iter().map(|s| s.0).sum::<Vec2>() / n;
        let offset = median(&differences).unwrap_or(0.0);
        let mut fitted = Self { centre, offset, along: 0.0, down: 0.0 };
        for _ in 0..ROUNDS {
            let (mut normal, mut right) = (Mat3::zeros(), Vec3::zeros());
            for (p, dy) in samples {
                let u = (dy - fitted.at(p)) / (CUTOFF * tolerance);
                if u.abs() < 1.0 {
                    let weight = (1.0 - u * u).powi(2);
                    let j = Vec3::new(1.0, p.x - centre.x, p.y - centre.y);
                    normal += weight * j * j.transpose();
                    right += weight * j * *dy;
                }
            }
            for (i, damping) in [(0, OFFSET_DAMPING), (1, slope_damping), (2, slope_damping)] {
                normal[(i, i)] += damping;
            }
            let Some(solved) = normal.try_inverse().map(|inverse| inverse * right) else {
                break;
            };
            (fitted.offset, fitted.along, fitted.down) = (solved.x, solved.y, solved.z);
        }
        fitted
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tilt_is_found_among_wrong_pairs() {
        let truth = |p: &Vec2| 1.5 + 0.004 * p.x - 0.002 * p.y;
        let samples: Vec<(Vec2, f64)> = (0..400)
            .map(|i| {
                let p = Vec2::new(f64::from(i % 20) * 20.0, f64::from(i / 20) * 20.0);
                // every fifth pair is a dot of another row
                (p, truth(&p) + if i % 5 == 0 { 9.0 } else { 0.0 })
            })
            .collect();
        let found = RowOffset::fit(&samples, 0.6, 9.0);
        for (p, _) in &samples {
            assert!((found.at(p) - truth(p)).abs() < 0.02, "{p}");
        }
        assert_eq!(RowOffset::fit(&[], 0.6, 9.0), RowOffset::zero());
    }
}
