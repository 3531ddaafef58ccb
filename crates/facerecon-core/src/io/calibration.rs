//! Stereo calibrations: OpenCV FileStorage (YAML 1.0, 1.2 or without header, XML, JSON) and plain
//! JSON or YAML with the same names.
//!
//! Names are compared without case, `_`, `-` and spaces: `K1 D1 K2 D2 R T`, `M1`/`M2`,
//! `camera_matrix_left`, `cameraMatrix1`, `dist_coeffs_1` and their like. `X_right = R X_left + T`;
//! T in millimetres unless the file has `unit: m` (or cm, in ...).

mod numbers;
mod tree;
mod xml;

use std::path::Path;

use super::source::{decode_text, nearest_name, read_bytes};
use super::{Fault, IoError, LengthUnit, atomic};
use crate::camera::{Pinhole, StereoRig};
use crate::math::{Mat3, Similarity, Vec3};
pub use numbers::distortion;
pub(crate) use numbers::{camera, rotation};
use tree::Tree;

/// Longest calibration file, MB; it also keeps alias bombs small.
const MAX_FILE_MB: u64 = 1;
/// Below this a baseline in millimetres is not one: it was measured in metres.
const METRES_BELOW: f64 = 1.0;
/// Below this a baseline in millimetres is odd (centimetres, or squares of a chessboard?).
const ODD_BELOW_MM: f64 = 20.0;

/// A calibration and what is odd about it.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibration {
    /// The rig, millimetres.
    pub rig: StereoRig,
    /// What the user should know.
    pub warnings: Vec<String>,
}

/// Reads a stereo calibration and checks that it can be one.
///
/// # Errors
/// [`IoError`]: unreadable, not understood, a matrix missing (with the nearest name there is) or of
/// the wrong size, a lens model that is not known, a T that looks like metres, or no rig at all.
pub fn read_calibration(path: &Path) -> Result<Calibration, IoError> {
    let bytes = read_bytes(path, "calibration", MAX_FILE_MB)?;
    let found = parse_calibration(&bytes).map_err(|e| e.in_file(path))?;
    let size = found.rig.image_size.unwrap_or_default();
    found.rig.validate(size).map_err(|source| IoError::Rig { path: path.to_owned(), source })?;
    Ok(found)
}

/// Reads a stereo calibration from the bytes of a file; see [`read_calibration`].
///
/// # Errors
/// [`Fault`] with what was found and what to do.
pub fn parse_calibration(bytes: &[u8]) -> Result<Calibration, Fault> {
    let entries = tree::parse(&decode_text(bytes))?;
    let file = Entries(&entries);
    file.refuse_fisheye()?;
    let mut warnings = Vec::new();
    let left = file.camera("left", LEFT_K, LEFT_D, &mut warnings)?;
    let right = file.camera("right", RIGHT_K, RIGHT_D, &mut warnings)?;
    let rotation = rotation(&file.numbers("R (rotation)", ROTATION)?)?;
    let translation = file.translation(&mut warnings)?;
    let image_size = file.image_size()?;
    let rig = StereoRig {
        left,
        right,
        right_from_left: Similarity::rigid(rotation, translation),
        image_size,
    };
    Ok(Calibration { rig, warnings })
}

const LEFT_K: &[&str] = &[
    "k1",
    "m1",
    "cameramatrix1",
    "cameramatrixleft",
    "cameramatrixl",
    "leftcameramatrix",
    "kleft",
    "kl",
    "leftk",
    "mtx1",
    "mtxl",
    "mtxleft",
    "leftmtx",
    "intrinsics1",
    "intrinsicsleft",
    "leftintrinsics",
    "intrinsicmatrix1",
    "intrinsicmatrixleft",
    "a1",
    "camera1matrix",
];
const RIGHT_K: &[&str] = &[
    "k2",
    "m2",
    "cameramatrix2",
    "cameramatrixright",
    "cameramatrixr",
    "rightcameramatrix",
    "kright",
    "kr",
    "rightk",
    "mtx2",
    "mtxr",
    "mtxright",
    "rightmtx",
    "intrinsics2",
    "intrinsicsright",
    "rightintrinsics",
    "intrinsicmatrix2",
    "intrinsicmatrixright",
    "a2",
    "camera2matrix",
];
const LEFT_D: &[&str] = &[
    "d1",
    "distcoeffs1",
    "distcoeffsleft",
    "distcoeffsl",
    "leftdistcoeffs",
    "dist1",
    "distl",
    "distleft",
    "leftdist",
    "dleft",
    "dl",
    "leftd",
    "distcoef1",
    "distcoeff1",
    "distcoeffleft",
    "distortion1",
    "distortionleft",
    "leftdistortion",
    "distortioncoefficients1",
    "distortioncoefficientsleft",
    "leftdistortioncoefficients",
    "kc1",
];
const RIGHT_D: &[&str] = &[
    "d2",
    "distcoeffs2",
    "distcoeffsright",
    "distcoeffsr",
    "rightdistcoeffs",
    "dist2",
    "distr",
    "distright",
    "rightdist",
    "dright",
    "dr",
    "rightd",
    "distcoef2",
    "distcoeff2",
    "distcoeffright",
    "distortion2",
    "distortionright",
    "rightdistortion",
    "distortioncoefficients2",
    "distortioncoefficientsright",
    "rightdistortioncoefficients",
    "kc2",
];
const ROTATION: &[&str] = &["r", "rot", "rotation", "rotationmatrix", "rmat", "stereor", "om"];
const TRANSLATION: &[&str] =
    &["t", "trans", "translation", "translationvector", "tvec", "stereot", "tvector"];
const UNIT: &[&str] = &["unit", "units", "tunit", "translationunit", "lengthunit"];

/// The top entries of a file, found by any of their names.
struct Entries<'a>(&'a [(String, Tree)]);

fn plain(name: &str) -> String {
    name.chars().filter(|c| !matches!(c, '_' | '-' | ' ')).flat_map(char::to_lowercase).collect()
}

impl Entries<'_> {
    fn find(&self, names: &[&str]) -> Option<&Tree> {
        // In the order of the names: `K1` counts before `intrinsics1`.
        names.iter().find_map(|n| self.0.iter().find(|(k, _)| plain(k) == *n)).map(|(_, v)| v)
    }

    fn numbers(&self, what: &str, names: &[&str]) -> Result<Vec<f64>, Fault> {
        let Some(value) = self.find(names) else {
            let keys: Vec<&str> = self.0.iter().map(|(k, _)| k.as_str()).take(20).collect();
            let first = names.first().copied().unwrap_or_default().to_uppercase();
            let near = nearest_name(&first, keys.iter().copied())
                .filter(|_| first.len() > 2)
                .map_or(String::new(), |n| format!("; is it {n}?"));
            let split = if names == ROTATION || names == TRANSLATION {
                " (OpenCV's samples write R and T to a second file, extrinsics.yml: put them into one)"
            } else {
                ""
            };
            return Err(Fault::new(format!(
                "{what} is missing{near}; the file has {}; wanted are K1 D1 K2 D2 R T{split}",
                if keys.is_empty() { "no entries".to_owned() } else { keys.join(", ") },
            )));
        };
        value.numbers().map_err(|e| Fault::new(format!("{what}: {e}")))
    }

    fn camera(
        &self,
        side: &str,
        matrix: &[&str],
        lens: &[&str],
        warnings: &mut Vec<String>,
    ) -> Result<Pinhole, Fault> {
        let k = self.numbers(&format!("the {side} camera matrix"), matrix)?;
        let d = match self.find(lens) {
            Some(_) => self.numbers(&format!("the {side} distortion"), lens)?,
            None => {
                warnings.push(format!(
                    "the calibration has no distortion of the {side} camera; none is assumed"
                ));
                Vec::new()
            }
        };
        camera(&k, &d, warnings).map_err(|e| Fault::new(format!("the {side} camera: {e}")))
    }

    fn translation(&self, warnings: &mut Vec<String>) -> Result<Vec3, Fault> {
        let t = self.numbers("T (translation)", TRANSLATION)?;
        let [x, y, z] = t[..] else {
            return Err(Fault::new(format!("T has {} numbers, but 3 are expected", t.len())));
        };
        let t = Vec3::new(x, y, z);
        if let Some(value) = self.find(UNIT) {
            let name = value.text().unwrap_or_default();
            let unit = LengthUnit::from_name(&name.to_lowercase()).ok_or_else(|| {
                Fault::new(format!("the unit {name:?} is not known; use mm, cm, dm, m, um or in"))
            })?;
            return Ok(t * unit.in_mm());
        }
        check_baseline(t.norm(), "T", warnings)?;
        Ok(t)
    }

    fn image_size(&self) -> Result<Option<(usize, usize)>, Fault> {
        let pair = match (self.find(&["imagewidth"]), self.find(&["imageheight"])) {
            (Some(w), Some(h)) => vec![w.numbers(), h.numbers()],
            _ => match self.find(&["imagesize", "size", "imgsize", "resolution", "imageshape"]) {
                Some(Tree::Map(m)) => ["width", "height"]
                    .iter()
                    .filter_map(|n| m.iter().find(|(k, _)| plain(k) == *n))
                    .map(|(_, v)| v.numbers())
                    .collect(),
                Some(other) => vec![other.numbers()],
                None => return Ok(None),
            },
        };
        let numbers: Vec<f64> =
            pair.into_iter().collect::<Result<Vec<_>, _>>().map_err(Fault::new)?.concat();
        let whole = |v: f64| (1.0..=1e6).contains(&v) && v.fract() == 0.0;
        match numbers[..] {
            [w, h] if whole(w) && whole(h) => Ok(Some((w as usize, h as usize))),
            _ => Err(Fault::new(format!(
                "the image size is {numbers:?}; two whole numbers, width and height, are expected"
            ))),
        }
    }

    fn refuse_fisheye(&self) -> Result<(), Fault> {
        let names = ["distortionmodel", "cameramodel", "model", "lensmodel"];
        let model = self.find(&names).and_then(Tree::text).unwrap_or_default().to_lowercase();
        if ["fisheye", "equidistant", "omni", "mei"].iter().any(|m| model.contains(m)) {
            return Err(Fault::new(format!(
                "the lens model is {model:?}; only the pinhole with radial and tangential \
                 distortion is known: calibrate with OpenCV's stereoCalibrate"
            )));
        }
        Ok(())
    }
}

/// Refuses a baseline that looks like metres, and warns of an odd one.
pub(crate) fn check_baseline(
    length: f64,
    name: &str,
    warnings: &mut Vec<String>,
) -> Result<(), Fault> {
    if length > 0.0 && length < METRES_BELOW {
        return Err(Fault::new(format!(
            "the baseline {name} is {length} long, but millimetres are expected: it looks like \
             metres. Multiply T by 1000, or add the line `unit: m` to the calibration"
        )));
    }
    if length > 0.0 && length < ODD_BELOW_MM {
        warnings.push(format!(
            "the baseline {name} is only {length:.2} mm long; if it was measured in centimetres or \
             in squares of a chessboard, all lengths of the result are wrong by that factor"
        ));
    }
    Ok(())
}

/// The rig as OpenCV FileStorage YAML, readable by every version of OpenCV.
pub fn calibration_yaml(rig: &StereoRig) -> String {
    let mut out =
        String::from("%YAML:1.0\n---\n# X_right = R X_left + T; pixel centres at integers\n");
    out += "unit: mm\n";
    if let Some((width, height)) = rig.image_size {
        out += &format!("image_width: {width}\nimage_height: {height}\n");
    }
    let rows = |m: &Mat3| m.transpose().iter().copied().collect::<Vec<f64>>();
    for (n, camera) in [(1, &rig.left), (2, &rig.right)] {
        out += &matrix_yaml(&format!("K{n}"), 3, 3, &rows(&camera.matrix()));
        let d = camera.distortion.0;
        let used = if d[5..].iter().all(|c| *c == 0.0) { 5 } else { 8 };
        out += &matrix_yaml(&format!("D{n}"), 1, used, &d[..used]);
    }
    out += &matrix_yaml("R", 3, 3, &rows(&rig.right_from_left.rotation));
    out += &matrix_yaml("T", 3, 1, rig.right_from_left.translation.as_slice());
    out
}

fn matrix_yaml(name: &str, rows: usize, columns: usize, data: &[f64]) -> String {
    let numbers: Vec<String> = data.iter().map(|v| format!("{v:?}")).collect();
    format!(
        "{name}: !!opencv-matrix\n   rows: {rows}\n   cols: {columns}\n   dt: d\n   data: [ {} ]\n",
        numbers.join(", ")
    )
}

/// Writes [`calibration_yaml`], whole or not at all.
///
/// # Errors
/// [`IoError::Write`].
pub fn write_calibration(path: &Path, rig: &StereoRig) -> Result<(), IoError> {
    atomic::write(path, calibration_yaml(rig).as_bytes())
}

#[cfg(test)]
mod tests;
