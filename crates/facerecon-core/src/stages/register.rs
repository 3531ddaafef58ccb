//! Stage register: bring the measured points to the generic head (thesis chapter 3, section 6.5.2).

mod besl;
mod quaternion;
mod robust;
mod start;

use crate::data::{Cloud, CloudFrame, Mesh, MeshError, Topology};
use crate::math::{Mat3, Similarity, Vec3, percentile};
use crate::observer::{Cancelled, Observer};
use crate::settings::{SettingsError, Value};
use crate::spatial::PointIndex;

pub use crate::spatial::eliminate_multiple;
pub use quaternion::fit_quaternion;
pub use robust::RobustParams;

crate::choices! {
    /// How the points are brought to the generic head.
    pub enum RegisterMethod {
        /// Point-to-point ICP with unit quaternions (Besl and McKay 1992; thesis Eq. 3.1-3.8).
        Besl = "besl",
        /// Many starts, trimmed point-to-plane ICP on the surface; needs no landmarks.
        Robust = "robust",
    }
}

crate::settings! {
    /// Bringing the measured points to the generic head.
    pub struct RegisterParams {
        /// How the points are brought to the generic head.
        method: RegisterMethod = RegisterMethod::Besl;
        /// Whether marked features, where there are at least three, give the start (thesis section 6.5.2).
        use_features: bool = true;
        /// Whether the coarse head is registered first, where the template has one (thesis section 6.5.2).
        coarse_first: bool = true;
        /// Whether the points may also be scaled uniformly; the thesis only turns and moves them.
        /// Points in model units (no calibration) are always scaled.
        scale: bool = false;
        /// Besl: the threshold tau. It stops once the error d of Eq. 3.8 falls by less than this in
        /// a step, as a fraction of d itself.
        tolerance: f64 = 3e-4, range 0.0..=0.1;
        /// Besl: most steps on each mesh.
        max_iterations: usize = 200, range 1.0..=10_000.0;
        /// Besl: fraction of the closest pairs that count in each step; 1 is the thesis's way, less
        /// ignores the pairs farthest apart.
        keep: f64 = 0.95, range 0.5..=1.0;
        /// A fit whose typical pair (root mean square of the closest 80 %) is farther apart than
        /// this, as a fraction of the head's height, is refused.
        max_residual: f64 = 0.05, range 0.001..=1.0;
        /// The robust method's own parameters.
        robust: RobustParams = RobustParams::default();
    }
}

/// What is registered.
#[derive(Clone, Copy, Debug)]
pub struct RegisterInput<'a> {
    /// The measured points.
    pub data: &'a Cloud,
    /// The generic head, model frame.
    pub model: &'a Mesh,
    /// The same head with fewer vertices.
    pub coarse: Option<&'a Mesh>,
    /// Marked features as `(measured, on the model)`.
    pub features: &'a [(Vec3, Vec3)],
    /// Where the points lie. Millimetres are kept, other units scaled to the model's.
    pub frame: CloudFrame,
}

/// Why the iteration stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Termination {
    /// The error fell by less than the tolerance.
    Converged,
    /// The allowed number of steps was used up.
    MaxIterations,
}

/// Where the points lie on the generic head.
#[derive(Clone, Debug, PartialEq)]
pub struct Registration {
    /// Brings measured points into the model frame. With `scale` the model keeps its own size:
    /// lengths in the model frame are then `scale` times the measured ones.
    pub model_from_data: Similarity,
    /// Steps taken. Besl: all of them, for a start, on the coarse mesh and on the detailed one;
    /// robust: those of the pose that won.
    pub iterations: usize,
    /// Of these, steps spent on finding a start; 0 with marked features.
    pub start_iterations: usize,
    /// Of these, steps on the coarse mesh.
    pub coarse_iterations: usize,
    /// Error after each step on the detailed mesh, the first entry before any (Besl: Eq. 3.8).
    pub history: Vec<f64>,
    /// Why it stopped.
    pub termination: Termination,
    /// Whether marked features gave the start.
    pub from_features: bool,
    /// Root mean square distance of the closest 80 % to the model at the start, model units.
    pub rms_before: f64,
    /// The same at the end.
    pub rms_after: f64,
    /// Indices of the points that belong to the head and were used.
    pub inliers: Vec<usize>,
}

impl Registration {
    /// The used points in the model frame, one for each vertex they are closest to (thesis section
    /// 3.2): the deformation's `assignments`.
    pub fn assignments(&self, data: &Cloud, model: &Mesh) -> Vec<(usize, Vec3)> {
        let points: Vec<Vec3> = self
            .inliers
            .iter()
            .filter_map(|&i| data.points.get(i))
            .map(|p| self.model_from_data.apply(p))
            .collect();
        let goals =
            eliminate_multiple(&points, &model.vertices, Some(4.0 * self.rms_after.max(1e-12)));
        let edge = edge_of_mask(model);
        goals.into_iter().filter(|(vertex, _)| !edge[*vertex]).collect()
    }
}

/// A registration that cannot be made, or whose result cannot be right.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RegisterError {
    /// Not enough points.
    #[error(
        "{got} points of the face were measured, but at least {needed} are needed to find the head; check the matches"
    )]
    TooFewPoints {
        /// Points found.
        got: usize,
        /// Points needed.
        needed: usize,
    },
    /// A point that is not a number.
    #[error("measured point {index} has a coordinate that is not a finite number")]
    NotFinite {
        /// Its index.
        index: usize,
    },
    /// A template that cannot be used.
    #[error("the generic head cannot be used: {0}")]
    Model(#[from] MeshError),
    /// Points that determine no rotation.
    #[error(
        "the measured points lie on one line or at one place, so no turn of the head can be told from them"
    )]
    Degenerate,
    /// Marked features that do not fit the model.
    #[error(
        "the marked features do not fit the head: they are {rms:.1} apart (root mean square) after the best turn and shift, at most {limit:.1} is plausible; feature {worst} (from 0) is the worst; check its position in both photos, or mark none"
    )]
    Features {
        /// Root mean square distance left.
        rms: f64,
        /// Greatest that is accepted.
        limit: f64,
        /// The feature farthest off.
        worst: usize,
    },
    /// A result worse than the start.
    #[error(
        "the registration made the fit worse: points lay {before:.2} from the head before and {after:.2} after; give marked features or another template"
    )]
    Worse {
        /// Root mean square distance before.
        before: f64,
        /// And after.
        after: f64,
    },
    /// A result too far from the head.
    #[error(
        "the points do not fit the head: {before:.2} from it before and still {after:.2} after registration, at most {limit:.2} is plausible; check the calibration's unit, the matches and the template's unit"
    )]
    Implausible {
        /// Root mean square distance before.
        before: f64,
        /// And after.
        after: f64,
        /// Greatest that is accepted.
        limit: f64,
    },
    /// Most points are not of the head.
    #[error(
        "the points do not fit the head: only {inlier_percent:.0} % come to lie near it, at least {expected_percent:.0} % are needed; are pattern, calibration and the order left/right those of these photos?"
    )]
    NotTheHead {
        /// Points near the head.
        inlier_percent: f64,
        /// Wanted.
        expected_percent: f64,
    },
    /// A parameter outside its range.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// Cancelled by the observer.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

crate::stage_error!(RegisterError, "register");

/// Least number of points from which a pose is told.
const LEAST_POINTS: usize = 12;

/// A registration whose typical pairs end this many times farther apart than they began is refused.
const WORSE: f64 = 1.1;

/// Brings the measured points to the generic head.
///
/// # Errors
/// [`RegisterError`] when the input cannot be used, or when the fit ends worse than it began or
/// farther from the head than `max_residual` of its height.
pub fn register(
    input: &RegisterInput<'_>,
    params: &RegisterParams,
    observer: &dyn Observer,
) -> Result<Registration, RegisterError> {
    params.check("register", None)?;
    input.model.validate()?;
    if let Some(coarse) = input.coarse {
        coarse.validate()?;
    }
    let finite = |p: &Vec3| p.iter().all(|c| c.is_finite());
    if let Some(index) = input.data.points.iter().position(|p| !finite(p)) {
        return Err(RegisterError::NotFinite { index });
    }
    if input.data.len() < LEAST_POINTS {
        return Err(RegisterError::TooFewPoints { got: input.data.len(), needed: LEAST_POINTS });
    }
    if on_one_line(&input.data.points) {
        return Err(RegisterError::Degenerate);
    }
    let found = match params.method {
        RegisterMethod::Besl => besl::register(input, params, observer)?,
        RegisterMethod::Robust => robust::register(input, params, observer)?,
    };
    judge(&found, input.model, params)?;
    Ok(found)
}

/// Whether points lie on one line or at one place, by the middle one of their three variances.
fn on_one_line(points: &[Vec3]) -> bool {
    let mean = points.iter().sum::<Vec3>() / points.len().max(1) as f64;
    let spread: Mat3 = points.iter().map(|p| (p - mean) * (p - mean).transpose()).sum();
    let mut variances: [f64; 3] = spread.symmetric_eigenvalues().into();
    variances.sort_by(f64::total_cmp);
    variances[1] <= 1e-9 * variances[2]
}

/// Refuses a fit that cannot be right.
fn judge(found: &Registration, model: &Mesh, params: &RegisterParams) -> Result<(), RegisterError> {
    let (before, after) = (found.rms_before, found.rms_after);
    // The far pairs count in the iteration but not here: a little worse is still the same fit.
    if !(after <= WORSE * before + 1e-6 * height(model)) {
        return Err(RegisterError::Worse { before, after });
    }
    let limit = params.max_residual * head_height(model);
    if !(after <= limit) {
        return Err(RegisterError::Implausible { before, after, limit });
    }
    Ok(())
}

/// The vertices on the edge of a mask: points that come nearest to them belong to a part of the head
/// that the mask does not have. None of a whole head, which is deeper than broad.
fn edge_of_mask(mesh: &Mesh) -> Vec<bool> {
    match mesh.bounds() {
        Some((low, high)) if high.z - low.z < high.x - low.x => Topology::new(mesh).border,
        _ => vec![false; mesh.vertices.len()],
    }
}

/// Height of the head that a mesh shows, or shows a part of: a mask's own height is less, but its
/// breadth is the head's, which is about 1.6 times as high with the neck.
fn head_height(mesh: &Mesh) -> f64 {
    mesh.bounds().map_or(0.0, |(low, high)| (high.y - low.y).max(1.6 * (high.x - low.x)))
}

/// Height of a mesh, its own unit.
fn height(mesh: &Mesh) -> f64 {
    mesh.bounds().map_or(0.0, |(low, high)| high.y - low.y)
}

/// Root mean square distance of the closest 80 % of the points to their closest vertices.
fn trimmed_rms(points: &[Vec3], index: &PointIndex<3>) -> f64 {
    let distances: Vec<f64> =
        points.iter().filter_map(|p| index.nearest(&[p.x, p.y, p.z])).map(|n| n.distance).collect();
    let Some(limit) = percentile(&distances, 0.8) else {
        return f64::INFINITY;
    };
    let near: Vec<f64> = distances.into_iter().filter(|d| *d <= limit).collect();
    (near.iter().map(|d| d * d).sum::<f64>() / near.len() as f64).sqrt()
}

#[cfg(test)]
mod tests;
