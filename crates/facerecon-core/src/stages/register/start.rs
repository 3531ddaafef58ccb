//! Where the iteration starts: which points belong to the head, and a first pose.

use nalgebra::Rotation3;
use rayon::prelude::*;

use super::quaternion::fit_quaternion;
use super::{RegisterError, RegisterInput, height, trimmed_rms};
use crate::data::{CloudFrame, Mesh};
use crate::math::{Mat3, Similarity, Vec3, median, percentile};
use crate::spatial::PointIndex;

/// Points looked at while trying starts.
const SAMPLE: usize = 250;
/// How many of the best starts are stepped, and how often.
const FINALISTS: usize = 6;
const STEPS: usize = 8;

/// Turns camera axes (y down, z forward) into model axes (y up, z toward the viewer).
pub fn upright(frame: CloudFrame) -> Similarity {
    let turn = match frame {
        CloudFrame::Metric | CloudFrame::Camera => Vec3::new(1.0, -1.0, -1.0),
        CloudFrame::Model => Vec3::repeat(1.0),
    };
    Similarity::rigid(Mat3::from_diagonal(&turn), Vec3::zeros())
}

/// The points no farther behind the front of the face than the head is deep: what the pattern drew
/// on the wall does not belong to the head.
pub fn on_the_head(points: &[Vec3], model: &Mesh, frame: CloudFrame) -> Vec<usize> {
    let depth = model.bounds().map_or(0.0, |(low, high)| high.z - low.z);
    let turned: Vec<f64> = points.iter().map(|p| upright(frame).apply(p).z).collect();
    // A wall may hold more dots than the face: the front is where points begin to be dense.
    let front = percentile(&turned, 0.98).unwrap_or(0.0);
    let limit = if frame.is_metric() { front - 1.1 * depth } else { f64::NEG_INFINITY };
    (0..points.len()).filter(|&i| turned[i] >= limit).collect()
}

/// The pose from marked features, by the same solver as in each step.
///
/// # Errors
/// [`RegisterError::Features`] when they do not fit the model, [`RegisterError::Degenerate`] when
/// they lie on one line.
pub fn from_features(
    features: &[(Vec3, Vec3)],
    with_scale: bool,
) -> Result<Similarity, RegisterError> {
    let (data, model): (Vec<Vec3>, Vec<Vec3>) = features.iter().copied().unzip();
    let pose = fit_quaternion(&data, &model, with_scale).ok_or(RegisterError::Degenerate)?;
    let misses: Vec<f64> = features.iter().map(|(d, m)| (pose.apply(d) - m).norm()).collect();
    let rms = (misses.iter().map(|d| d * d).sum::<f64>() / misses.len() as f64).sqrt();
    let centre = model.iter().sum::<Vec3>() / model.len() as f64;
    let spread = (model.iter().map(|m| (m - centre).norm_squared()).sum::<f64>()
        / model.len() as f64)
        .sqrt();
    let limit = 0.35 * spread;
    if !(rms <= limit) {
        let worst = (0..misses.len()).max_by(|&a, &b| misses[a].total_cmp(&misses[b]));
        return Err(RegisterError::Features { rms, limit, worst: worst.unwrap_or(0) });
    }
    Ok(pose)
}

/// A first pose without marks: front against front, from several heights, depths and turns of the
/// head; the start whose points come closest after a few steps on a sample wins. Also gives the
/// number of steps taken.
///
/// # Errors
/// [`RegisterError::Degenerate`] when no start can be stepped.
pub fn from_shape(
    input: &RegisterInput<'_>,
    points: &[Vec3],
    with_scale: bool,
) -> Result<(Similarity, usize), RegisterError> {
    let model = input.coarse.unwrap_or(input.model);
    let index = PointIndex::<3>::new(&model.vertices).ok_or(RegisterError::Degenerate)?;
    let stride = points.len().div_ceil(SAMPLE).max(1);
    let sample: Vec<Vec3> = points.iter().step_by(stride).copied().collect();
    let starts = starts(model, &sample, upright(input.frame));
    let mut tried: Vec<(f64, usize)> =
        starts.par_iter().enumerate().map(|(i, s)| (score(&sample, s, &index), i)).collect();
    tried.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    // The closest start is often a shallow one: a few steps tell more than the start itself.
    let stepped: Vec<(f64, Similarity)> = tried
        .iter()
        .take(FINALISTS)
        .map(|&(_, i)| {
            let mut pose = starts[i];
            for _ in 0..STEPS {
                pose = step(&sample, &pose, model, &index, with_scale).unwrap_or(pose);
            }
            (score(&sample, &pose, &index), starts[i])
        })
        .collect();
    let steps = stepped.len() * STEPS;
    stepped
        .into_iter()
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, pose)| (pose, steps))
        .ok_or(RegisterError::Degenerate)
}

fn starts(model: &Mesh, sample: &[Vec3], upright: Similarity) -> Vec<Similarity> {
    // The side of the model that the cameras see.
    let normals = model.vertex_normals();
    let front: Vec<Vec3> =
        model.vertices.iter().zip(&normals).filter(|(_, n)| n.z > 0.2).map(|(v, _)| *v).collect();
    let front = if front.is_empty() { &model.vertices } else { &front };
    let mut starts = Vec::new();
    for yaw_deg in [0.0f64, -25.0, 25.0] {
        let turn = Similarity::rigid(
            Rotation3::from_axis_angle(&Vec3::y_axis(), yaw_deg.to_radians()).into_inner(),
            Vec3::zeros(),
        );
        let pose = turn.compose(&upright);
        let turned: Vec<Vec3> = sample.iter().map(|p| pose.apply(p)).collect();
        let base = Vec3::new(
            middle(front, 0) - middle(&turned, 0),
            middle(front, 1) - middle(&turned, 1),
            nearest(front) - nearest(&turned),
        );
        for up in -4..=4 {
            for back in -1..=1 {
                let shift = base
                    + Vec3::new(0.0, f64::from(up) * 0.07, f64::from(back) * 0.06) * height(model);
                starts.push(Similarity::rigid(Mat3::identity(), shift).compose(&pose));
            }
        }
    }
    starts
}

fn middle(points: &[Vec3], axis: usize) -> f64 {
    let values: Vec<f64> = points.iter().map(|p| p[axis]).collect();
    median(&values).unwrap_or(0.0)
}

fn nearest(points: &[Vec3]) -> f64 {
    let values: Vec<f64> = points.iter().map(|p| p.z).collect();
    percentile(&values, 0.97).unwrap_or(0.0)
}

fn score(sample: &[Vec3], pose: &Similarity, index: &PointIndex<3>) -> f64 {
    let placed: Vec<Vec3> = sample.iter().map(|p| pose.apply(p)).collect();
    // A larger scale alone must not make a start look worse.
    trimmed_rms(&placed, index) / pose.scale
}

fn step(
    sample: &[Vec3],
    pose: &Similarity,
    model: &Mesh,
    index: &PointIndex<3>,
    with_scale: bool,
) -> Option<Similarity> {
    let pairs: Vec<(f64, usize, Vec3)> = sample
        .iter()
        .enumerate()
        .filter_map(|(i, p)| {
            let q = pose.apply(p);
            let n = index.nearest(&[q.x, q.y, q.z])?;
            Some((n.distance, i, model.vertices[n.index]))
        })
        .collect();
    let distances: Vec<f64> = pairs.iter().map(|p| p.0).collect();
    let limit = percentile(&distances, 0.85)?;
    let (points, targets): (Vec<Vec3>, Vec<Vec3>) =
        pairs.iter().filter(|p| p.0 <= limit).map(|p| (sample[p.1], p.2)).unzip();
    fit_quaternion(&points, &targets, with_scale)
}
