//! The 18 named features of the thesis (section 6.5.1).

use std::collections::BTreeMap;

use super::Pair;

/// Names of the 18 features; left and right are as seen in the picture.
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

/// Vertex numbers of features on a mesh, by name.
pub type Landmarks = BTreeMap<String, usize>;
/// Positions of features in both photos, original pixels, by name.
pub type LandmarkPairs = BTreeMap<String, Pair>;
