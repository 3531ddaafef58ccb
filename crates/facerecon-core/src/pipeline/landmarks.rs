//! The stage landmarks with what it is given; marked landmarks take precedence.

use super::measured::Points;
use super::run::Run;
use super::{Error, Params};
use crate::data::{Capture, CloudFrame, MeasuredLandmark};
use crate::stages::landmarks::{LandmarksInput, find_landmarks};
use crate::stages::rectify::Rectified;

/// The landmarks of a run.
pub(super) struct Landmarks {
    /// Marked and found.
    pub(super) measured: Vec<MeasuredLandmark>,
    /// Expected positions of others, which are not measurements.
    pub(super) expected: Vec<MeasuredLandmark>,
}

/// The marked landmarks, and those that are found of the others.
pub(super) fn with_found(
    run: &Run<'_>,
    capture: &Capture,
    rectified: &Rectified,
    points: &Points,
    frame: CloudFrame,
    params: &Params,
) -> Result<Landmarks, Error> {
    let mut measured = points.landmarks.clone();
    if frame == CloudFrame::Model {
        return Ok(Landmarks { measured, expected: Vec::new() });
    }
    let input = LandmarksInput {
        surface: &points.all,
        plain: capture.plain.as_ref().map(|[left, right]| [&left.rgb, &right.rgb]),
        rectification: &rectified.rectification,
    };
    let found = run.stage("landmarks", |o| find_landmarks(&input, &params.landmarks, o))?;
    for landmark in found.landmarks {
        if measured.iter().all(|l| l.name != landmark.name) {
            measured.push(landmark);
        }
    }
    let missing = |l: &MeasuredLandmark| measured.iter().all(|m| m.name != l.name);
    let expected = found.expected.into_iter().filter(missing).collect();
    Ok(Landmarks { measured, expected })
}
