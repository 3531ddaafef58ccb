//! Stage deform: bend the generic head to the points (thesis chapter 4).

mod nicp;
mod rbf;
mod rbf_biharmonic;
mod rbf_gaussian;
mod rbf_linear;

use crate::data::{Cloud, Mesh, MeshError};
use crate::math::Vec3;
use crate::observer::{Cancelled, Observer};
use crate::settings::{SettingsError, Value};

pub use nicp::NicpParams;

crate::choices! {
    /// How the generic head is bent.
    pub enum DeformMethod {
        /// Gaussian radial basis functions, each as wide as its neighbours are near (thesis section 4.2.1).
        GaussianRbf = "gaussian-rbf",
        /// Linear radial basis functions inside a radius (thesis section 4.2.2).
        LinearRbf = "linear-rbf",
        /// Regularised biharmonic splines with an affine part (Carr et al. 2001).
        BiharmonicRbf = "biharmonic-rbf",
        /// Robust non-rigid ICP to all points, with the head subdivided where they are dense
        /// (after Amberg et al. 2007).
        Nicp = "nicp",
    }
}

crate::settings! {
    /// Bending the generic head to the points.
    pub struct DeformParams {
        /// How the generic head is bent.
        method: DeformMethod = DeformMethod::GaussianRbf;
        /// Whether marked features join the points (thesis sections 6.5.2 and 7).
        use_features: bool = true;
        /// Gaussian and linear: value of a basis function (1 at its centre) at the nearest other
        /// centre; the thesis wants it close to zero.
        neighbour_value: f64 = 0.1, range 0.001..=0.5;
        /// Biharmonic: stiffness. How far, in model units, the surface gives way to neighbouring
        /// points that contradict each other; 0 passes through every point.
        stiffness: f64 = 2.0, range 0.0..=1000.0;
        /// Biharmonic: how often points are matched anew to the bent head.
        rounds: usize = 3, range 1.0..=20.0;
        /// Radial basis functions: most centres; above it the points are thinned evenly. Time grows
        /// with the cube of it.
        max_centres: usize = 3000, range 4.0..=6000.0;
        /// The non-rigid ICP's own parameters.
        nicp: NicpParams = NicpParams::default();
    }
}

/// What is bent, and to what.
#[derive(Clone, Copy, Debug)]
pub struct DeformInput<'a> {
    /// The generic head, model frame.
    pub template: &'a Mesh,
    /// The registered points, model frame.
    pub data: &'a Cloud,
    /// Vertices with the one data point each must reach.
    pub assignments: &'a [(usize, Vec3)],
    /// Vertices of marked features with their measured places.
    pub features: &'a [(usize, Vec3)],
}

/// A bent head.
#[derive(Clone, Debug, PartialEq)]
pub struct Deformed {
    /// The template with new vertex positions; vertices that non-rigid ICP adds come after its own.
    pub mesh: Mesh,
    /// Points the fit rests on.
    pub centres: usize,
    /// Root mean square distance of the used vertices (or points) from their goals before.
    pub rms_before: f64,
    /// The same afterwards.
    pub rms_after: f64,
}

/// A deformation that cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DeformError {
    /// A template that cannot be used.
    #[error("the generic head cannot be used: {0}")]
    Template(#[from] MeshError),
    /// A vertex that is not there.
    #[error(
        "point {position} is assigned to vertex {vertex}, but the head has {count} (counted from 0)"
    )]
    Vertex {
        /// Place in the list.
        position: usize,
        /// Vertex named.
        vertex: usize,
        /// Vertices there are.
        count: usize,
    },
    /// A goal that is not a number.
    #[error("the goal of vertex {vertex} has a coordinate that is not a finite number")]
    NotFinite {
        /// The vertex.
        vertex: usize,
    },
    /// Not enough points.
    #[error(
        "{got} vertices have a point to go to, but at least {needed} are needed to bend the head; check matches and registration"
    )]
    TooFew {
        /// Found.
        got: usize,
        /// Needed.
        needed: usize,
    },
    /// Equations without a usable solution.
    #[error(
        "the {centres} equations of the {method} deformation have no stable solution (relative error {error:.1e}); lower deform.neighbour_value or use deform.method = \"biharmonic-rbf\""
    )]
    Singular {
        /// The method.
        method: DeformMethod,
        /// Number of equations.
        centres: usize,
        /// Relative error of the solution found.
        error: f64,
    },
    /// Sparse equations without a solution.
    #[error(
        "the thin plate could not be solved ({reason}); is the generic head one sound surface?"
    )]
    Plate {
        /// In the solver's words.
        reason: String,
    },
    /// A parameter outside its range.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// Cancelled by the observer.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

crate::stage_error!(DeformError, "deform");

/// Bends the generic head to the points.
///
/// # Errors
/// [`DeformError`] when the input cannot be used or the equations have no stable solution.
pub fn deform(
    input: &DeformInput<'_>,
    params: &DeformParams,
    observer: &dyn Observer,
) -> Result<Deformed, DeformError> {
    params.check("deform", None)?;
    input.template.validate()?;
    observer.check()?;
    for list in [input.assignments, input.features] {
        check_goals(list, input.template.vertices.len())?;
    }
    match params.method {
        DeformMethod::GaussianRbf => rbf_gaussian::deform(input, params),
        DeformMethod::LinearRbf => rbf_linear::deform(input, params),
        DeformMethod::Nicp => nicp::deform(input, params, observer),
        DeformMethod::BiharmonicRbf => rbf_biharmonic::deform(input, params, observer),
    }
}

fn check_goals(goals: &[(usize, Vec3)], count: usize) -> Result<(), DeformError> {
    for (position, &(vertex, goal)) in goals.iter().enumerate() {
        if vertex >= count {
            return Err(DeformError::Vertex { position, vertex, count });
        }
        if !goal.iter().all(|c| c.is_finite()) {
            return Err(DeformError::NotFinite { vertex });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
