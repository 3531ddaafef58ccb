//! Trimmed point-to-plane alignment (Chetverikov et al. 2005; Chen and Medioni 1992) from several
//! starts.

use nalgebra::{SMatrix, SVector};
use rayon::prelude::*;

use super::params::{Alignment, CompareError, CompareParams};
use super::samples::Sample;
use crate::data::Mesh;
use crate::math::{Mat3, Similarity, Vec3, percentile};
use crate::observer::Observer;
use crate::spatial::{IcpIteration, IcpStep, SurfaceIndex, iterate_closest_points};

/// Points that take part; more change nothing.
const POINTS: usize = 4000;
/// Steps each start is given before the best one goes on.
const TRIAL_STEPS: usize = 12;
/// A step smaller than this fraction of the mesh's size ends the search.
const SETTLED: f64 = 1e-9;

/// Finds the transform that brings the samples of the first mesh to the second, and the number of
/// steps it took. Never worse (in the trimmed mean distance) than leaving things as they are.
pub(super) fn align(
    samples: &[Sample],
    second: &Mesh,
    index: &SurfaceIndex,
    params: &CompareParams,
    observer: &dyn Observer,
) -> Result<(Similarity, usize), CompareError> {
    let every = samples.len().div_ceil(POINTS).max(1);
    let points: Vec<Vec3> = samples.iter().step_by(every).map(|s| s.point).collect();
    let search = Search { points: &points, index, second, params, observer };
    let mut best: Option<(f64, Similarity)> = None;
    for start in starts(&points, second, params.alignment == Alignment::Similarity) {
        let (found, _) = search.run(start, TRIAL_STEPS)?;
        let cost = search.cost(&found);
        if best.is_none_or(|(least, _)| cost < least) {
            best = Some((cost, found));
        }
    }
    let (_, start) = best.unwrap_or((0.0, Similarity::identity()));
    let (found, steps) = search.run(start, params.iterations)?;
    let unmoved = Similarity::identity();
    Ok(if search.cost(&found) <= search.cost(&unmoved) { (found, steps) } else { (unmoved, 0) })
}

/// As they lie; middles and sizes matched; and the same with the axes of the camera frame turned to
/// those of the model frame.
fn starts(points: &[Vec3], second: &Mesh, size_may_change: bool) -> Vec<Similarity> {
    let spread = |list: &[Vec3]| {
        let middle = list.iter().sum::<Vec3>() / list.len().max(1) as f64;
        let square: f64 = list.iter().map(|p| (p - middle).norm_squared()).sum();
        (middle, (square / list.len().max(1) as f64).sqrt())
    };
    let (from, from_size) = spread(points);
    let (to, to_size) = spread(&second.vertices);
    let ratio = to_size / from_size.max(1e-12);
    let mut list = vec![Similarity::identity()];
    let turned = Mat3::from_diagonal(&Vec3::new(1.0, -1.0, -1.0));
    for rotation in [Mat3::identity(), turned] {
        let mut scales = vec![1.0];
        if size_may_change && !(0.8..1.25).contains(&ratio) {
            scales.push(ratio);
        }
        for scale in scales {
            list.push(Similarity { scale, rotation, translation: to - rotation * from * scale });
        }
    }
    list
}

struct Search<'a> {
    points: &'a [Vec3],
    index: &'a SurfaceIndex,
    second: &'a Mesh,
    params: &'a CompareParams,
    observer: &'a dyn Observer,
}

impl Search<'_> {
    /// Points as moved, where they meet the second mesh, the normal there, and the distance.
    fn meet(&self, pose: &Similarity) -> Vec<(Vec3, Vec3, Vec3, f64)> {
        self.points
            .par_iter()
            .filter_map(|p| {
                let moved = pose.apply(p);
                let hit = self.index.closest(&moved)?;
                let [a, b, c] = self.second.corners(hit.face);
                let normal = (b - a).cross(&(c - a)).try_normalize(1e-300)?;
                Some((moved, hit.point, normal, hit.distance))
            })
            .collect()
    }

    /// Distance within which the kept part of the points lies.
    fn limit(&self, distances: &[f64]) -> f64 {
        percentile(distances, self.params.keep).unwrap_or(0.0)
    }

    /// Mean distance of the kept points.
    fn cost(&self, pose: &Similarity) -> f64 {
        let mut distances: Vec<f64> = self.meet(pose).iter().map(|m| m.3).collect();
        distances.sort_unstable_by(f64::total_cmp);
        let kept = ((distances.len() as f64 * self.params.keep) as usize).max(1);
        let kept = &distances[..kept.min(distances.len())];
        if kept.is_empty() { f64::INFINITY } else { kept.iter().sum::<f64>() / kept.len() as f64 }
    }

    fn run(&self, start: Similarity, steps: usize) -> Result<(Similarity, usize), CompareError> {
        let find_pairs = |pose: &Similarity| self.meet(pose);
        let step = |iteration: &IcpIteration<'_, Vec<(Vec3, Vec3, Vec3, f64)>>| -> Result<_, CompareError> {
            self.observer.check()?;
            let meetings = iteration.pairs;
            let distances: Vec<f64> = meetings.iter().map(|m| m.3).collect();
            let limit = self.limit(&distances);
            let Some(change) = self.step(meetings, limit) else { return Ok(None) };
            let size = meetings.iter().map(|m| m.0.norm()).fold(1e-9, f64::max);
            let moved =
                change.translation.norm() / size + change.angle() + (change.scale - 1.0).abs();
            let pose = change.compose(iteration.pose);
            Ok(Some(IcpStep { pose, pairs: None, converged: moved < SETTLED }))
        };
        let icp = iterate_closest_points(start, steps, find_pairs, step)?;
        Ok((icp.pose, icp.iterations))
    }

    /// One Gauss-Newton step on the point-to-plane distances of the kept points, about their
    /// middle: rotation vector, shift, growth.
    fn step(&self, meetings: &[(Vec3, Vec3, Vec3, f64)], limit: f64) -> Option<Similarity> {
        let kept: Vec<_> = meetings.iter().filter(|m| m.3 <= limit).collect();
        if kept.len() < 10 {
            return None;
        }
        let middle = kept.iter().map(|m| m.0).sum::<Vec3>() / kept.len() as f64;
        let mut normal_matrix = SMatrix::<f64, 7, 7>::zeros();
        let mut right = SVector::<f64, 7>::zeros();
        for (point, target, normal, distance) in kept {
            let from_middle = point - middle;
            let turn = from_middle.cross(normal);
            let grow = from_middle.dot(normal);
            let row = SVector::<f64, 7>::from([
                turn.x, turn.y, turn.z, normal.x, normal.y, normal.z, grow,
            ]);
            // far points pull less (Tukey's biweight at the trimming limit)
            let ratio = distance / (limit * 1.5).max(1e-12);
            let weight = (1.0 - ratio * ratio).max(0.0).powi(2);
            normal_matrix += row * row.transpose() * weight;
            right += row * ((target - point).dot(normal) * weight);
        }
        // symmetric shapes leave directions free: hold them, relative to the others
        let trace = normal_matrix.trace() / 7.0;
        for k in 0..7 {
            normal_matrix[(k, k)] += trace * 1e-9;
        }
        if self.params.alignment != Alignment::Similarity {
            for k in 0..7 {
                normal_matrix[(6, k)] = 0.0;
                normal_matrix[(k, 6)] = 0.0;
            }
            normal_matrix[(6, 6)] = 1.0;
            right[6] = 0.0;
        }
        let x = normal_matrix.cholesky()?.solve(&right);
        if !x.iter().all(|v| v.is_finite()) {
            return None;
        }
        let turn = Vec3::new(x[0], x[1], x[2]);
        let rotation = nalgebra::Rotation3::from_scaled_axis(turn).into_inner();
        let scale = (1.0 + x[6]).clamp(0.5, 2.0);
        let shift = Vec3::new(x[3], x[4], x[5]);
        let translation = middle + shift - rotation * middle * scale;
        Some(Similarity { scale, rotation, translation })
    }
}
