//! Stereolithography: triangles without texture. Corners at one place become one vertex.

use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::Path;

use super::{Fault, IoError, LoadedMesh, atomic};
use crate::data::Mesh;
use crate::math::Vec3;

/// Bytes before the triangles of a binary STL: a header of 80 and their number.
const HEADER: usize = 84;
/// Bytes a triangle.
const TRIANGLE: usize = 50;

/// Reads the bytes of a binary or ASCII STL file. Vertices come in the order of first use.
///
/// # Errors
/// [`Fault`] with what is wrong.
pub fn decode(bytes: &[u8]) -> Result<LoadedMesh, Fault> {
    let mut bytes = bytes.to_vec();
    if is_binary(&bytes) {
        // Many programs begin binary files with "solid", the mark of the ASCII ones.
        bytes[..5].fill(b' ');
    }
    let fault = |e: std::io::Error| {
        let shown: String = e.to_string().chars().take(200).collect();
        Fault::new(format!("the STL is damaged or none: {shown}"))
    };
    let mut cursor = Cursor::new(&bytes);
    let triangles = stl_io::create_stl_reader(&mut cursor).map_err(fault)?;
    let mut mesh = Mesh::default();
    let mut number = BTreeMap::new();
    let mut flat = 0;
    for triangle in triangles {
        let face = triangle.map_err(fault)?.vertices.map(|corner| {
            // Adding 0 makes one zero of both.
            let place = corner.0.map(|c| c + 0.0);
            *number.entry(place.map(f32::to_bits)).or_insert_with(|| {
                mesh.vertices.push(Vec3::from(place.map(f64::from)));
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
        warnings.push(format!("{flat} triangles have two corners at one place and are left out"));
    }
    Ok(LoadedMesh { mesh, warnings, ..LoadedMesh::default() })
}

fn is_binary(bytes: &[u8]) -> bool {
    let count = bytes.get(80..HEADER).and_then(|b| <[u8; 4]>::try_from(b).ok());
    count.is_some_and(|c| {
        let wanted = (u32::from_le_bytes(c) as usize).checked_mul(TRIANGLE);
        wanted.and_then(|w| w.checked_add(HEADER)) == Some(bytes.len())
    })
}

/// Writes a binary STL, whole or not at all; positions are rounded to 32-bit floats.
///
/// # Errors
/// [`IoError::Mesh`] for a face without vertices, [`IoError::Write`].
pub fn write(path: &Path, mesh: &Mesh) -> Result<(), IoError> {
    mesh.validate().map_err(|source| IoError::Mesh { path: path.to_owned(), source })?;
    let single = |v: Vec3| [v.x as f32, v.y as f32, v.z as f32];
    let triangles: Vec<stl_io::Triangle> = (0..mesh.faces.len())
        .map(|f| {
            let [a, b, c] = mesh.corners(f);
            let normal = (b - a).cross(&(c - a)).try_normalize(1e-300).unwrap_or_default();
            stl_io::Triangle {
                normal: stl_io::Normal::new(single(normal)),
                vertices: [a, b, c].map(|p| stl_io::Vertex::new(single(p))),
            }
        })
        .collect();
    let mut bytes = Vec::with_capacity(HEADER + TRIANGLE * triangles.len());
    stl_io::write_stl(&mut bytes, triangles.iter())
        .map_err(|source| IoError::Write { path: path.to_owned(), source })?;
    atomic::write(path, &bytes)
}

#[cfg(test)]
mod tests;
