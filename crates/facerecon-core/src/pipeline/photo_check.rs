//! The stage check with what it is given: the dots of the photos as taken, and the views.

use crate::camera::Rectification;
use crate::data::{Capture, Gray, PatternKind};
use crate::observer::Observer;
use crate::pipeline::{Error, Params};
use crate::stages::check::{CheckInput, CheckParams, CheckReport, PhotoDots, check};
use crate::stages::detect::{DetectMethod, DetectParams, Detection, detect};
use crate::stages::filter::{FilterParams, filter};
use crate::stages::rectify::{Rectified, RectifyError, rectify};

/// Checks the photographs of a capture alone, by the thesis's rules (section 6.5.1). Photos that
/// cannot be rectified are a finding, not an error.
///
/// # Errors
/// A parameter out of its range, or a cancelled run.
pub(super) fn check_photos(
    capture: &Capture,
    params: &Params,
    observer: &dyn Observer,
) -> Result<CheckReport, Error> {
    let rectified = match rectify(capture, &params.rectify, observer) {
        Ok(rectified) => Ok(rectified),
        Err(error @ (RectifyError::Settings(_) | RectifyError::Cancelled(_))) => {
            return Err(error.into());
        }
        Err(error) => Err(error.to_string()),
    };
    let corrected = rectified.as_ref().is_ok_and(|r| r.rows.corrected);
    let views = rectified.as_ref().map(|r| &r.rectification).map_err(Clone::clone);
    check_with(capture, views, corrected, &params.check, observer)
}

/// Checks the photographs of a capture that is rectified already.
pub(super) fn check_rectified(
    capture: &Capture,
    rectified: &Rectified,
    params: &Params,
    observer: &dyn Observer,
) -> Result<CheckReport, Error> {
    let views = Ok(&rectified.rectification);
    check_with(capture, views, rectified.rows.corrected, &params.check, observer)
}

fn check_with(
    capture: &Capture,
    views: Result<&Rectification, String>,
    rows_corrected: bool,
    params: &CheckParams,
    observer: &dyn Observer,
) -> Result<CheckReport, Error> {
    let (left, right) = match capture.pattern.kind {
        PatternKind::Dots => {
            rayon::join(|| dots_of(&capture.left.gray), || dots_of(&capture.right.gray))
        }
        PatternKind::Stripes => (None, None),
    };
    let dots = [&left, &right]
        .map(|found| found.as_ref().map(|d| PhotoDots { dots: &d.dots, spacing_px: d.spacing_px }));
    Ok(check(&CheckInput { capture, dots, views, rows_corrected }, params, observer)?)
}

/// The dots of a photo as taken, for the check: always by the same methods and settings, so that
/// its figures can be compared between captures. `None` where there is no pattern.
fn dots_of(image: &Gray) -> Option<Detection> {
    let params =
        DetectParams { method: DetectMethod::Thin, round: false, ..DetectParams::default() };
    let binary = filter(image, &FilterParams::default(), &()).ok()?.binary;
    detect(&binary, &params, &()).ok()
}
