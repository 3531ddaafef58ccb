//! The point of the head that each texel shows.

use super::super::error::TextureError;
use crate::camera::Pinhole;
use crate::data::{Mesh, Raster};
use crate::math::{Similarity, Vec2, Vec3, interpolate};
use crate::render::{NO_FACE, rasterize};

/// The texels of a square texture of `size`.
pub(super) struct Texels<'a> {
    pub size: usize,
    mesh: &'a Mesh,
    normals: Vec<Vec3>,
    face: Raster<u32>,
    barycentric: Raster<[f32; 3]>,
}

impl<'a> Texels<'a> {
    /// Draws the UV layout as a flat mesh; texel centres are at integers, v is up.
    pub fn new(mesh: &'a Mesh, size: usize) -> Result<Self, TextureError> {
        let s = size as f64;
        let to_texel = |uv: &[f64; 2]| Vec3::new(uv[0] * s - 0.5, (1.0 - uv[1]) * s - 0.5, 1.0);
        let layout = Mesh {
            vertices: mesh.uvs.iter().map(to_texel).collect(),
            faces: mesh.face_uvs.clone(),
            ..Mesh::default()
        };
        let flat = Pinhole::ideal(1.0, Vec2::zeros());
        let drawn = rasterize(&layout, &flat, &Similarity::identity(), (size, size))?;
        let normals = mesh.vertex_normals();
        Ok(Self { size, mesh, normals, face: drawn.face, barycentric: drawn.barycentric })
    }

    /// Corners and barycentric weights of a texel; `None` off the mesh.
    #[inline]
    pub fn corners(&self, index: usize) -> Option<([usize; 3], [f64; 3])> {
        let face = self.face.data()[index];
        (face != NO_FACE).then(|| {
            let corners = self.mesh.faces[face as usize].map(|v| v as usize);
            (corners, self.barycentric.data()[index].map(f64::from))
        })
    }

    /// Position and unit normal of a texel, mesh frame; `None` off the mesh.
    pub fn point(&self, index: usize) -> Option<(Vec3, Vec3)> {
        let (corners, weights) = self.corners(index)?;
        let mix = |list: &[Vec3]| interpolate(corners.map(|v| list[v]), weights);
        Some((mix(&self.mesh.vertices), mix(&self.normals).try_normalize(1e-12)?))
    }

    /// Position of a texel, mesh frame; `None` off the mesh.
    #[inline]
    pub fn position(&self, index: usize) -> Option<Vec3> {
        let (corners, weights) = self.corners(index)?;
        Some(interpolate(corners.map(|v| self.mesh.vertices[v]), weights))
    }
}
