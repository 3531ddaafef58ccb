//! The 18 landmarks of the thesis (section 6.5.1).

use std::collections::BTreeMap;

use super::Pair;
use crate::math::Vec3;
use crate::settings::nearest_name;

/// Names of the 18 landmarks; left and right are as seen in the picture.
pub const LANDMARKS: [&str; 18] = [
    "eye_left_outer",
    "eye_left_inner",
    "eye_right_inner",
    "eye_right_outer",
    "ear_left_upper",
    "ear_left_lower",
    "ear_right_upper",
    "ear_right_lower",
    "mouth_left",
    "mouth_right",
    "mouth_up",
    "mouth_down",
    "ala_left",
    "ala_right",
    "nose_saddle",
    "nose_tip",
    "chin",
    "forehead",
];

/// Vertex numbers of landmarks on a mesh, by name.
pub type Landmarks = BTreeMap<String, usize>;
/// Positions of landmarks in both photos by name, pixels of the photos.
pub type LandmarkPairs = BTreeMap<String, Pair>;

crate::settings::choices! {
    /// Where the position of a landmark comes from.
    pub enum LandmarkSource {
        /// Marked in both photos by the user.
        Marked = "marked",
        /// Found in the photos and on the measured surface.
        Found = "found",
    }
}

/// Standard deviation of a landmark that was marked by hand in both photos, mm: about half a
/// millimetre across the line of sight, and more along it.
pub const MARKED_LANDMARK_SIGMA_MM: f64 = 1.0;

/// The measured position of one landmark.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredLandmark {
    /// One of [`LANDMARKS`], or a name of the template's own.
    pub name: String,
    /// Position in the frame of the measured points; mm when these are metric.
    pub position: Vec3,
    /// Standard deviation of the position in each direction, in the unit of `position`.
    pub sigma_mm: f64,
    /// Where it comes from.
    pub source: LandmarkSource,
}

/// The message for a name that is none of the 18.
pub(crate) fn unknown_landmark(name: &str) -> String {
    match nearest_name(name, LANDMARKS) {
        Some(near) => format!("unknown landmark {name:?}; did you mean {near}?"),
        None => format!("unknown landmark {name:?}; the 18 names are {}", LANDMARKS.join(", ")),
    }
}
