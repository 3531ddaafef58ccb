//! Pictures of a mesh: shaded, textured, as wireframe or as heat map.

use super::error::{LARGEST_SIDE, RenderError};
use super::heat::{Heat, draw_legend};
use super::light::{from_rgb, linear_table, studio, to_rgb};
use super::occlusion::ambient_openness;
use super::ramp::heat_color;
use super::surface::{SAMPLES, SHADED, Sample, surface_color};
use super::view::{Frame, Framing, View};
use super::zbuffer::{rasterize, supersampled};
use crate::camera::Pinhole;
use crate::data::{Mesh, Rgb};
use crate::math::{Similarity, Vec2, Vec3, interpolate};
use crate::settings::choices;

choices! {
    /// How a mesh is drawn.
    pub enum Mode {
        /// Shape only, in studio light.
        Shaded = "shaded",
        /// With its texture (or vertex colours) as it is, without further light.
        Textured = "textured",
        /// With its texture in studio light.
        Lit = "lit",
        /// Its edges on a pale surface; hidden ones are not drawn.
        Wireframe = "wireframe",
        /// Values at the vertices as colours, with a legend.
        Heat = "heat",
        /// The standard deviation of measured vertices as colours, with a legend in mm; grey where
        /// nothing was measured.
        Uncertainty = "uncertainty",
    }
}

/// Albedo of the surface below a wireframe, and colour of its lines, linear.
const WIREFRAME_SURFACE: [f64; 3] = [0.86, 0.87, 0.88];
const WIREFRAME_LINE: [f64; 3] = [0.02, 0.05, 0.11];
/// Half the width of a line, pixels, in pictures up to the given width; wider ones get wider lines.
const LINE_PX: f64 = 0.45;
const LINE_PICTURE_PX: f64 = 700.0;
/// Brightness of heat maps and lit textures, so that studio light leaves their colours as they are.
const HEAT_EXPOSURE: f64 = 1.25;
const LIT_EXPOSURE: f64 = 1.35;
/// A surface that faces away by more than this cosine shows its inside; the inside is dimmer.
const INSIDE_COSINE: f64 = -0.1;
const INSIDE_LIGHT: f64 = 0.45;

/// End of the scale of standard deviations, mm: five times those of a face, so that pictures of
/// different results can be compared.
const UNCERTAINTY_LIMIT_MM: f64 = 1.0;

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
///
/// # Example
/// ```
/// use facerecon_core::data::Mesh;
/// use facerecon_core::math::Vec3;
/// use facerecon_core::render::{Mode, Scene, View, picture};
///
/// let vertices = [(0.0, 0.0), (80.0, 0.0), (0.0, 80.0)].map(|(x, y)| Vec3::new(x, y, 0.0));
/// let mesh = Mesh { vertices: vertices.to_vec(), faces: vec![[0, 1, 2]], ..Mesh::default() };
/// let image = picture(&Scene::new(&mesh), View::Front, Mode::Shaded, (64, 48))?;
/// assert_eq!(image.size(), (64, 48));
/// # Ok::<(), facerecon_core::render::RenderError>(())
/// ```
pub fn picture(
    scene: &Scene<'_>,
    view: View,
    mode: Mode,
    size: (usize, usize),
) -> Result<Rgb, RenderError> {
    Studio::new(scene, mode)?.picture(view, None, size)
}

/// A scene prepared for drawing from several views: ambient occlusion is computed once.
#[derive(Debug)]
pub struct Studio<'a> {
    scene: Scene<'a>,
    mode: Mode,
    normals: Vec<Vec3>,
    openness: Vec<f64>,
    /// Values drawn as colours, one per vertex; NaN is grey.
    values: Vec<f64>,
    /// Value at the end of their scale.
    limit: f64,
    linear: [f64; 256],
}

impl<'a> Studio<'a> {
    /// Prepares a scene.
    ///
    /// # Errors
    /// [`RenderError`] for an invalid mesh, or colours without values.
    pub fn new(scene: &Scene<'a>, mode: Mode) -> Result<Self, RenderError> {
        let openness = match mode {
            Mode::Textured => Vec::new(),
            _ => ambient_openness(scene.mesh)?,
        };
        Self::with_openness(scene, mode, openness)
    }

    /// Prepares a scene with known openness of its vertices (see [`ambient_openness`]); vertices
    /// beyond the list are unoccluded.
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
        let (values, limit) = match (mode, &scene.heat) {
            (Mode::Uncertainty, _) => {
                if !scene.mesh.has_uncertainty() {
                    return Err(RenderError::NoUncertainty);
                }
                let pairs = scene.mesh.sigmas.iter().zip(&scene.mesh.measured);
                let shown =
                    pairs.map(|(sigma, measured)| if *measured { *sigma } else { f64::NAN });
                (shown.collect(), UNCERTAINTY_LIMIT_MM)
            }
            (Mode::Heat, Some(heat)) => (heat.values.to_vec(), heat.limit()),
            _ => (Vec::new(), 1.0),
        };
        Ok(Self { scene: *scene, mode, normals, openness, values, limit, linear: linear_table() })
    }

    /// Unoccluded fraction of the sky at each vertex, 0 to 1.
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
        let room = room(self.mode, size);
        let framing = Framing::new(self.scene.mesh, view, self.scene.frame);
        let camera = framing.camera(focal_px.unwrap_or_else(|| framing.focal_px(room)), room);
        let mut image = self.draw(&camera, &framing.camera_from_mesh, size)?;
        match (self.mode, &self.scene.heat) {
            (Mode::Uncertainty, _) => draw_legend(&mut image, self.limit, "mm"),
            (Mode::Heat, Some(heat)) => draw_legend(&mut image, self.limit, heat.unit),
            _ => {}
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
        let line = LINE_PX * SAMPLES as f64 * (width as f64 / LINE_PICTURE_PX).max(1.0);
        let line_color = Vec3::from(WIREFRAME_LINE);
        let share = 1.0 / (SAMPLES * SAMPLES) as f64;
        let rows: Vec<Vec3> = (0..height).map(|y| background(y, height)).collect();
        let empty: Vec<[u8; 3]> = rows.iter().map(to_rgb).collect();
        Ok(Rgb::par_from_fn(width, height, |x, y| {
            let back = rows[y];
            let (mut sum, mut hit) = (Vec3::zeros(), false);
            for sy in y * SAMPLES..(y + 1) * SAMPLES {
                for sx in x * SAMPLES..(x + 1) * SAMPLES {
                    let sample = Sample::at(&buffers, sx, sy);
                    hit |= sample.is_some();
                    sum += sample.map_or(back, |s| {
                        let here = Vec2::new(sx as f64, sy as f64);
                        let light = self.light(&s, &normals, &fine.ray(here));
                        let edge = self.edge(&s, &corners, here, line);
                        light * (1.0 - edge) + line_color * edge
                    });
                }
            }
            if hit { to_rgb(&(sum * share)) } else { empty[y] }
        }))
    }

    /// Light from a point of the surface toward the camera, linear.
    fn light(&self, sample: &Sample, normals: &[Vec3], ray: &Vec3) -> Vec3 {
        let corners = self.scene.mesh.faces[sample.face].map(|i| i as usize);
        let mix = |value: &dyn Fn(usize) -> f64| interpolate(corners.map(value), sample.weights);
        let albedo = match self.mode {
            Mode::Textured | Mode::Lit => {
                surface_color(self.scene.mesh, self.scene.texture, sample, &self.linear)
            }
            Mode::Shaded => Vec3::from(SHADED),
            Mode::Wireframe => Vec3::from(WIREFRAME_SURFACE),
            Mode::Heat | Mode::Uncertainty => {
                let color = heat_color(mix(&|i| self.values[i]) / self.limit);
                from_rgb(color, &self.linear) * HEAT_EXPOSURE
            }
        };
        if self.mode == Mode::Textured {
            return albedo;
        }
        let toward = -ray.normalize();
        let smooth = interpolate(corners.map(|v| normals[v]), sample.weights);
        let normal = smooth.try_normalize(1e-12).unwrap_or(toward);
        let facing = normal.dot(&toward);
        // the inside of an open mesh is drawn with its normal turned
        let (normal, inside) =
            if facing < INSIDE_COSINE { (-normal, INSIDE_LIGHT) } else { (normal, 1.0) };
        let (matt, gloss) = studio(&normal, &toward, mix(&|i| self.openness[i]).clamp(0.0, 1.0));
        let exposure = if self.mode == Mode::Lit { LIT_EXPOSURE } else { 1.0 };
        (albedo * matt * exposure + Vec3::repeat(gloss)) * inside
    }

    /// Fraction of a sample that an edge of its face covers, 0 to 1.
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

/// The part of a picture that the mesh fills: in heat maps the legend takes the lower tenth.
pub(super) fn room(mode: Mode, (width, height): (usize, usize)) -> (usize, usize) {
    match mode {
        Mode::Heat | Mode::Uncertainty => (width, (height * 9 / 10).max(1)),
        _ => (width, height),
    }
}

/// A grey gradient, linear; brighter at the top.
fn background(y: usize, height: usize) -> Vec3 {
    let t = y as f64 / height.max(2) as f64;
    Vec3::new(0.80, 0.81, 0.82) * (1.0 - 0.30 * t * t)
}
