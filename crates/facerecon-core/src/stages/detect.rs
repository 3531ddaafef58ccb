//! Detect: the projected dots of one photo.

mod gaussian;
mod thin;

#[cfg(test)]
mod tests;

pub use gaussian::{GaussianParams, gaussian};
pub use thin::{Thinned, thin};

use crate::data::{Dot, Gray};
use crate::math::{Vec2, median};
use crate::observer::{Artifact, Cancelled, Event, Observer};
use crate::settings::{SettingsError, Value};
use crate::spatial::PointIndex;
use crate::{choices, settings};

choices! {
    /// How dots are found.
    pub enum DetectMethod {
        /// The thesis's thinning of a black and white photo (section 2.2.3).
        Thin = "thin",
        /// Gaussian dots fitted to the rectified photo, to hundredths of a pixel.
        Gaussian = "gaussian",
    }
}

settings! {
    /// Detection of the projected dots.
    pub struct DetectParams {
        /// How dots are found.
        method: DetectMethod = DetectMethod::Thin;
        /// Side of the raster-scan window (thesis: 5x5), for `thin` without `merge`.
        window_px: usize = 5, range 1.0..=101.0, unit "px";
        /// Whether the window follows the dot, for `thin`: white pixels that touch are one dot. The
        /// thesis's fixed window cuts a dot whose top row does not begin at its left end in two, and
        /// joins dots closer than its side.
        merge: bool = true;
        /// Least number of white pixels of a dot; fewer are noise, for `thin` with `merge`.
        min_area_px: usize = 3, range 1.0..=10000.0, unit "px";
        /// Largest area of a dot in medians of all areas; larger are shine or dots run together,
        /// for `thin` with `merge`.
        max_area: f64 = 3.0, range 1.0..=1000.0;
        /// Whether a dot's place is rounded to a pixel, as in the thesis, or keeps its fraction,
        /// for `thin`.
        round: bool = true;
        /// The sub-pixel fit, for `gaussian`.
        gaussian: GaussianParams = GaussianParams::default();
    }
}

/// A photo in which no dots can be found.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DetectError {
    /// Too few dots.
    #[error(
        "{got} dots found, at least {needed} are needed; is this the photo with the pattern, and is it sharp? For the thesis's way try another filter.threshold or filter.level"
    )]
    TooFewDots {
        /// Dots found.
        got: usize,
        /// Dots needed.
        needed: usize,
    },
    /// No pixels.
    #[error("the photo has no pixels ({width}x{height})")]
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

crate::stage_error!(DetectError, "detect");

/// The dots of one photo.
#[derive(Clone, Debug, PartialEq)]
pub struct Detection {
    /// In raster order of their positions, pixels of the given image.
    pub dots: Vec<Dot>,
    /// Usual distance to the next dot, pixels.
    pub spacing_px: f64,
    /// One white pixel a dot on black (thesis Fig. 2.4); `thin` only.
    pub thinned: Option<Gray>,
}

/// Fewer dots than this are no pattern.
const LEAST_DOTS: usize = 12;

/// Finds the dots: of the black and white photo that `filter` makes (`thin`), or of the rectified
/// photo itself (`gaussian`).
///
/// # Errors
/// [`DetectError`] when fewer than a dozen dots are found.
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
        Some(spacing_px) if dots.len() >= LEAST_DOTS => Ok(Detection { dots, spacing_px, thinned }),
        _ => Err(DetectError::TooFewDots { got: dots.len(), needed: LEAST_DOTS }),
    }
}

/// Median distance from a dot to the nearest other one, pixels; `None` with fewer than two dots.
pub fn spacing_px(dots: &[Dot]) -> Option<f64> {
    let positions: Vec<Vec2> = dots.iter().map(|d| d.position).collect();
    let index = PointIndex::<2>::new(&positions)?;
    let nearest: Vec<f64> = positions
        .iter()
        .filter_map(|p| index.nearest_n(&[p.x, p.y], 2).get(1).map(|n| n.distance))
        .collect();
    median(&nearest).filter(|s| *s > 0.0)
}
