//! Ambient occlusion: the unoccluded part of the sky at each vertex. It darkens nostrils, eye
//! corners and the line between the lips.

use rayon::prelude::*;

use super::error::RenderError;
use super::zbuffer::rasterize;
use crate::camera::Pinhole;
use crate::data::Mesh;
use crate::math::{Mat3, Similarity, Vec2, Vec3};

/// Directions from which the mesh is drawn, and the width of each depth image, pixels: time grows
/// with both, and the neighbourhood mean hides what is left of the grain.
const DIRECTIONS: usize = 32;
const SIDE: usize = 256;
/// Distance of the camera in radii of the mesh: far, so that its rays are almost parallel.
const FAR: f64 = 30.0;
/// Fraction of the depth image that the mesh fills.
const FILLED: f64 = 0.98;
/// A vertex this much farther than the depth image, in radii of the mesh, is occluded: more than the
/// depth of a pixel (2 / `SIDE`).
const BIAS: f64 = 0.012;
/// The bias grows with the slope of the surface, up to that at this cosine.
const SLOPE_COSINE: f64 = 0.25;

/// Cosine-weighted unoccluded part of the hemisphere above each vertex, 0 to 1, found by drawing
/// the mesh from evenly distributed directions.
///
/// # Errors
/// [`RenderError`] for an invalid mesh.
pub fn ambient_openness(mesh: &Mesh) -> Result<Vec<f64>, RenderError> {
    mesh.validate()?;
    let normals = mesh.vertex_normals();
    let Some((low, high)) = mesh.bounds() else { return Ok(Vec::new()) };
    let centre = (low + high) / 2.0;
    let radius = mesh.vertices.iter().map(|v| (v - centre).norm()).fold(1e-9, f64::max);
    let focal = FILLED * (SIDE as f64 / 2.0) * (FAR * FAR - 1.0).sqrt();
    let camera = Pinhole::ideal(focal, Vec2::repeat((SIDE as f64 - 1.0) / 2.0));
    let bias = radius * BIAS;
    let directions: Vec<Vec3> = (0..DIRECTIONS).map(sphere_direction).collect();

    let seen: Vec<Vec<f32>> = directions
        .par_iter()
        .map(|direction| {
            let camera_from_mesh = looking_along(&-*direction, &centre, radius * FAR);
            let buffers = rasterize(mesh, &camera, &camera_from_mesh, (SIDE, SIDE))?;
            let weights = mesh.vertices.iter().zip(&normals).map(|(vertex, normal)| {
                let cosine = normal.dot(direction);
                if cosine <= 0.0 {
                    return 0.0;
                }
                let p = camera_from_mesh.apply(vertex);
                let Some(pixel) = camera.project(&p) else { return 0.0 };
                let (x, y) = (pixel.x.round() as isize, pixel.y.round() as isize);
                let nearest = buffers.depth_mm.get(x, y).map_or(f64::INFINITY, f64::from);
                // a slanted surface covers more depth within one pixel
                let slack = bias / cosine.max(SLOPE_COSINE);
                if p.z <= nearest + slack { cosine as f32 } else { 0.0 }
            });
            Ok(weights.collect())
        })
        .collect::<Result<_, RenderError>>()?;

    let open: Vec<f64> = normals
        .par_iter()
        .enumerate()
        .map(|(vertex, normal)| {
            let whole: f64 = directions.iter().map(|d| normal.dot(d).max(0.0)).sum();
            let free: f64 = seen.iter().map(|s| f64::from(s[vertex])).sum();
            if whole > 0.0 { (free / whole).min(1.0) } else { 1.0 }
        })
        .collect();
    Ok(averaged(mesh, &open))
}

/// The `k`-th of evenly distributed directions (spherical Fibonacci lattice).
fn sphere_direction(k: usize) -> Vec3 {
    let y = 1.0 - (2.0 * k as f64 + 1.0) / DIRECTIONS as f64;
    let around = k as f64 * std::f64::consts::PI * (3.0 - 5f64.sqrt());
    let r = (1.0 - y * y).max(0.0).sqrt();
    Vec3::new(r * around.cos(), y, r * around.sin())
}

/// A camera that looks along `forward` at `centre` from `distance` away.
fn looking_along(forward: &Vec3, centre: &Vec3, distance: f64) -> Similarity {
    let side = if forward.y.abs() < 0.9 { Vec3::y() } else { Vec3::x() };
    let x = side.cross(forward).try_normalize(1e-12).unwrap_or_else(Vec3::x);
    let y = forward.cross(&x);
    let rotation = Mat3::from_rows(&[x.transpose(), y.transpose(), forward.transpose()]);
    Similarity::rigid(rotation, Vec3::new(0.0, 0.0, distance) - rotation * centre)
}

/// Weighted mean with the neighbours along the faces: hides the grain of the small depth images.
fn averaged(mesh: &Mesh, values: &[f64]) -> Vec<f64> {
    let mut sum: Vec<(f64, f64)> = values.iter().map(|v| (2.0 * v, 2.0)).collect();
    for face in &mesh.faces {
        for (i, j) in [(0, 1), (1, 2), (2, 0)] {
            let (a, b) = (face[i] as usize, face[j] as usize);
            sum[a].0 += 0.5 * values[b];
            sum[a].1 += 0.5;
            sum[b].0 += 0.5 * values[a];
            sum[b].1 += 0.5;
        }
    }
    sum.iter().map(|(total, weight)| total / weight).collect()
}
