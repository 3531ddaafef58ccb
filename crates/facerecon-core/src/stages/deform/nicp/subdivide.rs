//! Splitting faces where the data have more detail than the template.

use std::collections::HashMap;

use super::matching::Found;
use crate::data::Mesh;
use crate::math::Vec3;

/// Splits faces that carry matches until their edges are about `edge_mm` long; no more than
/// `max_vertices` come out.
pub(super) fn where_measured(
    mesh: &Mesh,
    found: &[Found],
    edge_mm: f64,
    max_vertices: usize,
) -> Mesh {
    let mut near = vec![0u32; mesh.vertices.len()];
    found.iter().filter(|f| f.weight > 0.1).flat_map(|f| f.corners).for_each(|v| near[v] += 1);
    let mut measured: Vec<bool> =
        mesh.faces.iter().map(|f| f.iter().all(|&v| near[v as usize] > 0)).collect();
    let mut mesh = mesh.clone();
    // each round halves the edges; four rounds are a factor of 16
    for _ in 0..4 {
        let wanted: Vec<bool> = mesh
            .faces
            .iter()
            .zip(&measured)
            .map(|(f, m)| *m && mean_edge(&mesh, f) > 1.33 * edge_mm)
            .collect();
        let count = wanted.iter().filter(|w| **w).count();
        // a split of all faces of a region adds 3/2 of a vertex for each
        if count == 0 || mesh.vertices.len() + 2 * count > max_vertices {
            break;
        }
        let (finer, parents) = subdivide_faces(&mesh, &wanted);
        measured = parents.iter().map(|&p| measured[p]).collect();
        mesh = finer;
    }
    mesh
}

fn mean_edge(mesh: &Mesh, face: &[u32; 3]) -> f64 {
    let [a, b, c] = face.map(|i| mesh.vertices[i as usize]);
    ((a - b).norm() + (b - c).norm() + (c - a).norm()) / 3.0
}

/// Splits the wanted faces in four and their neighbours so that no vertex is left hanging (red
/// and green refinement). New vertices come after the old ones and lie on the smooth surface
/// through the edge's ends (cubic Hermite by the vertex normals), so that a coarse mesh becomes
/// rounder and not only finer. Texture coordinates and colours are carried.
///
/// Returns the mesh and for each of its faces the face it came from.
fn subdivide_faces(mesh: &Mesh, wanted: &[bool]) -> (Mesh, Vec<usize>) {
    let normals = mesh.vertex_normals();
    let mut out = mesh.clone();
    out.faces.clear();
    out.face_uvs.clear();
    let mut split: HashMap<(u32, u32), u32> = HashMap::new();
    for (face, _) in mesh.faces.iter().zip(wanted).filter(|(_, w)| **w) {
        for k in 0..3 {
            let (i, j) = (face[k], face[(k + 1) % 3]);
            split.entry((i.min(j), i.max(j))).or_insert_with(|| {
                let id = out.vertices.len() as u32;
                out.vertices.push(middle(mesh, &normals, i as usize, j as usize));
                if let (Some(a), Some(b)) =
                    (mesh.colors.get(i as usize), mesh.colors.get(j as usize))
                {
                    out.colors.push([0, 1, 2].map(|c| a[c].midpoint(b[c])));
                }
                id
            });
        }
    }
    let mut split_uv: HashMap<(u32, u32), u32> = HashMap::new();
    let mut parents = Vec::new();
    for (f, face) in mesh.faces.iter().enumerate() {
        let cut = [0, 1, 2].map(|k| {
            let (i, j) = (face[k], face[(k + 1) % 3]);
            split.get(&(i.min(j), i.max(j))).copied()
        });
        let pieces = pattern(cut.map(|c| c.is_some()));
        let corner = |k: usize| if k < 3 { face[k] } else { cut[k - 3].unwrap_or(face[k - 3]) };
        out.faces.extend(pieces.iter().map(|p| p.map(corner)));
        parents.extend(pieces.iter().map(|_| f));
        let Some(uv) = mesh.face_uvs.get(f) else { continue };
        let mut corner_uv = |k: usize| {
            if k < 3 {
                return uv[k];
            }
            let (i, j) = (uv[k - 3], uv[(k - 2) % 3]);
            *split_uv.entry((i.min(j), i.max(j))).or_insert_with(|| {
                let (a, b) = (mesh.uvs[i as usize], mesh.uvs[j as usize]);
                out.uvs.push([(a[0] + b[0]) / 2.0, (a[1] + b[1]) / 2.0]);
                out.uvs.len() as u32 - 1
            })
        };
        out.face_uvs.extend(pieces.iter().map(|p| p.map(&mut corner_uv)));
    }
    (out, parents)
}

/// The pieces of a face by which of its edges (0-1, 1-2, 2-0) are cut; 3, 4, 5 are their middles.
fn pattern(cut: [bool; 3]) -> Vec<[usize; 3]> {
    let turned = |by: usize, list: &[[usize; 3]]| {
        let turn = |k: usize| if k < 3 { (k + by) % 3 } else { 3 + (k - 3 + by) % 3 };
        list.iter().map(|p| p.map(turn)).collect()
    };
    match cut {
        [false, false, false] => vec![[0, 1, 2]],
        [true, true, true] => vec![[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]],
        [true, false, false] => turned(0, &[[0, 3, 2], [3, 1, 2]]),
        [false, true, false] => turned(1, &[[0, 3, 2], [3, 1, 2]]),
        [false, false, true] => turned(2, &[[0, 3, 2], [3, 1, 2]]),
        [true, true, false] => turned(0, &[[3, 1, 4], [0, 3, 2], [3, 4, 2]]),
        [false, true, true] => turned(1, &[[3, 1, 4], [0, 3, 2], [3, 4, 2]]),
        [true, false, true] => turned(2, &[[3, 1, 4], [0, 3, 2], [3, 4, 2]]),
    }
}

/// Middle of an edge on the smooth surface; plain where the surface has a crease.
fn middle(mesh: &Mesh, normals: &[Vec3], i: usize, j: usize) -> Vec3 {
    let (a, b) = (mesh.vertices[i], mesh.vertices[j]);
    let (na, nb) = (normals[i], normals[j]);
    let plain = (a + b) / 2.0;
    if na.dot(&nb) < 0.5 {
        return plain;
    }
    let edge = b - a;
    plain + (nb * edge.dot(&nb) - na * edge.dot(&na)) / 8.0
}
