//! Stereo calibrations: OpenCV FileStorage (YAML 1.0, 1.2 or without header, XML, JSON) and plain
//! JSON or YAML with the same names.
//!
//! Names are compared without case, `_`, `-` and spaces: `K1 D1 K2 D2 R T`, `M1`/`M2`,
//! `camera_matrix_left`, `cameraMatrix1`, `dist_coeffs_1` and similar ones. `X_right = R X_left + T`;
//! T is in millimetres unless the file has `unit: m` (or another unit of length).

mod entries;
mod names;
mod numbers;
mod parse;
mod tree;
mod types;
mod write;
mod xml;

use std::path::Path;

use super::error::{Fault, IoError};
use super::source::{decode_text, read_bytes};
use crate::camera::StereoRig;
use crate::math::Similarity;
use entries::Entries;
pub(super) use numbers::{camera, check_baseline, distortion, rotation};
pub use types::Calibration;
pub use write::write_calibration;

/// Longest calibration file, MB: a stereo calibration has a few kB. The limit also bounds what
/// aliases of a YAML file can expand to.
const MAX_FILE_MB: u64 = 1;

/// Reads a stereo calibration and validates the rig.
///
/// # Errors
/// [`IoError`]: unreadable or malformed, a matrix that is missing (with the nearest name of the
/// file) or has the wrong size, an unsupported lens model, a T that seems to be in metres, or a rig
/// that cannot be used.
///
/// ```
/// use facerecon_core::camera::StereoRig;
/// use facerecon_core::io::{read_calibration, write_calibration};
/// use facerecon_core::math::Vec2;
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("calibration.yml");
/// let centre = Vec2::new(383.5, 287.5);
/// let rig = StereoRig::parallel(150.0, 2766.0, centre, centre);
/// write_calibration(&path, &rig)?;
/// let calibration = read_calibration(&path)?;
/// assert_eq!(calibration.rig.baseline_mm(), 150.0);
/// assert!(calibration.warnings.is_empty());
/// # Ok(())
/// # }
/// ```
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
fn parse_calibration(bytes: &[u8]) -> Result<Calibration, Fault> {
    let tree = parse::parse(&decode_text(bytes))?;
    let file = Entries::new(&tree);
    file.refuse_fisheye()?;
    let mut warnings = Vec::new();
    let left = file.camera("left", names::LEFT_K, names::LEFT_D, &mut warnings)?;
    let right = file.camera("right", names::RIGHT_K, names::RIGHT_D, &mut warnings)?;
    let rotation = rotation(&file.numbers("R (rotation)", names::ROTATION)?)?;
    let translation = file.translation(&mut warnings)?;
    let image_size = file.image_size()?;
    let right_from_left = Similarity::rigid(rotation, translation);
    let rig = StereoRig { left, right, right_from_left, image_size };
    Ok(Calibration { rig, warnings })
}

#[cfg(test)]
mod tests;
