//! Cameras: estimate uncalibrated cameras from the photos.
//!
//! Level rows leave two numbers open that determine the shape of the face: the focal length and the
//! disparity of infinity. Their ratio scales depth relative to width, their size is the strength of
//! perspective. The projector is a third view: dots equally spaced along both directions of the
//! lattice, from a projector with square pixels, are square for one scale of depth only (image of
//! the absolute conic, Hartley and Zisserman 2004, section 19.3). Photos of one face hardly
//! determine the strength of perspective; for it the usual lens of a portrait rig is assumed. An
//! error of a third moves the surface by a tenth of a millimetre.

mod posterior;

#[cfg(test)]
mod tests;

use crate::camera::{RectifiedRig, resect};
use crate::data::Match;
use crate::math::{Mat3, Vec2, Vec3, median, percentile};
use crate::observer::{Cancelled, Observer};
use crate::settings::settings;
use crate::settings::{SettingsError, Value};
use posterior::CameraPosterior;

settings! {
    /// Estimating the cameras of a capture without calibration.
    pub struct CamerasParams {
        /// Whether unknown cameras are estimated from the lattice of the pattern, which must be
        /// square (as `facerecon pattern` makes it); else depth follows from the template (thesis
        /// Eq. 2.3).
        estimate: bool = true;
        /// Usual focal length, in widths of the photo.
        focal_widths: f64 = 3.0, range 0.3..=30.0;
        /// Standard deviation of the logarithm of the focal length about the usual one.
        focal_spread: f64 = 0.4, range 0.01..=3.0;
        /// Usual distance of the face, in distances between the cameras.
        distance_baselines: f64 = 8.0, range 1.0..=100.0;
        /// Standard deviation of the logarithm of that distance.
        distance_spread: f64 = 0.35, range 0.01..=3.0;
        /// Relative deviation from a square lattice caused by lenses and projector.
        lattice_error: f64 = 5e-4, range 1e-6..=0.1;
        /// Maximum relative standard deviation of depth against width at which the estimate is
        /// used.
        max_depth_error: f64 = 0.2, range 0.001..=1.0;
    }
}

/// Cameras estimated from the photos. `Display` gives the figures in one line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EstimatedCameras {
    /// The pair as two equal cameras side by side. Its unit of length is about a millimetre.
    pub rig: RectifiedRig,
    /// Relative standard deviation of depth against width.
    pub depth_error: f64,
    /// Relative standard deviation of the focal length, and so of the perspective.
    pub focal_error: f64,
}

/// Why the cameras cannot be estimated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CamerasError {
    /// Too few dots with lattice labels.
    #[error("{got} matches have lattice labels (at least {needed} expected)")]
    TooFewLabels {
        /// Found.
        got: usize,
        /// Needed.
        needed: usize,
    },
    /// Dots that do not determine the projector.
    #[error("the dots do not determine the pose of the projector")]
    Degenerate,
    /// A projector in line with the cameras does not determine depth.
    #[error(
        "the lattice determines depth to {found_percent:.0} % (at most {needed_percent:.0} % expected); move the projector away from the line between the cameras"
    )]
    Uncertain {
        /// Relative standard deviation found, percent.
        found_percent: f64,
        /// Maximum, percent.
        needed_percent: f64,
    },
    /// A parameter out of its range.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// Cancelled by the observer.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

crate::stages::stage_error!(CamerasError, "cameras");

/// Fewer labelled dots than this do not determine the cameras. Set by hand: five dots for each of
/// the twelve entries of the projection.
const MIN_LABELS: usize = 60;
/// Scale of disparity that makes a pixel of it about as long as one across: the usual distance over
/// the baseline.
const DISPARITY_SCALE: f64 = 8.0;
/// Width of a face between its outer dots, about, mm: sets the unit of length.
const FACE_WIDTH_MM: f64 = 120.0;
/// Percentiles of the columns between which the outer dots are measured.
const OUTER_PERCENTILES: [f64; 2] = [0.05, 0.95];

/// Estimates focal length and disparity of infinity from matches (rectified pixels) with labels in
/// a square lattice, and from what is usual for rigs. `size` (width, height) is that of the
/// rectified pictures; the optical axis is assumed to be in their middle.
///
/// Warns that the cameras were estimated, with the figures.
///
/// ```
/// use facerecon_core::stages::cameras::{CamerasError, CamerasParams, estimate_cameras};
///
/// // without labelled matches the cameras cannot be estimated
/// let found = estimate_cameras(&[], (768, 576), &CamerasParams::default(), &());
/// assert!(matches!(found, Err(CamerasError::TooFewLabels { got: 0, .. })));
/// ```
///
/// # Errors
/// [`CamerasError`] where the lattice does not determine the cameras, which is a normal outcome; for
/// a parameter out of its range; and for a cancelled run.
pub fn estimate_cameras(
    matches: &[Match],
    size: (usize, usize),
    params: &CamerasParams,
    observer: &dyn Observer,
) -> Result<EstimatedCameras, CamerasError> {
    params.check("cameras", None)?;
    observer.check()?;
    let middle = Vec2::new(size.0 as f64 - 1.0, size.1 as f64 - 1.0) / 2.0;
    let dots = labelled(matches, middle)?;
    let (projector, _) = resect(&dots.points, &dots.cells).ok_or(CamerasError::Degenerate)?;
    let posterior = CameraPosterior {
        across: projector.matrix.column(0).into(),
        down: projector.matrix.column(1).into(),
        ahead: projector.shift,
        parallax: projector.matrix.column(2) * DISPARITY_SCALE,
        usual: Vec2::new(
            (params.focal_widths * size.0 as f64).ln(),
            params.distance_baselines.ln(),
        ),
        spread: Vec2::new(params.focal_spread, params.distance_spread),
        lattice_error: params.lattice_error,
    };
    let best = posterior.mode();
    let covariance = posterior.covariance(best).ok_or(CamerasError::Degenerate)?;
    let [focal_error, depth_error] = [0, 1].map(|i| covariance[(i, i)].max(0.0).sqrt());
    if !(depth_error <= params.max_depth_error) {
        return Err(CamerasError::Uncertain {
            found_percent: 100.0 * depth_error,
            needed_percent: 100.0 * params.max_depth_error,
        });
    }
    let rig = rig_of(best, &dots, middle);
    let found = EstimatedCameras { rig, depth_error, focal_error };
    observer.warn("cameras", &found.to_string());
    Ok(found)
}

/// Matches with lattice labels, in a view midway between the cameras, so that neither is preferred.
struct LabelledDots {
    /// Pixels from the middle of the picture, and scaled disparity beyond the median.
    points: Vec<Vec3>,
    /// Column and row of the lattice.
    cells: Vec<Vec2>,
    /// Median disparity, pixels.
    disparity_px: f64,
}

fn labelled(matches: &[Match], middle: Vec2) -> Result<LabelledDots, CamerasError> {
    let labelled: Vec<_> = matches.iter().filter_map(|m| Some((m, m.lattice?))).collect();
    let got = labelled.len();
    if got < MIN_LABELS {
        return Err(CamerasError::TooFewLabels { got, needed: MIN_LABELS });
    }
    let disparities: Vec<f64> = labelled.iter().map(|(m, _)| m.disparity()).collect();
    let disparity_px = median(&disparities).ok_or(CamerasError::Degenerate)?;
    let midway = |m: &Match| (m.left + m.right) / 2.0 - middle;
    let points = labelled
        .iter()
        .map(|(m, _)| {
            let p = midway(m);
            Vec3::new(p.x, p.y, DISPARITY_SCALE * (m.disparity() - disparity_px))
        })
        .collect();
    let cells =
        labelled.iter().map(|(_, [c, r])| Vec2::new(f64::from(*c), f64::from(*r))).collect();
    Ok(LabelledDots { points, cells, disparity_px })
}

/// The rig of the logarithms of focal length and distance.
fn rig_of(best: Vec2, dots: &LabelledDots, middle: Vec2) -> RectifiedRig {
    let focal_px = best.x.exp();
    // disparity of the face minus disparity of infinity
    let parallax_px = focal_px / best.y.exp();
    let infinity_px = dots.disparity_px - parallax_px;
    let columns: Vec<f64> = dots.points.iter().map(|p| p.x).collect();
    let [low, high] = OUTER_PERCENTILES.map(|q| percentile(&columns, q).unwrap_or(0.0));
    let width_px = (high - low).max(1.0);
    RectifiedRig {
        focal_px,
        baseline_mm: FACE_WIDTH_MM * parallax_px / width_px,
        principal_left: middle + Vec2::new(infinity_px / 2.0, 0.0),
        principal_right: middle - Vec2::new(infinity_px / 2.0, 0.0),
        camera_from_rectified: Mat3::identity(),
        metric: false,
    }
}

impl std::fmt::Display for EstimatedCameras {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "the cameras were estimated from the pattern: focal length {:.0} px (to {:.0} %), depth against width to {:.1} %; calibrate for millimetres",
            self.rig.focal_px,
            100.0 * self.focal_error,
            100.0 * self.depth_error
        )
    }
}
