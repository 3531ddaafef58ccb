//! Making a picture of a mesh: shaded, textured, as wireframe or as heat map.

use rayon::prelude::*;

use super::heat::draw_legend;
use super::light::{from_rgb, linear_table, sample_texture, studio, to_rgb};
use super::view::Framing;
use super::{
    Buffers, Frame, Heat, LARGEST_SIDE, NO_FACE, RenderError, View, ambient_openness, heat_color,
    rasterize, supersampled,
};
use crate::camera::Pinhole;
use crate::choices;
use crate::data::{Mesh, Raster, Rgb};
use crate::math::{Similarity, Vec2, Vec3};

choices! {
    /// How a mesh is drawn.
    pub enum Mode {
        /// As a plaster cast in studio light.
        Shaded = "shaded",
        /// With its texture (or vertex colours) as it is, without further light.
        Textured = "textured",
        /// With its texture in studio light.
        Lit = "lit",
        /// Its edges on a pale surface; hidden ones are not drawn.
        Wireframe = "wireframe",
        /// Values at the vertices as colours, with a legend.
        Heat = "heat",
    }
}

/// Samples a side of a pixel.
const SAMPLES: usize = 2;
/// Albedo of the plaster cast, linear.
const PLASTER: [f64; 3] = [0.78, 0.70, 0.63];

/// What is drawn.
#[derive(Clone, Copy, Debug)]
pub struct Scene<'a> {
    /// The mesh.
    pub mesh: &'a Mesh,
    /// Its texture.
    pub texture: Option<&'a Rgb>,
    /// Values for the heat map.
    pub heat: Option<Heat<'a>>,
    /// Its axes.
    pub frame: Frame,
}

impl<'a> Scene<'a> {
    /// A bare mesh in the model frame.
    pub fn new(mesh: &'a Mesh) -> Self {
        Self { mesh, texture: None, heat: None, frame: Frame::Model }
    }
}

/// Draws the scene from a named view so that it fills a picture of `size` = (width, height).
///
/// # Errors
/// [`RenderError`] for an invalid mesh or size, or a heat map without values.
pub fn picture(
    scene: &Scene<'_>,
    view: View,
    mode: Mode,
    size: (usize, usize),
) -> Result<Rgb, RenderError> {
    Studio::new(scene, mode)?.picture(view, None, size)
}

/// A scene made ready to be drawn from several views: what lies open to the sky is found once.
#[derive(Debug)]
pub struct Studio<'a> {
    scene: Scene<'a>,
    mode: Mode,
    normals: Vec<Vec3>,
    openness: Vec<f64>,
    /// Value at the end of the heat map's scale.
    limit: f64,
    linear: [f64; 256],
}

impl<'a> Studio<'a> {
    /// Makes a scene ready.
    ///
    /// # Errors
    /// [`RenderError`] for an invalid mesh, or a heat map without values.
    pub fn new(scene: &Scene<'a>, mode: Mode) -> Result<Self, RenderError> {
        let openness = match mode {
            Mode::Textured => Vec::new(),
            _ => ambient_openness(scene.mesh)?,
        };
        Self::with_openness(scene, mode, openness)
    }

    /// Makes a scene ready whose vertices are known to lie open to the sky by so much, 0 to 1;
    /// those beyond the list lie quite open.
    ///
    /// # Errors
    /// [`RenderError`] for an invalid mesh, or a heat map without values.
    pub fn with_openness(
        scene: &Scene<'a>,
        mode: Mode,
        mut openness: Vec<f64>,
    ) -> Result<Self, RenderError> {
        scene.mesh.validate()?;
        let expected = scene.mesh.vertices.len();
        let got = scene.heat.map_or(0, |h| h.values.len());
        if mode == Mode::Heat && got != expected {
            return Err(RenderError::Heat { got, expected });
        }
        openness.resize(expected, 1.0);
        let normals = scene.mesh.vertex_normals();
        let limit = scene.heat.map_or(1.0, |h| h.limit());
        Ok(Self { scene: *scene, mode, normals, openness, limit, linear: linear_table() })
    }

    /// How open each vertex lies to the sky, 0 to 1.
    pub fn openness(&self) -> &[f64] {
        &self.openness
    }

    /// Focal length at which the mesh fills the picture.
    pub(super) fn focal_px(&self, view: View, size: (usize, usize)) -> f64 {
        Framing::new(self.scene.mesh, view, self.scene.frame).focal_px(size)
    }

    /// Draws a named view into a picture of `size` = (width, height); without `focal_px` the mesh
    /// fills it.
    ///
    /// # Errors
    /// [`RenderError::Size`].
    pub fn picture(
        &self,
        view: View,
        focal_px: Option<f64>,
        size: (usize, usize),
    ) -> Result<Rgb, RenderError> {
        let (width, height) = size;
        if width == 0 || height == 0 || width.max(height) > LARGEST_SIDE / SAMPLES {
            return Err(RenderError::Size { width, height });
        }
        let legend = self.mode == Mode::Heat;
        // the legend takes the lower tenth
        let room = if legend { (width, (height * 9 / 10).max(1)) } else { size };
        let framing = Framing::new(self.scene.mesh, view, self.scene.frame);
        let camera = framing.camera(focal_px.unwrap_or_else(|| framing.focal_px(room)), room);
        let mut image = self.draw(&camera, &framing.camera_from_mesh, size)?;
        if let (true, Some(heat)) = (legend, &self.scene.heat) {
            draw_legend(&mut image, self.limit, heat.unit);
        }
        Ok(image)
    }

    fn draw(
        &self,
        camera: &Pinhole,
        camera_from_mesh: &Similarity,
        (width, height): (usize, usize),
    ) -> Result<Rgb, RenderError> {
        let fine = supersampled(camera, SAMPLES);
        let fine_size = (width * SAMPLES, height * SAMPLES);
        let buffers = rasterize(self.scene.mesh, &fine, camera_from_mesh, fine_size)?;
        let normals: Vec<Vec3> = self.normals.iter().map(|n| camera_from_mesh.rotate(n)).collect();
        let corners: Vec<Vec2> = match self.mode {
            Mode::Wireframe => {
                let pixel = |v| fine.project(&camera_from_mesh.apply(v)).unwrap_or_default();
                self.scene.mesh.vertices.iter().map(pixel).collect()
            }
            _ => Vec::new(),
        };
        let line = 0.45 * SAMPLES as f64 * (width as f64 / 700.0).max(1.0);
        let share = 1.0 / (SAMPLES * SAMPLES) as f64;
        let pixels = (0..height)
            .into_par_iter()
            .flat_map_iter(|y| {
                let back = background(y, height);
                let empty = to_rgb(&back);
                let (buffers, normals, corners, fine) = (&buffers, &normals, &corners, &fine);
                (0..width).map(move |x| {
                    let (mut sum, mut hit) = (Vec3::zeros(), false);
                    for sy in y * SAMPLES..(y + 1) * SAMPLES {
                        for sx in x * SAMPLES..(x + 1) * SAMPLES {
                            let sample = Sample::at(buffers, sx, sy);
                            hit |= sample.is_some();
                            sum += sample.map_or(back, |s| {
                                let here = Vec2::new(sx as f64, sy as f64);
                                let light = self.light(&s, normals, &fine.ray(here));
                                let edge = self.edge(&s, corners, here, line);
                                light * (1.0 - edge) + Vec3::new(0.02, 0.05, 0.11) * edge
                            });
                        }
                    }
                    if hit { to_rgb(&(sum * share)) } else { empty }
                })
            })
            .collect();
        Ok(Raster::from_vec(width, height, pixels).unwrap_or_else(|| Rgb::filled(1, 1, [0; 3])))
    }

    /// Light that comes from a point of the surface.
    fn light(&self, sample: &Sample, normals: &[Vec3], ray: &Vec3) -> Vec3 {
        let corners = self.scene.mesh.faces[sample.face].map(|i| i as usize);
        let mix = |value: &dyn Fn(usize) -> f64| {
            (0..3).map(|k| value(corners[k]) * sample.weights[k]).sum::<f64>()
        };
        let albedo = match self.mode {
            Mode::Textured | Mode::Lit => self.color(sample, &corners),
            Mode::Shaded => Vec3::from(PLASTER),
            Mode::Wireframe => Vec3::new(0.86, 0.87, 0.88),
            Mode::Heat => self.scene.heat.map_or(Vec3::zeros(), |heat| {
                let color = heat_color(mix(&|i| heat.values[i]) / self.limit);
                from_rgb(color, &self.linear) * 1.25
            }),
        };
        if self.mode == Mode::Textured {
            return albedo;
        }
        let toward = -ray.normalize();
        let smooth: Vec3 = (0..3).map(|k| normals[corners[k]] * sample.weights[k]).sum();
        let normal = smooth.try_normalize(1e-12).unwrap_or(toward);
        let facing = normal.dot(&toward);
        // the inside of an open mesh is drawn dimmer, with its normal turned
        let (normal, inside) = if facing < -0.1 { (-normal, 0.45) } else { (normal, 1.0) };
        let (matt, gloss) = studio(&normal, &toward, mix(&|i| self.openness[i]).clamp(0.0, 1.0));
        let exposure = if self.mode == Mode::Lit { 1.35 } else { 1.0 };
        (albedo * matt * exposure + Vec3::repeat(gloss)) * inside
    }

    /// The surface's own colour, linear: texture, else vertex colours, else plaster.
    fn color(&self, sample: &Sample, corners: &[usize; 3]) -> Vec3 {
        surface_color(self.scene.mesh, self.scene.texture, sample, corners, &self.linear)
            .unwrap_or_else(|| Vec3::from(PLASTER))
    }

    /// How much of a sample an edge of its face covers, 0 to 1.
    fn edge(&self, sample: &Sample, pixels: &[Vec2], here: Vec2, line: f64) -> f64 {
        if self.mode != Mode::Wireframe {
            return 0.0;
        }
        let [a, b, c] = self.scene.mesh.faces[sample.face].map(|i| pixels[i as usize]);
        let distance = |p: Vec2, q: Vec2| {
            let along = q - p;
            along.perp(&(here - p)).abs() / along.norm().max(1e-12)
        };
        let nearest = distance(a, b).min(distance(b, c)).min(distance(c, a));
        (line + 0.5 - nearest).clamp(0.0, 1.0)
    }
}

/// A point of the surface seen at a sample.
struct Sample {
    face: usize,
    weights: [f64; 3],
}

impl Sample {
    fn at(buffers: &Buffers, x: usize, y: usize) -> Option<Self> {
        let face = buffers.face.at(x, y);
        let weights = buffers.barycentric.at(x, y).map(f64::from);
        (face != NO_FACE).then_some(Self { face: face as usize, weights })
    }
}

fn surface_color(
    mesh: &Mesh,
    texture: Option<&Rgb>,
    sample: &Sample,
    corners: &[usize; 3],
    linear: &[f64; 256],
) -> Option<Vec3> {
    let w = &sample.weights;
    if let (Some(texture), Some(uv)) = (texture, mesh.face_uvs.get(sample.face)) {
        let [a, b, c] = uv.map(|i| mesh.uvs[i as usize]);
        let at = [0, 1].map(|k| a[k] * w[0] + b[k] * w[1] + c[k] * w[2]);
        let mix = |v: f64| {
            // between table entries; the coding is all but straight over one step
            let low = (v as usize).min(254);
            linear[low] + (linear[low + 1] - linear[low]) * (v - low as f64)
        };
        return Some(Vec3::from(sample_texture(texture, at).map(mix)));
    }
    if mesh.colors.is_empty() {
        return None;
    }
    Some((0..3).map(|k| from_rgb(mesh.colors[corners[k]], linear) * w[k]).sum())
}

/// A soft grey sweep, linear.
fn background(y: usize, height: usize) -> Vec3 {
    let t = y as f64 / height.max(2) as f64;
    Vec3::new(0.80, 0.81, 0.82) * (1.0 - 0.30 * t * t)
}

/// The textured mesh as a given camera would photograph it, unlit; the second raster is the share
/// of each pixel that shows the mesh (0 to 1). Used to compare a texture with a photo.
///
/// # Errors
/// [`RenderError`] for an invalid mesh, size or camera.
pub fn photograph(
    mesh: &Mesh,
    texture: Option<&Rgb>,
    camera: &Pinhole,
    camera_from_mesh: &Similarity,
    (width, height): (usize, usize),
) -> Result<(Rgb, Raster<f32>), RenderError> {
    if width == 0 || height == 0 || width.max(height) > LARGEST_SIDE / SAMPLES {
        return Err(RenderError::Size { width, height });
    }
    let fine = supersampled(camera, SAMPLES);
    let buffers = rasterize(mesh, &fine, camera_from_mesh, (width * SAMPLES, height * SAMPLES))?;
    let linear = linear_table();
    let pixels: Vec<([u8; 3], f32)> = (0..width * height)
        .into_par_iter()
        .map(|i| {
            let (x, y) = (i % width * SAMPLES, i / width * SAMPLES);
            let (mut sum, mut count) = (Vec3::zeros(), 0.0);
            for sy in y..y + SAMPLES {
                for sx in x..x + SAMPLES {
                    let Some(s) = Sample::at(&buffers, sx, sy) else { continue };
                    let corners = mesh.faces[s.face].map(|i| i as usize);
                    sum += surface_color(mesh, texture, &s, &corners, &linear)
                        .unwrap_or_else(|| Vec3::from(PLASTER));
                    count += 1.0;
                }
            }
            let share = count / (SAMPLES * SAMPLES) as f64;
            (to_rgb(&(sum / f64::max(count, 1.0))), share as f32)
        })
        .collect();
    let image = Rgb::from_fn(width, height, |x, y| pixels[y * width + x].0);
    Ok((image, Raster::from_fn(width, height, |x, y| pixels[y * width + x].1)))
}
