//! Meshes of all formats.

use std::path::Path;

use super::error::{Fault, IoError};
use super::loaded_mesh::LoadedMesh;
use super::source::read_bytes;
use super::{glb, obj, ply, stl, vrml};
use crate::data::{Mesh, Rgb};

/// Longest mesh file, MB: about three million triangles as text.
const MAX_FILE_MB: u64 = 256;
/// Largest coordinate: a metre in nanometres. Larger ones are garbage, and squares of them would
/// lose all digits.
const MAX_COORDINATE: f64 = 1e9;

/// A format of mesh files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshFormat {
    /// Wavefront OBJ with MTL and a texture image.
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
    /// The format by the first bytes of the file, or else by the file name extension.
    pub fn of(path: &Path, bytes: &[u8]) -> Option<Self> {
        match bytes {
            [b'p', b'l', b'y', b'\n' | b'\r', ..] => Some(Self::Ply),
            [b'g', b'l', b'T', b'F', ..] => Some(Self::Glb),
            [b'#', b'V', b'R', b'M', b'L', ..] => Some(Self::Vrml),
            _ => Self::of_extension(path),
        }
    }

    fn of_extension(path: &Path) -> Option<Self> {
        match extension(path).as_str() {
            "obj" => Some(Self::Obj),
            "wrl" | "vrml" => Some(Self::Vrml),
            "ply" => Some(Self::Ply),
            "glb" => Some(Self::Glb),
            "stl" => Some(Self::Stl),
            _ => None,
        }
    }
}

fn extension(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default()
}

/// Reads a mesh: OBJ, VRML, PLY, GLB or STL. All vertices are kept in the order of the file (STL: of
/// first use); polygons become triangle fans.
///
/// # Errors
/// [`IoError`]: unreadable, an unknown format, malformed (with the line where the format has
/// lines), or without faces.
///
/// ```
/// use facerecon_core::data::Mesh;
/// use facerecon_core::io::{read_mesh, write_mesh};
/// use facerecon_core::math::Vec3;
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("triangle.ply");
/// let mesh = Mesh {
///     vertices: vec![Vec3::zeros(), Vec3::new(10.0, 0.0, 0.0), Vec3::new(0.0, 10.0, 0.0)],
///     faces: vec![[0, 1, 2]],
///     ..Mesh::default()
/// };
/// write_mesh(&path, &mesh, None)?;
/// assert_eq!(read_mesh(&path)?.mesh, mesh);
/// # Ok(())
/// # }
/// ```
pub fn read_mesh(path: &Path) -> Result<LoadedMesh, IoError> {
    let loaded = read_any(path)?;
    let fail = |source| IoError::Mesh { path: path.to_owned(), source };
    loaded.mesh.validate().map_err(fail)?;
    Ok(loaded)
}

/// Reads a mesh file; unlike [`read_mesh`] it accepts one without faces (a point cloud).
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
                found: extension(path),
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
            "vertex {i} is at {:?}; coordinates up to {MAX_COORDINATE:e} are expected",
            mesh.vertices[i].as_slice()
        )));
    }
    if let Some(i) = mesh.uvs.iter().position(|uv| !uv.iter().all(|c| fine(*c))) {
        return Err(Fault::new(format!(
            "texture coordinate {i} is {:?}; values up to {MAX_COORDINATE:e} are expected",
            mesh.uvs[i]
        )));
    }
    Ok(())
}

/// Writes a mesh in the format of the file name extension: `.obj` (with `.mtl`, and the texture as
/// `.png` in the same folder), `.ply` (the texture likewise), `.glb` (the texture inside) or `.stl`
/// (no texture).
///
/// # Errors
/// [`IoError`] for an extension that cannot be written, a mesh that is not valid, or a failure to
/// write.
pub fn write_mesh(path: &Path, mesh: &Mesh, texture: Option<&Rgb>) -> Result<(), IoError> {
    mesh.validate().map_err(|source| IoError::Mesh { path: path.to_owned(), source })?;
    match MeshFormat::of_extension(path) {
        Some(MeshFormat::Obj) => obj::write(path, mesh, texture),
        Some(MeshFormat::Ply) => ply::write_mesh(path, mesh, texture),
        Some(MeshFormat::Glb) => glb::write(path, mesh, texture),
        Some(MeshFormat::Stl) => stl::write(path, mesh),
        Some(MeshFormat::Vrml) | None => Err(IoError::Ending {
            path: path.to_owned(),
            found: extension(path),
            expected: ".obj, .ply, .glb or .stl to write a mesh",
        }),
    }
}
