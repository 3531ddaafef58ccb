//! Keeps part of a mesh.

use crate::data::Mesh;

/// A part of a mesh.
pub(super) struct Cropped {
    pub mesh: Mesh,
    /// For each kept vertex its index in the whole mesh.
    pub source_vertices: Vec<u32>,
    /// For each vertex of the whole mesh its index in the part.
    pub new_index: Vec<Option<u32>>,
}

/// Keeps the vertices in any of the ranges (ends included; without ranges all) that are less than
/// `top_mm` below the highest of them, in their order, and the faces all of whose vertices are kept.
pub(super) fn crop(mesh: &Mesh, ranges: &[[usize; 2]], top_mm: Option<f64>) -> Cropped {
    let in_range =
        |i: usize| ranges.is_empty() || ranges.iter().any(|&[low, high]| (low..=high).contains(&i));
    let top = (0..mesh.vertices.len())
        .filter(|&i| in_range(i))
        .map(|i| mesh.vertices[i].y)
        .fold(f64::NEG_INFINITY, f64::max);
    let floor = top_mm.map_or(f64::NEG_INFINITY, |height| top - height);
    let kept: Vec<u32> = (0..mesh.vertices.len())
        .filter(|&i| in_range(i) && mesh.vertices[i].y >= floor)
        .map(|i| i as u32)
        .collect();
    let mut new_index = vec![None; mesh.vertices.len()];
    for (new, &i) in kept.iter().enumerate() {
        new_index[i as usize] = Some(new as u32);
    }
    let mut part = Mesh {
        vertices: kept.iter().map(|&i| mesh.vertices[i as usize]).collect(),
        uvs: mesh.uvs.clone(),
        colors: kept.iter().filter_map(|&i| mesh.colors.get(i as usize).copied()).collect(),
        ..Mesh::default()
    };
    for (f, face) in mesh.faces.iter().enumerate() {
        let [a, b, c] = face.map(|i| new_index[i as usize]);
        if let (Some(a), Some(b), Some(c)) = (a, b, c) {
            part.faces.push([a, b, c]);
            part.face_uvs.extend(mesh.face_uvs.get(f));
        }
    }
    Cropped { mesh: part, source_vertices: kept, new_index }
}
