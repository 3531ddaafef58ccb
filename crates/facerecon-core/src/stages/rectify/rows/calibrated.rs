//! Rows of a calibrated rig whose right camera was moved: a small offset, roll or change of scale.

use nalgebra::{Rotation3, Vector3};

use super::RowsParams;
use super::affine::RowAffine;
use super::corners::{CornerPair, MIN_CORNERS};
use super::report::{RowCorrection, RowReport};
use crate::camera::{Pinhole, Rectification, View};
use crate::math::Vec2;

/// A correction from this multiple of `rows.least_px` on is worth a warning. Set by hand.
const WARNING_FACTOR: f64 = 3.0;

/// Corrects the right view by the row differences of the corners; `centre` is its principal point.
pub(super) fn correct(
    rectification: &Rectification,
    centre: Vec2,
    corners: &[CornerPair],
    params: &RowsParams,
) -> RowCorrection {
    let unknown =
        RowCorrection { rectification: None, report: RowReport::default(), warning: None };
    let Some(fit) =
        RowAffine::fit(corners, centre, params.least_px).filter(|_| corners.len() >= MIN_CORNERS)
    else {
        return unknown;
    };
    let error_px = corners.iter().map(|s| fit.at(s.right).abs()).fold(0.0, f64::max);
    let residual = fit.residual(corners);
    let mut report = RowReport {
        offset_px: fit.offset,
        roll_deg: fit.roll.atan().to_degrees(),
        scale: fit.scale,
        residual_px: Some(residual),
        corrected: false,
    };
    let found = format!(
        "offset {:+.2} px (positive: right photo lower), roll {:+.3} degrees, scale {:+.4}; {} corners, residual {residual:.2} px",
        report.offset_px,
        report.roll_deg,
        report.scale,
        corners.len()
    );
    if residual > params.residual_px || error_px > params.largest_px {
        let warning = format!(
            "the rows of the photos do not fit the calibration: {found} (at most {:.1} px residual and {:.1} px row error expected). They are not corrected; calibrate again, or check that photos and calibration belong together",
            params.residual_px, params.largest_px
        );
        return RowCorrection { report, warning: Some(warning), ..unknown };
    }
    if error_px < params.least_px {
        return RowCorrection { report, ..unknown };
    }
    let right = corrected_view(&rectification.right, &fit).filter(|_| params.correct);
    report.corrected = right.is_some();
    let done = if report.corrected { "The right view is corrected" } else { "It is not corrected" };
    let warning = (error_px >= WARNING_FACTOR * params.least_px).then(|| {
        format!(
            "the rows of the photos disagree with the calibration: {found}. {done}; a camera may have moved, so calibrate again"
        )
    });
    let rectification = right.map(|right| Rectification { right, ..*rectification });
    RowCorrection { rectification, report, warning }
}

/// The right view with the row error removed: rolled about its axis, zoomed, moved up.
fn corrected_view(view: &View, fit: &RowAffine) -> Option<View> {
    let View::Camera { camera, rectified_from_camera, rectified } = view else {
        return None;
    };
    let roll = Rotation3::from_axis_angle(&Vector3::z_axis(), -fit.roll.atan());
    let zoom = 1.0 + fit.scale;
    Some(View::Camera {
        camera: *camera,
        rectified_from_camera: roll.into_inner() * rectified_from_camera,
        rectified: Pinhole {
            fx: rectified.fx / zoom,
            fy: rectified.fy / zoom,
            cy: rectified.cy - fit.offset,
            ..*rectified
        },
    })
}
