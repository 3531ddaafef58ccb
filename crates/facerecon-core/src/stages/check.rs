//! Check: whether the photographs of a capture suffice, by the thesis's rules (section 6.5.1).
//!
//! Resolution, equal luminance, no saturation, sharp dots of good contrast, the subject in both
//! photos, level rows, the exposure of the plain pair, photos that belong together. Each rule gives the figure found, the figure
//! expected and what to do. A capture that breaks a rule may still be reconstructed: the rules
//! warn, they do not stop a run.

mod agreement;
mod dot_figures;
mod dot_rules;
mod input;
mod pair_rules;
mod photo_figures;
mod photo_rules;
mod report;
mod row_offset;

#[cfg(test)]
mod tests;

pub use input::{CheckInput, PhotoDots};
pub use report::{CheckReport, Finding, Verdict};

use crate::data::PatternKind;
use crate::observer::{Cancelled, Observer};
use crate::settings::settings;
use crate::settings::{SettingsError, Value};

settings! {
    /// The rules for a good capture and their limits.
    pub struct CheckParams {
        /// Minimum width of the photos (thesis section 6.5.1: 768).
        min_width: usize = 768, range 1.0..=100000.0, unit "px";
        /// Minimum height of the photos (thesis section 6.5.1: 576).
        min_height: usize = 576, range 1.0..=100000.0, unit "px";
        /// Maximum ratio of the brightness of both photos, measured in their lit parts.
        max_luminance_ratio: f64 = 1.25, range 1.0..=100.0;
        /// Maximum fraction of saturated pixels.
        max_saturated: f64 = 0.01, range 0.0..=1.0;
        /// Minimum height of the dots above their surroundings.
        min_contrast: f64 = 25.0, range 0.0..=255.0, unit "grey levels";
        /// Maximum radius at which a dot falls to half its height, in dot spacings. Dots that
        /// merge with their neighbours reach 0.24.
        max_blur: f64 = 0.23, range 0.0..=2.0;
        /// Minimum distance between neighbouring dots.
        min_spacing_px: f64 = 5.0, range 0.0..=1000.0, unit "px";
        /// Maximum row difference between the photos after rectification (the thesis's scan
        /// accepts 2).
        max_row_error_px: f64 = 1.0, range 0.0..=100.0, unit "px";
        /// Minimum ratio of the numbers of dots of both photos, smaller over larger.
        min_dot_ratio: f64 = 0.7, range 0.0..=1.0;
    }
}

/// A check that did not run to its end.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CheckError {
    /// A parameter out of its range.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// Cancelled by the observer.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

crate::stages::stage_error!(CheckError, "check");

/// Measures a capture against the rules. What cannot be measured becomes [`Verdict::Unknown`];
/// every broken rule is also a warning to the observer.
///
/// ```
/// use facerecon_core::camera::Rectification;
/// use facerecon_core::data::{Capture, Pattern, PatternKind, Photo, Rgb};
/// use facerecon_core::stages::check::{CheckInput, CheckParams, check};
///
/// let photo = Photo::from_rgb(Rgb::filled(64, 48, [90; 3]));
/// let capture = Capture {
///     left: photo.clone(),
///     right: photo,
///     plain: None,
///     extra: Vec::new(),
///     pattern: Pattern { kind: PatternKind::Dots, columns: 85, rows: 64, rotation: 0.0 },
///     rig: None,
///     seeds: None,
///     landmarks: Default::default(),
/// };
/// let views = Rectification::identity((64, 48));
/// let input = CheckInput {
///     capture: &capture,
///     dots: [None, None],
///     views: Ok(&views),
///     rows_corrected: false,
/// };
/// let report = check(&input, &CheckParams::default(), &())?;
/// assert!(!report.is_good());
/// assert!(report.findings[0].message.contains("64x48"));
/// # Ok::<(), facerecon_core::stages::check::CheckError>(())
/// ```
///
/// # Errors
/// [`CheckError`] for a parameter out of its range and a cancelled run; never for the photos.
pub fn check(
    input: &CheckInput<'_>,
    params: &CheckParams,
    observer: &dyn Observer,
) -> Result<CheckReport, CheckError> {
    params.check("check", None)?;
    let capture = input.capture;
    let mut report = CheckReport::default();
    photo_rules::resolution(capture, params, &mut report);
    photo_rules::luminance(capture, params, &mut report);
    photo_rules::saturation(capture, params, &mut report);
    observer.check()?;
    if capture.pattern.kind == PatternKind::Dots {
        dot_rules::all(input, params, &mut report);
    }
    photo_rules::plain_pair(capture, &mut report);
    pair_rules::all(input, &mut report);
    for warning in report.warnings() {
        observer.warn("check", &warning);
    }
    Ok(report)
}
