//! Nearest points and closest points on surfaces. Floor 1.

mod assign;
mod lattice;
mod points;
mod surface;

pub use assign::eliminate_multiple;
pub use lattice::{pitch, thinned};
pub use points::{Neighbour, PointIndex};
pub use surface::{SurfaceIndex, SurfacePoint};
