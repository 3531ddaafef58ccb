//! Splits faces where the data have more detail than the template.

use std::collections::HashMap;

use super::surface_match::SurfaceMatch;
use crate::data::Mesh;
use crate::math::Vec3;

/// Matches with a smaller weight do not mark a vertex as measured.
const MIN_WEIGHT: f64 = 0.1;
/// Rounds at most; each halves the edges, so these divide them by 16.
const MAX_ROUNDS: usize = 4;
/// Faces are split while their mean edge is longer than this, relative to the wanted length: the
/// edges after the last round are then between 2/3 and 4/3 of it.
const SPLIT_RATIO: f64 = 1.33;
/// Upper bound for the new vertices of each split face.
const NEW_VERTICES_PER_FACE: usize = 2;
/// Least cosine between the normals at the ends of an edge; below it the surface has a crease
/// there, and the edge is split at its straight middle.
const MIN_SMOOTH_COSINE: f64 = 0.5;

/// Splits faces that have matches until their edges are about `edge_mm` long; the result has at
/// most `max_vertices` vertices.
pub(super) fn subdivide_measured(
    mesh: &Mesh,
    matches: &[SurfaceMatch],
    edge_mm: f64,
    max_vertices: usize,
) -> Mesh {
    let mut near = vec![0u32; mesh.vertices.len()];
    let counted = matches.iter().filter(|m| m.weight > MIN_WEIGHT);
    counted.flat_map(|m| m.corners).for_each(|v| near[v] += 1);
    let mut measured: Vec<bool> =
        mesh.faces.iter().map(|f| f.iter().all(|&v| near[v as usize] > 0)).collect();
    let mut mesh = mesh.clone();
    for _ in 0..MAX_ROUNDS {
        let wanted: Vec<bool> = mesh
            .faces
            .iter()
            .zip(&measured)
            .map(|(f, m)| *m && mean_edge(&mesh, f) > SPLIT_RATIO * edge_mm)
            .collect();
        let count = wanted.iter().filter(|w| **w).count();
        if count == 0 || mesh.vertices.len() + NEW_VERTICES_PER_FACE * count > max_vertices {
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

/// Splits the wanted faces in four and their neighbours so that no vertex lies inside an edge (red
/// and green refinement). New vertices come after the old ones and lie on the smooth surface
/// through the ends of their edge (cubic Hermite by the vertex normals), so that a coarse mesh
/// becomes rounder and not only finer. Texture coordinates and colours are interpolated.
///
/// Returns the mesh and for each of its faces the face it came from.
fn subdivide_faces(mesh: &Mesh, wanted: &[bool]) -> (Mesh, Vec<usize>) {
    let mut out = mesh.clone();
    out.faces.clear();
    out.face_uvs.clear();
    let split = split_edges(mesh, wanted, &mut out);
    let mut split_uv: HashMap<(u32, u32), u32> = HashMap::new();
    let mut parents = Vec::new();
    for (f, face) in mesh.faces.iter().enumerate() {
        let middles = [0, 1, 2].map(|k| split.get(&edge_key(face[k], face[(k + 1) % 3])).copied());
        let triangles = split_pattern(middles.map(|c| c.is_some()));
        let corner = |k: usize| if k < 3 { face[k] } else { middles[k - 3].unwrap_or(face[k - 3]) };
        out.faces.extend(triangles.iter().map(|t| t.map(corner)));
        parents.extend(triangles.iter().map(|_| f));
        let Some(uv) = mesh.face_uvs.get(f) else { continue };
        let mut corner_uv = |k: usize| {
            if k < 3 {
                return uv[k];
            }
            let (i, j) = (uv[k - 3], uv[(k - 2) % 3]);
            *split_uv.entry(edge_key(i, j)).or_insert_with(|| {
                let (a, b) = (mesh.uvs[i as usize], mesh.uvs[j as usize]);
                out.uvs.push([(a[0] + b[0]) / 2.0, (a[1] + b[1]) / 2.0]);
                out.uvs.len() as u32 - 1
            })
        };
        out.face_uvs.extend(triangles.iter().map(|t| t.map(&mut corner_uv)));
    }
    (out, parents)
}

/// An edge in either direction.
fn edge_key(i: u32, j: u32) -> (u32, u32) {
    (i.min(j), i.max(j))
}

/// Adds the middles of all edges of the wanted faces to `out`; gives their numbers.
fn split_edges(mesh: &Mesh, wanted: &[bool], out: &mut Mesh) -> HashMap<(u32, u32), u32> {
    let normals = mesh.vertex_normals();
    let mut split: HashMap<(u32, u32), u32> = HashMap::new();
    for (face, _) in mesh.faces.iter().zip(wanted).filter(|(_, w)| **w) {
        for k in 0..3 {
            let (i, j) = (face[k], face[(k + 1) % 3]);
            split.entry(edge_key(i, j)).or_insert_with(|| {
                let id = out.vertices.len() as u32;
                out.vertices.push(smooth_middle(mesh, &normals, i as usize, j as usize));
                if let (Some(a), Some(b)) =
                    (mesh.colors.get(i as usize), mesh.colors.get(j as usize))
                {
                    out.colors.push([0, 1, 2].map(|c| a[c].midpoint(b[c])));
                }
                id
            });
        }
    }
    split
}

/// The triangles of a face by which of its edges (0-1, 1-2, 2-0) are split; 3, 4, 5 are the middles
/// of these edges.
fn split_pattern(split: [bool; 3]) -> Vec<[usize; 3]> {
    let turned = |by: usize, list: &[[usize; 3]]| {
        let turn = |k: usize| if k < 3 { (k + by) % 3 } else { 3 + (k - 3 + by) % 3 };
        list.iter().map(|p| p.map(turn)).collect()
    };
    match split {
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

/// Middle of an edge on the smooth surface.
fn smooth_middle(mesh: &Mesh, normals: &[Vec3], i: usize, j: usize) -> Vec3 {
    let (a, b) = (mesh.vertices[i], mesh.vertices[j]);
    let (na, nb) = (normals[i], normals[j]);
    let straight = (a + b) / 2.0;
    if na.dot(&nb) < MIN_SMOOTH_COSINE {
        return straight;
    }
    let edge = b - a;
    straight + (nb * edge.dot(&nb) - na * edge.dot(&na)) / 8.0
}

#[cfg(test)]
mod tests {
    use super::super::surface_match::fixtures::{match_at, sheet};
    use super::*;
    use crate::data::Topology;

    fn area(mesh: &Mesh) -> f64 {
        let one = |f: usize| {
            let [a, b, c] = mesh.corners(f);
            (b - a).cross(&(c - a)).norm() / 2.0
        };
        (0..mesh.faces.len()).map(one).sum()
    }

    #[test]
    fn measured_faces_are_split_to_the_wanted_length_without_gaps() {
        let mut mesh = sheet(9, 4.0);
        mesh.colors = vec![[10, 20, 30]; 81];
        let left = |v: &usize| mesh.vertices[*v].x < 14.0;
        let matches: Vec<SurfaceMatch> =
            (0..81).filter(left).map(|v| match_at(&mesh, v, mesh.vertices[v])).collect();
        let finer = subdivide_measured(&mesh, &matches, 1.0, 100_000);
        finer.validate().unwrap();
        assert_eq!(finer.vertices[..81], mesh.vertices[..]);
        assert!((area(&finer) - area(&mesh)).abs() < 1e-9);
        // an edge split on one side only would be a new border inside the sheet
        let border = Topology::new(&finer).border;
        for (p, border) in finer.vertices.iter().zip(&border) {
            let outside = [p.x, p.y].iter().any(|c| *c == 0.0 || *c == 32.0);
            assert_eq!(*border, outside, "{p}");
        }
        for face in finer.faces.iter() {
            let [a, b, c] = face.map(|v| finer.vertices[v as usize]);
            if a.x.max(b.x).max(c.x) <= 8.0 {
                assert!(mean_edge(&finer, face) < 1.33, "{}", mean_edge(&finer, face));
            }
        }
        // weak matches and the limit of the vertices leave the mesh as it is
        let weak: Vec<_> = matches.iter().map(|m| SurfaceMatch { weight: 0.05, ..*m }).collect();
        assert_eq!(subdivide_measured(&mesh, &weak, 1.0, 100_000), mesh);
        assert_eq!(subdivide_measured(&mesh, &matches, 1.0, 90), mesh);
    }

    #[test]
    fn new_vertices_lie_on_the_smooth_surface() {
        let radius = 20.0;
        let mut mesh = sheet(9, 2.0);
        for v in &mut mesh.vertices {
            let (x, y) = (v.x - 8.0, v.y - 8.0);
            *v = Vec3::new(x, y, (radius * radius - x * x - y * y).sqrt());
        }
        let split = subdivide_faces(&mesh, &vec![true; mesh.faces.len()]).0;
        let deviation = |p: &Vec3| (p.norm() - radius).abs();
        let inner = |p: &&Vec3| p.x.abs() < 5.0 && p.y.abs() < 5.0;
        let worst = split.vertices[81..].iter().filter(inner).map(deviation).fold(0.0, f64::max);
        // the straight middle of an edge of 2.8 mm lies 0.05 mm inside the sphere
        assert!(worst < 0.015, "{worst}");
    }
}
