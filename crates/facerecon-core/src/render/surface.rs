//! What a sample of a drawn mesh shows.

use super::light::{from_rgb, sample_texture};
use super::zbuffer::{Buffers, NO_FACE};
use crate::data::{Mesh, Rgb};
use crate::math::{Vec3, interpolate};

/// Samples along each side of a pixel: smooth contours at four times the work.
pub(super) const SAMPLES: usize = 2;
/// Albedo of shaded meshes, and of those without colours, linear: a light, warm grey.
pub(super) const SHADED: [f64; 3] = [0.78, 0.70, 0.63];

/// A point of the surface.
pub(super) struct Sample {
    pub(super) face: usize,
    /// Barycentric weights.
    pub(super) weights: [f64; 3],
}

impl Sample {
    /// The point visible at a pixel of the buffers.
    pub(super) fn at(buffers: &Buffers, x: usize, y: usize) -> Option<Self> {
        let face = buffers.face.at(x, y);
        let weights = buffers.barycentric.at(x, y).map(f64::from);
        (face != NO_FACE).then_some(Self { face: face as usize, weights })
    }
}

/// Own colour of the surface, linear: from the texture, else from vertex colours, else [`SHADED`].
/// `linear` is the table of [`super::linear_from_srgb`].
pub(super) fn surface_color(
    mesh: &Mesh,
    texture: Option<&Rgb>,
    sample: &Sample,
    linear: &[f64; 256],
) -> Vec3 {
    let w = &sample.weights;
    if let (Some(texture), Some(uv)) = (texture, mesh.face_uvs.get(sample.face)) {
        let [a, b, c] = uv.map(|i| mesh.uvs[i as usize]);
        let at = [0, 1].map(|k| a[k] * w[0] + b[k] * w[1] + c[k] * w[2]);
        let decoded = |v: f64| {
            // between table entries; sRGB is almost linear over one step
            let low = (v as usize).min(254);
            linear[low] + (linear[low + 1] - linear[low]) * (v - low as f64)
        };
        return Vec3::from(sample_texture(texture, at).map(decoded));
    }
    if mesh.colors.is_empty() {
        return Vec3::from(SHADED);
    }
    let corners = mesh.faces[sample.face].map(|i| i as usize);
    interpolate(corners.map(|v| from_rgb(mesh.colors[v], linear)), *w)
}
