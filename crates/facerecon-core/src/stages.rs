//! The stages, one file each; none imports another.

pub mod cameras;
pub mod check;
pub mod correspond;
pub mod deform;
pub mod detect;
mod error;
pub mod filter;
pub mod landmarks;
pub mod outline;
pub mod rectify;
pub mod refine;
pub mod register;
pub mod smooth;
pub mod surface;
pub mod texture;
pub mod triangulate;

pub(crate) use error::stage_error;
pub use error::{ErrorKind, StageError};
