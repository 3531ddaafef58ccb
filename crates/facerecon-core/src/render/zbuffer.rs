//! The rasteriser: the visible face at each pixel, the point on it, and its depth.

use rayon::prelude::*;

use super::error::{LARGEST_SIDE, RenderError};
use crate::camera::Pinhole;
use crate::data::{Mesh, Raster};
use crate::math::{Similarity, Vec2, Vec3, interpolate};

/// Face index of a pixel where nothing is visible.
pub const NO_FACE: u32 = u32::MAX;

/// Rows that one task draws; fixed, so that the work is divided the same way for any number of
/// threads.
const BAND: usize = 32;
/// Tolerance of the inside test in barycentric units: neighbours leave no gap along their edge.
const SLACK: f64 = 1e-9;
/// The near plane as a fraction of the farthest vertex' depth.
const NEAR: f64 = 1e-4;

/// What a camera sees of a mesh, one value per pixel centre.
#[derive(Clone, Debug, PartialEq)]
pub struct Buffers {
    /// Depth along the camera's z axis, in the unit of the mesh (mm); infinite where nothing is
    /// visible.
    pub depth_mm: Raster<f32>,
    /// Index of the face, or [`NO_FACE`].
    pub face: Raster<u32>,
    /// Perspective-correct barycentric weights of the face's corners.
    pub barycentric: Raster<[f32; 3]>,
}

/// A face on the screen, clipped at the near plane where necessary.
struct Screen {
    face: u32,
    corner: [Vec2; 3],
    inverse_depth: [f64; 3],
    /// Weights of the face's own corners at the three corners of a clipped triangle.
    weights: Option<Box<[[f64; 3]; 3]>>,
    rows: (usize, usize),
}

/// The camera of an image with `factor` times as many pixels along each side.
pub fn supersampled(camera: &Pinhole, factor: usize) -> Pinhole {
    let s = factor as f64;
    Pinhole {
        fx: camera.fx * s,
        fy: camera.fy * s,
        // pixel centres are at integers, so the image corner is at -0.5
        cx: (camera.cx + 0.5) * s - 0.5,
        cy: (camera.cy + 0.5) * s - 0.5,
        distortion: camera.distortion,
    }
}

/// Draws a mesh into depth, face and barycentric buffers of `size` = (width, height) pixels.
/// Both sides of a face are drawn; of equal depths the lower face index wins. Lens distortion
/// moves the corners, edges between them stay straight.
///
/// # Errors
/// [`RenderError`] for an invalid mesh, size or camera.
///
/// # Example
/// ```
/// use facerecon_core::camera::Pinhole;
/// use facerecon_core::data::Mesh;
/// use facerecon_core::math::{Similarity, Vec2, Vec3};
/// use facerecon_core::render::{NO_FACE, rasterize};
///
/// let vertices = [(-9.0, -9.0), (9.0, -9.0), (0.0, 9.0)].map(|(x, y)| Vec3::new(x, y, 500.0));
/// let mesh = Mesh { vertices: vertices.to_vec(), faces: vec![[0, 1, 2]], ..Mesh::default() };
/// let camera = Pinhole::ideal(400.0, Vec2::new(15.5, 11.5));
/// let buffers = rasterize(&mesh, &camera, &Similarity::identity(), (32, 24))?;
/// assert_eq!((buffers.face.at(16, 12), buffers.depth_mm.at(16, 12)), (0, 500.0));
/// assert_eq!(buffers.face.at(0, 0), NO_FACE);
/// # Ok::<(), facerecon_core::render::RenderError>(())
/// ```
pub fn rasterize(
    mesh: &Mesh,
    camera: &Pinhole,
    camera_from_mesh: &Similarity,
    size: (usize, usize),
) -> Result<Buffers, RenderError> {
    mesh.validate()?;
    let (width, height) = size;
    if width == 0 || height == 0 || width > LARGEST_SIDE || height > LARGEST_SIDE {
        return Err(RenderError::Size { width, height });
    }
    if !camera.is_plausible() {
        return Err(RenderError::Camera);
    }
    let vertices: Vec<Vec3> = mesh.vertices.par_iter().map(|v| camera_from_mesh.apply(v)).collect();
    let screen = Projected::new(mesh, &vertices, camera, size);
    let mut bins = vec![Vec::new(); height.div_ceil(BAND)];
    let rows: Vec<_> = (0..mesh.faces.len()).into_par_iter().map(|f| screen.rows(f)).collect();
    for (face, rows) in rows.into_iter().enumerate() {
        if let Some((first, last)) = rows {
            bins[first / BAND..=last / BAND].iter_mut().for_each(|bin| bin.push(face));
        }
    }

    let mut depth = Raster::filled(width, height, f32::INFINITY);
    let mut face = Raster::filled(width, height, NO_FACE);
    let mut barycentric = Raster::filled(width, height, [0.0f32; 3]);
    depth
        .data_mut()
        .par_chunks_mut(width * BAND)
        .zip(face.data_mut().par_chunks_mut(width * BAND))
        .zip(barycentric.data_mut().par_chunks_mut(width * BAND))
        .zip(bins.par_iter())
        .enumerate()
        .for_each(|(band, (((depth, face), barycentric), bin))| {
            for &number in bin {
                screen.triangles(number, |triangle| {
                    draw(triangle, band * BAND, width, depth, face, barycentric);
                });
            }
        });
    Ok(Buffers { depth_mm: depth, face, barycentric })
}

/// A mesh in front of the camera.
struct Projected<'a> {
    mesh: &'a Mesh,
    /// Vertices, camera frame.
    vertices: &'a [Vec3],
    /// Their pixels; `None` behind the near plane and where the lens model fails.
    pixels: Vec<Option<Vec2>>,
    camera: &'a Pinhole,
    near: f64,
    size: (usize, usize),
}

impl<'a> Projected<'a> {
    fn new(
        mesh: &'a Mesh,
        vertices: &'a [Vec3],
        camera: &'a Pinhole,
        size: (usize, usize),
    ) -> Self {
        let farthest = vertices.iter().map(|v| v.z).fold(0.0, f64::max);
        let near = (farthest * NEAR).max(1e-9);
        let project = |v: &Vec3| if v.z < near { None } else { pixel(camera, v) };
        let pixels = vertices.par_iter().map(project).collect();
        Self { mesh, vertices, pixels, camera, near, size }
    }

    /// Pixels of a face's corners; `None` where the near plane clips it, or a corner has none.
    #[inline]
    fn unclipped(&self, face: usize) -> Option<[Vec2; 3]> {
        let [a, b, c] = self.mesh.faces[face].map(|i| self.pixels[i as usize]);
        Some([a?, b?, c?])
    }

    /// First and last row that a face may cover; `None` when it covers none.
    fn rows(&self, face: usize) -> Option<(usize, usize)> {
        if let Some(corner) = self.unclipped(face) {
            return rows(&corner, self.size);
        }
        let mut all: Option<(usize, usize)> = None;
        self.triangles(face, |t| {
            let (first, last) = all.unwrap_or(t.rows);
            all = Some((first.min(t.rows.0), last.max(t.rows.1)));
        });
        all
    }

    /// Calls `take` for each triangle on the screen that a face becomes: one; when the near plane
    /// clips it, up to two; or none.
    #[inline]
    fn triangles(&self, face: usize, mut take: impl FnMut(&Screen)) {
        let points = self.mesh.faces[face].map(|i| self.vertices[i as usize]);
        if let Some(corner) = self.unclipped(face) {
            let inverse_depth = points.map(|p| 1.0 / p.z);
            let triangle = on_screen(face as u32, corner, inverse_depth, None, self.size);
            return triangle.iter().for_each(take);
        }
        if let 1 | 2 = points.iter().filter(|p| p.z < self.near).count() {
            let parts = clipped(face as u32, &points, self.near, self.camera, self.size);
            parts.iter().for_each(&mut take);
        }
    }
}

/// Pixel of a point in front of the camera; `None` where the lens model is not monotone and would
/// project points far outside into the image.
fn pixel(camera: &Pinhole, point: &Vec3) -> Option<Vec2> {
    let pixel = camera.project(point)?;
    if !camera.distortion.is_none() {
        let back = camera.ray(pixel);
        let n = Vec2::new(point.x / point.z, point.y / point.z);
        if !((back.xy() - n).norm() < 1e-6 * (1.0 + n.norm())) {
            return None;
        }
    }
    Some(pixel)
}

/// Clips a face at the near plane (Sutherland and Hodgman 1974) into one or two triangles.
fn clipped(
    face: u32,
    points: &[Vec3; 3],
    near: f64,
    camera: &Pinhole,
    size: (usize, usize),
) -> Vec<Screen> {
    let mut polygon: Vec<[f64; 3]> = Vec::with_capacity(4);
    for i in 0..3 {
        let j = (i + 1) % 3;
        let (a, b) = (points[i].z, points[j].z);
        let mut corner = [0.0; 3];
        if a >= near {
            corner[i] = 1.0;
            polygon.push(corner);
        }
        if (a >= near) != (b >= near) {
            let t = (near - a) / (b - a);
            let mut cut = [0.0; 3];
            cut[i] = 1.0 - t;
            cut[j] = t;
            polygon.push(cut);
        }
    }
    let at = |w: &[f64; 3]| interpolate(*points, *w);
    (2..polygon.len())
        .filter_map(|k| {
            let weights = [polygon[0], polygon[k - 1], polygon[k]];
            let [p, q, r] = weights.map(|w| at(&w));
            let corners = [pixel(camera, &p)?, pixel(camera, &q)?, pixel(camera, &r)?];
            let inverse = [1.0 / p.z, 1.0 / q.z, 1.0 / r.z];
            on_screen(face, corners, inverse, Some(Box::new(weights)), size)
        })
        .collect()
}

/// A triangle on the screen, or `None` when it has no area or covers no pixel.
fn on_screen(
    face: u32,
    corner: [Vec2; 3],
    inverse_depth: [f64; 3],
    weights: Option<Box<[[f64; 3]; 3]>>,
    size: (usize, usize),
) -> Option<Screen> {
    let rows = rows(&corner, size)?;
    let area = double_area(&corner);
    if !area.is_finite() || area.abs() < 1e-12 {
        return None;
    }
    Some(Screen { face, corner, inverse_depth, weights, rows })
}

/// First and last row of pixel centres in the bounding box of a triangle, or `None` where there are
/// none: small faces often lie between pixels.
#[inline]
fn rows([a, b, c]: &[Vec2; 3], (width, height): (usize, usize)) -> Option<(usize, usize)> {
    let (low, high) = (a.inf(b).inf(c), a.sup(b).sup(c));
    let inside = high.x >= 0.0
        && high.y >= 0.0
        && low.x <= (width - 1) as f64
        && low.y <= (height - 1) as f64;
    if !inside {
        return None;
    }
    let (first, last) = (round_up(low.y), high.y.min((height - 1) as f64) as usize);
    // with more tolerance than the inside test has
    let column = round_up(low.x - 1e-6) as f64 <= high.x + 1e-6;
    (first <= last && column).then_some((first, last))
}

/// The first integer not below a value, at least 0. (`ceil` is a library call on common
/// processors.)
#[inline]
fn round_up(value: f64) -> usize {
    let below = value as usize;
    below + usize::from((below as f64) < value)
}

fn double_area([a, b, c]: &[Vec2; 3]) -> f64 {
    (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)
}

/// Draws the part of a triangle in the band that starts at row `top`.
fn draw(
    t: &Screen,
    top: usize,
    width: usize,
    depth: &mut [f32],
    face: &mut [u32],
    barycentric: &mut [[f32; 3]],
) {
    let [a, b, c] = t.corner;
    let share = 1.0 / double_area(&t.corner);
    // the three weights are linear in the offset from a
    let step = [(b.y - c.y) * share, (c.y - a.y) * share, (a.y - b.y) * share];
    let per_step = step.map(|s| 1.0 / s);
    let bottom = top + depth.len() / width;
    for y in t.rows.0.max(top)..=t.rows.1.min(bottom - 1) {
        let dy = y as f64 - a.y;
        let w1 = -dy * (c.x - a.x) * share;
        let w2 = dy * (b.x - a.x) * share;
        let start = [1.0 - w1 - w2, w1, w2];
        let Some((first, last)) = span(&start, &step, &per_step, a.x, width) else { continue };
        let row = (y - top) * width;
        for x in first..=last {
            let dx = x as f64 - a.x;
            let w = [start[0] + step[0] * dx, start[1] + step[1] * dx, start[2] + step[2] * dx];
            // 1/z is linear on the screen, and so is weight/z
            let scaled = [
                w[0].max(0.0) * t.inverse_depth[0],
                w[1].max(0.0) * t.inverse_depth[1],
                w[2].max(0.0) * t.inverse_depth[2],
            ];
            let inverse = scaled[0] + scaled[1] + scaled[2];
            let z = (1.0 / inverse) as f32;
            if z < depth[row + x] {
                depth[row + x] = z;
                face[row + x] = t.face;
                let own = scaled.map(|s| s / inverse);
                let weights = match &t.weights {
                    None => own,
                    Some(cut) => [0, 1, 2].map(|i| (0..3).map(|k| own[k] * cut[k][i]).sum()),
                };
                barycentric[row + x] = weights.map(|v: f64| v as f32);
            }
        }
    }
}

/// First and last pixel of a row whose three weights are all at least zero.
#[inline]
fn span(
    start: &[f64; 3],
    step: &[f64; 3],
    per_step: &[f64; 3],
    origin: f64,
    width: usize,
) -> Option<(usize, usize)> {
    let (mut low, mut high) = (0.0f64, (width - 1) as f64);
    for i in 0..3 {
        let bound = origin + (-SLACK - start[i]) * per_step[i];
        if step[i] > 0.0 {
            low = low.max(bound);
        } else if step[i] < 0.0 {
            high = high.min(bound);
        } else if start[i] < -SLACK {
            return None;
        }
    }
    // from here on `high` is at least 0, so that the cast rounds down
    (low <= high).then(|| (round_up(low), high as usize)).filter(|(first, last)| first <= last)
}
