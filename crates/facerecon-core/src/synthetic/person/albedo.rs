//! The skin of a made-up person as a texture.

use super::beard;
use super::model::Model;
use crate::data::Raster;
use crate::math::Vec3;

/// Texels outside the texture layout, up to this distance, repeat the colour of the nearest triangle.
const GUTTER_TEXELS: f64 = 2.5;
/// Twice the area of a triangle, in square texels, below which it covers nothing.
const LEAST_AREA: f64 = 1e-12;

/// Colour of skin, brows, eyes and hair over the texture square: linear RGB, 0 to 1,
/// `size` x `size`, row 0 at v = 1.
pub(super) fn albedo(model: &Model, size: usize) -> Raster<[f32; 3]> {
    let points = rest_points(model, size);
    Raster::par_from_fn(size, size, |x, y| match points.at(x, y) {
        Some(point) if model.bearded => beard::over(&model.skin, &point, model.skin.albedo(&point)),
        Some(point) => model.skin.albedo(&point),
        None => model.skin.plain(),
    })
}

/// For each texel the point of the rest surface that it shows.
fn rest_points(model: &Model, size: usize) -> Raster<Option<Vec3>> {
    let mut points = Raster::filled(size, size, None);
    let mut distance = Raster::filled(size, size, f64::MAX);
    let mesh = &model.head.mesh;
    let n = size as f64;
    for (f, t) in mesh.faces.iter().zip(&mesh.face_uvs) {
        let uv = t.map(|i| {
            let [u, v] = mesh.uvs[i as usize];
            [u * n - 0.5, (1.0 - v) * n - 0.5]
        });
        let area = cross(uv[0], uv[1], uv[2]);
        if area.abs() < LEAST_AREA {
            continue;
        }
        let p = f.map(|i| model.rest[i as usize]);
        let longest = (0..3)
            .map(|k| (uv[k][0] - uv[(k + 1) % 3][0]).hypot(uv[k][1] - uv[(k + 1) % 3][1]))
            .fold(1e-9, f64::max);
        for y in texels(uv.map(|q| q[1]), size) {
            for x in texels(uv.map(|q| q[0]), size) {
                let at = [x as f64, y as f64];
                let b = [0, 1, 2].map(|k| cross(uv[(k + 1) % 3], uv[(k + 2) % 3], at) / area);
                // Distance outside the triangle, in texels (0 inside).
                let outside = -b[0].min(b[1]).min(b[2]).min(0.0) * area.abs() / longest;
                if outside > GUTTER_TEXELS || outside >= distance.at(x, y) {
                    continue;
                }
                let b = b.map(|w| w.clamp(-0.5, 1.5));
                let sum: f64 = b.iter().sum();
                points.set(x, y, Some((p[0] * b[0] + p[1] * b[1] + p[2] * b[2]) / sum));
                distance.set(x, y, outside);
            }
        }
    }
    points
}

/// Twice the signed area of a triangle.
fn cross(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Texels along one axis that a triangle with its gutter can cover.
fn texels(corners: [f64; 3], size: usize) -> std::ops::Range<usize> {
    let [a, b, c] = corners;
    let low = (a.min(b).min(c) - GUTTER_TEXELS).ceil().max(0.0) as usize;
    let high = (a.max(b).max(c) + GUTTER_TEXELS).floor().max(0.0) as usize;
    low..(high + 1).min(size)
}
