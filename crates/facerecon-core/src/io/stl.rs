//! Stereolithography: triangles without texture. Corners at the same position become one vertex.

use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::Path;

use super::atomic;
use super::error::{Fault, IoError};
use super::loaded_mesh::LoadedMesh;
use crate::data::Mesh;
use crate::math::Vec3;

/// Bytes before the triangles of a binary STL: 80 of a header and 4 of their number.
const HEADER: usize = 84;
/// Bytes of a triangle.
const TRIANGLE: usize = 50;

/// Longest message of the parser that is shown, characters.
const MAX_REASON: usize = 200;

/// Reads the bytes of a binary or ASCII STL file. Vertices are in the order of first use.
///
/// # Errors
/// [`Fault`] with what is wrong.
pub(super) fn decode(bytes: &[u8]) -> Result<LoadedMesh, Fault> {
    let mut bytes = bytes.to_vec();
    if is_binary(&bytes) {
        // Many programs begin binary files with "solid", as ASCII files must.
        bytes[..5].fill(b' ');
    }
    let fault = |e: std::io::Error| {
        let shown: String = e.to_string().chars().take(MAX_REASON).collect();
        Fault::new(format!("the STL is damaged, or not an STL: {shown}"))
    };
    let mut cursor = Cursor::new(&bytes);
    let triangles = stl_io::create_stl_reader(&mut cursor).map_err(fault)?;
    let mut mesh = Mesh::default();
    let mut number = BTreeMap::new();
    let mut flat = 0;
    for triangle in triangles {
        let face = triangle.map_err(fault)?.vertices.map(|corner| {
            // Adding 0 turns -0 into 0.
            let position = corner.0.map(|c| c + 0.0);
            *number.entry(position.map(f32::to_bits)).or_insert_with(|| {
                mesh.vertices.push(Vec3::from(position.map(f64::from)));
                mesh.vertices.len() as u32 - 1
            })
        });
        let [a, b, c] = face;
        if a == b || b == c || c == a {
            flat += 1;
        } else {
            mesh.faces.push(face);
        }
    }
    let mut warnings = Vec::new();
    if flat > 0 {
        warnings.push(format!(
            "{flat} triangles have two corners at the same position and are not read"
        ));
    }
    Ok(LoadedMesh { mesh, warnings, ..LoadedMesh::default() })
}

fn is_binary(bytes: &[u8]) -> bool {
    let count = bytes.get(80..HEADER).and_then(|b| <[u8; 4]>::try_from(b).ok());
    count.is_some_and(|c| {
        let triangles = (u32::from_le_bytes(c) as usize).checked_mul(TRIANGLE);
        triangles.and_then(|t| t.checked_add(HEADER)) == Some(bytes.len())
    })
}

/// Writes a binary STL atomically; positions are rounded to 32-bit floats.
///
/// # Errors
/// [`IoError::Mesh`] for a mesh that is not valid, [`IoError::Write`].
pub(super) fn write(path: &Path, mesh: &Mesh) -> Result<(), IoError> {
    mesh.validate().map_err(|source| IoError::Mesh { path: path.to_owned(), source })?;
    let single = |v: Vec3| [v.x as f32, v.y as f32, v.z as f32];
    let triangles: Vec<stl_io::Triangle> = (0..mesh.faces.len())
        .map(|f| stl_io::Triangle {
            normal: stl_io::Normal::new(single(mesh.face_normal(f))),
            vertices: mesh.corners(f).map(|p| stl_io::Vertex::new(single(p))),
        })
        .collect();
    let mut bytes = Vec::with_capacity(HEADER + TRIANGLE * triangles.len());
    stl_io::write_stl(&mut bytes, triangles.iter())
        .map_err(|source| IoError::Write { path: path.to_owned(), source })?;
    atomic::write(path, &bytes)
}

#[cfg(test)]
mod tests;
