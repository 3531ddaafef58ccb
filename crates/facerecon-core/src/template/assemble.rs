//! From half a head in the chart to the mesh of the whole head.

use super::half_head::{HALF_LANDMARKS, HalfHead};
use super::sculpt::Sculpt;
use crate::data::{Landmarks, Mesh, Rgb};
use crate::math::Vec3;

/// A head mesh to deform to a face, with its landmarks.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Template {
    /// `head`, `head-coarse`, or the name of its file.
    pub name: String,
    /// The mesh in the model frame: x right as seen by the viewer, y up, z toward the viewer, mm,
    /// origin between the ears.
    pub mesh: Mesh,
    /// Vertices of the 18 landmarks.
    pub landmarks: Landmarks,
    /// The same head with fewer vertices, if there is one.
    pub coarse: Option<Mesh>,
    /// Its own texture, if it has one.
    pub texture: Option<Rgb>,
}

impl Template {
    /// Height of the chin in the model frame, mm: what lies below it is neck and clothing.
    #[must_use]
    pub fn chin_y(&self) -> Option<f64> {
        let vertex = *self.landmarks.get("chin")?;
        self.mesh.vertices.get(vertex).map(|p| p.y)
    }
}

/// Evaluates the sculpt at the vertices of the half and adds the mirror image. Both halves share
/// the vertices on the midline.
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

    // Both halves share the texture coordinates at u = 0.5 (front midline), not those of the seam.
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
    for (name, &i) in HALF_LANDMARKS.iter().zip(&half.landmarks) {
        if name.contains("{}") {
            // The viewer's right is +x.
            landmarks.insert(name.replace("{}", "right"), i);
            landmarks.insert(name.replace("{}", "left"), mirror(i as u32) as usize);
        } else {
            landmarks.insert((*name).to_owned(), i);
        }
    }
    let mesh = Mesh { vertices, faces, uvs, face_uvs, ..Mesh::default() };
    Template { mesh, landmarks, ..Template::default() }
}
