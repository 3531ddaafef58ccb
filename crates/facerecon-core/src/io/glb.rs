//! Binary glTF 2.0: one mesh with its texture inside, read and written.
//!
//! glTF is in metres: the writer keeps millimetres in the buffers and puts the scale 0.001 on the
//! node; the reader applies the nodes' transforms and returns millimetres.

mod accessor;
mod constants;
mod container;
mod decode;
mod encode;
mod srgb;

use std::path::Path;

use super::atomic;
use super::error::IoError;
use super::image::encode_png;
use crate::data::{Mesh, Rgb};
pub(super) use decode::decode;
pub use encode::encode;

/// Writes a GLB with the texture inside as PNG, atomically.
///
/// # Errors
/// [`IoError::Mesh`] for a mesh that is not valid, [`IoError::Write`].
pub(super) fn write(path: &Path, mesh: &Mesh, texture: Option<&Rgb>) -> Result<(), IoError> {
    mesh.validate().map_err(|source| IoError::Mesh { path: path.to_owned(), source })?;
    let png = texture.map(encode_png).transpose().map_err(|e| e.in_file(path))?;
    atomic::write(path, &encode(mesh, png.as_deref()))
}

#[cfg(test)]
mod tests;
