//! Measured points as the robust registration uses them.

use crate::data::Cloud;
use crate::math::{Vec3, median};

/// Inverse of the golden ratio: its multiples are spread evenly over the unit interval.
const GOLDEN_RATIO: f64 = 0.618_033_988_749_895;

/// A measured point; the normal is zero where unknown.
#[derive(Clone, Copy)]
pub(super) struct Sample {
    pub(super) point: Vec3,
    pub(super) normal: Vec3,
}

impl Sample {
    /// The points of a cloud whose numbers are finite.
    pub(super) fn from_cloud(data: &Cloud) -> Vec<Self> {
        let with_normals = data.normals.len() == data.points.len();
        (0..data.points.len())
            .map(|i| Self {
                point: data.points[i],
                normal: if with_normals { data.normals[i] } else { Vec3::zeros() },
            })
            .filter(|s| s.point.iter().chain(s.normal.iter()).all(|c| c.is_finite()))
            .collect()
    }
}

/// At most `count` samples, spread evenly over the list in a golden-ratio order: a regular stride
/// could coincide with the rows of the points.
pub(super) fn spread_samples(samples: &[Sample], count: usize) -> Vec<Sample> {
    if samples.len() <= count {
        return samples.to_vec();
    }
    let mut picks: Vec<usize> = (0..count)
        .map(|k| ((k as f64 + 0.5) * GOLDEN_RATIO).fract())
        .map(|t| ((t * samples.len() as f64) as usize).min(samples.len() - 1))
        .collect();
    picks.sort_unstable();
    picks.dedup();
    picks.iter().map(|&i| samples[i]).collect()
}

/// The median of each coordinate.
pub(super) fn median_position(samples: &[Sample]) -> Vec3 {
    let axis = |a: usize| {
        median(&samples.iter().map(|s| s.point[a]).collect::<Vec<_>>()).unwrap_or_default()
    };
    Vec3::new(axis(0), axis(1), axis(2))
}
