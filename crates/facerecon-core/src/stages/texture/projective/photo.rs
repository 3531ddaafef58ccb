//! A photo and what of the head it sees.

use super::super::{TextureError, TextureInput, TexturePhoto};
use super::motion::HeadMotion;
use super::subject::Subject;
use crate::camera::{Pinhole, Projection, resect};
use crate::data::{Mesh, Raster, Rgb, Topology};
use crate::math::{Mat3, Vec2, Vec3};
use crate::observer::{Event, Observer};
use crate::render::{NO_FACE, linear_from_srgb, rasterize};

/// A camera and how the mesh stands before it: `camera = matrix * mesh + shift`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sight {
    pub camera: Pinhole,
    pub matrix: Mat3,
    pub shift: Vec3,
}

impl Sight {
    /// The point in the camera's frame.
    #[inline]
    pub fn place(&self, point: &Vec3) -> Vec3 {
        self.matrix * point + self.shift
    }

    /// The camera's centre in the mesh's frame.
    fn centre(&self) -> Vec3 {
        self.matrix.try_inverse().map_or(Vec3::repeat(f64::NAN), |m| -(m * self.shift))
    }

    /// Whether the camera is one matrix found from dots, pixels included.
    fn is_general(&self) -> bool {
        self.camera.fx == 1.0
    }

    /// The camera of the photo at half the size. Pixel centres are at integers: pixel `u` becomes
    /// `(u + 0.5) / 2 - 0.5`.
    pub fn halved(&self) -> Self {
        if self.is_general() {
            let half = Mat3::new(0.5, 0.0, -0.25, 0.0, 0.5, -0.25, 0.0, 0.0, 1.0);
            return Self { matrix: half * self.matrix, shift: half * self.shift, ..*self };
        }
        let c = self.camera;
        let camera = Pinhole {
            fx: c.fx / 2.0,
            fy: c.fy / 2.0,
            cx: c.cx / 2.0 - 0.25,
            cy: c.cy / 2.0 - 0.25,
            ..c
        };
        Self { camera, ..*self }
    }

    /// The head has moved since the mesh was measured.
    pub fn follow(&mut self, motion: &HeadMotion) {
        let m = motion.moved_from_mesh;
        self.shift += self.matrix * m.translation;
        self.matrix *= m.rotation;
    }
}

/// The photos that can be laid on the head: the pair, and further ones with a camera.
pub(super) fn usable<'a>(input: &TextureInput<'a>, obs: &dyn Observer) -> Vec<TexturePhoto<'a>> {
    let fits = |&(i, p): &(usize, &TexturePhoto<'_>)| i < 2 || p.camera.is_some();
    let kept: Vec<_> = input.photos.iter().enumerate().filter(fits).map(|(_, p)| *p).collect();
    if kept.len() < input.photos.len() {
        let message =
            "further photos are left out: without a calibrated pair their cameras do not help";
        obs.event(&Event::Warning { stage: "texture", message });
    }
    kept
}

/// The cameras of the photos: given, or resected from the dots.
pub(super) fn views(input: &TextureInput<'_>) -> Result<Vec<Sight>, TextureError> {
    let one = |(photo, given): (usize, &TexturePhoto<'_>)| {
        if let Some((camera, pose)) = given.camera {
            let (matrix, shift) = (pose.rotation * pose.scale, pose.translation);
            return Ok(Sight { camera, matrix, shift });
        }
        let points: Vec<Vec3> = given.dots.iter().map(|d| d.point).collect();
        let pixels: Vec<Vec2> = given.dots.iter().map(|d| d.pixel).collect();
        let limit = 1.5;
        match resect(&points, &pixels) {
            Some((Projection { matrix, shift }, rms)) if rms <= limit => {
                Ok(Sight { camera: Pinhole::ideal(1.0, Vec2::zeros()), matrix, shift })
            }
            found => Err(TextureError::NoCamera {
                photo,
                dots: points.len(),
                rms: found.map_or(f64::INFINITY, |f| f.1),
                limit,
            }),
        }
    };
    input.photos.iter().enumerate().map(one).collect()
}

/// What one camera sees of a mesh: depth and the distance to the nearest edge in it.
pub(super) struct Visibility {
    /// Depth of the seen surface; infinite where there is none.
    pub depth: Raster<f32>,
    /// Distance to the nearest depth edge or end of the photo, pixels, counted up to 15; less by
    /// the outline's own margin near the outline of the head.
    pub edge_px: Raster<f32>,
    /// Face and weights at each pixel.
    pub face: Raster<u32>,
    pub barycentric: Raster<[f32; 3]>,
}

impl Visibility {
    pub fn new(
        mesh: &Mesh,
        view: &Sight,
        size: (usize, usize),
        edge_px: f64,
    ) -> Result<Self, TextureError> {
        let placed = mesh.with_vertices(mesh.vertices.iter().map(|v| view.place(v)).collect());
        let drawn = rasterize(&placed, &view.camera, &crate::math::Similarity::identity(), size)
            .map_err(|e| TextureError::Draw(e.to_string()))?;
        let open = open_faces(mesh);
        let is_open = drawn.face.map(|f| f != NO_FACE && open[f as usize]);
        let outline_px = (OUTLINE - 1.0) * edge_px as f32;
        let edge_px = edge_distance(&drawn.depth_mm, &is_open, view, outline_px);
        Ok(Self {
            depth: drawn.depth_mm,
            edge_px,
            face: drawn.face,
            barycentric: drawn.barycentric,
        })
    }

    /// How far a point of the camera frame at a pixel lies behind the seen surface (negative:
    /// before it), and the distance to the nearest depth edge; `None` where nothing is seen.
    #[inline]
    pub fn behind(&self, pixel: Vec2, depth: f64) -> Option<(f64, f64)> {
        let (w, h) = self.depth.size();
        if !(pixel.x >= 0.0 && pixel.y >= 0.0) {
            return None;
        }
        let (x, y) = (pixel.x as usize, pixel.y as usize);
        if x + 1 >= w || y + 1 >= h {
            return None;
        }
        let (fx, fy) = ((pixel.x - x as f64) as f32, (pixel.y - y as f64) as f32);
        let mix = |r: &Raster<f32>| {
            let top = r.at(x, y) * (1.0 - fx) + r.at(x + 1, y) * fx;
            let bottom = r.at(x, y + 1) * (1.0 - fx) + r.at(x + 1, y + 1) * fx;
            f64::from(top * (1.0 - fy) + bottom * fy)
        };
        let seen = mix(&self.depth);
        seen.is_finite().then(|| (depth - seen, mix(&self.edge_px)))
    }
}

/// The outline of the head keeps this many times the distance of other edges.
const OUTLINE: f32 = 3.0;
/// Edges count up to this distance, pixels.
const EDGE_REACH: f32 = 15.0;

/// For each face whether it lies at an open edge: there the mesh ends, not the subject.
fn open_faces(mesh: &Mesh) -> Vec<bool> {
    let border = Topology::new(mesh).border;
    mesh.faces.iter().map(|face| face.iter().any(|&v| border[v as usize])).collect()
}

/// Chamfer distance to pixels beside a jump in depth, or beside the outline but where `open`. A jump is a slope that no surface seen at a
/// usable angle has: 8 pixels' width in depth from one pixel to the next.
fn edge_distance(
    depth: &Raster<f32>,
    open: &Raster<bool>,
    view: &Sight,
    outline_px: f32,
) -> Raster<f32> {
    let camera = &view.camera;
    let (w, h) = depth.size();
    // width of a pixel at unit depth, in the mesh's unit
    let stretch = view.matrix.determinant().abs().cbrt();
    let pixel = (stretch / (camera.fx * camera.fy).sqrt().max(1e-12)) as f32;
    // a resected projection: pixels from its own scale
    let width =
        |z: f32| if view.is_general() { z / view.matrix.row(0).norm() as f32 } else { z * pixel };
    let mut distance = Raster::filled(w, h, EDGE_REACH);
    for y in 0..h {
        for x in 0..w {
            let z = depth.at(x, y);
            let background = !z.is_finite();
            let mut edge = x == 0 || y == 0 || x + 1 == w || y + 1 == h;
            for (dx, dy) in [(1isize, 0isize), (-1, 0), (0, 1), (0, -1)] {
                if let Some(other) = depth.get(x as isize + dx, y as isize + dy) {
                    let ends = !other.is_finite() && open.at(x, y);
                    edge |= !ends && !((other - z).abs() < 8.0 * width(z));
                }
            }
            if background {
                // beside the outline; what lies farther out does not matter
                let around = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy)));
                let outlines = |(dx, dy): (isize, isize)| {
                    let (i, j) = (x as isize + dx, y as isize + dy);
                    depth.get(i, j).is_some_and(f32::is_finite) && open.get(i, j) == Some(false)
                };
                if around.into_iter().any(outlines) {
                    distance.set(x, y, -outline_px);
                }
            } else if edge {
                distance.set(x, y, 0.0);
            }
        }
    }
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

/// A photo ready to be laid on the head.
pub(super) struct Photo<'a> {
    pub view: Sight,
    pub centre: Vec3,
    pub sight: Visibility,
    pub image: &'a Rgb,
    /// Where it shows the subject; `None` where that is not known.
    pub subject: Option<Subject>,
    /// Linear light of each channel's values.
    pub tones: [[f32; 256]; 3],
}

impl<'a> Photo<'a> {
    /// `measured`: points known to lie on the subject.
    pub fn new(
        mesh: &Mesh,
        view: &Sight,
        image: &'a Rgb,
        edge_px: f64,
        measured: &[Vec3],
    ) -> Result<Self, TextureError> {
        let sight = Visibility::new(mesh, view, image.size(), edge_px)?;
        let tone = std::array::from_fn(|v| linear_from_srgb(v as u8) as f32);
        let (view, centre) = (*view, view.centre());
        let mut photo = Self { view, centre, sight, image, subject: None, tones: [tone; 3] };
        photo.subject = Subject::new(&photo, measured);
        Ok(photo)
    }

    /// The photo with each channel's values replaced by those of a table.
    pub fn looked_up(&self, table: &[[f32; 256]; 3]) -> Raster<[f32; 3]> {
        let (w, h) = self.image.size();
        Raster::par_from_fn(w, h, |x, y| {
            let p = self.image.at(x, y);
            std::array::from_fn(|c| table[c][p[c] as usize])
        })
    }

    /// 1 where no channel of the pixel next to a place is saturated, down to 0.
    pub fn unsaturated(&self, pixel: Vec2) -> f32 {
        let nearest = self.image.get(pixel.x.round() as isize, pixel.y.round() as isize);
        nearest.map_or(0.0, |p| {
            let top = p.into_iter().max().unwrap_or(0);
            ((254.0 - f32::from(top)) / 10.0).clamp(0.02, 1.0)
        })
    }

    /// How surely a place shows the subject, 0 to 1.
    pub fn shows_subject(&self, pixel: Vec2) -> f32 {
        self.subject.as_ref().map_or(1.0, |s| s.at(pixel))
    }

    /// Pixel of a point of the mesh frame and its depth.
    #[inline]
    pub fn project(&self, point: &Vec3) -> Option<(Vec2, f64)> {
        let placed = self.view.place(point);
        Some((self.view.camera.project(&placed)?, placed.z))
    }

    /// Whether a pixel shows the head.
    pub fn shows_head(&self, x: usize, y: usize) -> bool {
        self.sight.face.at(x, y) != NO_FACE
    }
}

/// Bilinear sample of three channels; the border goes on outside.
#[inline]
pub(super) fn bilinear(image: &Raster<[f32; 3]>, pixel: Vec2) -> [f32; 3] {
    let (w, h) = image.size();
    let x = pixel.x.clamp(0.0, (w - 1) as f64);
    let y = pixel.y.clamp(0.0, (h - 1) as f64);
    let (x0, y0) = (x as usize, y as usize);
    let (x1, y1) = ((x0 + 1).min(w - 1), (y0 + 1).min(h - 1));
    let (fx, fy) = ((x - x0 as f64) as f32, (y - y0 as f64) as f32);
    let (a, b) = (image.at(x0, y0), image.at(x1, y0));
    let (c, d) = (image.at(x0, y1), image.at(x1, y1));
    std::array::from_fn(|i| {
        let top = a[i] + (b[i] - a[i]) * fx;
        let bottom = c[i] + (d[i] - c[i]) * fx;
        top + (bottom - top) * fy
    })
}

/// Bicubic sample (Catmull and Rom 1974): sharper than bilinear; near the border bilinear.
#[inline]
pub(super) fn bicubic(image: &Raster<[f32; 3]>, pixel: Vec2) -> [f32; 3] {
    let (w, h) = image.size();
    let inside =
        pixel.x >= 1.0 && pixel.y >= 1.0 && pixel.x < w as f64 - 2.0 && pixel.y < h as f64 - 2.0;
    if !inside {
        return bilinear(image, pixel);
    }
    let (x, y) = (pixel.x as usize, pixel.y as usize);
    let cubic = |t: f32| {
        let (t2, t3) = (t * t, t * t * t);
        [
            0.5 * (-t + 2.0 * t2 - t3),
            0.5 * (2.0 - 5.0 * t2 + 3.0 * t3),
            0.5 * (t + 4.0 * t2 - 3.0 * t3),
            0.5 * (t3 - t2),
        ]
    };
    let (wx, wy) = (cubic((pixel.x - x as f64) as f32), cubic((pixel.y - y as f64) as f32));
    let mut sum = [0.0f32; 3];
    for (j, wy) in wy.into_iter().enumerate() {
        let row = &image.row(y + j - 1)[x - 1..x + 3];
        for (pixel, wx) in row.iter().zip(wx) {
            for i in 0..3 {
                sum[i] += wy * wx * pixel[i];
            }
        }
    }
    sum
}
