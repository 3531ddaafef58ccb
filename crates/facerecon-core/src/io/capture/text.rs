//! The text of `capture.toml`: its structure, unknown names, and the template for a new one.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::Deserialize;

use super::{Fault, line_of};
use crate::data::LANDMARKS;
use crate::io::source::nearest_name;

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct CaptureText {
    pub images: Option<ImagesText>,
    pub pattern: Option<PatternText>,
    pub rig: Option<RigText>,
    pub seeds: Option<SeedsText>,
    pub landmarks: BTreeMap<String, PairText>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct ImagesText {
    pub left: Option<PathBuf>,
    pub right: Option<PathBuf>,
    #[serde(alias = "left_texture")]
    pub left_plain: Option<PathBuf>,
    #[serde(alias = "right_texture")]
    pub right_plain: Option<PathBuf>,
    pub extra: Vec<ExtraText>,
}

#[derive(Debug, Deserialize)]
pub(super) struct ExtraText {
    pub image: PathBuf,
    #[serde(rename = "K")]
    pub k: [[f64; 3]; 3],
    #[serde(rename = "D", default)]
    pub d: Vec<f64>,
    #[serde(rename = "R")]
    pub r: [[f64; 3]; 3],
    #[serde(rename = "T")]
    pub t: [f64; 3],
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct PatternText {
    pub kind: Option<String>,
    pub columns: Option<usize>,
    pub rows: Option<usize>,
    pub rotation_deg: Option<f64>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct RigText {
    pub calibration: Option<PathBuf>,
    pub baseline_mm: Option<f64>,
    pub focal_px: Option<f64>,
    pub principal_left: Option<[f64; 2]>,
    pub principal_right: Option<[f64; 2]>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct SeedsText {
    pub head: Option<PairText>,
    pub left_ear: Option<PairText>,
    pub right_ear: Option<PairText>,
}

#[derive(Debug, Deserialize)]
pub(super) struct PairText {
    pub left: [f64; 2],
    pub right: [f64; 2],
}

/// The names each table may have.
const KNOWN: [(&str, &[&str]); 5] = [
    ("", &["images", "pattern", "rig", "seeds", "landmarks"]),
    ("images", &["left", "right", "left_plain", "right_plain", "extra"]),
    ("pattern", &["kind", "columns", "rows", "rotation_deg"]),
    ("rig", &["calibration", "baseline_mm", "focal_px", "principal_left", "principal_right"]),
    ("seeds", &["head", "left_ear", "right_ear"]),
];

/// Earlier names of keys; files that use them are read without a warning.
const EARLIER: [&str; 2] = ["left_texture", "right_texture"];

/// Reads the text; each unknown key gives a warning.
pub(super) fn parse(text: &str) -> Result<(CaptureText, Vec<String>), Fault> {
    let fault = |e: toml::de::Error| Fault {
        line: e.span().map(|s| line_of(text, s.start)),
        message: format!("the capture file is not right: {}", e.message()),
    };
    let capture: CaptureText = toml::from_str(text).map_err(fault)?;
    let table: toml::Table = toml::from_str(text).map_err(fault)?;
    let mut warnings = Vec::new();
    for (name, known) in KNOWN {
        let inner = if name.is_empty() {
            Some(&table)
        } else {
            table.get(name).and_then(toml::Value::as_table)
        };
        for key in inner.into_iter().flat_map(toml::Table::keys) {
            let earlier = name == "images" && EARLIER.contains(&key.as_str());
            if !known.contains(&key.as_str()) && !earlier {
                let place = if name.is_empty() { String::new() } else { format!("[{name}] ") };
                let near = nearest_name(key, known.iter().copied())
                    .map_or(String::new(), |n| format!("; did you mean {n}?"));
                warnings.push(format!("{place}{key}: unknown key, ignored{near}"));
            }
        }
    }
    Ok((capture, warnings))
}

/// The commented `capture.toml` that `facerecon new` writes for the user to fill in.
pub fn new_capture_toml() -> String {
    let mut out = String::from(
        r##"# A capture for facerecon: the photographs of one session and what is known about them.
# Paths are relative to this file and stay inside its folder. A line that begins with # is off.

[images]
# The pair under the projected pattern, taken at the same moment. PNG, JPEG or GIF, same size.
left = "left_dots.png"
right = "right_dots.png"
# The same pair without the pattern, for the texture (and it helps to find the right match).
left_plain = "left_plain.png"
right_plain = "right_plain.png"

# Further photos without the pattern, each with its camera: X_cam = R X_left + T, millimetres.
# [[images.extra]]
# image = "profile_plain.png"
# K = [[2291.67, 0, 383.5], [0, 2291.67, 287.5], [0, 0, 1]]
# D = [0, 0, 0, 0, 0]
# R = [[0.643, 0, 0.766], [0, 1, 0], [-0.766, 0, 0.643]]
# T = [-918.9, -3.0, 413.8]

[pattern]
kind = "dots"        # "dots" or "stripes"
columns = 85         # dots across in the projected picture
rows = 64            # dots down
# rotation_deg = 0.0 # how far the lattice is turned, clockwise

[rig]
# Without a rig the result has the right shape but no true size.
# The stereo calibration: OpenCV YAML, XML or JSON with K1 D1 K2 D2 R T, millimetres.
calibration = "calibration.yml"
# Or, for parallel cameras, these four (a calibration counts when both are there):
# baseline_mm = 150.0
# focal_px = 2765.96
# principal_left = [383.5, 287.5]   # pixel centres at integers: the middle of 768x576
# principal_right = [383.5, 287.5]

# The three marked pairs of the thesis (only the profile "facebuilder" needs them): one dot on the
# forehead and one at each ear, in pixels of both photos; left_ear is at the left of the picture.
# [seeds]
# head = { left = [548.0, 187.9], right = [219.0, 187.9] }
# left_ear = { left = [399.6, 359.0], right = [79.4, 359.0] }
# right_ear = { left = [678.2, 319.7], right = [357.3, 319.7] }

# Landmarks marked in both photos, any of these (left and right as seen in the picture):
"##,
    );
    for names in LANDMARKS.chunks(6) {
        out += &format!("#   {}\n", names.join(" "));
    }
    out += "# [landmarks]\n# nose_tip = { left = [552.4, 363.4], right = [214.4, 363.4] }\n";
    out
}
