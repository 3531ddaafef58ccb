//! Rectify: resample both photos so that a point has the same row in both. The thesis expects the
//! photographer to align the cameras; here the calibration, or the photos themselves, correct them.

mod rows;
mod warp;

#[cfg(test)]
mod tests;

pub use rows::{RowReport, RowsParams};
pub use warp::{warp, warp_rgb};

use crate::camera::{Rectification, View};
use crate::data::{Capture, CaptureError, Gray, PatternKind, Photo, Rgb};
use crate::observer::{Artifact, Cancelled, Observer};
use crate::settings::settings;
use crate::settings::{SettingsError, Value};

settings! {
    /// Rectification of the photos.
    pub struct RectifyParams {
        /// Whether the calibration of the rig is used where the capture has one; else the photos
        /// are used as taken, apart from the correction of rows.
        calibrated: bool = true;
        /// Row errors measured from the photos.
        rows: RowsParams = RowsParams::default();
    }
}

/// Photos that cannot be rectified.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RectifyError {
    /// A capture that is not valid.
    #[error(transparent)]
    Capture(#[from] CaptureError),
    /// A rig whose rectified pictures would be far larger than the photos.
    #[error(
        "the rectified pictures would have {got_width}x{got_height} pixels for photos of {width}x{height} (at most {CANVAS_LIMIT} times as many pixels expected); check that the calibration belongs to these photos, and that the cameras look in similar directions"
    )]
    Canvas {
        /// Width of the rectified pictures.
        got_width: usize,
        /// Their height.
        got_height: usize,
        /// Width of the photos.
        width: usize,
        /// Their height.
        height: usize,
    },
    /// A parameter out of its range.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// Cancelled by the observer.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

crate::stages::stage_error!(RectifyError, "rectify");

/// The rectified pair.
#[derive(Clone, Debug, PartialEq)]
pub struct Rectified {
    /// The transforms between photo pixels and rectified pixels.
    pub rectification: Rectification,
    /// The left dotted photo, rectified, grey levels 0 to 255.
    pub left: Gray,
    /// The right dotted photo, rectified.
    pub right: Gray,
    /// The plain pair `[left, right]`, rectified.
    pub plain: Option<[Gray; 2]>,
    /// The pair with the pattern in colour `[left, right]`, for stripes; `None` for dots.
    pub colors: Option<[Rgb; 2]>,
    /// The rows as measured, and whether they were corrected.
    pub rows: RowReport,
}

/// Rectified pictures have at most this many times the pixels of a photo. Set by
/// hand: bounds the memory that a wrong calibration can ask for.
const CANVAS_LIMIT: usize = 6;

/// Rectifies both pairs of a capture. Photos of a parallel rig keep their pixels.
///
/// Warns when no calibration is used, and of row errors.
///
/// ```
/// use facerecon_core::camera::StereoRig;
/// use facerecon_core::data::{Capture, Pattern, PatternKind, Photo, Rgb};
/// use facerecon_core::math::Vec2;
/// use facerecon_core::stages::rectify::{RectifyParams, rectify};
///
/// let photo = Photo::from_rgb(Rgb::from_fn(60, 40, |x, y| [(3 * x + y) as u8; 3]));
/// let (baseline_mm, focal_px) = (100.0, 500.0);
/// let (left, right) = (Vec2::new(30.0, 20.0), Vec2::new(35.0, 20.0));
/// let capture = Capture {
///     left: photo.clone(),
///     right: photo.clone(),
///     plain: None,
///     extra: Vec::new(),
///     pattern: Pattern { kind: PatternKind::Dots, columns: 85, rows: 64, rotation: 0.0 },
///     rig: Some(StereoRig::parallel(baseline_mm, focal_px, left, right)),
///     seeds: None,
///     landmarks: Default::default(),
/// };
/// let rectified = rectify(&capture, &RectifyParams::default(), &())?;
/// assert_eq!(rectified.left, photo.gray);
/// assert!(rectified.rectification.rig.is_some());
/// # Ok::<(), facerecon_core::stages::rectify::RectifyError>(())
/// ```
///
/// # Errors
/// [`RectifyError`] for a capture that is not valid, a rig that does not fit the photos, a parameter
/// out of its range, and a cancelled run.
pub fn rectify(
    capture: &Capture,
    params: &RectifyParams,
    observer: &dyn Observer,
) -> Result<Rectified, RectifyError> {
    params.check("rectify", None)?;
    capture.validate()?;
    let size = capture.left.size();
    let mut rectification = match &capture.rig {
        Some(rig) if params.calibrated => Rectification::from_rig(rig, size),
        _ => Rectification::identity(size),
    };
    check_canvas(&rectification, size)?;
    observer.check()?;
    let mut pictures = Pictures::new(capture, &rectification);
    let mut rows = RowReport::default();
    if params.rows.measure {
        let dots = [&pictures.left, &pictures.right];
        let plain = pictures.plain.as_ref().map(|p| [&p[0], &p[1]]);
        let dots = (capture.pattern.kind == PatternKind::Dots).then_some(dots);
        let correction = rows::correct_rows(&rectification, dots, plain, &params.rows);
        rows = correction.report;
        if let Some(warning) = correction.warning {
            observer.warn("rectify", &warning);
        }
        if let Some(corrected) = correction.rectification {
            rectification = corrected;
            pictures = Pictures::new(capture, &rectification);
        }
    } else if rectification.rig.is_none() {
        observer.warn(
            "rectify",
            "no calibration is used: rows are assumed to be level, and lengths are in model units; calibrate for millimetres",
        );
    }
    let Pictures { left, right, plain } = pictures;
    let colors = (capture.pattern.kind == PatternKind::Stripes).then(|| {
        let size = rectification.size;
        [(&capture.left, &rectification.left), (&capture.right, &rectification.right)]
            .map(|(photo, view)| warp_rgb(&photo.rgb, view, size))
    });
    observer.artifact("rectify", "left", Artifact::Gray(&left));
    observer.artifact("rectify", "right", Artifact::Gray(&right));
    Ok(Rectified { rectification, left, right, plain, colors, rows })
}

/// Both pairs resampled by the views.
struct Pictures {
    left: Gray,
    right: Gray,
    plain: Option<[Gray; 2]>,
}

impl Pictures {
    fn new(capture: &Capture, rectification: &Rectification) -> Self {
        let warped = |photo: &Photo, view: &View| warp(&photo.gray, view, rectification.size);
        let (left, right) = (&rectification.left, &rectification.right);
        Self {
            left: warped(&capture.left, left),
            right: warped(&capture.right, right),
            plain: capture.plain.as_ref().map(|[l, r]| [warped(l, left), warped(r, right)]),
        }
    }
}

fn check_canvas(
    rectification: &Rectification,
    (width, height): (usize, usize),
) -> Result<(), RectifyError> {
    let (got_width, got_height) = rectification.size;
    let limit = width.saturating_mul(height).saturating_mul(CANVAS_LIMIT);
    if got_width.saturating_mul(got_height) > limit {
        return Err(RectifyError::Canvas { got_width, got_height, width, height });
    }
    Ok(())
}
