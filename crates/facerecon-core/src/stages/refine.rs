//! Stage refine: disparity by image matching on the dotted pair, at the dots and between them.
//!
//! The matches of the correspondence stage are the initial values.
//! 1. Where one photo is less sharp, the other one is smoothed to it. Then a window around each
//!    match is fitted by least squares (Gruen 1985).
//! 2. A bicubic B-spline of disparity is fitted to these matches.
//! 3. Gauss-Newton steps move its control values until the warped right photo agrees with the left
//!    one. Residuals are weighted by the noise at their brightness. A thin-plate energy resists
//!    bending, less so where the surface is creased, so that noses are not flattened.
//! 4. Pixels that cannot be measured reliably become holes.

mod bending;
mod binning;
mod descent;
mod image;
mod initial;
mod noise;
mod normal_equations;
mod photometry;
mod plane;
mod quality;
mod refined;
mod rows;
mod samples;
mod sharpness;
mod spline;
mod stiffness;
#[cfg(test)]
mod tests;
mod unmatched;
mod update;
mod window;

pub use refined::Refined;
pub use unmatched::match_remaining_dots;

use crate::camera::RectifiedRig;
use crate::data::{Gray, Match};
use crate::observer::{Cancelled, Event, Observer};
use crate::settings::{SettingsError, Value};
use crate::settings::{choices, settings};

use binning::Binning;
use descent::descend;
use image::RowSpline;
use photometry::PhotometricModel;
use samples::Sample;
use sharpness::equal_sharpness;
use stiffness::{Stiffness, depth_ratio};

/// The smoothing before matching is cut off at this many standard deviations.
const SMOOTH_CUTOFF: f64 = 3.5;

choices! {
    /// How disparity is measured.
    pub enum RefineMethod {
        /// By the positions of the dots only.
        None = "none",
        /// By image matching on the dotted pair, at the dots and between them.
        Photometric = "photometric",
    }
}

settings! {
    /// Measuring disparity by image matching.
    pub struct RefineParams {
        /// How disparity is measured; `none` skips the stage.
        method: RefineMethod = RefineMethod::Photometric;
        /// Distance between neighbouring dots or stripes; estimated from the matches when left out.
        pitch_px: Option<f64> = None, range 3.0..=400.0, unit "px";
        /// Half width of the windows matched at the dots, in pitches.
        window: f64 = 0.85, range 0.4..=3.0;
        /// Cell size of the disparity spline, in pitches.
        knot: f64 = 0.5, range 0.2..=2.0;
        /// Stiffness of the surface: weight of its squared bending in space against the squared
        /// residuals over their noise. Larger is smoother.
        stiffness: f64 = 22.0, range 0.0..=1e6;
        /// Radius of curvature below which bending costs less (creases), as a share of the size of
        /// the measured region (square root of its area).
        crease_radius: f64 = 0.15, range 0.001..=10.0;
        /// Gaussian smoothing of both photos before matching, in pixels of the photos as matched
        /// (reduced where the dots are far apart); reduces the bias that noise causes in
        /// interpolation between pixels.
        smooth_px: f64 = 0.4, range 0.0..=3.0, unit "px";
        /// Residuals of many more standard deviations than this hardly count (specular highlights,
        /// eyelashes): scale of the Geman-McClure weight.
        robust: f64 = 5.0, range 1.0..=20.0;
        /// Most Gauss-Newton steps.
        iterations: usize = 5, range 1.0..=50.0;
        /// Points with a larger standard deviation of the disparity become holes, in pitches.
        max_sigma: f64 = 0.066, range 0.001..=1.0;
        /// Points become holes where the local root mean square of the residuals is more than this
        /// many times the expected noise.
        max_misfit: f64 = 2.5, range 1.0..=20.0;
        /// Points become holes where the slopes of both photos agree on less than this share of the
        /// information (noise only: dark hair, deep shadow).
        min_agreement: f64 = 0.5, range 0.0..=1.0;
        /// Dots detected in one photo only are matched through the surface where its standard
        /// deviation is at most this, in pitches; 0 leaves them out.
        unmatched_sigma: f64 = 0.0167, range 0.0..=1.0;
        /// Points become holes where the surface is tilted further away from the cameras.
        max_tilt_deg: f64 = 82.0, range 10.0..=89.0, unit "degrees";
    }
}

/// Most control values of the spline (about 40 MB of normal equations). Its cells grow where the
/// photos would need more.
const MAX_CONTROL_VALUES: usize = 100_000;

/// Smallest number of matches to start from: three rows of four dots.
const MIN_MATCHES: usize = 12;

/// Smallest pitch that the matches may have, pixels.
const MIN_PITCH_PX: f64 = 1.0;

/// Why disparity could not be measured.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RefineError {
    /// A parameter is out of its range.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// The photos have different sizes.
    #[error(
        "the rectified photos differ in size: left {left_width}x{left_height}, right {right_width}x{right_height}; rectify both to the same size"
    )]
    SizeMismatch {
        /// Width of the left photo.
        left_width: usize,
        /// Height of the left photo.
        left_height: usize,
        /// Width of the right photo.
        right_width: usize,
        /// Height of the right photo.
        right_height: usize,
    },
    /// Too few matches to start from.
    #[error(
        "{got} matches agree with their neighbours (at least {needed} expected); check the pattern's size in the capture, the focus and the contrast of the dots"
    )]
    TooFewMatches {
        /// Usable matches.
        got: usize,
        /// Matches needed.
        needed: usize,
    },
    /// Every pixel is a hole.
    #[error(
        "the disparity could be measured at none of {pixels} pixels: the photos show different brightness or no pattern; check that left and right belong to one capture"
    )]
    NothingMeasured {
        /// Pixels tried.
        pixels: usize,
    },
    /// The observer cancelled the run.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

crate::stages::stage_error!(RefineError, "refine");

/// Refines matches and measures disparity between them.
///
/// `left` and `right` are the rectified dotted pair, grey levels 0 to 255, both of one size.
/// `matches` are in rectified pixels; those outside the photos are removed. `rig` sets the scale of
/// depth against disparity; without it cameras 15 cm apart and a face at 1.2 m are assumed.
///
/// # Errors
/// [`RefineError`] for parameters out of range, photos of different sizes, too few matches, photos
/// that agree nowhere, or when cancelled.
///
/// ```
/// use facerecon_core::data::{Gray, Match};
/// use facerecon_core::math::Vec2;
/// use facerecon_core::stages::refine::{RefineParams, refine};
///
/// // dots 9 px apart, everywhere at a disparity of 12 px
/// let dots = |x: f64, y: f64| {
///     let off = |v: f64| v - 9.0 * (v / 9.0).round();
///     (40.0 + 150.0 * (-(off(x).powi(2) + off(y).powi(2)) / 6.0).exp()) as f32
/// };
/// let left = Gray::from_fn(120, 90, |x, y| dots(x as f64, y as f64));
/// let right = Gray::from_fn(120, 90, |x, y| dots(x as f64 + 12.0, y as f64));
/// // matches with an error of a quarter of a pixel
/// let matches: Vec<Match> = (0..80)
///     .map(|k| Vec2::new(f64::from(27 + 9 * (k % 10)), f64::from(9 + 9 * (k / 10))))
///     .map(|left| Match {
///         left,
///         right: left - Vec2::new(11.75, 0.0),
///         lattice: None,
///         sigma_px: 0.0,
///         score: 1.0,
///     })
///     .collect();
///
/// let refined = refine(&left, &right, None, &matches, &RefineParams::default(), &())?;
/// assert!((refined.matches[0].disparity() - 12.0).abs() < 0.05);
/// assert!((refined.disparity.at(60, 40) - 12.0).abs() < 0.05);
/// # Ok::<(), facerecon_core::stages::refine::RefineError>(())
/// ```
pub fn refine(
    left: &Gray,
    right: &Gray,
    rig: Option<&RectifiedRig>,
    matches: &[Match],
    params: &RefineParams,
    observer: &dyn Observer,
) -> Result<Refined, RefineError> {
    params.check("refine", None)?;
    require_equal_sizes(left, right)?;
    let inside: Vec<Match> = matches.iter().copied().filter(|m| is_inside(m, left)).collect();
    let samples: Vec<Sample> = inside.iter().map(Sample::new).collect();
    let pitch_px = pitch_px(&samples, params)?;

    let binning = Binning::for_pitch(pitch_px);
    let pitch = pitch_px / binning.factor();
    let working = |photo: &Gray| binning.reduce(photo).blurred_to(params.smooth_px, SMOOTH_CUTOFF);
    let mut samples: Vec<Sample> = samples.iter().map(|s| binning.working_sample(s)).collect();
    let levelled = working(&rows::levelled(right, &inside, pitch_px));
    let (working_left, levelled, blur_px) =
        equal_sharpness(working(left), levelled, &samples, pitch);
    let working_right = RowSpline::new(&levelled);

    let half_width = params.window * pitch;
    let reliable =
        initial::measure_windows(&mut samples, &working_left, &working_right, pitch, half_width);
    let reliable: Vec<Sample> = reliable.iter().map(|&i| samples[i]).collect();
    if reliable.len() < MIN_MATCHES {
        return Err(too_few(reliable.len()));
    }
    observer.check()?;

    let (width, height) = working_left.size();
    let domain = initial::domain(&reliable, pitch, width, height);
    let pixels = domain.data().iter().filter(|p| **p).count();
    let cell = cell_size(params.knot * pitch, width, height);
    let mut spline =
        initial::spline(&reliable, &domain, pitch, cell).ok_or_else(|| too_few(reliable.len()))?;
    let model = PhotometricModel::new(
        working_left,
        working_right,
        domain,
        pitch,
        params.smooth_px,
        params.robust,
    );
    let stiffness = Stiffness::new(spline.cell, pixels, depth_ratio(rig, &inside), params);
    let last = descend(&model, &mut spline, &stiffness, pitch, params.iterations, observer)?;

    let limits = limits(params, pitch, stiffness.depth_ratio);
    let sigma = quality::sigma(&model, &spline, &last, pitch, &limits);
    let (disparity, sigma_px) = binning.enlarge(&spline, &sigma, left.size());
    if !disparity.data().iter().any(|d| d.is_finite()) {
        return Err(RefineError::NothingMeasured { pixels });
    }
    let matches = update::updated_matches(
        &inside,
        &samples,
        binning,
        &spline,
        &sigma,
        pitch,
        params.max_sigma * pitch_px,
    );
    let dropped = inside.len() - matches.len();
    observer.event(&Event::Count { stage: "refine", what: "matches", count: matches.len() });
    observer.event(&Event::Count { stage: "refine", what: "matches dropped", count: dropped });
    Ok(Refined {
        matches,
        disparity,
        sigma_px,
        pitch_px,
        dropped,
        misfit: last.misfit,
        blur_difference: blur_px / pitch,
    })
}

fn require_equal_sizes(left: &Gray, right: &Gray) -> Result<(), RefineError> {
    if left.size() == right.size() {
        return Ok(());
    }
    let ((left_width, left_height), (right_width, right_height)) = (left.size(), right.size());
    Err(RefineError::SizeMismatch { left_width, left_height, right_width, right_height })
}

fn too_few(got: usize) -> RefineError {
    RefineError::TooFewMatches { got, needed: MIN_MATCHES }
}

/// Whether both positions of a match lie inside the photos.
fn is_inside(m: &Match, image: &Gray) -> bool {
    let (w, h) = (image.width() as f64, image.height() as f64);
    let inside = |x: f64, y: f64| x >= 0.0 && y >= 0.0 && x <= w - 1.0 && y <= h - 1.0;
    inside(m.left.x, m.left.y) && inside(m.right.x, m.right.y)
}

/// The given or estimated pitch in given pixels.
fn pitch_px(samples: &[Sample], params: &RefineParams) -> Result<f64, RefineError> {
    params
        .pitch_px
        .or_else(|| samples::pitch(samples))
        .filter(|p| p.is_finite() && *p >= MIN_PITCH_PX && samples.len() >= MIN_MATCHES)
        .ok_or_else(|| too_few(samples.len()))
}

/// Cell size of the spline, working pixels: the one asked for, or larger where the photos would
/// need too many control values.
fn cell_size(cell: f64, width: usize, height: usize) -> f64 {
    cell.max(((width * height) as f64 / MAX_CONTROL_VALUES as f64).sqrt())
}

/// The limits of the parameters in working pixels.
fn limits(params: &RefineParams, pitch: f64, depth_ratio: f64) -> quality::Limits {
    quality::Limits {
        sigma_px: params.max_sigma * pitch,
        misfit: params.max_misfit,
        agreement: params.min_agreement,
        slope: params.max_tilt_deg.to_radians().tan() / depth_ratio,
    }
}
