//! Filter: white dots on black from a dotted photo (thesis section 2.2).
//!
//! Steps: histogram equalisation (optional), sharpening (Eq. 2.1), thresholding. The thesis gives no
//! value for its fixed threshold, and reports that it fails in dark regions. The default is therefore
//! a threshold relative to the surroundings; the fixed one can be chosen.

mod equalize;
mod sharpen;
mod threshold;

#[cfg(test)]
mod tests;

pub use sharpen::sharpen;

use equalize::{equalize_clahe, equalize_global};
use threshold::{otsu_level, threshold_fixed, threshold_local};

use crate::data::Gray;
use crate::observer::{Artifact, Cancelled, Observer};
use crate::settings::{SettingsError, Value};
use crate::settings::{choices, settings};

choices! {
    /// Histogram equalisation before sharpening (future work in the thesis).
    pub enum Equalize {
        /// No equalisation, as in the thesis.
        None = "none",
        /// One mapping for the whole photo.
        Global = "global",
        /// Contrast-limited: one mapping for each tile, interpolated between tiles (Zuiderveld 1994).
        Clahe = "clahe",
    }
}

choices! {
    /// How white is separated from black.
    pub enum Threshold {
        /// Above the grey level `level` everywhere, as in the thesis.
        Fixed = "fixed",
        /// Above the level that separates the histogram best (Otsu 1979).
        Otsu = "otsu",
        /// Above the mean of the surroundings by `deviations` standard deviations, at least
        /// `contrast` (after Niblack 1986): also works in shadow and on dark skin.
        Local = "local",
    }
}

settings! {
    /// Preprocessing of the photos for `detect.method = "thin"` (thesis section 2.2).
    pub struct FilterParams {
        /// Histogram equalisation before sharpening.
        equalize: Equalize = Equalize::None;
        /// Tiles along each side of the photo, for `equalize = "clahe"`.
        tiles: usize = 8, range 1.0..=64.0;
        /// Clip limit of `clahe`, in multiples of the mean histogram bin: 1 changes the photo hardly,
        /// large values equalise fully.
        clip_limit: f64 = 2.0, range 1.0..=1000.0;
        /// Standard deviation of a blur before sharpening, against the sensor noise that Eq. 2.1
        /// amplifies five times; 0 as in the thesis.
        smooth_px: f64 = 1.0, range 0.0..=20.0, unit "px";
        /// The sharpening kernel, row by row, with an odd number of rows and as many columns. Its sum
        /// should be 1: a larger sum brightens the photo, a smaller one darkens it. Default: Eq. 2.1.
        kernel: Vec<f64> = vec![-0.5, -0.5, -0.5, -0.5, 5.0, -0.5, -0.5, -0.5, -0.5];
        /// How white is separated from black.
        threshold: Threshold = Threshold::Local;
        /// Grey level of the fixed threshold, on the sharpened photo.
        level: f64 = 128.0, range 0.0..=255.0, unit "grey levels";
        /// Side of the square window of the local threshold; two to five dot spacings.
        window_px: usize = 31, range 3.0..=1001.0, unit "px";
        /// Height of the local threshold above the mean of its window, in standard deviations.
        deviations: f64 = 0.8, range -5.0..=5.0;
        /// Minimum height of the local threshold above the mean of its window.
        contrast: f64 = 10.0, range 0.0..=255.0, unit "grey levels";
    }
}

/// A photo that cannot be filtered.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FilterError {
    /// No pixels.
    #[error("the photo has {width}x{height} pixels (at least 1x1 expected); give another photo")]
    Empty {
        /// Width found.
        width: usize,
        /// Height found.
        height: usize,
    },
    /// A kernel that is not an odd square.
    #[error(
        "filter.kernel has {got} numbers, but must have 1, 9, 25, 49 ... (the square of an odd number); give them row by row"
    )]
    Kernel {
        /// Numbers found.
        got: usize,
    },
    /// A kernel with an entry that is not finite.
    #[error("filter.kernel contains {got}, but every entry must be a finite number; correct it")]
    KernelEntry {
        /// Entry found.
        got: f64,
    },
    /// A pixel that is not finite.
    #[error(
        "pixel ({x}, {y}) of the photo is not a finite number; give a photo with grey levels 0 to 255"
    )]
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

crate::stages::stage_error!(FilterError, "filter");

/// The photo after each step, all of its size, grey levels 0 to 255.
#[derive(Clone, Debug, PartialEq)]
pub struct Filtered {
    /// After equalisation; `None` without.
    pub equalized: Option<Gray>,
    /// After sharpening (thesis Fig. 2.2).
    pub sharpened: Gray,
    /// After thresholding: 0 or 255 (thesis Fig. 2.3).
    pub binary: Gray,
}

/// Tolerance of the kernel's sum about 1 before a warning: rounding of decimal entries.
const KERNEL_SUM_TOLERANCE: f64 = 1e-6;

/// Computes a black and white photo of the dots from a dotted photo (grey levels 0 to 255).
///
/// Warns of a kernel whose sum is not 1.
///
/// ```
/// use facerecon_core::data::Gray;
/// use facerecon_core::stages::filter::{FilterParams, filter};
///
/// let dot = |v: usize| (v as f32 % 10.0 - 5.0).powi(2);
/// let photo = Gray::from_fn(60, 40, |x, y| 30.0 + 120.0 * (-(dot(x) + dot(y)) / 4.0).exp());
/// let filtered = filter(&photo, &FilterParams::default(), &())?;
/// assert_eq!(filtered.binary.at(25, 15), 255.0);
/// assert_eq!(filtered.binary.at(20, 10), 0.0);
/// # Ok::<(), facerecon_core::stages::filter::FilterError>(())
/// ```
///
/// # Errors
/// [`FilterError`] for a photo without pixels or with values that are not finite, a kernel that is
/// not an odd square, a parameter out of its range, and a cancelled run.
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
    let sharpened = sharpen(&source.blurred_f64(params.smooth_px), &params.kernel)?;
    let sum: f64 = params.kernel.iter().sum();
    if (sum - 1.0).abs() > KERNEL_SUM_TOLERANCE {
        let message = format!(
            "the sum of filter.kernel is {sum:.3} (1 expected), so the photo becomes {}; divide the entries by their sum",
            if sum > 1.0 { "brighter" } else { "darker" }
        );
        observer.warn("filter", &message);
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

/// Histogram equalisation by `params.equalize`; `None` for `none`.
pub fn equalize(image: &Gray, params: &FilterParams) -> Option<Gray> {
    match params.equalize {
        Equalize::None => None,
        Equalize::Global => Some(equalize_global(image)),
        Equalize::Clahe => Some(equalize_clahe(image, params.tiles, params.clip_limit)),
    }
}

/// Thresholding by `params.threshold` (thesis section 2.2.2): larger than the threshold is white
/// (255), else black (0).
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
