//! Registration without landmarks: robust point-to-plane ICP from many starts.
//!
//! Point-to-plane (Chen and Medioni 1991) ends within a tenth of a millimetre where point-to-point
//! is still a millimetre off after a hundred steps. The starts cover turned and tilted heads and are
//! ranked by a bounded error, so that hair, collar and wrong matches do not favour a wrong pose.

mod model_surface;
mod samples;
mod starts;

use std::convert::Infallible;

use rayon::prelude::*;

use crate::math::{PlanePair, Similarity, Vec3, fit_to_planes, plane_rms};
use crate::observer::{Event, Observer};
use crate::spatial::{IcpIteration, IcpStep, Termination, iterate_closest_points};

use super::input::RegisterInput;
use super::registration::Registration;
use super::start::pose_from_landmarks;
use super::{RegisterError, RegisterParams};
use model_surface::ModelSurface;
use samples::{Sample, median_position, spread_samples};
use starts::{frontal_start, starts};

crate::settings::settings! {
    /// Robust registration: point-to-plane ICP from many starts.
    pub struct RobustParams {
        /// Heads turned to either side by up to this angle are found.
        yaw_deg: f64 = 40.0, range 0.0..=80.0, unit "deg";
        /// Heads tilted up or down by up to this angle are found.
        pitch_deg: f64 = 20.0, range 0.0..=60.0, unit "deg";
        /// Points used in the last round; the first rounds use fewer.
        points: usize = 1500, range 100.0..=100000.0;
        /// The last round ends when no point moves by more than this in one step.
        tolerance_mm: f64 = 0.03, range 0.0..=10.0, unit "mm";
        /// The registration is rejected when a smaller fraction of the points is near the model.
        min_inliers: f64 = 0.5, range 0.0..=1.0;
    }
}

/// Steps from every start, and further steps from the best of them. Fewer are faster,
/// but rank the starts less reliably.
const TRIAL_STEPS: usize = 6;
const FURTHER_STEPS: usize = 14;
/// Points of these steps.
const TRIAL_POINTS: usize = 200;
const FURTHER_POINTS: usize = 400;
/// How many of the best starts are continued.
const FINALISTS: usize = 6;
/// Weight of the distance to the closest point relative to that to its plane, in the first rounds
/// (far from the pose, sliding must be prevented) and in the last.
const EARLY_POINT_WEIGHT: f64 = 0.1;
const POINT_WEIGHT: f64 = 0.02;
/// With so many landmarks the pose is theirs: one that is wrong is outvoted.
const ENOUGH_LANDMARKS: usize = 6;
/// A start is abandoned when its scale changes by more than this: it shrinks the data to a spot or
/// spreads them over the whole head.
const SCALE_RANGE: std::ops::Range<f64> = 0.6..1.6;

/// Finds the pose of the data on the model. Metric data are only moved; others are scaled too.
pub(super) fn register(
    input: &RegisterInput<'_>,
    params: &RegisterParams,
    observer: &dyn Observer,
) -> Result<Registration, RegisterError> {
    let (frame, own) = (input.frame, &params.robust);
    let model = ModelSurface::new(input.model).ok_or(RegisterError::Degenerate)?;
    let samples = Sample::from_cloud(input.data);
    let frontal = frontal_start(&samples, model.front, frame);
    let dense = spread_samples(&samples, own.points);
    let keeps_scale = frame.is_metric() && !params.scale;
    let from_landmarks = params.use_landmarks && input.landmarks.len() >= ENOUGH_LANDMARKS;
    let (trial_steps, last) = if from_landmarks {
        // The distance from the surface hardly changes when a face slides over a head: landmarks
        // that determine the pose are not outvoted by it.
        let pose = pose_from_landmarks(input.landmarks, true)?;
        let pose = if keeps_scale { about_landmarks(&pose, input.landmarks) } else { pose };
        (0, LastRound { pose, history: Vec::new(), termination: Termination::Converged })
    } else {
        let start = best_start(input, &samples, &model, frontal, params, observer)?;
        // With scale first: a head larger or smaller than the model then finds its pose. Metric
        // data keep their millimetres afterwards, and the deformation changes the head's size.
        let mut last = refine(start, &dense, &model, true, params, observer)?;
        if keeps_scale {
            let rigid = without_scale(&last.pose, &dense);
            last = refine(rigid, &dense, &model, false, params, observer)?;
        }
        (TRIAL_STEPS + FURTHER_STEPS, last)
    };

    let inliers = model.near(&input.data.points, &last.pose);
    let fraction = inliers.len() as f64 / samples.len().max(1) as f64;
    if fraction < own.min_inliers {
        return Err(RegisterError::NotTheHead {
            inlier_percent: fraction * 100.0,
            expected_percent: own.min_inliers * 100.0,
        });
    }
    Ok(Registration {
        model_from_data: last.pose,
        iterations: trial_steps + last.history.len(),
        start_iterations: trial_steps,
        coarse_iterations: 0,
        history: last.history,
        termination: last.termination,
        from_landmarks,
        rms_before: model.bounded_error(&dense, &frontal).sqrt(),
        rms_after: model.bounded_error(&dense, &last.pose).sqrt(),
        inliers,
    })
}

/// Every start for a few steps on few points, the best ones for more steps on more points.
fn best_start(
    input: &RegisterInput<'_>,
    samples: &[Sample],
    model: &ModelSurface,
    frontal: Similarity,
    params: &RegisterParams,
    observer: &dyn Observer,
) -> Result<Similarity, RegisterError> {
    let own = &params.robust;
    let sparse = spread_samples(samples, own.points.min(TRIAL_POINTS));
    let medium = spread_samples(samples, own.points.min(FURTHER_POINTS));
    let landmarks = if params.use_landmarks { input.landmarks } else { &[] };
    let all = starts(samples, frontal, landmarks, input.frame, own);
    let few = best(run_round(&all, &sparse, model, TRIAL_STEPS), FINALISTS);
    observer.check()?;
    let winner = best(run_round(&few, &medium, model, FURTHER_STEPS), 1);
    winner.first().copied().ok_or(RegisterError::Degenerate)
}

/// Some steps from each start; bounded error and pose of each, in the order of the starts.
fn run_round(
    starts: &[Similarity],
    samples: &[Sample],
    model: &ModelSurface,
    steps: usize,
) -> Vec<(f64, Similarity)> {
    let one = |start: &Similarity| {
        let find_pairs = |pose: &Similarity| model.pairs(samples, pose);
        let step = |iteration: &IcpIteration<'_, Vec<PlanePair>>| {
            // the scale only when the pose is roughly right
            let with_scale = iteration.number > steps / 2;
            let step = fit_to_planes(iteration.pairs, EARLY_POINT_WEIGHT, with_scale);
            let next = step.map(|step| step.compose(iteration.pose));
            let plausible = next.filter(|pose| SCALE_RANGE.contains(&(pose.scale / start.scale)));
            Ok::<_, Infallible>(plausible.map(|pose| IcpStep {
                pose,
                pairs: None,
                converged: false,
            }))
        };
        let Ok(icp) = iterate_closest_points(*start, steps, find_pairs, step);
        (model.bounded_error(samples, &icp.pose), icp.pose)
    };
    starts.par_iter().map(one).collect()
}

fn best(mut poses: Vec<(f64, Similarity)>, count: usize) -> Vec<Similarity> {
    poses.sort_by(|a, b| a.0.total_cmp(&b.0)); // stable: ties keep the order of the starts
    poses.into_iter().take(count).map(|p| p.1).collect()
}

/// The last round.
struct LastRound {
    pose: Similarity,
    /// RMS distance along the normals before each step.
    history: Vec<f64>,
    termination: Termination,
}

/// Iterates one pose until no point moves any more.
fn refine(
    start: Similarity,
    samples: &[Sample],
    model: &ModelSurface,
    with_scale: bool,
    params: &RegisterParams,
    observer: &dyn Observer,
) -> Result<LastRound, RegisterError> {
    let mut history = Vec::new();
    let find_pairs = |pose: &Similarity| model.pairs(samples, pose);
    let step = |iteration: &IcpIteration<'_, Vec<PlanePair>>| -> Result<_, RegisterError> {
        let pairs = iteration.pairs;
        let step =
            fit_to_planes(pairs, POINT_WEIGHT, with_scale).ok_or(RegisterError::Degenerate)?;
        let moved = pairs.iter().map(|p| (step.apply(&p.point) - p.point).norm());
        let converged = moved.fold(0.0, f64::max) < params.robust.tolerance_mm;
        let error = plane_rms(pairs);
        history.push(error);
        observer.event(&Event::Iteration { stage: "register", step: history.len(), error });
        observer.check()?;
        Ok(Some(IcpStep { pose: step.compose(iteration.pose), pairs: None, converged }))
    };
    let icp = iterate_closest_points(start, params.max_iterations, find_pairs, step)?;
    Ok(LastRound { pose: icp.pose, history, termination: icp.termination })
}

/// The same pose with scale 1; the centre of the landmarks stays where it is.
fn about_landmarks(pose: &Similarity, landmarks: &[(Vec3, Vec3)]) -> Similarity {
    let centre = landmarks.iter().map(|l| l.0).sum::<Vec3>() / landmarks.len().max(1) as f64;
    Similarity::rigid(pose.rotation, pose.apply(&centre) - pose.rotation * centre)
}

/// The same pose with scale 1; the median position of the points stays where it is.
fn without_scale(pose: &Similarity, samples: &[Sample]) -> Similarity {
    let centre = median_position(samples);
    Similarity::rigid(pose.rotation, pose.apply(&centre) - pose.rotation * centre)
}

#[cfg(test)]
mod tests;
