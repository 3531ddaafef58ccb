//! Smooth: reduce the noise of the mesh (thesis sections 4.3 and 6.5.2).

mod enlarge;
mod laplacian;

use crate::data::{Mesh, MeshError};
use crate::math::Vec3;
use crate::observer::{Cancelled, Observer};
use crate::settings::{SettingsError, Value};

crate::settings::choices! {
    /// How the mesh is smoothed.
    pub enum SmoothMethod {
        /// No smoothing.
        None = "none",
        /// Every vertex moves toward the mean of its neighbours (thesis Eq. 4.9, 4.10). The mesh shrinks.
        Laplacian = "laplacian",
        /// A second step with a negative factor compensates the shrinkage (Taubin 1995; thesis section
        /// 4.3).
        Taubin = "taubin",
    }
}

crate::settings::settings! {
    /// Smoothing the mesh.
    pub struct SmoothParams {
        /// How the mesh is smoothed.
        method: SmoothMethod = SmoothMethod::Laplacian;
        /// Maximum number of steps.
        steps: usize = 3, range 0.0..=10_000.0;
        /// Smoothing ends when the mean movement of a vertex in a step is below this, in model units
        /// (mm with calibration); 0 takes all steps.
        threshold: f64 = 0.0, range 0.0..=1000.0;
        /// The factor lambda of Eq. 4.10.
        lambda: f64 = 0.5, range 0.0..=1.0;
        /// The negative factor mu of Taubin's second step; must be below -lambda.
        mu: f64 = -0.53, range -2.0..=0.0;
        /// Whether vertices on the border stay in place; else holes and the outer border shrink.
        keep_border: bool = true;
        /// Whether the mesh is enlarged to the bounds that its reference points had before (thesis
        /// section 6.5.2).
        enlarge: bool = true;
        /// Manual scale factor along x, about the middle of the mesh (thesis section 6.5.2).
        enlarge_x: f64 = 1.0, range 0.1..=10.0;
        /// Manual scale factor along y.
        enlarge_y: f64 = 1.0, range 0.1..=10.0;
        /// Manual scale factor along z.
        enlarge_z: f64 = 1.0, range 0.1..=10.0;
    }
}

/// A smoothed mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Smoothed {
    /// The mesh, in the frame and units given.
    pub mesh: Mesh,
    /// Steps taken.
    pub steps: usize,
    /// Mean movement of a vertex in each step, units of the mesh.
    pub movement: Vec<f64>,
    /// Scale factors along x, y and z that compensated the shrinkage, without the manual ones.
    pub enlarged: Vec3,
}

/// Input that cannot be smoothed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SmoothError {
    /// A mesh that cannot be used.
    #[error("the mesh cannot be used: {0}")]
    Mesh(#[from] MeshError),
    /// A reference point that is not finite.
    #[error(
        "reference point {index} has a coordinate that is not a finite number; remove the point"
    )]
    NotFinite {
        /// Its index.
        index: usize,
    },
    /// A mu that does not compensate lambda.
    #[error(
        "smooth.mu is {mu}, but must be below -smooth.lambda = {limit}; set it to {example:.3}"
    )]
    Mu {
        /// Given.
        mu: f64,
        /// Its upper limit, -lambda.
        limit: f64,
        /// A value that works.
        example: f64,
    },
    /// A parameter outside its range.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// Cancelled by the observer.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

crate::stages::stage_error!(SmoothError, "smooth");

/// Values of mu that compensate lambda well are this multiple of -lambda (Taubin 1995: slightly
/// larger in magnitude).
const MU_PER_LAMBDA: f64 = 1.06;

/// Smooths a mesh and enlarges it to compensate the shrinkage. `reference` holds points of the face
/// in the frame of the mesh (for example all registered points): the bounds of the vertices nearest
/// to them are restored. When empty, the bounds of all vertices are.
///
/// ```
/// use facerecon_core::data::Mesh;
/// use facerecon_core::math::Vec3;
/// use facerecon_core::stages::smooth::{SmoothMethod, SmoothParams, smooth};
///
/// // a cone of height 1
/// let mesh = Mesh {
///     vertices: vec![Vec3::z(), Vec3::x(), Vec3::y(), -Vec3::x(), -Vec3::y()],
///     faces: vec![[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]],
///     ..Mesh::default()
/// };
/// let method = SmoothMethod::Laplacian;
/// let params = SmoothParams { method, steps: 1, enlarge: false, ..SmoothParams::default() };
/// let smoothed = smooth(&mesh, &[], &params, &())?;
/// assert_eq!(smoothed.mesh.vertices[0], Vec3::new(0.0, 0.0, 0.5));
/// # Ok::<(), facerecon_core::stages::smooth::SmoothError>(())
/// ```
///
/// # Errors
/// [`SmoothError`] for a mesh, reference points or parameters that cannot be used, and for a
/// cancelled run.
pub fn smooth(
    mesh: &Mesh,
    reference: &[Vec3],
    params: &SmoothParams,
    observer: &dyn Observer,
) -> Result<Smoothed, SmoothError> {
    params.check("smooth", None)?;
    mesh.validate()?;
    if let Some(index) = reference.iter().position(|p| !p.iter().all(|c| c.is_finite())) {
        return Err(SmoothError::NotFinite { index });
    }
    let (vertices, movement) = match params.method {
        SmoothMethod::None => (mesh.vertices.clone(), Vec::new()),
        SmoothMethod::Laplacian => laplacian::smooth(mesh, params, None, observer)?,
        SmoothMethod::Taubin if params.mu < -params.lambda => {
            laplacian::smooth(mesh, params, Some(params.mu), observer)?
        }
        SmoothMethod::Taubin => {
            let (mu, limit) = (params.mu, -params.lambda);
            return Err(SmoothError::Mu { mu, limit, example: MU_PER_LAMBDA * limit });
        }
    };
    let (vertices, enlarged) = if params.enlarge && params.method != SmoothMethod::None {
        enlarge::restore_bounds(&mesh.vertices, vertices, reference)
    } else {
        (vertices, Vec3::repeat(1.0))
    };
    let manual = Vec3::new(params.enlarge_x, params.enlarge_y, params.enlarge_z);
    let vertices = enlarge::by_factors(vertices, manual);
    let steps = movement.len();
    Ok(Smoothed { mesh: mesh.with_vertices(vertices), steps, movement, enlarged })
}

#[cfg(test)]
mod tests;
