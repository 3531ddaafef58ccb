//! Points spread evenly over a surface, the same ones every time.

use crate::data::Mesh;
use crate::math::Vec3;

/// A point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Position.
    pub point: Vec3,
    /// Unit normal of its face.
    pub normal: Vec3,
}

/// About `count` points spread over the area of a mesh (of the faces whose corners all lie in
/// `region`), by equal steps along the faces' running area and a low-discrepancy sequence within
/// each face. Empty when there is no area.
pub fn sample_surface(mesh: &Mesh, region: Option<&[bool]>, count: usize) -> Vec<Sample> {
    let counts = |face: &[u32; 3]| {
        region.is_none_or(|mask| face.iter().all(|i| mask.get(*i as usize).copied() == Some(true)))
    };
    let faces: Vec<(usize, f64)> = mesh
        .faces
        .iter()
        .enumerate()
        .filter(|(_, face)| counts(face))
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
    let (mut passed, mut next) = (0.0, step / 2.0);
    for (number, area) in faces {
        passed += area;
        while next <= passed && samples.len() < count {
            let [a, b, c] = mesh.corners(number);
            let (u, v) = in_triangle(samples.len());
            let point = a + (b - a) * u + (c - a) * v;
            let normal = (b - a).cross(&(c - a)).try_normalize(1e-300).unwrap_or_default();
            samples.push(Sample { point, normal });
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
