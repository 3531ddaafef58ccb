//! The truth of a simulated capture.

use std::collections::BTreeMap;

use crate::camera::StereoRig;
use crate::data::{Capture, LandmarkPairs, Mesh, Pair, Raster, Seeds};
use crate::math::{Similarity, Vec2, Vec3};

/// A dot is marked as a seed only if it is at most this far from its landmark, mm.
const SEED_REACH_MM: f64 = 30.0;

/// One dot of the pattern.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DotTruth {
    /// Column in the pattern, 0 at the left.
    pub column: usize,
    /// Row in the pattern, 0 at the top.
    pub row: usize,
    /// Whether it is on the subject. If not, the following fields are false or NaN.
    pub lit: bool,
    /// Whether it is on the face.
    pub on_face: bool,
    /// Its centre on the subject, left camera frame, mm.
    pub point: Vec3,
    /// Its centre in the left and the right photo, pixels.
    pub pixel: [Vec2; 2],
    /// Whether the left and the right camera see it.
    pub visible: [bool; 2],
}

/// The truth of a simulated capture.
#[derive(Clone, Debug, PartialEq)]
pub struct Truth {
    /// The subject in the frame of the left camera, mm, when the dotted pair was taken.
    pub mesh: Mesh,
    /// From the model frame to [`Truth::mesh`].
    pub camera_from_model: Similarity,
    /// The actual rig, with its deviations from the calibration.
    pub rig: StereoRig,
    /// Depth of the subject at each pixel centre of the left photo, mm; NaN elsewhere.
    pub depth_mm: Raster<f32>,
    /// Whether each of those pixels shows the face (any part of the subject if it has no face mask).
    pub face: Raster<bool>,
    /// All dots of the pattern, row by row.
    pub dots: Vec<DotTruth>,
    /// The landmarks in both photos (pixels), if the subject has landmarks.
    pub landmarks: LandmarkPairs,
    /// The landmarks in space, left camera frame, mm.
    pub landmark_points: BTreeMap<String, Vec3>,
    /// Motion of the head from the dotted pair to the plain pair, left camera frame.
    pub plain_from_dots: Similarity,
}

/// A capture and its truth.
#[derive(Clone, Debug, PartialEq)]
pub struct Simulated {
    /// The photographs and the nominal rig. No landmarks are marked in it.
    pub capture: Capture,
    /// What only the simulator knows.
    pub truth: Truth,
}

impl Truth {
    /// The three dots that the thesis marks by hand (section 2.3): one at the forehead and one at each
    /// ear, all visible to both cameras. `None` if the subject has no landmarks, or if no such dot is
    /// near one of them.
    pub fn seeds(&self) -> Option<Seeds> {
        let near = |names: &[&str]| {
            let points: Vec<&Vec3> =
                names.iter().filter_map(|n| self.landmark_points.get(*n)).collect();
            let target = points.iter().copied().sum::<Vec3>() / points.len().max(1) as f64;
            let candidates = self.dots.iter().filter(|d| d.lit && d.visible == [true; 2]);
            let best = candidates
                .min_by(|a, b| (a.point - target).norm().total_cmp(&(b.point - target).norm()))?;
            (!points.is_empty() && (best.point - target).norm() < SEED_REACH_MM)
                .then_some(Pair { left: best.pixel[0], right: best.pixel[1] })
        };
        Some(Seeds {
            head: near(&["forehead"])?,
            left_ear: near(&["ear_left_upper", "ear_left_lower"])?,
            right_ear: near(&["ear_right_upper", "ear_right_lower"])?,
        })
    }
}
