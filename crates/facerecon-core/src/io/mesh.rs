//! Meshes of any format.

use std::path::Path;

use super::source::read_bytes;
use super::{Fault, IoError, LengthUnit, glb, obj, ply, stl, vrml};
use crate::data::{Mesh, Rgb};

/// Longest mesh file, MB.
const MAX_FILE_MB: u64 = 256;
/// Coordinates beyond this are no lengths in any unit.
const MAX_COORDINATE: f64 = 1e9;

/// A mesh from a file, and what came with it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoadedMesh {
    /// The mesh, vertices in the order of the file.
    pub mesh: Mesh,
    /// Its texture.
    pub texture: Option<Rgb>,
    /// The unit of the coordinates where the format states it (GLB: converted to millimetres).
    pub unit: Option<LengthUnit>,
    /// What the user should know: things left out, a texture that is missing.
    pub warnings: Vec<String>,
}

/// A format of mesh files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshFormat {
    /// Wavefront OBJ with MTL and a picture.
    Obj,
    /// VRML 1.0 or 2.0 (read only).
    Vrml,
    /// Stanford PLY.
    Ply,
    /// Binary glTF 2.0, the texture inside.
    Glb,
    /// Stereolithography.
    Stl,
}

impl MeshFormat {
    /// The format that a file's beginning shows, or else its ending names.
    pub fn of(path: &Path, bytes: &[u8]) -> Option<Self> {
        match bytes {
            [b'p', b'l', b'y', b'\n' | b'\r', ..] => Some(Self::Ply),
            [b'g', b'l', b'T', b'F', ..] => Some(Self::Glb),
            [b'#', b'V', b'R', b'M', b'L', ..] => Some(Self::Vrml),
            _ => Self::of_ending(path),
        }
    }

    fn of_ending(path: &Path) -> Option<Self> {
        match ending(path).as_str() {
            "obj" => Some(Self::Obj),
            "wrl" | "vrml" => Some(Self::Vrml),
            "ply" => Some(Self::Ply),
            "glb" => Some(Self::Glb),
            "stl" => Some(Self::Stl),
            _ => None,
        }
    }
}

fn ending(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default()
}

/// Reads a mesh: OBJ, VRML, PLY, GLB or STL. The vertices keep the order of the file, those that no
/// face uses too; polygons are cut into triangles as fans.
///
/// # Errors
/// [`IoError`]: unreadable, an unknown format, malformed (with the line where the format has
/// lines), or without faces.
pub fn read_mesh(path: &Path) -> Result<LoadedMesh, IoError> {
    let loaded = read_any(path)?;
    let fail = |source| IoError::Mesh { path: path.to_owned(), source };
    loaded.mesh.validate().map_err(fail)?;
    Ok(loaded)
}

/// Reads a mesh file that may have no faces: a cloud of points.
pub(super) fn read_any(path: &Path) -> Result<LoadedMesh, IoError> {
    let bytes = read_bytes(path, "mesh", MAX_FILE_MB)?;
    if bytes.starts_with(&[0x1f, 0x8b]) {
        return Err(IoError::malformed(
            path,
            "the file is compressed; unpack it with gunzip first",
        ));
    }
    let folder = path.parent().unwrap_or(Path::new(""));
    let loaded = match MeshFormat::of(path, &bytes) {
        Some(MeshFormat::Obj) => obj::decode(&bytes, folder),
        Some(MeshFormat::Vrml) => vrml::decode(&bytes, folder),
        Some(MeshFormat::Ply) => ply::decode(&bytes, folder),
        Some(MeshFormat::Glb) => glb::decode(&bytes),
        Some(MeshFormat::Stl) => stl::decode(&bytes),
        None => {
            return Err(IoError::Ending {
                path: path.to_owned(),
                found: ending(path),
                expected: ".obj, .wrl, .ply, .glb or .stl",
            });
        }
    };
    let loaded = loaded.map_err(|e| e.in_file(path))?;
    check_coordinates(&loaded.mesh).map_err(|e| e.in_file(path))?;
    Ok(loaded)
}

fn check_coordinates(mesh: &Mesh) -> Result<(), Fault> {
    let fine = |v: f64| v.abs() <= MAX_COORDINATE;
    if let Some(i) = mesh.vertices.iter().position(|v| !v.iter().all(|c| fine(*c))) {
        return Err(Fault::new(format!(
            "vertex {i} lies at {:?}; that is no place",
            mesh.vertices[i]
        )));
    }
    if let Some(i) = mesh.uvs.iter().position(|uv| !uv.iter().all(|c| fine(*c))) {
        return Err(Fault::new(format!("texture coordinate {i} is {:?}", mesh.uvs[i])));
    }
    Ok(())
}

/// Writes a mesh in the format of the ending: `.obj` (with `.mtl`, and the texture as `.png`
/// beside it), `.ply` (the texture beside it too), `.glb` (the texture inside; positions in
/// millimetres, as the mesh) or `.stl` (no texture).
///
/// # Errors
/// [`IoError`] for an ending that cannot be written, a mesh that is not valid, or a full disk.
pub fn write_mesh(path: &Path, mesh: &Mesh, texture: Option<&Rgb>) -> Result<(), IoError> {
    mesh.validate().map_err(|source| IoError::Mesh { path: path.to_owned(), source })?;
    match MeshFormat::of_ending(path) {
        Some(MeshFormat::Obj) => obj::write(path, mesh, texture),
        Some(MeshFormat::Ply) => ply::write_mesh(path, mesh, texture),
        Some(MeshFormat::Glb) => glb::write(path, mesh, texture),
        Some(MeshFormat::Stl) => stl::write(path, mesh),
        Some(MeshFormat::Vrml) | None => Err(IoError::Ending {
            path: path.to_owned(),
            found: ending(path),
            expected: ".obj, .ply, .glb or .stl to write a mesh",
        }),
    }
}
