//! Registration without landmarks: many starts, trimmed point-to-plane ICP, and a verdict.
//!
//! Point-to-plane (Chen and Medioni 1991) ends within a tenth of a millimetre where point-to-point
//! is still a millimetre off after a hundred steps. Starts that cover turned and tilted heads are
//! ranked by a bounded error, so that hair, collar and wrong matches cannot carry a wrong pose.

use nalgebra::Rotation3;
use rayon::prelude::*;

use crate::data::{Cloud, CloudFrame, Mesh};
use crate::math::{PlanePair, Similarity, Vec3, fit_similarity, fit_to_planes, median};
use crate::observer::{Event, Observer};
use crate::spatial::SurfaceIndex;

use super::start;
use super::{RegisterError, RegisterInput, RegisterParams, Registration, Termination};

crate::settings! {
    /// Robust registration: multi-start, trimmed, point-to-plane.
    pub struct RobustParams {
        /// Heads turned to either side by up to this angle are found.
        yaw_deg: f64 = 40.0, range 0.0..=80.0, unit "deg";
        /// Heads nodding up or down by up to this angle are found.
        pitch_deg: f64 = 20.0, range 0.0..=60.0, unit "deg";
        /// Points used in the last round; the first rounds use fewer.
        points: usize = 1500, range 100.0..=100000.0;
        /// The last round ends when no point moves by more than this in one step.
        tolerance_mm: f64 = 0.03, range 0.0..=10.0, unit "mm";
        /// Refused when a smaller fraction of the points comes to lie near the model.
        min_inliers: f64 = 0.5, range 0.0..=1.0;
    }
}

/// Distances count up to this much; farther points are all equally wrong. mm
const BOUND: f64 = 12.0;
/// Steps from every start, and further steps from the best of them.
const TRIAL: usize = 6;
const RUN_OFF: usize = 14;
/// A normal off by more than 60 degrees is another part of the head.
const NORMAL_GATE: f64 = 0.5;

/// Finds the pose of the data on the model. Metric data are only moved; others are scaled too.
pub(super) fn register(
    input: &RegisterInput<'_>,
    params: &RegisterParams,
    obs: &dyn Observer,
) -> Result<Registration, RegisterError> {
    let (frame, own) = (input.frame, &params.robust);
    let model = ModelSurface::new(input.model).ok_or(RegisterError::Degenerate)?;
    let samples = Sample::all(input.data);
    let plain = plain_start(&samples, &model, frame);
    let sparse = spread(&samples, own.points.min(200));
    let medium = spread(&samples, own.points.min(400));
    let dense = spread(&samples, own.points);
    let features = if params.use_features { input.features } else { &[] };

    // Rounds: every start for a few steps on few points, the best for more on more.
    let all = starts(&samples, plain, features, frame, own);
    let few = best(round(&all, &sparse, &model, TRIAL), 6);
    obs.check()?;
    let winner = best(round(&few, &medium, &model, RUN_OFF), 1);
    let start = *winner.first().ok_or(RegisterError::Degenerate)?;

    // The size found on the way settles the pose of a head larger or smaller than the model; a
    // metric result then keeps its millimetres, and the deformation takes up the size.
    let mut ending = settle(start, &dense, &model, true, params, obs)?;
    if frame.is_metric() && !params.scale {
        let rigid = without_scale(&ending.pose, &dense);
        ending = settle(rigid, &dense, &model, false, params, obs)?;
    }
    let pose = ending.pose;

    // The plain start and the end by one measure: the same points, bounded distances.
    let rms_before = model.score(&dense, &plain).sqrt();
    let rms_after = model.score(&dense, &pose).sqrt();
    let inliers = model.near(input.data, &pose);
    let fraction = inliers.len() as f64 / samples.len().max(1) as f64;
    if fraction < own.min_inliers {
        return Err(RegisterError::NotTheHead {
            inlier_percent: fraction * 100.0,
            expected_percent: own.min_inliers * 100.0,
        });
    }
    Ok(Registration {
        model_from_data: pose,
        iterations: TRIAL + RUN_OFF + ending.history.len(),
        start_iterations: TRIAL + RUN_OFF,
        coarse_iterations: 0,
        history: ending.history,
        termination: ending.termination,
        from_features: false,
        rms_before,
        rms_after,
        inliers,
    })
}

/// The last round of one pose.
struct Ending {
    pose: Similarity,
    /// RMS distance along the normals after each step.
    history: Vec<f64>,
    termination: Termination,
}

fn settle(
    mut pose: Similarity,
    samples: &[Sample],
    model: &ModelSurface,
    with_scale: bool,
    params: &RegisterParams,
    obs: &dyn Observer,
) -> Result<Ending, RegisterError> {
    let mut history = Vec::new();
    for _ in 0..params.max_iterations {
        let pairs = model.pairs(samples, &pose);
        let step = fit_to_planes(&pairs, 0.02, with_scale).ok_or(RegisterError::Degenerate)?;
        let moved = pairs.iter().map(|p| (step.apply(&p.point) - p.point).norm());
        let moved = moved.fold(0.0, f64::max);
        pose = step.compose(&pose);
        let error = plane_rms(&pairs);
        history.push(error);
        obs.event(&Event::Iteration { stage: "register", step: history.len(), error });
        obs.check()?;
        if moved < params.robust.tolerance_mm {
            return Ok(Ending { pose, history, termination: Termination::Converged });
        }
    }
    Ok(Ending { pose, history, termination: Termination::MaxIterations })
}

/// A measured point; the normal is zero where unknown.
#[derive(Clone, Copy)]
struct Sample {
    point: Vec3,
    normal: Vec3,
}

impl Sample {
    fn all(data: &Cloud) -> Vec<Self> {
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

/// `count` samples spread evenly over the list, in a golden-ratio order that no scan order of the
/// points can resonate with.
fn spread(samples: &[Sample], count: usize) -> Vec<Sample> {
    if samples.len() <= count {
        return samples.to_vec();
    }
    let mut picks: Vec<usize> = (0..count)
        .map(|k| ((k as f64 + 0.5) * 0.618_033_988_749_895).fract())
        .map(|t| ((t * samples.len() as f64) as usize).min(samples.len() - 1))
        .collect();
    picks.sort_unstable();
    picks.dedup();
    picks.iter().map(|&i| samples[i]).collect()
}

/// The head looking straight at the camera, middle of the points on the middle of the model's front.
fn plain_start(samples: &[Sample], model: &ModelSurface, frame: CloudFrame) -> Similarity {
    let turn = start::upright(frame).rotation;
    Similarity::rigid(turn, model.front - turn * middle(samples))
}

fn middle(samples: &[Sample]) -> Vec3 {
    let axis = |a: usize| {
        median(&samples.iter().map(|s| s.point[a]).collect::<Vec<_>>()).unwrap_or_default()
    };
    Vec3::new(axis(0), axis(1), axis(2))
}

fn starts(
    samples: &[Sample],
    plain: Similarity,
    features: &[(Vec3, Vec3)],
    frame: CloudFrame,
    params: &RobustParams,
) -> Vec<Similarity> {
    let centre = plain.apply(&middle(samples));
    let mut list = vec![plain];
    let (source, target): (Vec<Vec3>, Vec<Vec3>) = features.iter().copied().unzip();
    list.extend(fit_similarity(&source, &target, &[], !frame.is_metric()));
    for yaw in [-1.0, -0.5, 0.0, 0.5, 1.0] {
        for pitch in [-1.0, 0.0, 1.0] {
            for rise in [-25.0, 15.0] {
                let turn = Rotation3::from_euler_angles(
                    pitch * params.pitch_deg.to_radians(),
                    yaw * params.yaw_deg.to_radians(),
                    0.0,
                );
                let turn = turn.into_inner();
                let shift = centre - turn * centre + Vec3::new(0.0, rise, 0.0);
                list.push(Similarity::rigid(turn, shift).compose(&plain));
            }
        }
    }
    list
}

/// Some steps from each start; bounded error and pose of each, in the order of the starts.
fn round(
    starts: &[Similarity],
    samples: &[Sample],
    model: &ModelSurface,
    steps: usize,
) -> Vec<(f64, Similarity)> {
    starts
        .par_iter()
        .map(|start| {
            let mut pose = *start;
            for k in 0..steps {
                let pairs = model.pairs(samples, &pose);
                // the size only once the pose is roughly right
                let Some(step) = fit_to_planes(&pairs, 0.1, k >= steps / 2) else { break };
                let next = step.compose(&pose);
                if !(0.6..1.6).contains(&(next.scale / start.scale)) {
                    break;
                }
                pose = next;
            }
            (model.score(samples, &pose), pose)
        })
        .collect()
}

fn best(mut poses: Vec<(f64, Similarity)>, count: usize) -> Vec<Similarity> {
    poses.sort_by(|a, b| a.0.total_cmp(&b.0)); // stable: ties keep the order of the starts
    poses.into_iter().take(count).map(|p| p.1).collect()
}

/// The same pose with scale 1, the middle of the points staying where it is.
fn without_scale(pose: &Similarity, samples: &[Sample]) -> Similarity {
    let centre = middle(samples);
    Similarity::rigid(pose.rotation, pose.apply(&centre) - pose.rotation * centre)
}

fn plane_rms(pairs: &[PlanePair]) -> f64 {
    let weight: f64 = pairs.iter().map(|p| p.weight).sum();
    let sum: f64 = pairs.iter().map(|p| p.weight * p.normal.dot(&(p.foot - p.point)).powi(2)).sum();
    (sum / weight.max(1e-300)).sqrt()
}

/// The model's surface with what registration asks of it.
struct ModelSurface {
    index: SurfaceIndex,
    faces: Vec<[u32; 3]>,
    normals: Vec<Vec3>,
    /// Middle of the part that faces the viewer.
    front: Vec3,
}

impl ModelSurface {
    fn new(model: &Mesh) -> Option<Self> {
        let index = SurfaceIndex::new(model)?;
        let normals = model.vertex_normals();
        let facing: Vec<Sample> = model
            .vertices
            .iter()
            .zip(&normals)
            .filter(|(_, n)| n.z > 0.3)
            .map(|(p, n)| Sample { point: *p, normal: *n })
            .collect();
        let front = middle(&facing);
        Some(Self { index, faces: model.faces.clone(), normals, front })
    }

    /// Closest point and smooth normal of each sample in a pose; `None` where normals disagree.
    fn matches(&self, samples: &[Sample], pose: &Similarity) -> Vec<Option<(Vec3, Vec3, Vec3)>> {
        let one = |s: &Sample| {
            let point = pose.apply(&s.point);
            let found = self.index.closest(&point)?;
            let corners = self.faces[found.face];
            let normal: Vec3 =
                (0..3).map(|k| self.normals[corners[k] as usize] * found.barycentric[k]).sum();
            let normal = normal.try_normalize(1e-12)?;
            let other = pose.rotate(&s.normal);
            (other == Vec3::zeros() || other.dot(&normal) > NORMAL_GATE).then_some((
                point,
                found.point,
                normal,
            ))
        };
        samples.par_iter().map(one).collect()
    }

    /// Pairs with Geman-McClure weights whose width follows the middle of the distances.
    fn pairs(&self, samples: &[Sample], pose: &Similarity) -> Vec<PlanePair> {
        let found: Vec<_> = self.matches(samples, pose).into_iter().flatten().collect();
        let distances: Vec<f64> = found.iter().map(|(p, f, _)| (p - f).norm()).collect();
        let width = (2.5 * median(&distances).unwrap_or_default()).clamp(1.0, 60.0);
        found
            .iter()
            .zip(&distances)
            .map(|(&(point, foot, normal), d)| {
                let weight = (1.0 + (d / width).powi(2)).powi(-2);
                PlanePair { point, foot, normal, weight }
            })
            .collect()
    }

    /// Distances; infinite where normals disagree.
    fn distances(&self, samples: &[Sample], pose: &Similarity) -> Vec<f64> {
        let found = self.matches(samples, pose);
        found.iter().map(|m| m.map_or(f64::INFINITY, |(p, f, _)| (p - f).norm())).collect()
    }

    /// Indices of the points within the bound of the model.
    fn near(&self, data: &Cloud, pose: &Similarity) -> Vec<usize> {
        let close = |i: &usize| {
            self.index.closest_within(&pose.apply(&data.points[*i]), BOUND * pose.scale).is_some()
        };
        (0..data.points.len()).into_par_iter().filter(close).collect()
    }

    /// Mean squared bounded distance.
    fn score(&self, samples: &[Sample], pose: &Similarity) -> f64 {
        let distances = self.distances(samples, pose);
        let scale = pose.scale.max(1e-9);
        distances.iter().map(|d| (d / scale).min(BOUND).powi(2)).sum::<f64>()
            / distances.len().max(1) as f64
    }
}

#[cfg(test)]
mod tests;
