//! The weight of every photo at every texel.

use super::super::params::ProjectiveParams;
use super::photo::Photo;
use super::texels::Texels;
use crate::data::Raster;
use crate::math::Vec3;

/// A mirrored point may lie this far from the surface, mm: faces are not quite symmetric.
const MIRROR_BIAS_MM: f64 = 6.0;
/// The weight rises from 0 to 1 over this many pixels beyond the margin of a depth discontinuity,
/// so that the change from one photo to another is gradual: as wide as the smoothest band.
const EDGE_RAMP_PX: f64 = 8.0;
/// The depth at a pixel is uncertain by the slope of the surface over half a pixel; the slope is
/// limited to that at this cosine.
const SLOPE_COSINE: f64 = 0.2;

/// Weights of the photos on the coarse grid, 0 where a photo does not see a texel.
pub(super) struct Weights {
    /// Of the photos.
    pub direct: Vec<Raster<f32>>,
    /// Of the photos as they see the mirrored head; empty without mirroring.
    pub mirrored: Vec<Raster<f32>>,
}

/// Weight of every photo at every texel: `max(0, cosine - least)^2 (px/mm)^2`, falling to 0 toward
/// depth discontinuities, the photo's border and saturated colours.
pub(super) fn weights(
    texels: &Texels<'_>,
    photos: &[Photo<'_>],
    params: &ProjectiveParams,
) -> Weights {
    let one = |photo: &Photo<'_>, mirrored: bool| {
        let bias_mm = if mirrored { MIRROR_BIAS_MM } else { params.bias_mm };
        let at = |index: usize| -> Option<f32> {
            let (mut point, mut normal) = texels.point(index)?;
            if mirrored {
                (point.x, normal.x) = (-point.x, -normal.x);
            }
            weight(photo, &point, &normal, bias_mm, params)
        };
        let size = texels.size;
        Raster::par_from_fn(size, size, |x, y| at(y * size + x).unwrap_or(0.0))
    };
    let direct = photos.iter().map(|p| one(p, false)).collect();
    let mirrored =
        if params.mirror { photos.iter().map(|p| one(p, true)).collect() } else { Vec::new() };
    Weights { direct, mirrored }
}

/// Weight of a photo at a point of the surface; `None` where it does not see it.
fn weight(
    photo: &Photo<'_>,
    point: &Vec3,
    normal: &Vec3,
    bias_mm: f64,
    params: &ProjectiveParams,
) -> Option<f32> {
    let (pixel, depth) = photo.camera.project(point)?;
    let (behind, edge_px) = photo.visibility.behind(pixel, depth)?;
    let toward = photo.centre - point;
    let cosine = normal.dot(&toward) / toward.norm();
    let facing = cosine - params.least_cosine;
    let ramp = ((edge_px - params.edge_px) / EDGE_RAMP_PX).clamp(0.0, 1.0);
    let focal = photo.camera.pinhole.fx;
    let slack = bias_mm + 0.5 * depth / focal.max(1.0) / cosine.max(SLOPE_COSINE);
    if facing <= 0.0 || ramp <= 0.0 || behind.abs() > slack.max(bias_mm) {
        return None;
    }
    let resolution = focal / depth;
    let geometric = (facing.powi(2) * resolution.powi(2) * ramp) as f32;
    Some(geometric * photo.unsaturated(pixel) * photo.shows_subject(pixel))
}
