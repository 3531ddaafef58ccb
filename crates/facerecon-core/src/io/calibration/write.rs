//! Writing stereo calibrations.

use std::path::Path;

use crate::camera::StereoRig;
use crate::io::atomic;
use crate::io::error::IoError;
use crate::math::Mat3;

/// Coefficients `k1 k2 p1 p2 k3`, which are written always; `k4 k5 k6` only where one is not 0.
const BASIC_COEFFICIENTS: usize = 5;

/// The rig as OpenCV FileStorage YAML 1.0, which every version of OpenCV reads.
fn calibration_yaml(rig: &StereoRig) -> String {
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
        let rational = d[BASIC_COEFFICIENTS..].iter().any(|c| *c != 0.0);
        let used = if rational { d.len() } else { BASIC_COEFFICIENTS };
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

/// Writes the rig as OpenCV FileStorage YAML 1.0 atomically.
///
/// # Errors
/// [`IoError::Write`].
pub fn write_calibration(path: &Path, rig: &StereoRig) -> Result<(), IoError> {
    atomic::write(path, calibration_yaml(rig).as_bytes())
}
