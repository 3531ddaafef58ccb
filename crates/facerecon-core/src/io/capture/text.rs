//! The text of `capture.toml`: its tables and keys, and warnings about unknown keys.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::Deserialize;

use crate::io::error::Fault;
use crate::io::source::line_of;
use crate::settings::nearest_name;

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

/// The keys of each table; the first is the file itself.
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
        message: format!("malformed capture file: {}", e.message()),
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
