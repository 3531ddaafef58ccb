//! Stage register: bring the measured points to the generic head (thesis chapter 3, section 6.5.2).

mod besl;
mod input;
mod mask;
mod quaternion;
mod registration;
mod residual;
mod robust;
mod start;

use crate::data::{Mesh, MeshError};
use crate::math::{Mat3, Vec3};
use crate::observer::{Cancelled, Observer};
use crate::settings::{SettingsError, Value};

pub use input::RegisterInput;
pub use registration::Registration;
pub use robust::RobustParams;

crate::settings::choices! {
    /// How the points are registered to the generic head.
    pub enum RegisterMethod {
        /// Point-to-point ICP with unit quaternions (Besl and McKay 1992; thesis Eq. 3.1-3.8).
        Besl = "besl",
        /// Robust point-to-plane ICP on the surface, from many starts; needs no landmarks.
        Robust = "robust",
    }
}

crate::settings::settings! {
    /// Registering the measured points to the generic head.
    pub struct RegisterParams {
        /// How the points are registered to the generic head.
        method: RegisterMethod = RegisterMethod::Besl;
        /// Whether landmarks, where there are at least three, give the start (thesis section 6.5.2).
        use_landmarks: bool = true, alias "use_features";
        /// Whether the coarse head is registered first, where the template has one (thesis section 6.5.2).
        coarse_first: bool = true;
        /// Whether the points are also scaled uniformly; in the thesis they are only rotated and
        /// translated. Points in model units (no calibration) are always scaled.
        scale: bool = false;
        /// Besl: the threshold tau. The iteration ends when a step lowers the error d of Eq. 3.8 by
        /// less than this fraction of d.
        tolerance: f64 = 3e-4, range 0.0..=0.1;
        /// Most steps on each mesh (Besl), or in the last round (robust).
        max_iterations: usize = 200, range 1.0..=10_000.0;
        /// Besl: fraction of the pairs that counts in each step, the closest ones; 1 is the method of
        /// the thesis.
        keep: f64 = 0.95, range 0.5..=1.0;
        /// A registration is rejected when the typical distance of the points from the head (root
        /// mean square of the closest 80 %) is larger than this fraction of the head's height.
        max_residual: f64 = 0.05, range 0.001..=1.0;
        /// The robust method's own parameters.
        robust: RobustParams = RobustParams::default();
    }
}

/// A registration that cannot be made, or whose result is implausible.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RegisterError {
    /// Not enough points.
    #[error(
        "{got} points of the face were measured, but at least {needed} are needed to register the head; check the matches of the dots"
    )]
    TooFewPoints {
        /// Measured points.
        got: usize,
        /// Least number.
        needed: usize,
    },
    /// A point that is not finite.
    #[error(
        "measured point {index} (from 0) has a coordinate that is not a finite number; remove it or check the calibration"
    )]
    NotFinite {
        /// Its index.
        index: usize,
    },
    /// A template that cannot be used.
    #[error("the generic head cannot be used: {0}")]
    Model(#[from] MeshError),
    /// Points that determine no rotation.
    #[error(
        "the measured points lie on one line or at one position, which determines no rotation of the head; check the matches and the calibration"
    )]
    Degenerate,
    /// Landmarks that do not fit the model.
    #[error(
        "the landmarks do not fit the head: after the best rotation and translation they are {rms:.1} from it (root mean square, model units), at most {limit:.1} expected; landmark {worst} (from 0) is farthest; check its position in both photos, or mark no landmarks"
    )]
    Landmarks {
        /// Root mean square residual, model units.
        rms: f64,
        /// Greatest that is accepted.
        limit: f64,
        /// The landmark with the largest residual.
        worst: usize,
    },
    /// A result worse than the start.
    #[error(
        "the registration increased the distance of the points from the head from {before:.2} to {after:.2} (model units); mark landmarks or choose another template"
    )]
    Worse {
        /// Typical distance before, model units.
        before: f64,
        /// The same after.
        after: f64,
    },
    /// A result too far from the head.
    #[error(
        "the points do not fit the head: their distance from it is {after:.2} after registration ({before:.2} before, model units), at most {limit:.2} expected; check the matches and the units of calibration and template"
    )]
    Implausible {
        /// Typical distance before, model units.
        before: f64,
        /// The same after.
        after: f64,
        /// Greatest that is accepted.
        limit: f64,
    },
    /// Most points are not of the head.
    #[error(
        "the points do not fit the head: only {inlier_percent:.0} % are near it after registration (at least {expected_percent:.0} % expected); check the pattern, the calibration and the order of the left and right photos"
    )]
    NotTheHead {
        /// Share of the points near the head, percent.
        inlier_percent: f64,
        /// Least share, percent.
        expected_percent: f64,
    },
    /// A parameter outside its range.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// Cancelled by the observer.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

crate::stages::stage_error!(RegisterError, "register");

/// A registration is rejected when the typical distance grows by more than this factor. The pairs
/// that are trimmed from it count in the iteration, so a correct pose may end slightly worse.
const MAX_GROWTH: f64 = 1.1;
/// Growth that is always accepted, as a fraction of the model's height: rounding at a perfect start.
const NEGLIGIBLE_GROWTH: f64 = 1e-6;
/// Points lie on one line when the second largest of their variances is below this fraction of the
/// largest.
const MIN_VARIANCE_RATIO: f64 = 1e-9;

/// Registers the measured points to the generic head.
///
/// # Errors
/// [`RegisterError`] when the input cannot be used, when the result is worse than the start or
/// farther from the head than `max_residual` of its height, for parameters out of range, and when
/// the observer cancels.
///
/// ```
/// use facerecon_core::data::{Cloud, CloudFrame, Mesh};
/// use facerecon_core::math::Vec3;
/// use facerecon_core::stages::register::{RegisterInput, RegisterParams, register};
///
/// // a bumpy sheet as the model, and its vertices, moved by 3 mm, as the measured points
/// let mut model = Mesh::default();
/// for i in 0..100u32 {
///     let (x, y) = (f64::from(i % 10) * 10.0, f64::from(i / 10) * 10.0);
///     model.vertices.push(Vec3::new(x, y, (x * 0.1).sin() * 9.0 + (y * 0.07).cos() * 7.0));
/// }
/// for i in (0..90u32).filter(|i| i % 10 < 9) {
///     model.faces.extend([[i, i + 1, i + 10], [i + 1, i + 11, i + 10]]);
/// }
/// let points = model.vertices.iter().map(|p| p + Vec3::new(0.0, 0.0, 3.0)).collect();
/// let data = Cloud::from_points(points);
/// let landmarks: Vec<(Vec3, Vec3)> =
///     [11, 18, 81, 88].map(|v| (data.points[v], model.vertices[v])).to_vec();
/// let input = RegisterInput {
///     data: &data,
///     model: &model,
///     coarse: None,
///     chin_y: None,
///     landmarks: &landmarks,
///     frame: CloudFrame::Model,
/// };
/// let registration = register(&input, &RegisterParams::default(), &())?;
/// assert!((registration.model_from_data.apply(&data.points[55]) - model.vertices[55]).norm() < 1e-6);
/// # Ok::<(), facerecon_core::stages::register::RegisterError>(())
/// ```
pub fn register(
    input: &RegisterInput<'_>,
    params: &RegisterParams,
    observer: &dyn Observer,
) -> Result<Registration, RegisterError> {
    params.check("register", None)?;
    check_input(input)?;
    let registration = match params.method {
        RegisterMethod::Besl => besl::register(input, params, observer)?,
        RegisterMethod::Robust => robust::register(input, params, observer)?,
    };
    reject_implausible(&registration, input.model, params)?;
    Ok(registration)
}

fn check_input(input: &RegisterInput<'_>) -> Result<(), RegisterError> {
    input.model.validate()?;
    if let Some(coarse) = input.coarse {
        coarse.validate()?;
    }
    let finite = |p: &Vec3| p.iter().all(|c| c.is_finite());
    if let Some(index) = input.data.points.iter().position(|p| !finite(p)) {
        return Err(RegisterError::NotFinite { index });
    }
    if input.data.len() < input::MIN_POINTS {
        let (got, needed) = (input.data.len(), input::MIN_POINTS);
        return Err(RegisterError::TooFewPoints { got, needed });
    }
    if on_one_line(&input.data.points) {
        return Err(RegisterError::Degenerate);
    }
    Ok(())
}

/// Whether points lie on one line or at one position.
fn on_one_line(points: &[Vec3]) -> bool {
    let mean = points.iter().sum::<Vec3>() / points.len().max(1) as f64;
    let spread: Mat3 = points.iter().map(|p| (p - mean) * (p - mean).transpose()).sum();
    let mut variances: [f64; 3] = spread.symmetric_eigenvalues().into();
    variances.sort_by(f64::total_cmp);
    variances[1] <= MIN_VARIANCE_RATIO * variances[2]
}

/// Rejects a registration that is worse than its start or too far from the head.
fn reject_implausible(
    registration: &Registration,
    model: &Mesh,
    params: &RegisterParams,
) -> Result<(), RegisterError> {
    let (before, after) = (registration.rms_before, registration.rms_after);
    if !(after <= MAX_GROWTH * before + NEGLIGIBLE_GROWTH * mask::height(model)) {
        return Err(RegisterError::Worse { before, after });
    }
    let limit = params.max_residual * mask::head_height(model);
    if !(after <= limit) {
        return Err(RegisterError::Implausible { before, after, limit });
    }
    Ok(())
}

#[cfg(test)]
mod tests;
