//! The subject in front of the virtual rig.

use super::error::SimulateError;
use crate::data::{Landmarks, Mesh, Rgb};
use crate::math::Vec3;
use crate::render::RenderError;

/// What the cameras photograph.
#[derive(Clone, Copy, Debug)]
pub struct Subject<'a> {
    /// The mesh, model frame (x right, y up, z toward the viewer), millimetres.
    pub mesh: &'a Mesh,
    /// Its albedo as a texture, sRGB. Without it the vertex colours count, or else a colour of skin.
    pub texture: Option<&'a Rgb>,
    /// Vertices of the 18 landmarks. With them the capture has the three marked pairs of the thesis,
    /// and the truth has all landmarks.
    pub landmarks: Option<&'a Landmarks>,
    /// Whether each vertex belongs to the face, for `on_face` of the dots. Without it all of the
    /// subject counts as the face.
    pub face: Option<&'a [bool]>,
}

impl Subject<'_> {
    /// Whether mesh, face mask and landmarks are valid.
    pub(super) fn check(&self) -> Result<(), SimulateError> {
        self.mesh.validate().map_err(RenderError::from)?;
        let expected = self.mesh.vertices.len();
        if let Some(face) = self.face.filter(|f| f.len() != expected) {
            return Err(SimulateError::Subject { what: "face mask", got: face.len(), expected });
        }
        match self.landmarks.and_then(|l| l.iter().find(|(_, i)| **i >= expected)) {
            Some((name, &vertex)) => {
                Err(SimulateError::Landmark { name: name.clone(), vertex, vertices: expected })
            }
            None => Ok(()),
        }
    }

    /// Whether a face with these corners belongs to the face of the person.
    pub(super) fn is_face(&self, corners: &[u32; 3]) -> bool {
        self.face.is_none_or(|face| corners.iter().all(|&i| face[i as usize]))
    }
}

/// Centre of the bounding box of a mesh.
pub(super) fn centre(mesh: &Mesh) -> Vec3 {
    mesh.bounds().map_or_else(Vec3::zeros, |(low, high)| (low + high) / 2.0)
}
