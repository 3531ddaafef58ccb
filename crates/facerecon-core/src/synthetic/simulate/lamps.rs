//! The lit scene: subject and wall in the left camera's frame, and the light they send back.

use super::geometry::Rig;
use super::{SimulateError, SimulateParams, Subject};
use crate::data::sampling::{Cell, bilinear};
use crate::data::{Mesh, Raster, Rgb};
use crate::math::{Similarity, Vec3};
use crate::render::{ambient_openness, linear_from_srgb, rasterize, sample_texture, supersampled};
use crate::synthetic::pattern::Design;

/// Texels of the shadow map from dot to dot.
const SHADOW_TEXELS: usize = 16;
/// Longest side of the shadow map.
const SHADOW_SIDE: usize = 4096;
/// A surface this much farther than the shadow map's entry lies in shadow.
const SHADOW_BIAS_MM: f64 = 0.8;
/// Albedo (linear) of skin where the subject brings no colour, and of the wall.
const SKIN: [f64; 3] = [0.50, 0.29, 0.20];
const WALL: f64 = 0.05;
/// Light of the projector where the pattern is black.
const BLACK_LEVEL: f64 = 0.004;

/// Light with and without the pattern, linear red, green, blue.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Light {
    pub(super) pattern: [f32; 3],
    pub(super) plain: [f32; 3],
}

/// Subject and wall with all that lights them.
pub(super) struct Lamps<'a> {
    /// Subject and wall, left camera frame.
    pub(super) mesh: Mesh,
    /// Faces below this number are the subject's.
    pub(super) subject_faces: usize,
    normals: Vec<Vec3>,
    openness: Vec<f64>,
    texture: Option<&'a Rgb>,
    table: [f64; 256],
    design: Design,
    shadow: Raster<f32>,
    shadow_scale: usize,
    lamp: Vec3,
    /// The projector's place, left camera frame.
    projector: Vec3,
    rig: &'a Rig,
    params: &'a SimulateParams,
}

impl<'a> Lamps<'a> {
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
            // a corner of the room
            openness.resize(openness.len() + wall.vertices.len(), 0.5);
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
        let map = supersampled(&rig.lattice, scale);
        let size = ((columns + 1) * scale, (rows + 1) * scale);
        let shadow = rasterize(&mesh, &map, &rig.projector_from_left, size)?.depth_mm;
        Ok(Self {
            mesh,
            subject_faces,
            normals,
            openness,
            texture: subject.texture,
            table: std::array::from_fn(|v| linear_from_srgb(v as u8)),
            design: Design::new(&params.pattern),
            shadow,
            shadow_scale: scale,
            lamp: rig.lamp(),
            projector: rig.projector_from_left.inverse().translation,
            rig,
            params,
        })
    }

    /// Light that a point of a face sends to a camera at `eye` (left camera frame).
    pub(super) fn light(&self, face: usize, weights: [f32; 3], eye: &Vec3) -> Light {
        let w = weights.map(f64::from);
        let corners = self.mesh.faces[face].map(|i| i as usize);
        let [a, b, c] = corners;
        let point = self.mesh.vertices[a] * w[0]
            + self.mesh.vertices[b] * w[1]
            + self.mesh.vertices[c] * w[2];
        let smooth = self.normals[a] * w[0] + self.normals[b] * w[1] + self.normals[c] * w[2];
        let toward_eye = (eye - point).normalize();
        let normal = smooth.try_normalize(1e-12).unwrap_or(toward_eye);
        // an open mesh may show its inside
        let normal = if normal.dot(&toward_eye) < -0.2 { -normal } else { normal };
        let open = self.openness[a] * w[0] + self.openness[b] * w[1] + self.openness[c] * w[2];
        let albedo = self.albedo(face, &corners, &w);

        let p = self.params;
        let (projected, mirrored) = self.projected(&point, &normal, &toward_eye);
        // the lamp is large: its light reaches a little around the edge
        let soft = ((normal.dot(&self.lamp) + 0.3) / 1.3).max(0.0) * (0.3 + 0.7 * open);
        let gloss = if face < self.subject_faces { p.gloss } else { 0.0 };
        let half = (self.lamp + toward_eye).try_normalize(1e-12).unwrap_or_default();
        let shine = gloss * normal.dot(&half).max(0.0).powi(30) * open;
        let pattern_base = p.ambient_light * open + p.soft_light * soft;
        let plain = p.ambient_plain * open + p.soft_plain * soft;
        let mut light = Light::default();
        for k in 0..3 {
            let with = albedo[k] * (pattern_base + projected[k])
                + p.soft_light * shine
                + gloss * mirrored * projected[k];
            light.pattern[k] = with as f32;
            light.plain[k] = (albedo[k] * plain + p.soft_plain * shine) as f32;
        }
        light
    }

    /// Light of the projector on a surface, and the strength of its mirror image in it.
    fn projected(&self, point: &Vec3, normal: &Vec3, toward_eye: &Vec3) -> ([f64; 3], f64) {
        let q = self.rig.projector_from_left.apply(point);
        let Some(at) = self.rig.lattice.project(&q) else { return ([0.0; 3], 0.0) };
        let toward = (self.projector - point).normalize();
        let cosine = normal.dot(&toward);
        if cosine <= 0.0 {
            return ([0.0; 3], 0.0);
        }
        let lit = self.lit(at.x, at.y, q.z, cosine);
        if lit == 0.0 {
            return ([0.0; 3], 0.0);
        }
        // inverse square, 1 at the subject's distance
        let fall = (self.params.distance_mm / q.norm()).powi(2);
        let strength = self.params.projector_light * cosine * fall * lit;
        let color = self.design.light(at, self.params.dot_softness);
        let half = (toward + toward_eye).try_normalize(1e-12).unwrap_or_default();
        let mirrored = normal.dot(&half).max(0.0).powi(30);
        (color.map(|l| strength * (BLACK_LEVEL + (1.0 - BLACK_LEVEL) * l)), mirrored)
    }

    /// Share of the projector's light that reaches a point at these lattice coordinates and depth:
    /// bilinear over the four nearest entries of the shadow map.
    fn lit(&self, u: f64, v: f64, depth: f64, cosine: f64) -> f64 {
        let s = self.shadow_scale as f64;
        let (x, y) = ((u + 0.5) * s - 0.5, (v + 0.5) * s - 0.5);
        let (w, h) = self.shadow.size();
        if !(x >= 0.0 && y >= 0.0 && x < (w - 1) as f64 && y < (h - 1) as f64) {
            return 0.0; // outside the picture of the projector
        }
        let slack = (SHADOW_BIAS_MM / cosine.max(0.1)) as f32;
        let open = |x, y| if depth as f32 <= self.shadow.at(x, y) + slack { 1.0 } else { 0.0 };
        let cell = Cell::clamped(x, y, (w, h));
        bilinear(cell.corners(open), cell.fraction)
    }

    /// Albedo of a point, linear.
    fn albedo(&self, face: usize, corners: &[usize; 3], w: &[f64; 3]) -> [f64; 3] {
        if face >= self.subject_faces {
            return [WALL; 3];
        }
        if let (Some(texture), Some(uv)) = (self.texture, self.mesh.face_uvs.get(face)) {
            let [a, b, c] = uv.map(|i| self.mesh.uvs[i as usize]);
            let at = [0, 1].map(|k| a[k] * w[0] + b[k] * w[1] + c[k] * w[2]);
            return sample_texture(texture, at).map(|v| {
                let low = (v as usize).min(254);
                let (from, to) = (self.table[low], self.table[low + 1]);
                from + (to - from) * (v - low as f64)
            });
        }
        if self.mesh.colors.is_empty() {
            return SKIN;
        }
        let color = |k: usize, i: usize| self.table[self.mesh.colors[corners[i]][k] as usize];
        [0, 1, 2].map(|k| (0..3).map(|i| color(k, i) * w[i]).sum())
    }
}
