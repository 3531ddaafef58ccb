//! Transforms, least-squares fits, robust statistics and interpolation.

mod fit;
mod interpolation;
mod plane;
mod point_to_plane;
mod robust;
mod transform;

pub use fit::{fit_line, fit_similarity};
pub use interpolation::interpolate;
pub use plane::fit_plane_robust;
pub use point_to_plane::{PlanePair, fit_to_planes, plane_rms};
pub use robust::{mad, median, percentile};
pub use transform::Similarity;

/// A vector or point in the plane, pixels unless a name says otherwise.
pub type Vec2 = nalgebra::Vector2<f64>;
/// A vector or point in space.
pub type Vec3 = nalgebra::Vector3<f64>;
/// A 2x2 matrix.
pub type Mat2 = nalgebra::Matrix2<f64>;
/// A 3x3 matrix.
pub type Mat3 = nalgebra::Matrix3<f64>;
