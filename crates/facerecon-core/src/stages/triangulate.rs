//! Triangulate: matches to points in space (thesis section 2.4), and grey depth maps (Fig. 2.5).

mod depth_map;
mod model_units;

#[cfg(test)]
mod tests;

pub use depth_map::depth_maps;
pub use model_units::{ModelUnits, model_units};

use crate::camera::RectifiedRig;
use crate::data::{Cloud, CloudFrame, Match, Mesh};
use crate::math::Vec3;
use crate::observer::{Artifact, Cancelled, Event, Observer};
use crate::settings::{SettingsError, Value};
use crate::{choices, settings};

choices! {
    /// How depth follows from disparity.
    pub enum TriangulateMethod {
        /// By the rig where it is known or was estimated, else relative to the generic face.
        Auto = "auto",
        /// By baseline and focal length (Eq. 2.2): millimetres, camera frame.
        Metric = "metric",
        /// Relative to the generic face's depth and height (Eq. 2.3 to 2.6): its units, its frame.
        Thesis = "thesis",
    }
}

settings! {
    /// Points in space from matches.
    pub struct TriangulateParams {
        /// How depth follows from disparity.
        method: TriangulateMethod = TriangulateMethod::Auto;
    }
}

/// Matches that give no points.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TriangulateError {
    /// Too few matches.
    #[error("{got} matches, at least {needed} are needed")]
    TooFewMatches {
        /// Matches found.
        got: usize,
        /// Matches needed.
        needed: usize,
    },
    /// `metric` without a rig.
    #[error(
        "triangulate.method = \"metric\" needs the cameras; add [rig] to capture.toml, or take \"thesis\""
    )]
    NoRig,
    /// A match at or behind infinity.
    #[error(
        "match {index} has a disparity of {disparity_px:.2} px, at or beyond infinity for this rig; left and right may be swapped, or the calibration is another rig's"
    )]
    Behind {
        /// Number of the match.
        index: usize,
        /// Its disparity.
        disparity_px: f64,
    },
    /// Matches that span no height or width.
    #[error(
        "the matches span {width_px:.1} x {height_px:.1} px; a face cannot be scaled from that"
    )]
    Flat {
        /// Extent across.
        width_px: f64,
        /// Extent down.
        height_px: f64,
    },
    /// A generic face without extent.
    #[error("the generic face spans {height} units in height; it cannot set the scale")]
    Template {
        /// Height found.
        height: f64,
    },
    /// A coordinate that is not a number.
    #[error("match {index} has a position that is not a finite number")]
    NotFinite {
        /// Number of the match.
        index: usize,
    },
    /// A parameter out of its range.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// Cancelled by the observer.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

crate::stage_error!(TriangulateError, "triangulate");

/// Points in space, one for each match.
#[derive(Clone, Debug, PartialEq)]
pub struct Triangulated {
    /// One point a match, in their order.
    pub cloud: Cloud,
    /// Where they lie.
    pub frame: CloudFrame,
}

/// Fewer points than this determine nothing.
const LEAST_MATCHES: usize = 3;

/// Turns matches into points: by the rig when it is known (Eq. 2.2), else relative to the generic
/// face `template` (Eq. 2.3 to 2.6).
///
/// # Errors
/// [`TriangulateError`] for too few matches, matches beyond infinity, or a flat template.
pub fn triangulate(
    matches: &[Match],
    rig: Option<&RectifiedRig>,
    template: &Mesh,
    params: &TriangulateParams,
    observer: &dyn Observer,
) -> Result<Triangulated, TriangulateError> {
    params.check("triangulate", None)?;
    if matches.len() < LEAST_MATCHES {
        return Err(TriangulateError::TooFewMatches { got: matches.len(), needed: LEAST_MATCHES });
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
        Some(rig) if rig.metric => (by_rig(matches, rig)?, CloudFrame::Metric),
        Some(rig) => (by_rig(matches, rig)?, CloudFrame::Camera),
        None => (model_units(matches, template)?, CloudFrame::Model),
    };
    observer.event(&Event::Count { stage: "triangulate", what: "points", count: cloud.len() });
    observer.artifact("triangulate", "cloud", Artifact::Points(&cloud.points));
    Ok(Triangulated { cloud, frame })
}

/// Eq. 2.2, with X and Y by the same similar triangles instead of Eq. 2.4 to 2.6, which are for an
/// unknown rig.
fn by_rig(matches: &[Match], rig: &RectifiedRig) -> Result<Cloud, TriangulateError> {
    let mut cloud = Cloud::default();
    for (index, m) in matches.iter().enumerate() {
        let disparity_px = m.disparity();
        // Eq. 2.2: Z = b f / (x2 - x1), x taken from the principal points
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
