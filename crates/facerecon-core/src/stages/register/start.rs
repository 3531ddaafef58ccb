//! The start of the iteration: which points belong to the head, and a first pose.

use std::convert::Infallible;

use nalgebra::Rotation3;
use rayon::prelude::*;

use super::RegisterError;
use super::input::RegisterInput;
use super::mask::height;
use super::quaternion::fit_quaternion;
use super::residual::trimmed_rms;
use crate::data::{CloudFrame, Mesh};
use crate::math::{Mat3, Similarity, Vec3, median, percentile};
use crate::spatial::{IcpStep, PointIndex, iterate_closest_points};

/// Points used for trying starts.
const SAMPLE: usize = 250;
/// How many of the best starts are refined, and the steps of each.
const FINALISTS: usize = 6;
const STEPS: usize = 8;
/// Share of the pairs that counts in these steps, the closest ones.
const COUNTED_SHARE: f64 = 0.85;
/// Quantile of the depths at which the face begins. A wall may have more dots than the face, but it
/// is behind it; the nearest few points may be wrong matches.
const FRONT_QUANTILE: f64 = 0.98;
/// Quantile of the depths at which the front of the points, or of the model, lies for a start.
const NEAR_QUANTILE: f64 = 0.97;
/// Points farther behind the front than this are on a wall, in depths of the head.
const HEAD_DEPTHS: f64 = 1.1;
/// Greatest RMS residual of landmarks that fit the head, relative to their RMS distance from their
/// centre. Landmarks of another head must pass, exchanged left and right ones must not.
const MAX_LANDMARK_RESIDUAL: f64 = 0.35;
/// Starts: rotations about the vertical, and steps up and in depth relative to the model's height.
const YAWS_DEG: [f64; 3] = [0.0, -25.0, 25.0];
const UP_STEP: f64 = 0.07;
const DEPTH_STEP: f64 = 0.06;
/// Vertices whose normal has at least this component toward the viewer are the model's front.
const FRONT_COSINE: f64 = 0.2;

/// Rotates camera axes (y down, z forward) to model axes (y up, z toward the viewer).
pub fn model_axes_from_data(frame: CloudFrame) -> Similarity {
    let axes = match frame {
        CloudFrame::Metric | CloudFrame::Camera => Vec3::new(1.0, -1.0, -1.0),
        CloudFrame::Model => Vec3::repeat(1.0),
    };
    Similarity::rigid(Mat3::from_diagonal(&axes), Vec3::zeros())
}

/// Indices of the points no farther behind the front of the face than the head is deep: farther
/// points are on the wall.
pub fn points_on_head(points: &[Vec3], model: &Mesh, frame: CloudFrame) -> Vec<usize> {
    let depth = model.bounds().map_or(0.0, |(low, high)| high.z - low.z);
    let z: Vec<f64> = points.iter().map(|p| model_axes_from_data(frame).apply(p).z).collect();
    let front = percentile(&z, FRONT_QUANTILE).unwrap_or(0.0);
    let limit = if frame.is_metric() { front - HEAD_DEPTHS * depth } else { f64::NEG_INFINITY };
    (0..points.len()).filter(|&i| z[i] >= limit).collect()
}

/// The pose from landmarks as `(measured, on the model)`, by the solver of the steps.
///
/// # Errors
/// [`RegisterError::Landmarks`] when they do not fit the model, [`RegisterError::Degenerate`] when
/// they lie on one line.
pub fn pose_from_landmarks(
    landmarks: &[(Vec3, Vec3)],
    with_scale: bool,
) -> Result<Similarity, RegisterError> {
    let (data, model): (Vec<Vec3>, Vec<Vec3>) = landmarks.iter().copied().unzip();
    let pose = fit_quaternion(&data, &model, with_scale).ok_or(RegisterError::Degenerate)?;
    let residuals: Vec<f64> = landmarks.iter().map(|(d, m)| (pose.apply(d) - m).norm()).collect();
    let rms = (residuals.iter().map(|d| d * d).sum::<f64>() / residuals.len() as f64).sqrt();
    let centre = model.iter().sum::<Vec3>() / model.len() as f64;
    let spread = (model.iter().map(|m| (m - centre).norm_squared()).sum::<f64>()
        / model.len() as f64)
        .sqrt();
    let limit = MAX_LANDMARK_RESIDUAL * spread;
    if !(rms <= limit) {
        let worst = (0..residuals.len()).max_by(|&a, &b| residuals[a].total_cmp(&residuals[b]));
        return Err(RegisterError::Landmarks { rms, limit, worst: worst.unwrap_or(0) });
    }
    Ok(pose)
}

/// A first pose without landmarks: the front of the points on the front of the model, at several
/// heights, depths and rotations; the start with the smallest distance after a few steps on a sample
/// wins. Returns it with the number of steps taken.
///
/// # Errors
/// [`RegisterError::Degenerate`] when there is no start.
pub fn pose_from_shape(
    input: &RegisterInput<'_>,
    points: &[Vec3],
    with_scale: bool,
) -> Result<(Similarity, usize), RegisterError> {
    let model = input.coarse.unwrap_or(input.model);
    let index = PointIndex::<3>::new(&model.vertices).ok_or(RegisterError::Degenerate)?;
    let stride = points.len().div_ceil(SAMPLE).max(1);
    let sample: Vec<Vec3> = points.iter().step_by(stride).copied().collect();
    let starts = starts(model, &sample, model_axes_from_data(input.frame));
    let mut ranked: Vec<(f64, usize)> =
        starts.par_iter().enumerate().map(|(i, s)| (distance(&sample, s, &index), i)).collect();
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    // The closest start is often in a local minimum: a few steps show which one leads to the head.
    let refined: Vec<(f64, Similarity)> = ranked
        .iter()
        .take(FINALISTS)
        .map(|&(_, i)| {
            let pose = stepped(&sample, starts[i], model, &index, with_scale);
            (distance(&sample, &pose, &index), starts[i])
        })
        .collect();
    let steps = refined.len() * STEPS;
    refined
        .into_iter()
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, pose)| (pose, steps))
        .ok_or(RegisterError::Degenerate)
}

fn starts(model: &Mesh, sample: &[Vec3], model_from_data: Similarity) -> Vec<Similarity> {
    let normals = model.vertex_normals();
    let front: Vec<Vec3> = model
        .vertices
        .iter()
        .zip(&normals)
        .filter(|(_, n)| n.z > FRONT_COSINE)
        .map(|(v, _)| *v)
        .collect();
    let front = if front.is_empty() { &model.vertices } else { &front };
    let mut starts = Vec::new();
    for yaw_deg in YAWS_DEG {
        let turn = Similarity::rigid(
            Rotation3::from_axis_angle(&Vec3::y_axis(), yaw_deg.to_radians()).into_inner(),
            Vec3::zeros(),
        );
        let pose = turn.compose(&model_from_data);
        let turned: Vec<Vec3> = sample.iter().map(|p| pose.apply(p)).collect();
        let base = Vec3::new(
            median_coordinate(front, 0) - median_coordinate(&turned, 0),
            median_coordinate(front, 1) - median_coordinate(&turned, 1),
            front_depth(front) - front_depth(&turned),
        );
        for up in -4..=4 {
            for back in -1..=1 {
                let steps = Vec3::new(0.0, f64::from(up) * UP_STEP, f64::from(back) * DEPTH_STEP);
                let shift = base + steps * height(model);
                starts.push(Similarity::rigid(Mat3::identity(), shift).compose(&pose));
            }
        }
    }
    starts
}

fn median_coordinate(points: &[Vec3], axis: usize) -> f64 {
    let values: Vec<f64> = points.iter().map(|p| p[axis]).collect();
    median(&values).unwrap_or(0.0)
}

fn front_depth(points: &[Vec3]) -> f64 {
    let values: Vec<f64> = points.iter().map(|p| p.z).collect();
    percentile(&values, NEAR_QUANTILE).unwrap_or(0.0)
}

/// Typical distance of the sample from the model under a pose, in the unit of the sample: a larger
/// scale alone does not make a start worse.
fn distance(sample: &[Vec3], pose: &Similarity, index: &PointIndex<3>) -> f64 {
    let moved: Vec<Vec3> = sample.iter().map(|p| pose.apply(p)).collect();
    trimmed_rms(&moved, index) / pose.scale
}

/// The pose after a few steps with the closest of the pairs.
fn stepped(
    sample: &[Vec3],
    start: Similarity,
    model: &Mesh,
    index: &PointIndex<3>,
    with_scale: bool,
) -> Similarity {
    let find_pairs = |pose: &Similarity| -> (Vec<Vec3>, Vec<Vec3>) {
        let pairs: Vec<(f64, Vec3, Vec3)> = sample
            .iter()
            .filter_map(|p| {
                let q = pose.apply(p);
                let n = index.nearest(&[q.x, q.y, q.z])?;
                Some((n.distance, *p, model.vertices[n.index]))
            })
            .collect();
        let distances: Vec<f64> = pairs.iter().map(|p| p.0).collect();
        let limit = percentile(&distances, COUNTED_SHARE).unwrap_or(0.0);
        pairs.iter().filter(|p| p.0 <= limit).map(|p| (p.1, p.2)).unzip()
    };
    let Ok(icp) = iterate_closest_points(start, STEPS, find_pairs, |iteration| {
        let (points, targets) = iteration.pairs;
        let pose = fit_quaternion(points, targets, with_scale);
        Ok::<_, Infallible>(pose.map(|pose| IcpStep { pose, pairs: None, converged: false }))
    });
    icp.pose
}
