//! Triangulate: points in space from matches (thesis section 2.4), and grey depth maps (Fig. 2.5).

mod depth_map;
mod model_units;

#[cfg(test)]
mod tests;

pub use depth_map::depth_maps;
pub(crate) use model_units::ModelUnits;

use model_units::model_units;

use crate::camera::RectifiedRig;
use crate::data::{Cloud, CloudFrame, Match, Mesh};
use crate::math::Vec3;
use crate::observer::{Artifact, Cancelled, Event, Observer};
use crate::settings::{SettingsError, Value};
use crate::settings::{choices, settings};

choices! {
    /// How depth is computed from disparity.
    pub enum TriangulateMethod {
        /// From the rig where it is calibrated or estimated, else relative to the template.
        Auto = "auto",
        /// From baseline and focal length (Eq. 2.2): millimetres, camera frame.
        Metric = "metric",
        /// Relative to depth and height of the template (Eq. 2.3 to 2.6): its units, its frame.
        Thesis = "thesis",
    }
}

settings! {
    /// Points in space from matches.
    pub struct TriangulateParams {
        /// How depth is computed from disparity.
        method: TriangulateMethod = TriangulateMethod::Auto;
    }
}

/// Matches that give no points.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TriangulateError {
    /// Too few matches.
    #[error(
        "{got} matches found (at least {needed} expected); `facerecon check` measures the photographs"
    )]
    TooFewMatches {
        /// Matches found.
        got: usize,
        /// Matches needed.
        needed: usize,
    },
    /// `metric` without a rig.
    #[error(
        "triangulate.method = \"metric\" needs calibrated cameras, but the capture has no calibration in use; add [rig] to capture.toml, or set the method to \"auto\" or \"thesis\""
    )]
    NoRig,
    /// A match at or behind infinity.
    #[error(
        "match {index} has a disparity of {disparity_px:.2} px, at or beyond infinity for this rig; check that left and right are not swapped, and that the calibration belongs to these photos"
    )]
    Behind {
        /// Index of the match.
        index: usize,
        /// Its disparity, rectified pixels.
        disparity_px: f64,
    },
    /// Matches that span no height or width.
    #[error(
        "the matches span {width_px:.1} x {height_px:.1} px (more than 1 px in both directions expected), so the scale is not determined; check that they cover the face"
    )]
    Flat {
        /// Extent across, pixels.
        width_px: f64,
        /// Extent down, pixels.
        height_px: f64,
    },
    /// A template without extent.
    #[error(
        "the template has a height of {height} units (a positive finite one expected), so it does not determine the scale; use another template"
    )]
    Template {
        /// Height found.
        height: f64,
    },
    /// A coordinate that is not finite.
    #[error("match {index} has a position that is not a finite number; remove the match")]
    NotFinite {
        /// Index of the match.
        index: usize,
    },
    /// A parameter out of its range.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// Cancelled by the observer.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

crate::stages::stage_error!(TriangulateError, "triangulate");

/// Points in space, one for each match.
#[derive(Clone, Debug, PartialEq)]
pub struct Triangulated {
    /// One point a match, in their order.
    pub cloud: Cloud,
    /// Their frame and unit.
    pub frame: CloudFrame,
}

/// Three points determine a similarity transform, which registration needs.
const MIN_MATCHES: usize = 3;

/// Computes one point for each match (rectified pixels): in the left camera frame from the rig
/// where it is known (Eq. 2.2), else in the frame of the template (Eq. 2.3 to 2.6). Standard
/// deviations along the line of sight follow from those of the disparities.
///
/// ```
/// use facerecon_core::camera::RectifiedRig;
/// use facerecon_core::data::{Match, Mesh};
/// use facerecon_core::math::{Mat3, Vec2, Vec3};
/// use facerecon_core::stages::triangulate::{TriangulateParams, triangulate};
///
/// let rig = RectifiedRig {
///     focal_px: 2500.0,
///     baseline_mm: 140.0,
///     principal_left: Vec2::new(300.0, 280.0),
///     principal_right: Vec2::new(420.0, 280.0),
///     camera_from_rectified: Mat3::identity(),
///     metric: true,
/// };
/// let points = [
///     Vec3::new(0.0, 0.0, 1200.0),
///     Vec3::new(50.0, 0.0, 1250.0),
///     Vec3::new(0.0, 60.0, 1300.0),
/// ];
/// let matches: Vec<Match> = points
///     .iter()
///     .filter_map(|p| rig.pixels(p))
///     .map(|(left, right)| Match { left, right, lattice: None, sigma_px: 0.1, score: 1.0 })
///     .collect();
/// let params = TriangulateParams::default();
/// let found = triangulate(&matches, Some(&rig), &Mesh::default(), &params, &())?;
/// assert!(found.frame.is_metric());
/// assert!((found.cloud.points[1] - points[1]).norm() < 1e-9);
/// # Ok::<(), facerecon_core::stages::triangulate::TriangulateError>(())
/// ```
///
/// # Errors
/// [`TriangulateError`] for too few matches, matches that are not finite or beyond infinity, a
/// scale that is not determined, a missing calibration, and a cancelled run.
pub fn triangulate(
    matches: &[Match],
    rig: Option<&RectifiedRig>,
    template: &Mesh,
    params: &TriangulateParams,
    observer: &dyn Observer,
) -> Result<Triangulated, TriangulateError> {
    params.check("triangulate", None)?;
    if matches.len() < MIN_MATCHES {
        return Err(TriangulateError::TooFewMatches { got: matches.len(), needed: MIN_MATCHES });
    }
    let finite = |m: &Match| m.left.iter().chain(m.right.iter()).all(|v| v.is_finite());
    if let Some(index) = matches.iter().position(|m| !finite(m)) {
        return Err(TriangulateError::NotFinite { index });
    }
    observer.check()?;
    let rig = match params.method {
        TriangulateMethod::Auto => rig,
        TriangulateMethod::Metric => Some(rig.filter(|r| r.metric).ok_or(TriangulateError::NoRig)?),
        TriangulateMethod::Thesis => None,
    };
    let (cloud, frame) = match rig {
        Some(rig) if rig.metric => (from_rig(matches, rig)?, CloudFrame::Metric),
        Some(rig) => (from_rig(matches, rig)?, CloudFrame::Camera),
        None => (model_units(matches, template)?, CloudFrame::Model),
    };
    observer.event(&Event::Count { stage: "triangulate", what: "points", count: cloud.len() });
    observer.artifact("triangulate", "cloud", Artifact::Points(&cloud.points));
    Ok(Triangulated { cloud, frame })
}

/// Eq. 2.2, with X and Y from the same similar triangles: Eq. 2.4 to 2.6 are for an unknown rig.
fn from_rig(matches: &[Match], rig: &RectifiedRig) -> Result<Cloud, TriangulateError> {
    let mut cloud = Cloud::default();
    for (index, m) in matches.iter().enumerate() {
        let disparity_px = m.disparity();
        // Eq. 2.2: Z = b f / (x2 - x1), with x relative to the principal points
        let (Some(point), Some(z)) = (rig.point(m.left, disparity_px), rig.depth_mm(disparity_px))
        else {
            return Err(TriangulateError::Behind { index, disparity_px });
        };
        cloud.points.push(point);
        // d Z / d disparity = Z^2 / (b f)
        cloud.sigmas.push(z * z / (rig.focal_px * rig.baseline_mm) * m.sigma_px);
    }
    if matches.iter().all(|m| m.sigma_px == 0.0) {
        cloud.sigmas.clear();
    }
    if let Some(index) = cloud.points.iter().position(|p: &Vec3| !p.iter().all(|c| c.is_finite())) {
        return Err(TriangulateError::NotFinite { index });
    }
    Ok(cloud)
}
