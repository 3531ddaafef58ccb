//! From the half in the chart to the whole head as a mesh.

use super::asset::{HalfHead, LANDMARKS};
use super::sculpt::Sculpt;
use crate::data::{Landmarks, Mesh, Rgb};
use crate::math::Vec3;

/// A mesh to bend to a face, with the places of the named features on it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Template {
    /// Its name: `head`, `head-coarse`, or that of its file.
    pub name: String,
    /// The head in the model frame: x right as seen by the viewer, y up, z toward the viewer, mm,
    /// origin between the ears.
    pub mesh: Mesh,
    /// Vertices of the 18 features.
    pub landmarks: Landmarks,
    /// The same head with fewer vertices, where there is one.
    pub coarse: Option<Mesh>,
    /// Its own texture, where it has one.
    pub texture: Option<Rgb>,
}

/// Evaluates the sculpt at the half's vertices and adds the mirror image; vertices on the
/// midline are shared.
pub(crate) fn assemble(sculpt: &Sculpt, half: &HalfHead) -> Template {
    let (n, m) = (half.q.len(), half.midline);
    let mut vertices: Vec<Vec3> = half.q.iter().map(|&q| sculpt.point(q)).collect();
    vertices.extend_from_within(m..);
    for v in &mut vertices[n..] {
        v.x = -v.x;
    }
    let mirror = |i: u32| if (i as usize) < m { i } else { i + (n - m) as u32 };
    let mut faces = half.faces.clone();
    faces.extend(half.faces.iter().map(|&[a, b, c]| [a, c, b].map(mirror)));

    // Texture: the part of the midline at u = 0.5 is shared, the seam is not.
    let mut uvs = half.uv.clone();
    let mut mirrored = Vec::with_capacity(n);
    for (i, &[u, v]) in half.uv.iter().enumerate() {
        if i < m && (u - 0.5).abs() < 1e-9 {
            mirrored.push(i as u32);
        } else {
            mirrored.push(uvs.len() as u32);
            uvs.push([1.0 - u, v]);
        }
    }
    let mut face_uvs = half.faces.clone();
    face_uvs.extend(half.faces.iter().map(|&[a, b, c]| [a, c, b].map(|i| mirrored[i as usize])));

    let mut landmarks = Landmarks::new();
    for (name, &i) in LANDMARKS.iter().zip(&half.landmarks) {
        if name.contains("{}") {
            // The viewer's right is +x.
            landmarks.insert(name.replace("{}", "right"), i);
            landmarks.insert(name.replace("{}", "left"), mirror(i as u32) as usize);
        } else {
            landmarks.insert((*name).to_owned(), i);
        }
    }
    let mesh = Mesh { vertices, faces, uvs, face_uvs, colors: Vec::new() };
    Template { mesh, landmarks, ..Template::default() }
}
