//! A camera of the virtual rig, its position, and what it sees.

use crate::camera::Pinhole;
use crate::data::Mesh;
use crate::math::{Similarity, Vec2, Vec3};
use crate::render::{Buffers, NO_FACE, RenderError, rasterize};

/// A point is visible if the surface drawn at its pixel is at most this far from it, along the line of
/// sight, mm. Far above rounding, and below the distance between surfaces that occlude each other.
const VISIBLE_MM: f64 = 0.4;

/// A camera and its pose.
#[derive(Clone, Copy, Debug)]
pub(super) struct Viewpoint {
    pub(super) camera: Pinhole,
    pub(super) camera_from_left: Similarity,
}

impl Viewpoint {
    /// Depth buffer of a mesh (left camera frame) in a photo of `size` pixels.
    pub(super) fn rasterize(
        &self,
        mesh: &Mesh,
        size: (usize, usize),
    ) -> Result<Buffers, RenderError> {
        rasterize(mesh, &self.camera, &self.camera_from_left, size)
    }

    /// Pixel of a point (left camera frame) of the mesh that the buffers were drawn from, and whether
    /// it is visible; NaN for a point behind the camera.
    pub(super) fn observe(&self, buffers: &Buffers, mesh: &Mesh, point: &Vec3) -> (Vec2, bool) {
        let here = self.camera_from_left.apply(point);
        match self.camera.project(&here) {
            Some(pixel) => (pixel, self.is_visible(buffers, mesh, pixel, &here)),
            None => (Vec2::repeat(f64::NAN), false),
        }
    }

    /// Whether the plane of one of the four faces drawn around a pixel passes through a point (frame of
    /// this camera).
    fn is_visible(&self, buffers: &Buffers, mesh: &Mesh, pixel: Vec2, point: &Vec3) -> bool {
        let (width, height) = buffers.face.size();
        let inside = pixel.x >= -0.5
            && pixel.y >= -0.5
            && pixel.x <= width as f64 - 0.5
            && pixel.y <= height as f64 - 0.5;
        if !inside {
            return false;
        }
        let (x0, y0) = (pixel.x.floor() as isize, pixel.y.floor() as isize);
        [(0, 0), (1, 0), (0, 1), (1, 1)].iter().any(|(dx, dy)| {
            let face = buffers.face.get(x0 + dx, y0 + dy).unwrap_or(NO_FACE);
            if face == NO_FACE {
                return false;
            }
            let [a, b, c] = mesh.corners(face as usize).map(|v| self.camera_from_left.apply(&v));
            let normal = (b - a).cross(&(c - a));
            let along = normal.dot(point);
            // The line of sight meets the plane at `point * normal.dot(&a) / along`.
            along.abs() > 1e-12 * normal.norm() * point.norm()
                && ((normal.dot(&a) / along - 1.0) * point.z).abs() < VISIBLE_MM
        })
    }
}
