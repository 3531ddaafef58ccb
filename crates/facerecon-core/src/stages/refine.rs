//! Refine: disparity measured by matching the patterned pictures themselves, at the dots and
//! between them.
//!
//! The matches of the correspondence stage only say where to begin. A window about each one is
//! matched by least squares (Gruen 1985); a smooth surface (bicubic B-spline) is laid through them
//! and then moved until the warped right picture explains the left one, pixel by pixel, with the
//! noise measured by brightness and bending resisted as a stiff sheet would, less where the
//! surface is creased. So no window flattens a nose, and every dot lends its strength to its
//! neighbours. What cannot be measured stays a hole.

mod bending;
mod binning;
mod descent;
mod image;
mod lone;
mod normal;
mod photometry;
mod prior;
mod quality;
mod surface;
#[cfg(test)]
mod tests;
mod window;

use crate::camera::RectifiedRig;
use crate::data::{Gray, Match};
use crate::math::median;
use crate::observer::{Cancelled, Event, Observer};
use crate::settings::{SettingsError, Value};
use crate::{choices, settings};

use bending::Bending;
use binning::{Binning, binned, moved};
use descent::{Sheet, descend};
use image::{RowSpline, shifted_down, smoothed};
use photometry::Scene;
use prior::Sample;

choices! {
    /// How disparity is measured.
    pub enum RefineMethod {
        /// As the dots' positions say.
        None = "none",
        /// By matching the patterned photos themselves, at the dots and between them.
        Photometric = "photometric",
    }
}

settings! {
    /// Measuring disparity by image matching.
    pub struct RefineParams {
        /// How disparity is measured; `none` skips the stage.
        method: RefineMethod = RefineMethod::Photometric;
        /// Distance between neighbouring dots or stripes; measured from the matches when left out.
        pitch_px: Option<f64> = None, range 3.0..=400.0, unit "px";
        /// Half width of the windows matched at the dots, in pitches.
        window: f64 = 0.85, range 0.4..=3.0;
        /// Width of the surface's cells, in pitches.
        knot: f64 = 0.5, range 0.2..=2.0;
        /// Stiffness of the surface: weight of its squared bending, in space, against the
        /// photographs' residuals over their noise. Larger is smoother.
        stiffness: f64 = 22.0, range 0.0..=1e6;
        /// Radius at which the surface counts as creased and bends more freely, as a share of the
        /// measured region's size (root of its area).
        crease_radius: f64 = 0.15, range 0.001..=10.0;
        /// Smoothing of both photographs before they are compared (against the bias that noise
        /// brings to interpolation).
        smooth_px: f64 = 0.4, range 0.0..=3.0, unit "px";
        /// Residuals beyond this many standard deviations lose their say (shine, eyelashes).
        robust: f64 = 5.0, range 1.0..=20.0;
        /// Most Gauss-Newton steps.
        iterations: usize = 5, range 1.0..=50.0;
        /// Points with a larger standard deviation of the disparity become holes.
        max_sigma_px: f64 = 0.6, range 0.01..=10.0, unit "px";
        /// Points whose neighbourhood's residuals exceed the expected noise this many times become
        /// holes.
        max_misfit: f64 = 2.5, range 1.0..=20.0;
        /// Points become holes where less than this share of the pictures' slopes is common to both
        /// (dark hair, deep shadow: noise only).
        min_agreement: f64 = 0.5, range 0.0..=1.0;
        /// Dots that only one photo shows are placed in the other where the surface is measured to
        /// this standard deviation; 0 leaves them out.
        lone_sigma_px: f64 = 0.15, range 0.0..=10.0, unit "px";
        /// Points whose surface is turned further away from the cameras become holes.
        max_tilt_deg: f64 = 82.0, range 10.0..=89.0, unit "degrees";
    }
}

/// Most control values of the surface; cells grow where a picture would need more.
const MAX_KNOTS: usize = 100_000;

/// Least number of matches to begin with.
pub const MIN_MATCHES: usize = 12;

/// Why disparity could not be measured.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RefineError {
    /// A parameter out of its range.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// Pictures of different sizes.
    #[error(
        "the rectified pictures differ in size: left {left_width}x{left_height}, right {right_width}x{right_height}; rectify both onto one canvas"
    )]
    SizeMismatch {
        /// Width of the left picture.
        left_width: usize,
        /// Height of the left picture.
        left_height: usize,
        /// Width of the right picture.
        right_width: usize,
        /// Height of the right picture.
        right_height: usize,
    },
    /// Too little to begin with.
    #[error(
        "{got} matches agree with their neighbours, but image matching needs {needed} to begin; check the pattern's size in the capture, the focus and the contrast of the dots"
    )]
    TooFewMatches {
        /// Usable matches.
        got: usize,
        /// Matches needed.
        needed: usize,
    },
    /// Nothing but holes.
    #[error(
        "the photographs could be matched at none of {pixels} pixels: their brightness is unlike or carries no pattern; check that left and right belong together"
    )]
    NothingMeasured {
        /// Pixels tried.
        pixels: usize,
    },
    /// Cancelled by the observer.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

crate::stage_error!(RefineError, "refine");

/// What was measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Refined {
    /// The matches with refined disparity (`right.x` moved) and its standard deviation, in the
    /// order given; those that contradict all their neighbours are gone.
    pub matches: Vec<Match>,
    /// Disparity `xl - xr` at every pixel of the rectified left picture; NaN in holes.
    pub disparity: Gray,
    /// Its standard deviation, pixels; NaN in holes.
    pub sigma_px: Gray,
    /// Distance between neighbouring dots or stripes, pixels.
    pub pitch_px: f64,
    /// Matches dropped.
    pub dropped: usize,
    /// Root mean square of the residuals over their expected noise (about 1).
    pub misfit: f64,
}

/// Refines matches and measures disparity between them, on a rectified patterned pair. `rig` says
/// how deep a pixel of disparity is; without it a usual portrait rig is assumed.
///
/// # Errors
/// [`RefineError`]: sizes, parameters, too few matches, nothing measured, or cancelled.
pub fn refine(
    left: &Gray,
    right: &Gray,
    rig: Option<&RectifiedRig>,
    matches: &[Match],
    params: &RefineParams,
    observer: &dyn Observer,
) -> Result<Refined, RefineError> {
    params.check("refine", None)?;
    if left.size() != right.size() {
        let ((left_width, left_height), (right_width, right_height)) = (left.size(), right.size());
        return Err(RefineError::SizeMismatch {
            left_width,
            left_height,
            right_width,
            right_height,
        });
    }
    let usable: Vec<Match> = matches.iter().copied().filter(|m| is_inside(m, left)).collect();
    let too_few = |got| RefineError::TooFewMatches { got, needed: MIN_MATCHES };
    let samples: Vec<Sample> = usable.iter().map(sample).collect();
    let pitch_px = params
        .pitch_px
        .or_else(|| prior::pitch(&samples))
        .filter(|p| p.is_finite() && *p >= 1.0 && usable.len() >= MIN_MATCHES)
        .ok_or(too_few(usable.len()))?;

    // Pictures much finer than the pattern are binned: the dots, not the pixels, set the detail.
    let bin = ((pitch_px / 8.0) as usize).clamp(1, 8);
    let grid = Binning { bin: bin as f64 };
    let pitch = pitch_px / grid.bin;
    let level = level_rows(right, &usable);
    let small_left = smoothed(&binned(left, bin), params.smooth_px);
    let small_right = RowSpline::new(&smoothed(&binned(&level, bin), params.smooth_px));

    let mut samples: Vec<Sample> = samples.iter().map(|s| grid.shrink(s)).collect();
    let kept = first_look(&mut samples, &small_left, &small_right, pitch, params);
    let firm: Vec<Sample> = kept.iter().map(|&i| samples[i]).collect();
    if firm.len() < MIN_MATCHES {
        return Err(too_few(firm.len()));
    }
    stop(observer)?;

    let (width, height) = small_left.size();
    let domain = prior::domain(&firm, pitch, width, height);
    let pixels = domain.data().iter().filter(|p| **p).count();
    let knot = (params.knot * pitch).max(((width * height) as f64 / MAX_KNOTS as f64).sqrt());
    let mut surface =
        prior::first_surface(&firm, &domain, pitch, knot).ok_or(too_few(firm.len()))?;
    let scene = Scene {
        left: small_left,
        right: small_right,
        domain,
        gain_sigma_px: 0.7 * pitch,
        robust: params.robust,
        independence: 1.0 / (4.0 * std::f64::consts::PI * params.smooth_px.powi(2)).max(1.0),
    };
    let sheet = Sheet {
        relief: relief(rig, &usable),
        bending: Bending::new(surface.knot),
        stiffness: params.stiffness,
        crease: 1.0 / (params.crease_radius * (pixels as f64).sqrt()),
    };
    let last = descend(&scene, &mut surface, &sheet, params, observer)?;

    let limits = quality::Limits {
        sigma_px: params.max_sigma_px / grid.bin,
        misfit: params.max_misfit,
        agreement: params.min_agreement,
        tilt: params.max_tilt_deg.to_radians().tan() / sheet.relief,
    };
    let sigma = quality::sigma(&scene, &surface, &last, pitch, &limits);
    let (disparity, sigma_px) = grid.enlarge(&surface, &sigma, left.size());
    if !disparity.data().iter().any(|d| d.is_finite()) {
        return Err(RefineError::NothingMeasured { pixels });
    }
    let matches = moved(&usable, &samples, &grid, &surface, &sigma, pitch, params.max_sigma_px);
    let dropped = usable.len() - matches.len();
    observer.event(&Event::Count { stage: "refine", what: "matches", count: matches.len() });
    observer.event(&Event::Count { stage: "refine", what: "matches dropped", count: dropped });
    Ok(Refined { matches, disparity, sigma_px, pitch_px, dropped, misfit: last.misfit })
}

fn stop(observer: &dyn Observer) -> Result<(), RefineError> {
    observer.check()?;
    Ok(())
}

fn is_inside(m: &Match, image: &Gray) -> bool {
    let (w, h) = (image.width() as f64, image.height() as f64);
    let inside = |x: f64, y: f64| x >= 0.0 && y >= 0.0 && x <= w - 1.0 && y <= h - 1.0;
    inside(m.left.x, m.left.y) && inside(m.right.x, m.right.y)
}

fn sample(m: &Match) -> Sample {
    Sample { x: m.left.x, y: m.left.y, disparity: m.disparity() }
}

/// The right picture with its rows where the matches say the left one's are, when they differ
/// smoothly by more than a few hundredths of a pixel.
fn level_rows(right: &Gray, matches: &[Match]) -> Gray {
    let centre = [right.width() as f64 / 2.0, right.height() as f64 / 2.0];
    let size = centre[0].max(centre[1]).max(1.0);
    let points: Vec<[f64; 4]> = matches
        .iter()
        .map(|m| {
            let (u, v) = ((m.right.x - centre[0]) / size, (m.right.y - centre[1]) / size);
            [u, v, m.right.y - m.left.y, 1.0]
        })
        .collect();
    let Some((plane, _)) = prior::robust_plane(&points, 0.02) else {
        return right.clone();
    };
    if plane.abs().sum() < 0.04 {
        return right.clone();
    }
    shifted_down(right, |x, y| {
        plane[0] + plane[1] * (x - centre[0]) / size + plane[2] * (y - centre[1]) / size
    })
}

/// Matches a window at every sample that the pattern needs, writes what it measured into the
/// sample, and returns those that agree with their neighbours.
fn first_look(
    samples: &mut [Sample],
    left: &Gray,
    right: &RowSpline,
    pitch: f64,
    params: &RefineParams,
) -> Vec<usize> {
    let chosen = prior::thinned(samples, pitch);
    let mut working: Vec<Sample> = chosen.iter().map(|&i| samples[i]).collect();
    // gross errors first: a window may not walk to a neighbouring dot
    let sound = prior::consistent(&working, pitch);
    let half = params.window * pitch;
    let measured = window::match_windows(left, right, &working, half, 0.2 * pitch);
    for (s, m) in working.iter_mut().zip(&measured) {
        if let Some(m) = m.filter(|m| m.sigma_px < 0.05 * pitch) {
            s.disparity = m.disparity;
        }
    }
    let agree = prior::consistent(&working, pitch);
    let mut kept = Vec::new();
    for (k, &i) in chosen.iter().enumerate() {
        samples[i] = working[k];
        if sound[k] && agree[k] {
            kept.push(i);
        }
    }
    kept
}

/// Depth in pixels across per pixel of disparity, `Z / B`.
fn relief(rig: Option<&RectifiedRig>, matches: &[Match]) -> f64 {
    let disparities: Vec<f64> = matches.iter().map(Match::disparity).collect();
    let depth = |r: &RectifiedRig| r.depth_mm(median(&disparities)?).map(|z| z / r.baseline_mm);
    // cameras 15 cm apart, a face at 1.2 m
    rig.and_then(depth).filter(|k| k.is_finite()).map_or(8.0, |k| k.clamp(1.0, 50.0))
}
