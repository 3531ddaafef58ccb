//! Iterative closest points with unit quaternions (Besl and McKay 1992; thesis section 3.2).

use rayon::prelude::*;

use super::quaternion::fit_quaternion;
use super::{
    LEAST_POINTS, RegisterError, RegisterInput, RegisterParams, Registration, Termination,
    edge_of_mask, start, trimmed_rms,
};
use crate::data::Mesh;
use crate::math::{Similarity, Vec3, percentile};
use crate::observer::{Event, Observer};
use crate::spatial::PointIndex;

/// Start pose, then the coarse head, then the detailed one.
pub fn register(
    input: &RegisterInput<'_>,
    params: &RegisterParams,
    observer: &dyn Observer,
) -> Result<Registration, RegisterError> {
    // Eq. 2.5 gives points of unknown size the height of the whole head, of which the dots cover a
    // part: without a scale no turn could bring them to the face.
    let params =
        &RegisterParams { scale: params.scale || !input.frame.is_metric(), ..params.clone() };
    let inliers = start::on_the_head(&input.data.points, input.model, input.frame);
    if inliers.len() < LEAST_POINTS {
        return Err(RegisterError::TooFewPoints { got: inliers.len(), needed: LEAST_POINTS });
    }
    let points: Vec<Vec3> = inliers.iter().map(|&i| input.data.points[i]).collect();
    let index = PointIndex::<3>::new(&input.model.vertices).ok_or(RegisterError::Degenerate)?;

    let from_features = params.use_features && input.features.len() >= 3;
    let (first, start_iterations) = if from_features {
        (start::from_features(input.features, params.scale)?, 0)
    } else {
        start::from_shape(input, &points, params.scale)?
    };
    let rms_before = trimmed_rms(&placed(&points, &first), &index);

    let coarse = input.coarse.filter(|_| params.coarse_first);
    let (pose, coarse_iterations) = match coarse {
        Some(mesh) => {
            let run = iterate(&points, mesh, first, params, observer)?;
            (run.pose, run.history.len() - 1)
        }
        None => (first, 0),
    };
    let run = iterate(&points, input.model, pose, params, observer)?;
    Ok(Registration {
        model_from_data: run.pose,
        iterations: start_iterations + coarse_iterations + run.history.len() - 1,
        start_iterations,
        coarse_iterations,
        history: run.history,
        termination: run.termination,
        from_features,
        rms_before,
        rms_after: trimmed_rms(&placed(&points, &run.pose), &index),
        inliers,
    })
}

struct Run {
    pose: Similarity,
    history: Vec<f64>,
    termination: Termination,
}

/// Steps 1 to 4 of thesis section 3.2; the history starts with the error of the start.
fn iterate(
    points: &[Vec3],
    model: &Mesh,
    start: Similarity,
    params: &RegisterParams,
    observer: &dyn Observer,
) -> Result<Run, RegisterError> {
    let index = PointIndex::<3>::new(&model.vertices).ok_or(RegisterError::Degenerate)?;
    let mut pose = start;
    let edge = edge_of_mask(model);
    let find = |pose: &Similarity| closest(points, pose, model, &index, &edge, params.keep);
    let mut pairs = find(&pose);
    let mut history = vec![error(&pairs, &pose)];
    let mut termination = Termination::MaxIterations;
    for k in 1..=params.max_iterations {
        observer.check()?;
        // the registration is always relative to the first position P_0
        let (from, to): (Vec<Vec3>, Vec<Vec3>) = pairs.iter().copied().unzip();
        let next = fit_quaternion(&from, &to, params.scale).ok_or(RegisterError::Degenerate)?;
        let next_pairs = find(&next); // Eq. 3.7 is in here
        let (last, d) = (history[k - 1], error(&next_pairs, &next));
        observer.event(&Event::Iteration { stage: "register", step: k, error: d });
        if d > last && params.keep < 1.0 {
            // only possible when the counted pairs change: the step before was the best
            termination = Termination::Converged;
            break;
        }
        (pose, pairs) = (next, next_pairs);
        history.push(d);
        if last - d < params.tolerance * last {
            termination = Termination::Converged;
            break;
        }
    }
    Ok(Run { pose, history, termination })
}

/// Eq. 3.1: every point (as measured) with its closest vertex, the `keep` closest of them. Points
/// beyond the edge of a mask do not count.
fn closest(
    points: &[Vec3],
    pose: &Similarity,
    model: &Mesh,
    index: &PointIndex<3>,
    edge: &[bool],
    keep: f64,
) -> Vec<(Vec3, Vec3)> {
    let found: Vec<(f64, Vec3, Vec3)> = points
        .par_iter()
        .filter_map(|p| {
            let q = pose.apply(p);
            let n = index.nearest(&[q.x, q.y, q.z])?;
            (!edge[n.index]).then(|| (n.distance, *p, model.vertices[n.index]))
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

fn placed(points: &[Vec3], pose: &Similarity) -> Vec<Vec3> {
    points.iter().map(|p| pose.apply(p)).collect()
}
