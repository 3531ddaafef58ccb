//! Stage smooth: take the noise off the bent head (thesis sections 4.3 and 6.5.2).

mod enlarge;
mod laplacian;

use crate::data::{Mesh, MeshError};
use crate::math::Vec3;
use crate::observer::{Cancelled, Observer};
use crate::settings::{SettingsError, Value};

crate::choices! {
    /// How the mesh is smoothed.
    pub enum SmoothMethod {
        /// Not at all.
        None = "none",
        /// Every vertex moves toward the mean of its neighbours (thesis Eq. 4.9, 4.10); shrinks.
        Laplacian = "laplacian",
        /// A second step with a negative factor undoes the shrinkage (Taubin 1995; thesis section 4.3).
        Taubin = "taubin",
    }
}

crate::settings! {
    /// Smoothing the bent head.
    pub struct SmoothParams {
        /// How the mesh is smoothed.
        method: SmoothMethod = SmoothMethod::Laplacian;
        /// Most steps.
        steps: usize = 3, range 0.0..=10_000.0;
        /// Smoothing ends once the vertices move less than this in a step, on average, in model
        /// units; 0 takes all steps.
        threshold: f64 = 0.0, range 0.0..=1000.0;
        /// The factor lambda of Eq. 4.10.
        lambda: f64 = 0.5, range 0.0..=1.0;
        /// Taubin: the negative factor mu, below -lambda.
        mu: f64 = -0.53, range -2.0..=0.0;
        /// Whether vertices on an open edge stay where they are; else the opening shrinks.
        keep_border: bool = true;
        /// Whether the mesh is enlarged to the bounds its features had before (thesis section 6.5.2).
        enlarge: bool = true;
        /// Manual enlargement along x, about the middle of the mesh.
        enlarge_x: f64 = 1.0, range 0.1..=10.0;
        /// Manual enlargement along y.
        enlarge_y: f64 = 1.0, range 0.1..=10.0;
        /// Manual enlargement along z.
        enlarge_z: f64 = 1.0, range 0.1..=10.0;
    }
}

/// A smoothed mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Smoothed {
    /// The mesh.
    pub mesh: Mesh,
    /// Steps taken.
    pub steps: usize,
    /// Mean movement of a vertex in each step.
    pub movement: Vec<f64>,
    /// Enlargement against shrinkage along x, y and z, before the manual one.
    pub enlarged: Vec3,
}

/// Smoothing that cannot be done.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SmoothError {
    /// A mesh that cannot be used.
    #[error("the mesh cannot be smoothed: {0}")]
    Mesh(#[from] MeshError),
    /// A reference that is not a number.
    #[error("reference point {index} has a coordinate that is not a finite number")]
    NotFinite {
        /// Its index.
        index: usize,
    },
    /// A mu that does not counteract lambda.
    #[error(
        "smooth.mu is {mu}, but Taubin's second step must be below -lambda = {limit}; try {example:.3}"
    )]
    Mu {
        /// Given.
        mu: f64,
        /// What it must stay below.
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

crate::stage_error!(SmoothError, "smooth");

/// Smooths a mesh and enlarges it against the shrinkage. `reference` holds points of the face (its
/// features, or all registered points) whose bounds are to be kept; when empty, those of the mesh.
///
/// # Errors
/// [`SmoothError`] when the mesh or the parameters cannot be used.
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
            return Err(SmoothError::Mu { mu, limit, example: 1.06 * limit });
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
