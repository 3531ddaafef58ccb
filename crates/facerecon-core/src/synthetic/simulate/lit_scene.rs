//! The lit scene: subject and wall in the frame of the left camera, and the light they reflect.

use super::error::SimulateError;
use super::params::SimulateParams;
use super::rig::Rig;
use super::subject::Subject;
use crate::data::sampling::{Cell, bilinear};
use crate::data::{Mesh, Raster, Rgb};
use crate::math::{Similarity, Vec3, interpolate};
use crate::render::{ambient_openness, linear_from_srgb, rasterize, sample_texture, supersampled};
use crate::synthetic::pattern::Design;

/// Texels of the shadow map between dots.
const SHADOW_TEXELS: usize = 16;
/// Longest side of the shadow map, texels: bounds its memory to 64 MB.
const SHADOW_SIDE: usize = 4096;
/// A surface this much farther from the projector than the shadow map is in shadow, mm; less gives
/// false shadows on oblique surfaces.
const SHADOW_BIAS_MM: f64 = 0.8;
/// The bias grows with the obliqueness of the surface, down to this cosine.
const LEAST_COSINE: f64 = 0.1;
/// Linear albedo of a subject without colours: medium skin.
const SKIN: [f64; 3] = [0.50, 0.29, 0.20];
/// Linear albedo of the wall: a dark curtain.
const WALL: f64 = 0.05;
/// Ambient openness of the wall.
const WALL_OPENNESS: f64 = 0.5;
/// Exponent of the specular reflection (Blinn-Phong).
const SPECULAR_EXPONENT: i32 = 30;
/// Extent of the large light: surfaces turned away from it by less than this cosine still receive light.
const WRAP: f64 = 0.3;
/// Below this cosine between normal and line of sight the inside of an open mesh is visible; smooth
/// normals at silhouettes are slightly negative.
const INSIDE_COSINE: f64 = -0.2;
/// Share of the large light that is not occluded in concave regions.
const UNOCCLUDED: f64 = 0.3;
/// Light of the projector in black areas of the pattern, as a fraction of white.
const BLACK_LEVEL: f64 = 0.004;

/// Light reflected with and without the pattern, linear red, green, blue.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Reflected {
    pub(super) dotted: [f32; 3],
    pub(super) plain: [f32; 3],
}

/// Subject and wall with their lights.
pub(super) struct LitScene<'a> {
    /// Subject and wall, left camera frame.
    pub(super) mesh: Mesh,
    /// The first faces, this many, are those of the subject.
    pub(super) subject_faces: usize,
    normals: Vec<Vec3>,
    openness: Vec<f64>,
    texture: Option<&'a Rgb>,
    /// Linear value of each sRGB value.
    linear: [f64; 256],
    design: Design,
    shadow: Raster<f32>,
    shadow_scale: usize,
    /// Direction to the large light.
    large_light: Vec3,
    /// Position of the projector, left camera frame.
    projector: Vec3,
    rig: &'a Rig,
    params: &'a SimulateParams,
}

impl<'a> LitScene<'a> {
    pub(super) fn new(
        subject: &Subject<'a>,
        camera_from_model: &Similarity,
        rig: &'a Rig,
        params: &'a SimulateParams,
    ) -> Result<Self, SimulateError> {
        let mut mesh = subject.mesh.transformed(camera_from_model);
        let subject_faces = mesh.faces.len();
        let mut normals: Vec<Vec3> = mesh.vertex_normals();
        let mut openness = ambient_openness(subject.mesh)?;
        if params.wall {
            let wall = rig.wall(params);
            let first = mesh.vertices.len() as u32;
            normals.extend(wall.vertex_normals());
            openness.resize(openness.len() + wall.vertices.len(), WALL_OPENNESS);
            mesh.vertices.extend(&wall.vertices);
            mesh.faces.extend(wall.faces.iter().map(|f| f.map(|i| i + first)));
            if mesh.has_uv() {
                mesh.face_uvs.resize(mesh.faces.len(), [0; 3]);
            }
            if !mesh.colors.is_empty() {
                mesh.colors.resize(mesh.vertices.len(), [0; 3]);
            }
        }
        let (columns, rows) = (params.pattern.columns, params.pattern.rows);
        let scale = SHADOW_TEXELS.min(SHADOW_SIDE / columns.max(rows)).max(1);
        let map = supersampled(&rig.projector.camera, scale);
        let size = ((columns + 1) * scale, (rows + 1) * scale);
        let shadow = rasterize(&mesh, &map, &rig.projector.camera_from_left, size)?.depth_mm;
        Ok(Self {
            mesh,
            subject_faces,
            normals,
            openness,
            texture: subject.texture,
            linear: std::array::from_fn(|v| linear_from_srgb(v as u8)),
            design: Design::new(&params.pattern),
            shadow,
            shadow_scale: scale,
            large_light: rig.large_light(),
            projector: rig.projector.camera_from_left.inverse().translation,
            rig,
            params,
        })
    }

    /// Light that a point of a face, given by barycentric weights, reflects to a camera at `eye` (left
    /// camera frame).
    pub(super) fn reflected(&self, face: usize, weights: [f32; 3], eye: &Vec3) -> Reflected {
        let w = weights.map(f64::from);
        let corners = self.mesh.faces[face].map(|i| i as usize);
        let point = interpolate(corners.map(|v| self.mesh.vertices[v]), w);
        let smooth = interpolate(corners.map(|v| self.normals[v]), w);
        let toward_eye = (eye - point).normalize();
        let normal = smooth.try_normalize(1e-12).unwrap_or(toward_eye);
        let normal = if normal.dot(&toward_eye) < INSIDE_COSINE { -normal } else { normal };
        let open = interpolate(corners.map(|v| self.openness[v]), w);
        let albedo = self.albedo(face, &corners, &w);

        let p = self.params;
        let (projected, specular) = self.projected(&point, &normal, &toward_eye);
        let soft = ((normal.dot(&self.large_light) + WRAP) / (1.0 + WRAP)).max(0.0)
            * (UNOCCLUDED + (1.0 - UNOCCLUDED) * open);
        let gloss = if face < self.subject_faces { p.gloss } else { 0.0 };
        let half = (self.large_light + toward_eye).try_normalize(1e-12).unwrap_or_default();
        let shine = gloss * normal.dot(&half).max(0.0).powi(SPECULAR_EXPONENT) * open;
        let dotted_base = p.ambient_light * open + p.soft_light * soft;
        let plain = p.ambient_plain * open + p.soft_plain * soft;
        let mut light = Reflected::default();
        for k in 0..3 {
            let with = albedo[k] * (dotted_base + projected[k])
                + p.soft_light * shine
                + gloss * specular * projected[k];
            light.dotted[k] = with as f32;
            light.plain[k] = (albedo[k] * plain + p.soft_plain * shine) as f32;
        }
        light
    }

    /// Light of the projector on a surface, and the strength of its specular reflection.
    fn projected(&self, point: &Vec3, normal: &Vec3, toward_eye: &Vec3) -> ([f64; 3], f64) {
        let q = self.rig.projector.camera_from_left.apply(point);
        let Some(at) = self.rig.projector.camera.project(&q) else { return ([0.0; 3], 0.0) };
        let toward = (self.projector - point).normalize();
        let cosine = normal.dot(&toward);
        if cosine <= 0.0 {
            return ([0.0; 3], 0.0);
        }
        let lit = self.lit(at.x, at.y, q.z, cosine);
        if lit == 0.0 {
            return ([0.0; 3], 0.0);
        }
        // Inverse square, 1 at the distance of the subject.
        let falloff = (self.params.distance_mm / q.norm()).powi(2);
        let strength = self.params.projector_light * cosine * falloff * lit;
        let color = self.design.light(at, self.params.dot_softness);
        let half = (toward + toward_eye).try_normalize(1e-12).unwrap_or_default();
        let specular = normal.dot(&half).max(0.0).powi(SPECULAR_EXPONENT);
        (color.map(|l| strength * (BLACK_LEVEL + (1.0 - BLACK_LEVEL) * l)), specular)
    }

    /// Fraction of the light of the projector that reaches a point at these lattice coordinates and
    /// depth: the shadow test, interpolated over the four nearest texels of the shadow map.
    fn lit(&self, u: f64, v: f64, depth: f64, cosine: f64) -> f64 {
        let s = self.shadow_scale as f64;
        let (x, y) = ((u + 0.5) * s - 0.5, (v + 0.5) * s - 0.5);
        let (w, h) = self.shadow.size();
        if !(x >= 0.0 && y >= 0.0 && x < (w - 1) as f64 && y < (h - 1) as f64) {
            return 0.0; // outside the image of the projector
        }
        let bias = (SHADOW_BIAS_MM / cosine.max(LEAST_COSINE)) as f32;
        let open = |x, y| if depth as f32 <= self.shadow.at(x, y) + bias { 1.0 } else { 0.0 };
        let cell = Cell::clamped(x, y, (w, h));
        bilinear(cell.corners(open), cell.fraction)
    }

    /// Linear albedo of a point.
    fn albedo(&self, face: usize, corners: &[usize; 3], w: &[f64; 3]) -> [f64; 3] {
        if face >= self.subject_faces {
            return [WALL; 3];
        }
        if let (Some(texture), Some(uv)) = (self.texture, self.mesh.face_uvs.get(face)) {
            let [a, b, c] = uv.map(|i| self.mesh.uvs[i as usize]);
            let at = [0, 1].map(|k| a[k] * w[0] + b[k] * w[1] + c[k] * w[2]);
            return sample_texture(texture, at).map(|v| {
                let low = (v as usize).min(254);
                let (from, to) = (self.linear[low], self.linear[low + 1]);
                from + (to - from) * (v - low as f64)
            });
        }
        if self.mesh.colors.is_empty() {
            return SKIN;
        }
        let color = |k: usize, i: usize| self.linear[self.mesh.colors[corners[i]][k] as usize];
        [0, 1, 2].map(|k| (0..3).map(|i| color(k, i) * w[i]).sum())
    }
}
