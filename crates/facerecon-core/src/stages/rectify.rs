//! Rectify: both photos as cameras with level rows would have taken them, so that a point has the
//! same row in both (the thesis asks the photographer for that; a calibrated rig gives it).

mod rows;
mod warp;

#[cfg(test)]
mod tests;

pub use rows::RowsParams;
pub use warp::{warp, warp_rgb};

use crate::camera::{Rectification, View};
use crate::data::{Capture, CaptureError, Gray, PatternKind, Photo, Rgb};
use crate::observer::{Artifact, Cancelled, Event, Observer};
use crate::settings;
use crate::settings::{SettingsError, Value};

settings! {
    /// Rectification of the photos.
    pub struct RectifyParams {
        /// Whether the rig's calibration is used where the capture has one; without it the photos
        /// are taken as they are.
        calibrated: bool = true;
        /// Rows that the photographs show to be off.
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
        "the rectified pictures would be {got_width}x{got_height} for photos of {width}x{height}; the calibration does not belong to these photos, or the cameras look too far apart"
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

crate::stage_error!(RectifyError, "rectify");

/// How level the rows were found and what was done about it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RowReport {
    /// Rows the right photo lay lower than the left, pixels.
    pub offset_px: f64,
    /// Roll of the right photo against the left, degrees, clockwise.
    pub roll_deg: f64,
    /// Vertical scale of the right photo over the left, less 1.
    pub scale: f64,
    /// Median row difference left after the correction, pixels; `None` when not measured.
    pub residual_px: Option<f64>,
    /// Whether the views were corrected by these figures.
    pub corrected: bool,
}

/// The rectified pair.
#[derive(Clone, Debug, PartialEq)]
pub struct Rectified {
    /// How photo and rectified pixels belong together.
    pub rectification: Rectification,
    /// The left photo with the pattern, rectified.
    pub left: Gray,
    /// The right photo with the pattern, rectified.
    pub right: Gray,
    /// The pair without the pattern, rectified.
    pub plain: Option<[Gray; 2]>,
    /// The pair with the pattern in colour, for stripes; `None` for dots.
    pub colors: Option<[Rgb; 2]>,
    /// How level the rows were found.
    pub rows: RowReport,
    /// What the user should know, in words.
    pub warnings: Vec<String>,
}

/// Rectified pictures may have this many times the pixels of a photo.
const CANVAS_LIMIT: usize = 6;

/// Rectifies both pairs of a capture. Photos of a parallel rig keep their pixels.
///
/// # Errors
/// [`RectifyError`] for a capture that is not valid, or a rig that does not fit the photos.
pub fn rectify(
    capture: &Capture,
    params: &RectifyParams,
    observer: &dyn Observer,
) -> Result<Rectified, RectifyError> {
    params.check("rectify", None)?;
    capture.validate()?;
    let size = capture.left.size();
    let mut warnings = Vec::new();
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
        let levelled = rows::level(&rectification, dots, plain, &params.rows);
        rows = levelled.report;
        warnings.extend(levelled.warnings);
        if let Some(better) = levelled.rectification {
            rectification = better;
            pictures = Pictures::new(capture, &rectification);
        }
    } else if rectification.rig.is_none() {
        warnings.push(
            "no calibration is used: rows are taken as level, and lengths are in model units"
                .to_owned(),
        );
    }
    let Pictures { left, right, plain } = pictures;
    let colors = (capture.pattern.kind == PatternKind::Stripes).then(|| {
        let size = rectification.size;
        [(&capture.left, &rectification.left), (&capture.right, &rectification.right)]
            .map(|(photo, view)| warp_rgb(&photo.rgb, view, size))
    });
    for message in &warnings {
        observer.event(&Event::Warning { stage: "rectify", message });
    }
    observer.artifact("rectify", "left", Artifact::Gray(&left));
    observer.artifact("rectify", "right", Artifact::Gray(&right));
    Ok(Rectified { rectification, left, right, plain, colors, rows, warnings })
}

/// Both pairs as the views see them.
struct Pictures {
    left: Gray,
    right: Gray,
    plain: Option<[Gray; 2]>,
}

impl Pictures {
    fn new(capture: &Capture, rectification: &Rectification) -> Self {
        let see = |photo: &Photo, view: &View| warp(&photo.gray, view, rectification.size);
        let (left, right) = (&rectification.left, &rectification.right);
        Self {
            left: see(&capture.left, left),
            right: see(&capture.right, right),
            plain: capture.plain.as_ref().map(|[l, r]| [see(l, left), see(r, right)]),
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
