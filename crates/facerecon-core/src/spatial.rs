//! Nearest points and closest points on surfaces. Floor 1.

mod points;
mod surface;

pub use points::{Neighbour, PointIndex};
pub use surface::{SurfaceIndex, SurfacePoint};
