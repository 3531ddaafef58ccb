//! Iterative closest points with unit quaternions (Besl and McKay 1992; thesis section 3.2).

use rayon::prelude::*;

use super::input::{MIN_POINTS, RegisterInput};
use super::mask::outside_head;
use super::quaternion::fit_quaternion;
use super::registration::Registration;
use super::residual::trimmed_rms;
use super::start;
use super::{RegisterError, RegisterParams};
use crate::data::Mesh;
use crate::math::{Similarity, Vec3, percentile};
use crate::observer::{Event, Observer};
use crate::spatial::{IcpIteration, IcpStep, PointIndex, Termination, iterate_closest_points};

/// Fewest landmarks that determine a pose.
const MIN_LANDMARKS: usize = 3;

/// Start pose, then the coarse head, then the detailed one.
pub fn register(
    input: &RegisterInput<'_>,
    params: &RegisterParams,
    observer: &dyn Observer,
) -> Result<Registration, RegisterError> {
    // Eq. 2.5 gives points of unknown size the height of the whole head, but the dots cover a part
    // of it: without a scale no pose would fit.
    let params =
        &RegisterParams { scale: params.scale || !input.frame.is_metric(), ..params.clone() };
    let inliers = start::points_on_head(&input.data.points, input.model, input.frame);
    if inliers.len() < MIN_POINTS {
        return Err(RegisterError::TooFewPoints { got: inliers.len(), needed: MIN_POINTS });
    }
    let points: Vec<Vec3> = inliers.iter().map(|&i| input.data.points[i]).collect();
    let index = PointIndex::<3>::new(&input.model.vertices).ok_or(RegisterError::Degenerate)?;

    let from_landmarks = params.use_landmarks && input.landmarks.len() >= MIN_LANDMARKS;
    let (first, start_iterations) = if from_landmarks {
        (start::pose_from_landmarks(input.landmarks, params.scale)?, 0)
    } else {
        start::pose_from_shape(input, &points, params.scale)?
    };
    let rms_before = trimmed_rms(&transformed(&points, &first), &index);

    let coarse = input.coarse.filter(|_| params.coarse_first);
    let (pose, coarse_iterations) = match coarse {
        Some(mesh) => {
            let run = iterate(&points, mesh, first, input, params, observer)?;
            (run.pose, run.history.len() - 1)
        }
        None => (first, 0),
    };
    let run = iterate(&points, input.model, pose, input, params, observer)?;
    Ok(Registration {
        model_from_data: run.pose,
        iterations: start_iterations + coarse_iterations + run.history.len() - 1,
        start_iterations,
        coarse_iterations,
        history: run.history,
        termination: run.termination,
        from_landmarks,
        rms_before,
        rms_after: trimmed_rms(&transformed(&points, &run.pose), &index),
        inliers,
    })
}

struct Run {
    pose: Similarity,
    /// Eq. 3.8 at the start and after each step that was kept.
    history: Vec<f64>,
    termination: Termination,
}

/// Steps 1 to 4 of thesis section 3.2.
fn iterate(
    points: &[Vec3],
    model: &Mesh,
    start: Similarity,
    input: &RegisterInput<'_>,
    params: &RegisterParams,
    observer: &dyn Observer,
) -> Result<Run, RegisterError> {
    let index = PointIndex::<3>::new(&model.vertices).ok_or(RegisterError::Degenerate)?;
    let outside = outside_head(model, input.chin_y);
    let find_pairs =
        |pose: &Similarity| closest_vertices(points, pose, model, &index, &outside, params.keep);
    let mut history = Vec::new();
    let max_iterations = params.max_iterations;
    let step = |iteration: &IcpIteration<'_, Vec<(Vec3, Vec3)>>| -> Result<_, RegisterError> {
        observer.check()?;
        // the registration is always relative to the first position P_0
        let (from, to): (Vec<Vec3>, Vec<Vec3>) = iteration.pairs.iter().copied().unzip();
        let next = fit_quaternion(&from, &to, params.scale).ok_or(RegisterError::Degenerate)?;
        let next_pairs = find_pairs(&next); // Eq. 3.7 is in here
        if history.is_empty() {
            history.push(error(iteration.pairs, iteration.pose));
        }
        let (last, d) = (history[iteration.number - 1], error(&next_pairs, &next));
        observer.event(&Event::Iteration { stage: "register", step: iteration.number, error: d });
        if d > last && params.keep < 1.0 {
            // only possible when the kept pairs change: the pose before was the best
            return Ok(Some(IcpStep { pose: *iteration.pose, pairs: None, converged: true }));
        }
        history.push(d);
        let converged = last - d < params.tolerance * last;
        Ok(Some(IcpStep { pose: next, pairs: Some(next_pairs), converged }))
    };
    let icp = iterate_closest_points(start, max_iterations, find_pairs, step)?;
    Ok(Run { pose: icp.pose, history, termination: icp.termination })
}

/// Eq. 3.1: every point (as measured) with its closest vertex; the fraction `keep` of the pairs that
/// are closest. Points closest to a vertex `outside` the head are left out.
fn closest_vertices(
    points: &[Vec3],
    pose: &Similarity,
    model: &Mesh,
    index: &PointIndex<3>,
    outside: &[bool],
    keep: f64,
) -> Vec<(Vec3, Vec3)> {
    let found: Vec<(f64, Vec3, Vec3)> = points
        .par_iter()
        .filter_map(|p| {
            let q = pose.apply(p);
            let n = index.nearest(&[q.x, q.y, q.z])?;
            (!outside[n.index]).then(|| (n.distance, *p, model.vertices[n.index]))
        })
        .collect();
    let distances: Vec<f64> = found.iter().map(|f| f.0).collect();
    let limit = if keep < 1.0 { percentile(&distances, keep) } else { None };
    let limit = limit.unwrap_or(f64::INFINITY);
    found.into_iter().filter(|f| f.0 <= limit).map(|(_, p, x)| (p, x)).collect()
}

/// Eq. 3.8.
fn error(pairs: &[(Vec3, Vec3)], pose: &Similarity) -> f64 {
    pairs.iter().map(|(p, x)| (pose.apply(p) - x).norm_squared()).sum::<f64>().sqrt()
}

fn transformed(points: &[Vec3], pose: &Similarity) -> Vec<Vec3> {
    points.iter().map(|p| pose.apply(p)).collect()
}
