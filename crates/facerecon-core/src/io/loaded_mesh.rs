//! What reading a mesh file gives.

use super::unit::LengthUnit;
use crate::data::{Mesh, Rgb};

/// A mesh from a file, with its texture and the warnings of its reading.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoadedMesh {
    /// The mesh, vertices in the order of the file.
    pub mesh: Mesh,
    /// Its texture.
    pub texture: Option<Rgb>,
    /// The unit of the coordinates where the format states it (GLB: converted to millimetres).
    pub unit: Option<LengthUnit>,
    /// Warnings: what was not read, a missing texture.
    pub warnings: Vec<String>,
}
