//! Nearest points, closest points on surfaces, and iterative closest points.

mod assignment;
mod icp;
mod pattern_pitch;
mod points;
mod surface;

pub use assignment::eliminate_multiple;
pub use icp::{Icp, IcpIteration, IcpStep, Termination, iterate_closest_points};
pub use pattern_pitch::{estimate_pitch, thin_to_pitch};
pub use points::{Neighbour, PointIndex, median_spacing};
pub use surface::{SurfaceIndex, SurfacePoint};
