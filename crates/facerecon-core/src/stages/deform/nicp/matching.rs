//! Which point of the surface each measured point belongs to, and how much it counts.

use rayon::prelude::*;
use std::collections::BTreeSet;

use super::super::DeformError;
use super::NicpParams;
use crate::data::{Cloud, Mesh, Topology};
use crate::math::{PlanePair, Similarity, Vec3, median};
use crate::spatial::SurfaceIndex;

/// A measured point; the normal is zero where unknown.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    pub at: Vec3,
    pub normal: Vec3,
    /// Weight from the point's own uncertainty; 1 for the typical point.
    pub weight: f64,
}

impl Point {
    /// The usable points of a cloud. What is far noisier than the rest counts less, but no point
    /// counts for more than four.
    pub fn all(data: &Cloud, default_sigma: f64) -> Vec<Self> {
        let n = data.points.len();
        let sigma = |i: usize| match data.sigmas.get(i) {
            Some(s) if *s > 0.0 && s.is_finite() && data.sigmas.len() == n => *s,
            _ => default_sigma,
        };
        let typical = median(&(0..n).map(sigma).collect::<Vec<_>>()).unwrap_or(default_sigma);
        (0..n)
            .map(|i| Self {
                at: data.points[i],
                normal: if data.normals.len() == n { data.normals[i] } else { Vec3::zeros() },
                weight: (typical / sigma(i)).powi(2).clamp(0.02, 4.0),
            })
            .filter(|p| p.at.iter().chain(p.normal.iter()).all(|c| c.is_finite()))
            .collect()
    }

    pub fn transformed(&self, target_from_source: &Similarity) -> Self {
        Self {
            at: target_from_source.apply(&self.at),
            normal: target_from_source.rotate(&self.normal),
            weight: self.weight,
        }
    }
}

/// About `count` points, evenly over space: one in each cell of a grid as fine as needed.
pub(super) fn thin(points: &[Point], count: usize) -> Vec<Point> {
    if points.len() <= count {
        return points.to_vec();
    }
    let pick = |cell: f64| {
        let mut seen = BTreeSet::new();
        let key = |p: &Point| p.at.map(|c| (c / cell).floor() as i64);
        let first = |p: &&Point| {
            let k = key(p);
            seen.insert([k.x, k.y, k.z])
        };
        points.iter().filter(first).copied().collect::<Vec<_>>()
    };
    let low = points.iter().fold(Vec3::repeat(f64::INFINITY), |a, p| a.inf(&p.at));
    let high = points.iter().fold(Vec3::repeat(f64::NEG_INFINITY), |a, p| a.sup(&p.at));
    // Cells on a surface: their number goes with the square of the length.
    let mut cell = ((high - low).norm() / (count as f64).sqrt()).max(1e-9);
    for _ in 0..3 {
        let got = thin_count(&pick(cell));
        cell *= (got / count as f64).sqrt().clamp(0.3, 3.0);
    }
    pick(cell)
}

fn thin_count(points: &[Point]) -> f64 {
    points.len().max(1) as f64
}

/// At most `count` points, evenly over the list.
pub(super) fn thin_evenly(points: &[Point], count: usize) -> Vec<Point> {
    if points.len() <= count {
        return points.to_vec();
    }
    (0..count).map(|k| points[k * points.len() / count]).collect()
}

/// What a match must satisfy.
pub(super) struct Gate {
    /// Faces that may be matched: those away from an open border.
    open: Vec<bool>,
    least_cosine: f64,
}

impl Gate {
    pub fn new(mesh: &Mesh, params: &NicpParams) -> Self {
        let rings = Topology::new(mesh).rings_from_border();
        let far = |v: &u32| rings[*v as usize] as usize >= params.border_rings;
        Self {
            open: mesh.faces.iter().map(|f| f.iter().all(far)).collect(),
            least_cosine: params.normal_gate_deg.to_radians().cos(),
        }
    }
}

/// A measured point and its place on the surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    pub data: Vec3,
    pub face: usize,
    pub corners: [usize; 3],
    pub barycentric: [f64; 3],
    pub foot: Vec3,
    /// Smooth unit normal of the surface at the foot.
    pub normal: Vec3,
    /// Weight from uncertainty and fit.
    pub weight: f64,
}

/// Finds matches on one state of the mesh.
pub(super) struct Matcher<'a> {
    mesh: &'a Mesh,
    gate: &'a Gate,
    index: SurfaceIndex,
    normals: Vec<Vec3>,
}

impl<'a> Matcher<'a> {
    pub fn new(mesh: &'a Mesh, gate: &'a Gate) -> Result<Self, DeformError> {
        mesh.validate()?;
        let index = SurfaceIndex::new(mesh).ok_or(crate::data::MeshError::Empty {
            vertices: mesh.vertices.len(),
            faces: mesh.faces.len(),
        })?;
        Ok(Self { mesh, gate, index, normals: mesh.vertex_normals() })
    }

    /// The matches within reach that pass the gates, with Geman-McClure weights of 2.5 median
    /// absolute deviations (floor 0.15 mm); in the order of the points.
    pub fn find(&self, points: &[Point], reach: f64) -> Vec<Found> {
        let one = |p: &Point| {
            let hit = self.index.closest_within(&p.at, reach)?;
            if !self.gate.open[hit.face] {
                return None;
            }
            let corners = self.mesh.faces[hit.face].map(|v| v as usize);
            let normal: Vec3 =
                (0..3).map(|k| self.normals[corners[k]] * hit.barycentric[k]).sum();
            let normal = normal.try_normalize(1e-12)?;
            if p.normal != Vec3::zeros() && p.normal.dot(&normal) < self.gate.least_cosine {
                return None;
            }
            Some(Found {
                data: p.at,
                face: hit.face,
                corners,
                barycentric: hit.barycentric,
                foot: hit.point,
                normal,
                weight: p.weight,
            })
        };
        let found: Vec<Option<Found>> = points.par_iter().map(one).collect();
        let mut found: Vec<Found> = found.into_iter().flatten().collect();
        let misses: Vec<f64> = found.iter().map(|f| f.normal.dot(&(f.data - f.foot))).collect();
        let deviation = crate::math::mad(&misses).unwrap_or_default() / 1.4826;
        let width = (2.5 * deviation).max(0.15);
        for f in &mut found {
            let miss = (f.data - f.foot).norm();
            f.weight *= (1.0 + (miss / width).powi(2)).powi(-2);
        }
        found
    }
}

/// The matches as pairs for a rigid or similarity step.
pub(super) fn planes(found: &[Found]) -> Vec<PlanePair> {
    found
        .iter()
        .map(|f| PlanePair { point: f.data, foot: f.foot, normal: f.normal, weight: f.weight })
        .collect()
}

/// Weighted RMS distance along the normals to the same places on a moved mesh.
pub(super) fn plane_rms(found: &[Found], mesh: &Mesh) -> f64 {
    let (mut sum, mut weight) = (0.0, 1e-300);
    for f in found {
        let foot: Vec3 =
            (0..3).map(|k| mesh.vertices[f.corners[k]] * f.barycentric[k]).sum();
        sum += f.weight * f.normal.dot(&(f.data - foot)).powi(2);
        weight += f.weight;
    }
    (sum / weight).sqrt()
}

/// Area of the faces that carry matches or touch one that does, mm^2: with it a sum over points
/// becomes an integral over the surface, whatever their density.
pub(super) fn covered_area(mesh: &Mesh, found: &[Found]) -> f64 {
    let mut near = vec![false; mesh.vertices.len()];
    found.iter().flat_map(|f| f.corners).for_each(|v| near[v] = true);
    let covered = |f: &&[u32; 3]| f.iter().all(|&v| near[v as usize]);
    mesh.faces.iter().filter(covered).map(|f| area(mesh, f)).sum()
}

/// Area of one face.
pub(super) fn area(mesh: &Mesh, face: &[u32; 3]) -> f64 {
    let [a, b, c] = face.map(|i| mesh.vertices[i as usize]);
    (b - a).cross(&(c - a)).norm() / 2.0
}
