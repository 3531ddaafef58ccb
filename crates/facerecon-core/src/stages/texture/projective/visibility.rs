//! The part of the mesh that a camera sees, and its depth discontinuities.

use super::super::error::TextureError;
use super::posed_camera::PosedCamera;
use crate::data::{Mesh, Raster, Topology};
use crate::math::{Similarity, Vec2};
use crate::render::{NO_FACE, rasterize};

/// Pixels keep this many times the distance of other discontinuities from the silhouette: the
/// background behind it has another colour, the surface behind an inner one is skin as well.
const SILHOUETTE: f32 = 3.0;
/// Distances to discontinuities are counted up to this, pixels: the largest margin
/// (`SILHOUETTE` times the greatest `edge_px`).
const MAX_DISTANCE_PX: f32 = 15.0;
/// A discontinuity is a step in depth of more than this many pixel widths from one pixel to the
/// next: a surface tilted by 83 degrees, beyond every usable angle.
const DISCONTINUITY: f32 = 8.0;

/// What a camera sees of a mesh, pixel by pixel.
pub(super) struct Visibility {
    /// Depth of the visible surface; infinite where there is none.
    pub depth: Raster<f32>,
    /// Distance to the nearest depth discontinuity or border of the photo, pixels, counted up to
    /// [`MAX_DISTANCE_PX`]; reduced by the additional margin near the silhouette.
    pub edge_px: Raster<f32>,
    /// Face, or [`NO_FACE`].
    pub face: Raster<u32>,
    /// Barycentric weights on it.
    pub barycentric: Raster<[f32; 3]>,
}

impl Visibility {
    /// Draws the mesh into a photo of `size` = (width, height) pixels.
    pub fn new(
        mesh: &Mesh,
        camera: &PosedCamera,
        size: (usize, usize),
        edge_px: f64,
    ) -> Result<Self, TextureError> {
        let vertices = mesh.vertices.iter().map(|v| camera.camera_point(v)).collect();
        let placed = mesh.with_vertices(vertices);
        let drawn = rasterize(&placed, &camera.pinhole, &Similarity::identity(), size)?;
        let border = border_faces(mesh);
        let on_border = drawn.face.map(|f| f != NO_FACE && border[f as usize]);
        let silhouette_px = (SILHOUETTE - 1.0) * edge_px as f32;
        let edges = edges(&drawn.depth_mm, &on_border, camera, silhouette_px);
        Ok(Self {
            depth: drawn.depth_mm,
            edge_px: chamfer_distance(edges),
            face: drawn.face,
            barycentric: drawn.barycentric,
        })
    }

    /// How far a point at a pixel and depth (camera frame) lies behind the visible surface
    /// (negative: before it), and the distance to the nearest depth discontinuity, pixels; `None`
    /// where nothing is visible.
    #[inline]
    pub fn behind(&self, pixel: Vec2, depth: f64) -> Option<(f64, f64)> {
        let (w, h) = self.depth.size();
        if !(pixel.x >= 0.0 && pixel.y >= 0.0) {
            return None;
        }
        if pixel.x as usize + 1 >= w || pixel.y as usize + 1 >= h {
            return None;
        }
        let at = |r: &Raster<f32>| r.bilinear(pixel.x, pixel.y).map(f64::from);
        let visible = at(&self.depth)?;
        Some((depth - visible, at(&self.edge_px)?)).filter(|_| visible.is_finite())
    }

    /// Whether a pixel shows the mesh.
    pub fn shows_mesh(&self, x: usize, y: usize) -> bool {
        self.face.at(x, y) != NO_FACE
    }
}

/// For each face whether it touches the border of the mesh: there the mesh ends, not the subject,
/// so that its outline is no silhouette.
fn border_faces(mesh: &Mesh) -> Vec<bool> {
    let border = Topology::new(mesh).border;
    mesh.faces.iter().map(|face| face.iter().any(|&v| border[v as usize])).collect()
}

/// 0 at pixels beside a depth discontinuity or the photo's border, `-silhouette_px` at background
/// pixels beside the silhouette, [`MAX_DISTANCE_PX`] elsewhere.
fn edges(
    depth: &Raster<f32>,
    on_border: &Raster<bool>,
    camera: &PosedCamera,
    silhouette_px: f32,
) -> Raster<f32> {
    let (w, h) = depth.size();
    let pixel_width = camera.pixel_width();
    let beside_silhouette = |x: usize, y: usize| {
        (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy))).any(|(dx, dy)| {
            let (i, j) = (x as isize + dx, y as isize + dy);
            depth.get(i, j).is_some_and(f32::is_finite) && on_border.get(i, j) == Some(false)
        })
    };
    let beside_discontinuity = |x: usize, y: usize| {
        let z = depth.at(x, y);
        let jump = DISCONTINUITY * pixel_width(z);
        [(1, 0), (-1, 0), (0, 1), (0, -1)].iter().any(|(dx, dy)| {
            depth.get(x as isize + dx, y as isize + dy).is_some_and(|other| {
                let mesh_ends = !other.is_finite() && on_border.at(x, y);
                !mesh_ends && !((other - z).abs() < jump)
            })
        })
    };
    Raster::par_from_fn(w, h, |x, y| {
        if !depth.at(x, y).is_finite() {
            return if beside_silhouette(x, y) { -silhouette_px } else { MAX_DISTANCE_PX };
        }
        let at_border = x == 0 || y == 0 || x + 1 == w || y + 1 == h;
        if at_border || beside_discontinuity(x, y) { 0.0 } else { MAX_DISTANCE_PX }
    })
}

/// Chamfer distance (Borgefors 1986): two passes over the image, each pixel taking the least of its
/// neighbours' distances plus the step to them.
fn chamfer_distance(mut distance: Raster<f32>) -> Raster<f32> {
    let (w, h) = distance.size();
    let diagonal = std::f32::consts::SQRT_2;
    let mut relax = |x: usize, y: usize, steps: [(isize, isize, f32); 4]| {
        let mut best = distance.at(x, y);
        for (dx, dy, d) in steps {
            if let Some(other) = distance.get(x as isize + dx, y as isize + dy) {
                best = best.min(other + d);
            }
        }
        distance.set(x, y, best);
    };
    let forward = [(-1, 0, 1.0), (0, -1, 1.0), (-1, -1, diagonal), (1, -1, diagonal)];
    let backward = forward.map(|(x, y, d)| (-x, -y, d));
    for y in 0..h {
        for x in 0..w {
            relax(x, y, forward);
        }
    }
    for y in (0..h).rev() {
        for x in (0..w).rev() {
            relax(x, y, backward);
        }
    }
    distance
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_grow_from_an_edge_in_all_directions() {
        let seed = Raster::from_fn(21, 21, |x, y| if (x, y) == (10, 10) { 0.0 } else { 15.0 });
        let distance = chamfer_distance(seed);
        assert_eq!((distance.at(14, 10), distance.at(10, 3)), (4.0, 7.0));
        let diagonal = 3.0 * std::f32::consts::SQRT_2;
        assert!((distance.at(7, 13) - diagonal).abs() < 1e-5);
    }
}
