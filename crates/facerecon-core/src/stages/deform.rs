//! Stage deform: bend the generic head to the registered points (thesis chapter 4).

mod nicp;
mod rbf;
mod rbf_biharmonic;
mod rbf_gaussian;
mod rbf_linear;

use crate::camera::Pinhole;
use crate::data::{Cloud, Mesh, MeshError, Outline};
use crate::math::{Similarity, Vec3};
use crate::observer::{Cancelled, Observer};
use crate::settings::{SettingsError, Value};

pub use nicp::NicpParams;

crate::settings::choices! {
    /// How the generic head is bent.
    pub enum DeformMethod {
        /// Gaussian radial basis functions; the width of each follows the distance to its nearest
        /// neighbour (thesis section 4.2.1).
        GaussianRbf = "gaussian-rbf",
        /// Linear radial basis functions within a radius (thesis section 4.2.2).
        LinearRbf = "linear-rbf",
        /// Regularised biharmonic splines with an affine part (Carr et al. 2001).
        BiharmonicRbf = "biharmonic-rbf",
        /// Robust non-rigid ICP to all points; the head is subdivided where they are dense (after
        /// Amberg et al. 2007).
        Nicp = "nicp",
    }
}

crate::settings::settings! {
    /// Bending the generic head to the points.
    pub struct DeformParams {
        /// How the generic head is bent.
        method: DeformMethod = DeformMethod::GaussianRbf;
        /// Whether landmarks are added to the points (thesis sections 6.5.2 and 7).
        use_landmarks: bool = true, alias "use_features";
        /// Gaussian and linear: value of a basis function (1 at its centre) at the nearest other
        /// centre; close to zero in the thesis.
        neighbour_value: f64 = 0.1, range 0.001..=0.5;
        /// Biharmonic: stiffness, in model units; more smooths more, 0 passes through every point.
        stiffness: f64 = 2.0, range 0.0..=1000.0;
        /// Biharmonic: rounds; in each the points are matched to the head as bent so far.
        rounds: usize = 3, range 1.0..=20.0;
        /// Radial basis functions: most centres; more points than this are thinned evenly. Time grows
        /// with the cube of their number.
        max_centres: usize = 3000, range 4.0..=6000.0;
        /// The non-rigid ICP's own parameters.
        nicp: NicpParams = NicpParams::default();
    }
}

/// The generic head and the points it is bent to; model frame, millimetres.
#[derive(Clone, Copy, Debug)]
pub struct DeformInput<'a> {
    /// The generic head.
    pub template: &'a Mesh,
    /// The registered points.
    pub data: &'a Cloud,
    /// Vertices with the one data point of each (not used by non-rigid ICP).
    pub assignments: &'a [(usize, Vec3)],
    /// Vertices of landmarks with their measured positions.
    pub landmarks: &'a [LandmarkTarget],
    /// The subject's outlines in the photos, which bound the head; only non-rigid ICP uses them.
    pub outlines: &'a [OutlineView<'a>],
}

/// The subject's outline in one photo, with the camera that took it.
#[derive(Clone, Copy, Debug)]
pub struct OutlineView<'a> {
    /// The camera.
    pub camera: Pinhole,
    /// From the frame of the head to that of the camera.
    pub camera_from_mesh: Similarity,
    /// The outline in the photo as taken.
    pub outline: &'a Outline,
}

/// The measured position of a landmark of the head; model frame, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LandmarkTarget {
    /// The landmark's vertex on the template.
    pub vertex: usize,
    /// Its measured position.
    pub position: Vec3,
    /// Standard deviation of the position in each direction.
    pub sigma_mm: f64,
}

/// A bent head.
#[derive(Clone, Debug, PartialEq)]
pub struct Deformed {
    /// The template with new vertex positions; vertices that non-rigid ICP adds come after its own.
    pub mesh: Mesh,
    /// Centres of the basis functions, or matched points (non-rigid ICP).
    pub centres: usize,
    /// Root mean square distance before: of the assigned vertices from their points, or of the
    /// matched points from the surface along its normals (non-rigid ICP). Model units.
    pub rms_before: f64,
    /// The same after.
    pub rms_after: f64,
}

/// A deformation that cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DeformError {
    /// A template that cannot be used.
    #[error("the generic head cannot be used: {0}")]
    Template(#[from] MeshError),
    /// A vertex that does not exist.
    #[error(
        "point {position} (from 0) is assigned to vertex {vertex}, but the head has {count} vertices; assign it to a vertex from 0 to {last}", last = .count.saturating_sub(1)
    )]
    Vertex {
        /// Position in the list.
        position: usize,
        /// The vertex it is assigned to.
        vertex: usize,
        /// Vertices of the head.
        count: usize,
    },
    /// A target position that is not finite.
    #[error(
        "the target of vertex {vertex} has a coordinate that is not a finite number; check the points that are assigned to it"
    )]
    NotFinite {
        /// The vertex.
        vertex: usize,
    },
    /// Too few points on the head.
    #[error(
        "{got} points are matched to the head, but at least {needed} are needed to bend it; check the matches of the dots and the registration"
    )]
    TooFew {
        /// Matched points.
        got: usize,
        /// Least number.
        needed: usize,
    },
    /// Equations without a usable solution.
    #[error(
        "the {centres} equations of the {method} deformation have no stable solution (relative error {error:.1e}, at most 1e-8 expected); lower deform.neighbour_value or use deform.method = \"biharmonic-rbf\""
    )]
    Singular {
        /// The method.
        method: DeformMethod,
        /// Centres, as many as equations.
        centres: usize,
        /// Relative error of the solution found.
        error: f64,
    },
    /// Sparse equations without a solution.
    #[error(
        "the equations of the thin plate have no solution ({reason}); check that the generic head is a manifold mesh without degenerate faces"
    )]
    Plate {
        /// The solver's message.
        reason: String,
    },
    /// A parameter outside its range.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// Cancelled by the observer.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

crate::stages::stage_error!(DeformError, "deform");

/// Greatest relative residual of a dense solution that is accepted: it moves vertices by less than a
/// thousandth of a micrometre.
const MAX_SOLVE_ERROR: f64 = 1e-8;

/// Bends the generic head to the points.
///
/// # Errors
/// [`DeformError`] when the input cannot be used or the equations have no stable solution, for
/// parameters out of range, and when the observer cancels.
///
/// ```
/// use facerecon_core::data::{Cloud, Mesh};
/// use facerecon_core::math::Vec3;
/// use facerecon_core::stages::deform::{DeformInput, DeformParams, deform};
///
/// let vertices = [[0.0, 0.0], [10.0, 0.0], [0.0, 10.0], [10.0, 10.0]];
/// let template = Mesh {
///     vertices: vertices.map(|[x, y]| Vec3::new(x, y, 0.0)).to_vec(),
///     faces: vec![[0, 1, 2], [1, 3, 2]],
///     ..Mesh::default()
/// };
/// // two vertices have a measured point, 1 mm and 2 mm in front of them
/// let assignments = [(0, Vec3::new(0.0, 0.0, 1.0)), (3, Vec3::new(10.0, 10.0, 2.0))];
/// let input = DeformInput {
///     template: &template,
///     data: &Cloud::default(),
///     assignments: &assignments,
///     landmarks: &[],
///     outlines: &[],
/// };
/// let deformed = deform(&input, &DeformParams::default(), &())?;
/// assert!((deformed.mesh.vertices[3].z - 2.0).abs() < 1e-9);
/// assert!(deformed.rms_after < 1e-9);
/// # Ok::<(), facerecon_core::stages::deform::DeformError>(())
/// ```
pub fn deform(
    input: &DeformInput<'_>,
    params: &DeformParams,
    observer: &dyn Observer,
) -> Result<Deformed, DeformError> {
    params.check("deform", None)?;
    input.template.validate()?;
    observer.check()?;
    let of_landmarks: Vec<_> = input.landmarks.iter().map(|l| (l.vertex, l.position)).collect();
    for list in [input.assignments, &of_landmarks] {
        check_targets(list, input.template.vertices.len())?;
    }
    match params.method {
        DeformMethod::GaussianRbf => rbf_gaussian::deform(input, params),
        DeformMethod::LinearRbf => rbf_linear::deform(input, params),
        DeformMethod::Nicp => nicp::deform(input, params, observer),
        DeformMethod::BiharmonicRbf => rbf_biharmonic::deform(input, params, observer),
    }
}

fn check_targets(targets: &[(usize, Vec3)], count: usize) -> Result<(), DeformError> {
    for (position, &(vertex, target)) in targets.iter().enumerate() {
        if vertex >= count {
            return Err(DeformError::Vertex { position, vertex, count });
        }
        if !target.iter().all(|c| c.is_finite()) {
            return Err(DeformError::NotFinite { vertex });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
