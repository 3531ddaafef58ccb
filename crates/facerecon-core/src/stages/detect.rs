//! Detect: find the projected dots in one photo.

mod gaussian;
mod thin;

#[cfg(test)]
mod tests;

pub use gaussian::GaussianParams;

use gaussian::gaussian;
use thin::{Thinned, thin};

use crate::data::{Dot, Gray};
use crate::math::Vec2;
use crate::observer::{Artifact, Cancelled, Event, Observer};
use crate::settings::{SettingsError, Value};
use crate::settings::{choices, settings};
use crate::spatial::median_spacing;

choices! {
    /// How dots are found.
    pub enum DetectMethod {
        /// Thinning of a black and white photo, as in the thesis (section 2.2.3).
        Thin = "thin",
        /// Fits of Gaussian profiles to the rectified photo, to hundredths of a pixel.
        Gaussian = "gaussian",
    }
}

settings! {
    /// Detection of the projected dots.
    pub struct DetectParams {
        /// How dots are found.
        method: DetectMethod = DetectMethod::Thin;
        /// Side of the window of the raster scan (thesis: 5x5), for `thin` without `merge`.
        window_px: usize = 5, range 1.0..=101.0, unit "px";
        /// Whether connected white pixels are one dot, for `thin`. The fixed window of the thesis
        /// splits a dot whose top row does not begin at its left end, and merges dots that are closer
        /// than its side.
        merge: bool = true;
        /// Minimum number of white pixels of a dot; fewer are noise. For `thin` with `merge`.
        min_area_px: usize = 3, range 1.0..=10000.0, unit "px";
        /// Maximum area of a dot in medians of all areas; larger ones are reflections or merged dots.
        /// For `thin` with `merge`.
        max_area: f64 = 3.0, range 1.0..=1000.0;
        /// Whether positions are rounded to whole pixels, as in the thesis, for `thin`.
        round: bool = true;
        /// The sub-pixel fit, for `gaussian`.
        gaussian: GaussianParams = GaussianParams::default();
    }
}

/// A photo without detectable dots.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DetectError {
    /// Too few dots.
    #[error(
        "{got} dots found (at least {needed} expected); check that this is the photo with the pattern and that it is sharp. With detect.method = \"thin\" try another filter.threshold or filter.level"
    )]
    TooFewDots {
        /// Dots found.
        got: usize,
        /// Dots needed.
        needed: usize,
    },
    /// No pixels.
    #[error("the photo has {width}x{height} pixels (at least 1x1 expected); give another photo")]
    Empty {
        /// Width found.
        width: usize,
        /// Height found.
        height: usize,
    },
    /// A parameter out of its range.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// Cancelled by the observer.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

crate::stages::stage_error!(DetectError, "detect");

/// The dots of one photo.
#[derive(Clone, Debug, PartialEq)]
pub struct Detection {
    /// Sorted by row, then column; pixels of the given image.
    pub dots: Vec<Dot>,
    /// Median distance to the nearest other dot (`thin`) or spacing of the lattice (`gaussian`), pixels.
    pub spacing_px: f64,
    /// One white pixel for each dot on black (thesis Fig. 2.4); `thin` only.
    pub thinned: Option<Gray>,
}

/// Fewer dots than this are not a pattern. Set by hand: a pattern on a face has hundreds.
const MIN_DOTS: usize = 12;

/// Finds the dots of a photo: of the black and white photo that `filter` computes (`thin`), or of the
/// rectified photo itself (`gaussian`).
///
/// ```
/// use facerecon_core::data::Gray;
/// use facerecon_core::stages::detect::{DetectMethod, DetectParams, detect};
///
/// // dots 10 pixels apart, with their centres 5 pixels from the border
/// let square = |v: usize| (v as f32 % 10.0 - 5.0).powi(2);
/// let image = Gray::from_fn(120, 80, |x, y| 200.0 * (-(square(x) + square(y)) / 4.0).exp());
/// let params = DetectParams { method: DetectMethod::Gaussian, ..DetectParams::default() };
/// let found = detect(&image, &params, &())?;
/// assert!(found.dots.len() >= 80);
/// assert!((found.spacing_px - 10.0).abs() < 0.2);
/// # Ok::<(), facerecon_core::stages::detect::DetectError>(())
/// ```
///
/// # Errors
/// [`DetectError`] for fewer than 12 dots, a photo without pixels, a parameter out of its range, and
/// a cancelled run.
pub fn detect(
    image: &Gray,
    params: &DetectParams,
    observer: &dyn Observer,
) -> Result<Detection, DetectError> {
    params.check("detect", None)?;
    let (width, height) = image.size();
    if width == 0 || height == 0 {
        return Err(DetectError::Empty { width, height });
    }
    observer.check()?;
    let (dots, spacing_px, thinned) = match params.method {
        DetectMethod::Thin => {
            let Thinned { dots, image } = thin(image, params);
            let spacing_px = spacing_px(&dots);
            (dots, spacing_px, Some(image))
        }
        DetectMethod::Gaussian => {
            let (dots, spacing_px) = gaussian(image, &params.gaussian);
            (dots, Some(spacing_px), None)
        }
    };
    observer.event(&Event::Count { stage: "detect", what: "dots", count: dots.len() });
    if let Some(thinned) = &thinned {
        observer.artifact("detect", "thinned", Artifact::Gray(thinned));
    }
    match spacing_px {
        Some(spacing_px) if dots.len() >= MIN_DOTS => Ok(Detection { dots, spacing_px, thinned }),
        _ => Err(DetectError::TooFewDots { got: dots.len(), needed: MIN_DOTS }),
    }
}

/// Median distance from a dot to the nearest other one, pixels; `None` with fewer than two dots.
fn spacing_px(dots: &[Dot]) -> Option<f64> {
    let positions: Vec<Vec2> = dots.iter().map(|d| d.position).collect();
    median_spacing(&positions).filter(|s| *s > 0.0)
}
