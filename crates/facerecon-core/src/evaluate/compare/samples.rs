//! Points evenly distributed over a surface; the same input gives the same points.

use crate::data::Mesh;
use crate::math::Vec3;

/// A point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sample {
    /// Position.
    pub(super) point: Vec3,
}

/// About `count` points on a mesh (on the faces whose vertices are all in `region`), at equal steps of
/// the cumulative area and by a low-discrepancy sequence within each face. Empty without area.
pub(super) fn sample_surface(mesh: &Mesh, region: Option<&[bool]>, count: usize) -> Vec<Sample> {
    let in_region = |face: &[u32; 3]| {
        region.is_none_or(|mask| face.iter().all(|i| mask.get(*i as usize).copied() == Some(true)))
    };
    let faces: Vec<(usize, f64)> = mesh
        .faces
        .iter()
        .enumerate()
        .filter(|(_, face)| in_region(face))
        .map(|(number, _)| {
            let [a, b, c] = mesh.corners(number);
            (number, (b - a).cross(&(c - a)).norm() / 2.0)
        })
        .collect();
    let total: f64 = faces.iter().map(|f| f.1).sum();
    if !(total > 0.0) || !total.is_finite() || count == 0 {
        return Vec::new();
    }
    let step = total / count as f64;
    let mut samples = Vec::with_capacity(count);
    let (mut cumulative, mut next) = (0.0, step / 2.0);
    for (number, area) in faces {
        cumulative += area;
        while next <= cumulative && samples.len() < count {
            let [a, b, c] = mesh.corners(number);
            let (u, v) = in_triangle(samples.len());
            let point = a + (b - a) * u + (c - a) * v;
            samples.push(Sample { point });
            next += step;
        }
    }
    samples
}

/// The `k`-th point of the R2 sequence (Roberts 2018), folded into a triangle.
fn in_triangle(k: usize) -> (f64, f64) {
    const PLASTIC: f64 = 1.324_717_957_244_746;
    let u = (0.5 + (k + 1) as f64 / PLASTIC).fract();
    let v = (0.5 + (k + 1) as f64 / (PLASTIC * PLASTIC)).fract();
    if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) }
}
