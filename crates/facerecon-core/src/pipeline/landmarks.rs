//! The stage landmarks with what it is given; marked landmarks take precedence.

use super::measured::Points;
use super::run::Run;
use super::{Error, Params};
use crate::data::{Capture, CloudFrame, MeasuredLandmark};
use crate::stages::landmarks::{LandmarksInput, find_landmarks};
use crate::stages::rectify::Rectified;

/// The marked landmarks, and those that are found of the others.
pub(super) fn with_found(
    run: &Run<'_>,
    capture: &Capture,
    rectified: &Rectified,
    points: &Points,
    frame: CloudFrame,
    params: &Params,
) -> Result<Vec<MeasuredLandmark>, Error> {
    let mut landmarks = points.landmarks.clone();
    if frame == CloudFrame::Model {
        return Ok(landmarks);
    }
    let input = LandmarksInput {
        surface: &points.all,
        plain: capture.plain.as_ref().map(|[left, right]| [&left.rgb, &right.rgb]),
        rectification: &rectified.rectification,
    };
    let found = run.stage("landmarks", |o| find_landmarks(&input, &params.landmarks, o))?;
    for landmark in found.landmarks {
        if landmarks.iter().all(|l| l.name != landmark.name) {
            landmarks.push(landmark);
        }
    }
    Ok(landmarks)
}
