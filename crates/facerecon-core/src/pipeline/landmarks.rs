//! The stage landmarks with what it is given; marked landmarks take precedence.

use super::measured::Points;
use super::run::Run;
use super::{Error, Params};
use crate::data::{Capture, CloudFrame, MeasuredLandmark, Outline};
use crate::stages::landmarks::{LandmarksInput, find_landmarks};
use crate::stages::rectify::Rectified;

/// Adds the landmarks that are found to the marked ones, and the expected positions of the others.
pub(super) fn find_unmarked(
    run: &Run<'_>,
    capture: &Capture,
    rectified: &Rectified,
    frame: CloudFrame,
    outlines: &[Option<Outline>; 2],
    points: &mut Points,
    params: &Params,
) -> Result<(), Error> {
    if frame == CloudFrame::Model {
        return Ok(());
    }
    let input = LandmarksInput {
        surface: &points.all,
        plain: capture.plain.as_ref().map(|[left, right]| [&left.rgb, &right.rgb]),
        outlines: outlines.each_ref().map(Option::as_ref),
        rectification: &rectified.rectification,
    };
    let found = run.stage("landmarks", |o| find_landmarks(&input, &params.landmarks, o))?;
    let unknown = |known: &[MeasuredLandmark], found: Vec<MeasuredLandmark>| -> Vec<_> {
        found.into_iter().filter(|l| known.iter().all(|k| k.name != l.name)).collect()
    };
    let added = unknown(&points.landmarks, found.landmarks);
    points.landmarks.extend(added);
    points.expected = unknown(&points.landmarks, found.expected);
    Ok(())
}
