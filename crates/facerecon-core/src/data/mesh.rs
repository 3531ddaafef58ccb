//! Triangle meshes.

use crate::math::{Similarity, Vec3};

/// Normals shorter than this (twice the area) cannot be normalised in 64 bit.
const NO_AREA: f64 = 1e-300;

/// A triangle mesh. The vertices are in the order of the file or template.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Positions, millimetres unless stated otherwise.
    pub vertices: Vec<Vec3>,
    /// Triangles, counter-clockwise seen from outside.
    pub faces: Vec<[u32; 3]>,
    /// Texture coordinates, u right, v up, (0, 0) the lower left corner of the texture.
    pub uvs: Vec<[f64; 2]>,
    /// For each face the three indices into `uvs`; empty when the mesh has none.
    pub face_uvs: Vec<[u32; 3]>,
    /// sRGB colour of each vertex; empty when the mesh has none.
    pub colors: Vec<[u8; 3]>,
    /// Standard deviation of each vertex along its normal, in the unit of `vertices`; empty when it
    /// is not known.
    pub sigmas: Vec<f64>,
    /// Whether measured points support each vertex; empty when it is not known.
    pub measured: Vec<bool>,
}

/// A mesh that cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshError {
    /// Fewer than 3 vertices, or no face.
    #[error("the mesh has {vertices} vertices and {faces} faces; at least 3 and 1 are needed")]
    Empty {
        /// Vertices found.
        vertices: usize,
        /// Faces found.
        faces: usize,
    },
    /// A face names a vertex or texture coordinate that does not exist.
    #[error("face {face} names vertex {index}, but there are {count} (counted from 0)")]
    Index {
        /// Number of the face.
        face: usize,
        /// Index found.
        index: u32,
        /// Number of vertices or texture coordinates.
        count: usize,
    },
    /// A coordinate that is not a number.
    #[error("vertex {vertex} has a coordinate that is not a finite number")]
    NotFinite {
        /// Number of the vertex.
        vertex: usize,
    },
    /// Lists of different lengths.
    #[error("the mesh has {got} {what}, but {expected} are expected")]
    Lengths {
        /// What was counted.
        what: &'static str,
        /// Found.
        got: usize,
        /// Expected.
        expected: usize,
    },
}

impl Mesh {
    /// Checks that there are faces, that all numbers are finite, and that lengths and indices fit.
    ///
    /// # Errors
    /// [`MeshError`] for the first fault.
    pub fn validate(&self) -> Result<(), MeshError> {
        if self.vertices.len() < 3 || self.faces.is_empty() {
            let (vertices, faces) = (self.vertices.len(), self.faces.len());
            return Err(MeshError::Empty { vertices, faces });
        }
        if let Some(vertex) = self.vertices.iter().position(|v| !v.iter().all(|c| c.is_finite())) {
            return Err(MeshError::NotFinite { vertex });
        }
        if !self.face_uvs.is_empty() && self.face_uvs.len() != self.faces.len() {
            let (got, expected) = (self.face_uvs.len(), self.faces.len());
            return Err(MeshError::Lengths {
                what: "faces with texture coordinates",
                got,
                expected,
            });
        }
        if !self.colors.is_empty() && self.colors.len() != self.vertices.len() {
            let (got, expected) = (self.colors.len(), self.vertices.len());
            return Err(MeshError::Lengths { what: "vertex colours", got, expected });
        }
        let expected = self.vertices.len();
        for (what, got) in [
            ("standard deviations of vertices", self.sigmas.len()),
            ("measured flags of vertices", self.measured.len()),
        ] {
            if got != 0 && got != expected {
                return Err(MeshError::Lengths { what, got, expected });
            }
        }
        let check = |faces: &[[u32; 3]], count: usize| {
            for (face, corners) in faces.iter().enumerate() {
                if let Some(&index) = corners.iter().find(|&&i| i as usize >= count) {
                    return Err(MeshError::Index { face, index, count });
                }
            }
            Ok(())
        };
        check(&self.faces, self.vertices.len())?;
        check(&self.face_uvs, self.uvs.len())
    }

    /// Whether every face has texture coordinates.
    pub fn has_uv(&self) -> bool {
        !self.face_uvs.is_empty()
    }

    /// The three corners of a face.
    #[inline]
    pub fn corners(&self, face: usize) -> [Vec3; 3] {
        self.faces[face].map(|i| self.vertices[i as usize])
    }

    /// Unit normal of a face; zero for a face without area.
    pub fn face_normal(&self, face: usize) -> Vec3 {
        let [a, b, c] = self.corners(face);
        (b - a).cross(&(c - a)).try_normalize(NO_AREA).unwrap_or_default()
    }

    /// Unit normals of the vertices, weighted by face area; zero for a vertex without area.
    pub fn vertex_normals(&self) -> Vec<Vec3> {
        let mut normals = vec![Vec3::zeros(); self.vertices.len()];
        for face in &self.faces {
            let [a, b, c] = face.map(|i| self.vertices[i as usize]);
            let n = (b - a).cross(&(c - a));
            for &i in face {
                normals[i as usize] += n;
            }
        }
        normals.iter().map(|n| n.try_normalize(NO_AREA).unwrap_or_default()).collect()
    }

    /// Smallest and largest coordinates; `None` without vertices.
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        let first = *self.vertices.first()?;
        Some(self.vertices.iter().fold((first, first), |(lo, hi), p| (lo.inf(p), hi.sup(p))))
    }

    /// Whether every vertex has a standard deviation and a measured flag.
    pub fn has_uncertainty(&self) -> bool {
        let count = self.vertices.len();
        count > 0 && self.sigmas.len() == count && self.measured.len() == count
    }

    /// The same mesh with other vertex positions; their uncertainty is unknown.
    pub fn with_vertices(&self, vertices: Vec<Vec3>) -> Self {
        Self {
            vertices,
            faces: self.faces.clone(),
            uvs: self.uvs.clone(),
            face_uvs: self.face_uvs.clone(),
            colors: self.colors.clone(),
            ..Self::default()
        }
    }

    /// The mesh in another frame.
    pub fn transformed(&self, target_from_source: &Similarity) -> Self {
        let vertices = self.vertices.iter().map(|v| target_from_source.apply(v)).collect();
        Self {
            sigmas: self.sigmas.iter().map(|s| s * target_from_source.scale).collect(),
            measured: self.measured.clone(),
            ..self.with_vertices(vertices)
        }
    }
}
