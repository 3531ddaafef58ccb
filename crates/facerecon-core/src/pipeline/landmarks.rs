//! The stage landmarks with what it is given; marked landmarks take precedence.

use super::measured::Points;
use super::run::Run;
use super::{Error, Params};
use crate::data::{Capture, CloudFrame, MeasuredLandmark, Outline};
use crate::stages::landmarks::{CoveredEyes, LandmarksInput, find_landmarks};
use crate::stages::rectify::Rectified;

/// Adds the landmarks that are found to the marked ones, and the expected positions of the others.
/// Returns what covers the eyes.
pub(super) fn find_unmarked(
    run: &Run<'_>,
    capture: &Capture,
    rectified: &Rectified,
    frame: CloudFrame,
    outlines: &[Option<Outline>; 2],
    points: &mut Points,
    params: &Params,
) -> Result<Option<CoveredEyes>, Error> {
    if frame == CloudFrame::Model {
        return Ok(None);
    }
    let input = LandmarksInput {
        surface: &points.all,
        plain: capture.plain.as_ref().map(|[left, right]| [&left.rgb, &right.rgb]),
        outlines: outlines.each_ref().map(Option::as_ref),
        rectification: &rectified.rectification,
    };
    let mut found = run.stage("landmarks", |o| find_landmarks(&input, &params.landmarks, o))?;
    let covers = found.head_from_camera.and_then(|h| CoveredEyes::find(&points.dots, &h));
    if let Some(covers) = &covers {
        // what was found there is on the cover, or seen through it
        let is_covered = |name: &str| {
            let side = |k: usize, prefix: &str| covers.is_covered(k) && name.starts_with(prefix);
            side(0, "eye_left") || side(1, "eye_right")
        };
        found.landmarks.retain(|l| !is_covered(&l.name));
    }
    let unknown = |known: &[MeasuredLandmark], found: Vec<MeasuredLandmark>| -> Vec<_> {
        found.into_iter().filter(|l| known.iter().all(|k| k.name != l.name)).collect()
    };
    let added = unknown(&points.landmarks, found.landmarks);
    points.landmarks.extend(added);
    points.expected = unknown(&points.landmarks, found.expected);
    Ok(covers)
}
