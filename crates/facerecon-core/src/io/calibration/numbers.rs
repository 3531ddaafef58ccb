//! Cameras, rotations and baselines from numbers, with messages for common mistakes.

use crate::camera::{Distortion, Pinhole};
use crate::io::error::Fault;
use crate::math::{Mat3, Vec3};

/// Largest skew of the camera matrix, pixels: about one column across the photo; it is ignored.
const MAX_SKEW_PX: f64 = 1.0;
/// Rotations within this deviation from orthonormality are exact up to rounding.
const EXACT_ROTATION: f64 = 1e-14;
/// Rotations within this deviation were rounded to a few digits in the file.
const ROUNDED_ROTATION: f64 = 1e-3;
/// A shorter baseline in millimetres is too short for two cameras: it is in metres.
const METRES_BELOW: f64 = 1.0;
/// A shorter baseline is unusual: centimetres, or squares of a chessboard.
const UNUSUAL_BELOW_MM: f64 = 20.0;

/// The lens distortion of 0, 4, 5, 8, 12 or 14 coefficients in OpenCV's order; beyond the eighth (thin prism,
/// tilted sensor) they must be 0.
///
/// # Errors
/// [`Fault`] with the number of coefficients, or the unsupported coefficient.
pub(in crate::io) fn distortion(d: &[f64]) -> Result<Distortion, Fault> {
    if !matches!(d.len(), 0 | 4 | 5 | 8 | 12 | 14) {
        return Err(Fault::new(format!(
            "the distortion has {} coefficients; 4, 5 or 8 (k1 k2 p1 p2 k3 k4 k5 k6) are expected",
            d.len()
        )));
    }
    if let Some(c) = d.iter().skip(8).find(|c| **c != 0.0) {
        return Err(Fault::new(format!(
            "the distortion has thin-prism or tilt coefficients ({c}), which are not supported: \
             calibrate without CALIB_THIN_PRISM_MODEL and CALIB_TILTED_MODEL"
        )));
    }
    let mut out = Distortion::default();
    out.0.iter_mut().zip(d).for_each(|(o, v)| *o = *v);
    Ok(out)
}

/// The camera of a 3x3 matrix, row by row, and its lens.
pub(in crate::io) fn camera(
    k: &[f64],
    d: &[f64],
    warnings: &mut Vec<String>,
) -> Result<Pinhole, Fault> {
    let &[fx, skew, cx, k10, fy, cy, k20, k21, one] = k else {
        return Err(Fault::new(format!(
            "the camera matrix has {} numbers, but 9 are expected",
            k.len()
        )));
    };
    if skew == 0.0 && cx == 0.0 && cy == 0.0 && k20 > 0.0 && k21 > 0.0 {
        return Err(Fault::new(
            "the camera matrix has the principal point in its last row: transpose it (MATLAB \
             writes it transposed)",
        ));
    }
    if [k10, k20, k21] != [0.0; 3] || one <= 0.0 {
        return Err(Fault::new(format!(
            "the camera matrix must have the form [fx 0 cx; 0 fy cy; 0 0 1], but is {k:?}"
        )));
    }
    if skew.abs() > MAX_SKEW_PX * one {
        return Err(Fault::new(format!(
            "the camera matrix has a skew of {skew}; square or rectangular pixels (skew 0) are expected"
        )));
    }
    if skew != 0.0 {
        warnings.push(format!("the camera matrix's skew of {skew} px is ignored"));
    }
    let camera = Pinhole {
        fx: fx / one,
        fy: fy / one,
        cx: cx / one,
        cy: cy / one,
        distortion: distortion(d)?,
    };
    if !camera.is_plausible() {
        return Err(Fault::new(format!(
            "the focal lengths are {fx} and {fy}; they must be above 0, in pixels"
        )));
    }
    Ok(camera)
}

/// The rotation of 9 numbers row by row, or of a rotation vector (axis times angle, radians).
/// A rotation rounded in the file is made orthonormal again. Other matrices are returned as they
/// are: the rig's validation refuses them.
pub(in crate::io) fn rotation(r: &[f64]) -> Result<Mat3, Fault> {
    let m = match *r {
        [x, y, z] => nalgebra::Rotation3::new(Vec3::new(x, y, z)).into_inner(),
        [_, _, _, _, _, _, _, _, _] => Mat3::from_row_slice(r),
        _ => {
            return Err(Fault::new(format!(
                "R has {} numbers, but 9 (a matrix) or 3 (a rotation vector) are expected",
                r.len()
            )));
        }
    };
    let deviation = (m * m.transpose() - Mat3::identity()).amax();
    if deviation > EXACT_ROTATION && deviation < ROUNDED_ROTATION {
        let svd = m.svd(true, true);
        if let (Some(u), Some(v)) = (svd.u, svd.v_t) {
            return Ok(u * v);
        }
    }
    Ok(m)
}

/// Refuses a baseline that seems to be in metres, and warns about an unusual one.
pub(in crate::io) fn check_baseline(
    length: f64,
    name: &str,
    warnings: &mut Vec<String>,
) -> Result<(), Fault> {
    if length > 0.0 && length < METRES_BELOW {
        return Err(Fault::new(format!(
            "the baseline {name} is {length} long, but millimetres are expected; it seems to be in \
             metres. Multiply T by 1000, or add the line `unit: m` to the calibration"
        )));
    }
    if length > 0.0 && length < UNUSUAL_BELOW_MM {
        warnings.push(format!(
            "the baseline {name} is only {length:.2} mm long; if it is in centimetres or in squares \
             of a chessboard, all lengths of the result are wrong by that factor"
        ));
    }
    Ok(())
}
