//! What a run measured, before any shape is fitted to it.

use crate::camera::{Pinhole, RectifiedRig};
use crate::data::{Cloud, CloudFrame, Match, MeasuredLandmark, Outline};
use crate::math::Similarity;
use crate::stages::refine::Refined;

/// What was measured: the input of the surface.
pub(super) struct Measured<'a> {
    pub(super) matches: &'a [Match],
    pub(super) dense: Option<&'a Refined>,
    /// Where points lie in the camera's frame.
    pub(super) rig: Option<&'a RectifiedRig>,
    /// Matches and marked features, which set the scale where they do not.
    pub(super) all_matches: &'a [Match],
    /// Frame of the points.
    pub(super) frame: CloudFrame,
}

/// The points of a run: those of the matches, those of the marked features, and all measured.
pub(super) struct Points {
    /// One for each match.
    pub(super) dots: Cloud,
    /// All that were measured: the dense surface where there is one, else the dots.
    pub(super) all: Cloud,
    /// Landmarks with measured positions.
    pub(super) landmarks: Vec<MeasuredLandmark>,
    /// Expected positions of landmarks that were not measured; they only guide the deformation.
    pub(super) expected: Vec<MeasuredLandmark>,
    /// The subject's outlines in the plain photos, where they were found.
    pub(super) outlines: Vec<CameraOutline>,
}

/// The subject's outline in one photo with the photo's camera.
pub(super) struct CameraOutline {
    pub(super) camera: Pinhole,
    /// From the frame of the points.
    pub(super) camera_from_points: Similarity,
    pub(super) outline: Outline,
}
