//! Which point of the surface each measured point belongs to, and how much it counts.

use rayon::prelude::*;
use std::collections::HashMap;

use super::super::DeformError;
use super::{NicpParams, islands};
use crate::data::{Cloud, Mesh, Topology};
use crate::math::{PlanePair, Similarity, Vec3, mad, median};
use crate::spatial::SurfaceIndex;

/// A measured point; the normal is zero where unknown.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    pub at: Vec3,
    pub normal: Vec3,
    /// Weight from the point's own uncertainty; 1 for the typical point.
    pub weight: f64,
    /// Cell of space it lies in, for comparing it with its neighbours.
    pub cell: u32,
    /// The small piece of the data it belongs to; none in the large pieces.
    pub island: Option<u32>,
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
        let mut points: Vec<Self> = (0..n)
            .map(|i| Self {
                at: data.points[i],
                normal: if data.normals.len() == n { data.normals[i] } else { Vec3::zeros() },
                weight: (typical / sigma(i)).powi(2).clamp(0.02, 4.0),
                cell: 0,
                island: None,
            })
            .filter(|p| p.at.iter().chain(p.normal.iter()).all(|c| c.is_finite()))
            .collect();
        islands::mark(&mut points);
        points
    }

    pub fn transformed(&self, target_from_source: &Similarity) -> Self {
        Self {
            at: target_from_source.apply(&self.at),
            normal: target_from_source.rotate(&self.normal),
            ..*self
        }
    }
}

/// About `count` points, evenly over space: one in each cell of a grid as fine as needed.
pub(super) fn thin(points: &[Point], count: usize) -> Vec<Point> {
    if points.len() <= count {
        return in_cells(points.to_vec());
    }
    let mut cell = cell_for(points, 1.0) * (points.len() as f64 / count as f64).sqrt();
    for _ in 0..3 {
        let got = occupied(points, cell).1.len() as f64;
        // cells on a surface: their number goes with the square of the length
        cell *= (got / count as f64).sqrt().clamp(0.3, 3.0);
    }
    in_cells(occupied(points, cell).1.iter().map(|&i| points[i]).collect())
}

/// At most `count` points, evenly over the list.
pub(super) fn thin_evenly(points: &[Point], count: usize) -> Vec<Point> {
    if points.len() <= count {
        return in_cells(points.to_vec());
    }
    in_cells((0..count).map(|k| points[k * points.len() / count]).collect())
}

/// Points that count as one another's neighbours, about.
const NEIGHBOURHOOD: f64 = 20.0;

fn in_cells(mut points: Vec<Point>) -> Vec<Point> {
    let cell = cell_of(&points, NEIGHBOURHOOD);
    let (cells, _) = occupied(&points, cell);
    points.iter_mut().zip(cells).for_each(|(p, c)| p.cell = c);
    points
}

/// The cell that holds about `count` points on average.
pub(super) fn cell_of(points: &[Point], count: f64) -> f64 {
    let mut cell = cell_for(points, count);
    for _ in 0..3 {
        let got = points.len() as f64 / occupied(points, cell).1.len().max(1) as f64;
        cell *= (count / got.max(1e-9)).sqrt().clamp(0.3, 3.0);
    }
    cell
}

/// First guess at the cell that holds `count` points of a surface.
fn cell_for(points: &[Point], count: f64) -> f64 {
    let low = points.iter().fold(Vec3::repeat(f64::INFINITY), |a, p| a.inf(&p.at));
    let high = points.iter().fold(Vec3::repeat(f64::NEG_INFINITY), |a, p| a.sup(&p.at));
    let size = if points.is_empty() { 1.0 } else { (high - low).norm() };
    (0.6 * size * (count / points.len().max(1) as f64).sqrt()).max(1e-9)
}

/// The cell of each point, counted from 0 in their order, and the first point of each cell.
pub(super) fn occupied(points: &[Point], cell: f64) -> (Vec<u32>, Vec<usize>) {
    let mut seen: HashMap<[i64; 3], u32> = HashMap::new();
    let mut first = Vec::new();
    let mut cells = Vec::with_capacity(points.len());
    for (i, p) in points.iter().enumerate() {
        let k = p.at.map(|c| (c / cell).floor() as i64);
        let id = *seen.entry([k.x, k.y, k.z]).or_insert_with(|| {
            first.push(i);
            first.len() as u32 - 1
        });
        cells.push(id);
    }
    (cells, first)
}

/// What a match must satisfy.
pub(super) struct Gate {
    /// Faces that may be matched: those away from an open border.
    open: Vec<bool>,
    normal_gate: f64,
}

impl Gate {
    pub fn new(mesh: &Mesh, params: &NicpParams) -> Self {
        let rings = Topology::new(mesh).rings_from_border();
        let far = |v: &u32| rings[*v as usize] as usize >= params.border_rings;
        Self {
            open: mesh.faces.iter().map(|f| f.iter().all(far)).collect(),
            normal_gate: params.normal_gate_deg.to_radians(),
        }
    }

    /// Least cosine between the normals of a point and its foot: what lies farther off must agree
    /// better. Beside the head's silhouette the nearest surface looks sideways, and what is
    /// measured there looks at the camera.
    fn least_cosine(&self, distance: f64) -> f64 {
        (self.normal_gate / (1.0 + distance / FAR_MM)).cos()
    }
}

/// At this distance the gate of the normals is half as wide, mm.
const FAR_MM: f64 = 20.0;

/// A measured point and its place on the surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    pub data: Vec3,
    pub corners: [usize; 3],
    pub barycentric: [f64; 3],
    pub foot: Vec3,
    /// Smooth unit normal of the surface at the foot.
    pub normal: Vec3,
    /// Weight from uncertainty and fit.
    pub weight: f64,
    /// Cell of the measured point.
    pub cell: u32,
    /// Its island.
    pub island: Option<u32>,
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

    /// The matches within reach that pass the gates, weighted; in the order of the points.
    /// Neighbourhoods whose points disagree by more than `calm_mm` count little.
    pub fn find(&self, points: &[Point], reach: f64, calm_mm: f64) -> Vec<Found> {
        let one = |p: &Point| {
            let hit = self.index.closest_within(&p.at, reach)?;
            if !self.gate.open[hit.face] {
                return None;
            }
            let corners = self.mesh.faces[hit.face].map(|v| v as usize);
            let normal: Vec3 = (0..3).map(|k| self.normals[corners[k]] * hit.barycentric[k]).sum();
            let normal = normal.try_normalize(1e-12)?;
            let turned = self.gate.least_cosine(hit.distance);
            if p.normal != Vec3::zeros() && p.normal.dot(&normal) < turned {
                return None;
            }
            Some(Found {
                data: p.at,
                corners,
                barycentric: hit.barycentric,
                foot: hit.point,
                normal,
                weight: p.weight,
                cell: p.cell,
                island: p.island,
            })
        };
        let found: Vec<Option<Found>> = points.par_iter().map(one).collect();
        let mut found: Vec<Found> = found.into_iter().flatten().collect();
        islands::forget(&mut found);
        forget_outliers(&mut found, calm_mm);
        found
    }
}

/// Geman-McClure weights about the median miss of each point's neighbourhood: a point that
/// disagrees with its neighbours is an outlier, a region that disagrees with the surface is news.
/// A region that disagrees within itself by more than `calm_mm` (ears, hair) is no measurement of
/// this surface yet, and counts little.
/// What hardly counts goes, as there may be nothing better to hold against it.
fn forget_outliers(found: &mut Vec<Found>, calm_mm: f64) {
    let miss = |f: &Found| f.normal.dot(&(f.data - f.foot));
    let count = found.iter().map(|f| f.cell as usize + 1).max().unwrap_or(0);
    let mut cells = vec![Vec::new(); count];
    found.iter().for_each(|f| cells[f.cell as usize].push(miss(f)));
    let all: Vec<f64> = found.iter().map(miss).collect();
    let everywhere = mad(&all).unwrap_or_default();
    let local: Vec<(f64, f64)> = cells
        .iter()
        .map(|cell| match (median(cell), mad(cell)) {
            (Some(middle), Some(spread)) if cell.len() >= 7 => (middle, spread),
            _ => (0.0, everywhere),
        })
        .collect();
    found.retain_mut(|f| {
        let (middle, spread) = local[f.cell as usize];
        let width = WIDTH * spread.max(FLOOR_MM);
        let calm = (1.0 + (spread / calm_mm).powi(2)).powi(-2);
        let trust = calm * (1.0 + ((miss(f) - middle) / width).powi(2)).powi(-2);
        f.weight *= trust;
        trust > LEAST_TRUST
    });
}

/// Points trusted less are left out.
const LEAST_TRUST: f64 = 0.05;

/// Width of the weights in standard deviations of the neighbourhood.
const WIDTH: f64 = 2.5;
/// Least standard deviation of a neighbourhood, mm.
const FLOOR_MM: f64 = 0.06;

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
        let foot: Vec3 = (0..3).map(|k| mesh.vertices[f.corners[k]] * f.barycentric[k]).sum();
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
