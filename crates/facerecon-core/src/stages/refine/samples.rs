//! Matches as positions in the left photo with a disparity, and their agreement with each other.

use nalgebra::Vector3;
use rayon::prelude::*;

use super::plane::robust_plane;
use crate::data::Match;
use crate::math::Vec2;
use crate::spatial::{self, PointIndex};

/// Radius of the neighbourhood that a sample is compared with, in pitches: the 20 nearest dots of
/// a square lattice.
const NEIGHBOUR_RADIUS: f64 = 2.3;
/// A sample agrees with its neighbours within this many scales of their plane's residuals, or
/// within [`MIN_TOLERANCE`].
const TOLERANCE_SCALES: f64 = 2.5;
/// Smallest tolerance of that comparison, in pitches. A match with a neighbouring dot is wrong by
/// one pitch, the detail of a face between dots by much less than this.
const MIN_TOLERANCE: f64 = 0.1;
/// Smallest scale of the residuals of a local plane, in pitches of disparity: the error of a
/// detected dot.
const MIN_PLANE_SCALE: f64 = 0.011;
/// Squared width of the Gaussian weights of a local plane, as a share of its radius squared.
const WEIGHT_WIDTH: f64 = 0.3;

/// A match: position in the left photo and disparity, in pixels of the given or of the working
/// photos.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    pub(super) x: f64,
    pub(super) y: f64,
    pub(super) disparity: f64,
}

impl Sample {
    pub(super) fn new(m: &Match) -> Self {
        Self { x: m.left.x, y: m.left.y, disparity: m.disparity() }
    }
}

/// Distance between neighbouring dots, or between stripes where the samples run along lines.
/// `None` for fewer than three samples.
pub(super) fn pitch(samples: &[Sample]) -> Option<f64> {
    spatial::estimate_pitch(&positions(samples))
}

/// Indices of samples no denser than the pitch needs.
pub(super) fn thinned(samples: &[Sample], pitch: f64) -> Vec<usize> {
    spatial::thin_to_pitch(&positions(samples), pitch)
}

/// Index of the samples' positions; `None` for fewer than three samples.
pub(super) fn index(samples: &[Sample]) -> Option<PointIndex<2>> {
    (samples.len() >= 3).then(|| PointIndex::<2>::new(&positions(samples))).flatten()
}

fn positions(samples: &[Sample]) -> Vec<Vec2> {
    samples.iter().map(|s| Vec2::new(s.x, s.y)).collect()
}

/// Disparity at a position on [`local_surface`], and the scale of its residuals.
pub(super) fn local_plane(
    samples: &[Sample],
    index: &PointIndex<2>,
    position: [f64; 2],
    radius: f64,
    pitch: f64,
    skip: Option<usize>,
) -> Option<(f64, f64)> {
    let (plane, scale) = local_surface(samples, index, position, radius, pitch, skip)?;
    Some((plane[0], scale))
}

/// The plane of the samples within `radius` (in units of `pitch`) of a position, without sample
/// `skip`: disparity at the position, its slopes across and down; and the scale of the residuals.
/// `None` with fewer than four samples.
pub(super) fn local_surface(
    samples: &[Sample],
    index: &PointIndex<2>,
    position: [f64; 2],
    radius: f64,
    pitch: f64,
    skip: Option<usize>,
) -> Option<(Vector3<f64>, f64)> {
    let radius = radius * pitch;
    let near = index.within(&position, radius);
    let points: Vec<[f64; 4]> = near
        .iter()
        .filter(|n| Some(n.index) != skip)
        .map(|n| {
            let s = &samples[n.index];
            let weight = (-n.distance * n.distance / (WEIGHT_WIDTH * radius * radius)).exp();
            [s.x - position[0], s.y - position[1], s.disparity, weight]
        })
        .collect();
    robust_plane(&points, MIN_PLANE_SCALE * pitch)
}

/// For each sample whether it agrees with the plane of its neighbours; isolated ones do not.
pub(super) fn agree_with_neighbours(samples: &[Sample], pitch: f64) -> Vec<bool> {
    let Some(index) = index(samples) else {
        return vec![false; samples.len()];
    };
    let agrees = |(i, s): (usize, &Sample)| {
        local_plane(samples, &index, [s.x, s.y], NEIGHBOUR_RADIUS, pitch, Some(i)).is_some_and(
            |(d, scale)| {
                let tolerance = (TOLERANCE_SCALES * scale).max(MIN_TOLERANCE * pitch);
                (s.disparity - d).abs() < tolerance
            },
        )
    };
    samples.par_iter().enumerate().map(agrees).collect()
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// 9 x 9 samples, turned a little by `skew`, on a plane of disparity.
    pub(in super::super) fn lattice(step: f64, skew: f64) -> Vec<Sample> {
        let at = |i: i32, j: i32| {
            let (u, v) = (f64::from(i) * step, f64::from(j) * step);
            Sample { x: 40.0 + u - skew * v, y: 40.0 + v + skew * u, disparity: 5.0 + 0.1 * u }
        };
        (0..9).flat_map(|j| (0..9).map(move |i| at(i, j))).collect()
    }

    #[test]
    fn pitch_of_lattices_and_of_stripes() {
        assert!((pitch(&lattice(9.0, 0.0)).unwrap() - 9.0).abs() < 1e-9);
        let turned = pitch(&lattice(9.0, 0.3)).unwrap();
        assert!((turned - 9.0 * 1.09f64.sqrt()).abs() < 1e-9);
        let stripe = |k: i32| (0..60).map(move |y| (12.0 * f64::from(k), f64::from(y)));
        let stripes: Vec<Sample> =
            (0..6).flat_map(stripe).map(|(x, y)| Sample { x, y, disparity: 0.0 }).collect();
        assert!((pitch(&stripes).unwrap() - 12.0).abs() < 0.5);
        assert!(pitch(&stripes[..2]).is_none());
    }

    #[test]
    fn an_outlier_does_not_agree_with_its_neighbours() {
        let mut samples = lattice(9.0, 0.0);
        samples[40].disparity += 4.0;
        let agree = agree_with_neighbours(&samples, 9.0);
        assert_eq!(agree.iter().filter(|a| !**a).count(), 1);
        assert!(!agree[40]);
    }
}
