//! Binary glTF 2.0: one mesh with its texture inside, out and in.
//!
//! glTF is in metres: the writer keeps millimetres in the buffers and puts the scale 0.001 on the
//! node; the reader applies the nodes' transforms and returns millimetres.

mod decode;
mod encode;

use std::path::Path;

use super::{IoError, atomic, encode_png};
use crate::data::{Mesh, Rgb};
pub use decode::decode;
pub use encode::encode;

/// Writes a GLB with the texture inside as PNG, whole or not at all.
///
/// # Errors
/// [`IoError::Mesh`] for a mesh that is not valid, [`IoError::Write`].
pub fn write(path: &Path, mesh: &Mesh, texture: Option<&Rgb>) -> Result<(), IoError> {
    mesh.validate().map_err(|source| IoError::Mesh { path: path.to_owned(), source })?;
    let png = texture.map(encode_png).transpose().map_err(|e| e.in_file(path))?;
    atomic::write(path, &encode(mesh, png.as_deref()))
}

#[cfg(test)]
mod tests;
