//! Filter: a photo of dots becomes white dots on black (thesis section 2.2).
//!
//! Recipe: equalise the histogram if asked, sharpen (Eq. 2.1), threshold. The thesis gives no value
//! for its threshold and names dark places as its trouble; the default is therefore a local
//! threshold, relative to the surroundings, and the fixed one of the thesis is a choice.

mod equalize;
mod sharpen;
mod threshold;

#[cfg(test)]
mod tests;

pub use equalize::{equalize_clahe, equalize_global};
pub use sharpen::{blur, sharpen};
pub use threshold::{otsu_level, threshold_fixed, threshold_local};

use crate::data::Gray;
use crate::observer::{Artifact, Cancelled, Event, Observer};
use crate::settings::{SettingsError, Value};
use crate::{choices, settings};

choices! {
    /// Histogram equalisation before sharpening (the thesis left it for later).
    pub enum Equalize {
        /// None, as in the thesis.
        None = "none",
        /// One mapping for the whole photo.
        Global = "global",
        /// Contrast-limited, a mapping for each tile, blended between tiles (Zuiderveld 1994).
        Clahe = "clahe",
    }
}

choices! {
    /// How white is told from black.
    pub enum Threshold {
        /// Above the grey level `level` everywhere, as in the thesis.
        Fixed = "fixed",
        /// Above the one level that parts the histogram best (Otsu 1979).
        Otsu = "otsu",
        /// Above the mean of the surroundings by `deviations` standard deviations, at least
        /// `contrast` (after Niblack 1986): holds in shadow and on dark skin.
        Local = "local",
    }
}

settings! {
    /// Preprocessing of the photos before thinning (thesis section 2.2).
    pub struct FilterParams {
        /// Histogram equalisation before sharpening.
        equalize: Equalize = Equalize::None;
        /// Tiles along each side for `equalize = "clahe"`.
        tiles: usize = 8, range 1.0..=64.0;
        /// Clip limit of `clahe`, in multiples of a flat histogram's bin; 1 leaves the photo nearly
        /// as it is, large values equalise fully.
        clip_limit: f64 = 2.0, range 1.0..=1000.0;
        /// Standard deviation of a blur before sharpening, against the sensor noise that Eq. 2.1
        /// amplifies five times; 0 is the thesis's way.
        smooth_px: f64 = 1.0, range 0.0..=20.0, unit "px";
        /// The sharpening matrix, row by row: any odd square. Its sum should be 1 (more brightens,
        /// less darkens). Default: Eq. 2.1.
        kernel: Vec<f64> = vec![-0.5, -0.5, -0.5, -0.5, 5.0, -0.5, -0.5, -0.5, -0.5];
        /// How white is told from black.
        threshold: Threshold = Threshold::Local;
        /// Grey level of the fixed threshold, on the sharpened photo.
        level: f64 = 128.0, range 0.0..=255.0, unit "grey levels";
        /// Side of the square of surroundings for the local threshold; two to five dot spacings.
        window_px: usize = 31, range 3.0..=1001.0, unit "px";
        /// Standard deviations of the surroundings above their mean (local threshold).
        deviations: f64 = 0.8, range -5.0..=5.0;
        /// Least height above the mean of the surroundings (local threshold).
        contrast: f64 = 10.0, range 0.0..=255.0, unit "grey levels";
    }
}

/// A photo that cannot be filtered.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FilterError {
    /// No pixels.
    #[error("the photo has no pixels ({width}x{height})")]
    Empty {
        /// Width found.
        width: usize,
        /// Height found.
        height: usize,
    },
    /// A kernel that is no odd square.
    #[error(
        "filter.kernel has {got} numbers; an odd square is needed: 1, 9, 25, 49 ... numbers, row by row"
    )]
    Kernel {
        /// Numbers found.
        got: usize,
    },
    /// A kernel with an entry that is not a finite number.
    #[error("filter.kernel holds {got}, but every entry must be a finite number")]
    KernelEntry {
        /// Entry found.
        got: f64,
    },
    /// A pixel that is not a number.
    #[error("the photo's pixel ({x}, {y}) is not a finite number")]
    NotFinite {
        /// Column.
        x: usize,
        /// Row.
        y: usize,
    },
    /// A parameter out of its range.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// Cancelled by the observer.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

crate::stage_error!(FilterError, "filter");

/// The photo after each step; all of the photo's size, 0 to 255.
#[derive(Clone, Debug, PartialEq)]
pub struct Filtered {
    /// After equalisation, where it was asked for.
    pub equalized: Option<Gray>,
    /// After sharpening (thesis Fig. 2.2).
    pub sharpened: Gray,
    /// After thresholding: 0 or 255 (thesis Fig. 2.3).
    pub binary: Gray,
}

/// Makes a photo of projected dots a black and white one.
///
/// # Errors
/// [`FilterError`] for a photo without pixels or with NaN, or a kernel that is no odd square.
pub fn filter(
    image: &Gray,
    params: &FilterParams,
    observer: &dyn Observer,
) -> Result<Filtered, FilterError> {
    params.check("filter", None)?;
    validate(image)?;
    let equalized = equalize(image, params);
    observer.check()?;
    let source = equalized.as_ref().unwrap_or(image);
    let sharpened = sharpen(&blur(source, params.smooth_px), &params.kernel)?;
    let sum: f64 = params.kernel.iter().sum();
    if (sum - 1.0).abs() > 1e-6 {
        let message = format!(
            "the sharpening kernel sums to {sum:.3}, not 1: the photo becomes {}",
            if sum > 1.0 { "brighter" } else { "darker" }
        );
        observer.event(&Event::Warning { stage: "filter", message: &message });
    }
    observer.check()?;
    let binary = threshold(&sharpened, params);
    if let Some(equalized) = &equalized {
        observer.artifact("filter", "equalized", Artifact::Gray(equalized));
    }
    observer.artifact("filter", "sharpened", Artifact::Gray(&sharpened));
    observer.artifact("filter", "binary", Artifact::Gray(&binary));
    Ok(Filtered { equalized, sharpened, binary })
}

/// Histogram equalisation as the parameters say; `None` when they say none.
pub fn equalize(image: &Gray, params: &FilterParams) -> Option<Gray> {
    match params.equalize {
        Equalize::None => None,
        Equalize::Global => Some(equalize_global(image)),
        Equalize::Clahe => Some(equalize_clahe(image, params.tiles, params.clip_limit)),
    }
}

/// Thresholding as the parameters say (thesis section 2.2.2): larger than the threshold is white.
pub fn threshold(image: &Gray, params: &FilterParams) -> Gray {
    match params.threshold {
        Threshold::Fixed => threshold_fixed(image, params.level),
        Threshold::Otsu => threshold_fixed(image, otsu_level(image)),
        Threshold::Local => {
            threshold_local(image, params.window_px, params.deviations, params.contrast)
        }
    }
}

fn validate(image: &Gray) -> Result<(), FilterError> {
    let (width, height) = image.size();
    if width == 0 || height == 0 {
        return Err(FilterError::Empty { width, height });
    }
    match image.data().iter().position(|v| !v.is_finite()) {
        Some(i) => Err(FilterError::NotFinite { x: i % width, y: i / width }),
        None => Ok(()),
    }
}
