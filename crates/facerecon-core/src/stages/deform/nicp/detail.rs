//! The detail step: each measured vertex moves along its normal to where the points around it are.
//!
//! One unknown for each vertex, exact point-to-plane residuals, and the thin plate smoothing over
//! the length that the noise of the data requires. The system is well conditioned where there are
//! data, so conjugate gradients suffice.

use rayon::prelude::*;

use super::super::DeformError;
use super::laplacian::{Laplacian, position_in_row};
use super::matching::{MatchLimits, Matcher, max_local_spread_mm};
use super::measured_points::MeasuredPoint;
use super::surface_match::{SurfaceMatch, area_per_match, rms_on};
use super::{NicpParams, thin_parts};
use crate::data::{Mesh, Topology};
use crate::math::Vec3;

/// Smoothing lengths of the rounds, relative to the last one.
const ROUNDS: [f64; 3] = [1.6, 1.0, 1.0];
/// The vertices that move reach so many rings beyond the last measured vertex, so that the
/// displacement fades out.
const MARGIN_RINGS: usize = 4;
/// Points farther than this from the bent surface are outliers in this step, mm: the bending has
/// left much less.
const MAX_DISTANCE_MM: f64 = 3.0;
/// Matches with a smaller weight do not mark a vertex as measured.
const MIN_WEIGHT: f64 = 0.05;
/// Conjugate gradients: most steps, and the relative energy of the residual at which they end
/// (the heights are then known to about a thousandth).
const MAX_STEPS: usize = 300;
const TOLERANCE: f64 = 1e-6;
/// Added to the diagonal: keeps the preconditioner finite where nothing is measured.
const MIN_DIAGONAL: f64 = 1e-9;
/// Least number of rows of a product that one task computes.
const ROWS_PER_TASK: usize = 2048;

/// Refines the mesh in place; returns the robust RMS distance along the normals, mm.
pub(super) fn refine_detail(
    mesh: &mut Mesh,
    points: &[MeasuredPoint],
    limits: &MatchLimits,
    params: &NicpParams,
    report: &mut dyn FnMut(f64) -> Result<f64, DeformError>,
) -> Result<f64, DeformError> {
    let base = mesh.clone();
    let normals = base.vertex_normals();
    let laplacian = Laplacian::new(&base);
    let columns = laplacian.columns();
    let topology = Topology::new(&base);
    let mut heights = vec![0.0; base.vertices.len()];
    let (mut rms, mut matches) = (0.0, Vec::new());
    for smoothing in ROUNDS {
        let length_mm = smoothing * params.detail_mm;
        let max_spread_mm = max_local_spread_mm(length_mm);
        matches = Matcher::new(mesh, limits)?.find(points, MAX_DISTANCE_MM, max_spread_mm);
        let active = active_vertices(&matches, &topology);
        let system =
            System::new(&base, &normals, &laplacian, &columns, &matches, &active, length_mm);
        system.solve(&mut heights);
        if !heights.iter().all(|h| h.is_finite()) {
            let reason = "the solution of the detail step is not finite".to_owned();
            return Err(DeformError::Plate { reason });
        }
        for (v, h) in heights.iter().enumerate() {
            mesh.vertices[v] = base.vertices[v] + normals[v] * *h;
        }
        rms = report(rms_on(mesh, &matches))?;
    }
    thin_parts::keep_thickness(&base, &normals, &topology, mesh, &matches);
    Ok(rms)
}

/// The measured vertices and a margin around them.
fn active_vertices(matches: &[SurfaceMatch], topology: &Topology) -> Vec<bool> {
    let mut active = vec![false; topology.neighbours.len()];
    let counted = matches.iter().filter(|m| m.weight > MIN_WEIGHT);
    counted.flat_map(|m| m.corners).for_each(|v| active[v] = true);
    for _ in 0..MARGIN_RINGS {
        let last = active.clone();
        for (v, near) in topology.neighbours.iter().enumerate() {
            active[v] |= near.iter().any(|&n| last[n as usize]);
        }
    }
    active
}

/// Normal equations of the heights: `sum w (c . h - r)^2 + length^4 |L h|^2`.
///
/// The matches couple the corners of a face, the Laplacian a vertex and its ring: both matrices
/// have their values in the same positions, a row for each vertex.
struct System<'a> {
    /// Matrix of the matches, values in the positions of the Laplacian's rows.
    data: Vec<Vec<f64>>,
    /// See [`Laplacian::columns`].
    columns: &'a [Vec<f64>],
    right: Vec<f64>,
    laplacian: &'a Laplacian,
    active: &'a [bool],
    /// Weight of the bending energy.
    bending: f64,
}

impl<'a> System<'a> {
    fn new(
        base: &Mesh,
        normals: &[Vec3],
        laplacian: &'a Laplacian,
        columns: &'a [Vec<f64>],
        matches: &[SurfaceMatch],
        active: &'a [bool],
        length_mm: f64,
    ) -> Self {
        let area = area_per_match(base, matches);
        let rows = &laplacian.rows;
        let mut data: Vec<Vec<f64>> = rows.iter().map(|row| vec![0.0; row.len()]).collect();
        let mut right = vec![0.0; rows.len()];
        for m in matches {
            let closest_point = m.interpolate(&base.vertices);
            let c = [0, 1, 2].map(|k| m.barycentric[k] * m.normal.dot(&normals[m.corners[k]]));
            let (residual, weight) = (m.normal.dot(&(m.data - closest_point)), m.weight * area);
            for i in 0..3 {
                let v = m.corners[i];
                right[v] += weight * c[i] * residual;
                for j in 0..3 {
                    if let Some(at) = position_in_row(&rows[v], m.corners[j]) {
                        data[v][at] += weight * c[i] * c[j];
                    }
                }
            }
        }
        let right = masked(right, active);
        Self { data, columns, right, laplacian, active, bending: length_mm.powi(4) }
    }

    /// The matrix times `x`, which is 0 where nothing moves.
    fn times(&self, x: &[f64]) -> Vec<f64> {
        let rows = &self.laplacian.rows;
        let curvature: Vec<f64> = rows
            .par_iter()
            .with_min_len(ROWS_PER_TASK)
            .map(|row| row.iter().map(|&(j, l)| l * x[j as usize]).sum())
            .collect();
        let one = |v: usize| {
            if !self.active[v] {
                return 0.0;
            }
            let values = rows[v].iter().zip(&self.data[v]).zip(&self.columns[v]);
            values
                .map(|((&(j, _), d), t)| {
                    d * x[j as usize] + self.bending * t * curvature[j as usize]
                })
                .sum()
        };
        (0..x.len()).into_par_iter().with_min_len(ROWS_PER_TASK).map(one).collect()
    }

    fn diagonal(&self) -> Vec<f64> {
        let one = |v: usize| {
            let row = &self.laplacian.rows[v];
            let own = position_in_row(row, v).map_or(0.0, |at| self.data[v][at]);
            let bending: f64 = self.columns[v].iter().map(|t| t * t).sum();
            MIN_DIAGONAL + own + self.bending * bending
        };
        (0..self.active.len()).map(one).collect()
    }

    /// Conjugate gradients with a diagonal preconditioner, from the present heights.
    fn solve(&self, heights: &mut [f64]) {
        let right = &self.right;
        let x = masked(heights.to_vec(), self.active);
        heights.copy_from_slice(&x);
        let diagonal = self.diagonal();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        let scaled = |r: &[f64]| r.iter().zip(&diagonal).map(|(r, d)| r / d).collect::<Vec<_>>();
        let product = self.times(heights);
        let mut residual: Vec<f64> = right.iter().zip(&product).map(|(b, a)| b - a).collect();
        let mut direction = scaled(&residual);
        let mut energy = dot(&residual, &direction);
        let stop = TOLERANCE * dot(right, &scaled(right));
        for _ in 0..MAX_STEPS {
            if !(energy > stop) {
                break;
            }
            let product = self.times(&direction);
            let rate = energy / dot(&direction, &product);
            heights.iter_mut().zip(&direction).for_each(|(h, d)| *h += rate * d);
            residual.iter_mut().zip(&product).for_each(|(r, p)| *r -= rate * p);
            let next = scaled(&residual);
            let after = dot(&residual, &next);
            let keep = after / energy;
            direction.iter_mut().zip(&next).for_each(|(d, n)| *d = n + keep * *d);
            energy = after;
        }
    }
}

/// `x` with zeros at the vertices that do not move.
fn masked(mut x: Vec<f64>, active: &[bool]) -> Vec<f64> {
    x.iter_mut().zip(active).filter(|(_, a)| !**a).for_each(|(v, _)| *v = 0.0);
    x
}

#[cfg(test)]
mod tests {
    use super::super::measured_points::thin_over_list;
    use super::super::surface_match::fixtures::{match_at, sheet};
    use super::*;
    use crate::data::Cloud;

    #[test]
    fn the_solution_satisfies_the_equations() {
        let mesh = sheet(15, 1.0);
        let normals = mesh.vertex_normals();
        let laplacian = Laplacian::new(&mesh);
        let columns = laplacian.columns();
        let height = |p: &Vec3| (p.x * 0.8).sin() + 0.3 * p.y;
        let matches: Vec<SurfaceMatch> = (0..225)
            .map(|v| match_at(&mesh, v, mesh.vertices[v] + Vec3::z() * height(&mesh.vertices[v])))
            .collect();
        let mut active = vec![true; 225];
        active[7] = false;
        let system = System::new(&mesh, &normals, &laplacian, &columns, &matches, &active, 0.7);
        let mut heights = vec![0.0; 225];
        system.solve(&mut heights);
        let product = system.times(&heights);
        let worst = (0..225).map(|v| (product[v] - system.right[v]).abs()).fold(0.0, f64::max);
        assert!(worst < 0.05, "{worst}");
        assert_eq!(heights[7], 0.0);
        // naive twin of the product: data and bending energy from their definitions
        for v in [0, 100, 224] {
            let mut unit = vec![0.0; 225];
            unit[v] = 1.0;
            let bending: f64 = laplacian
                .rows
                .iter()
                .flatten()
                .filter(|(j, _)| *j as usize == v)
                .map(|(_, l)| l * l)
                .sum::<f64>()
                * 0.7f64.powi(4);
            let data = area_per_match(&mesh, &matches);
            assert!((system.times(&unit)[v] - data - bending).abs() < 1e-9);
        }
    }

    #[test]
    fn vertices_reach_the_measured_surface_and_unmeasured_ones_stay() {
        let mut mesh = sheet(40, 1.0);
        let base = mesh.clone();
        let bump = |p: &Vec3| 0.6 * (-((p.x - 20.0).powi(2) + (p.y - 20.0).powi(2)) / 18.0).exp();
        let measured = |p: &&Vec3| (**p - Vec3::new(20.0, 20.0, 0.0)).norm() < 12.0;
        let positions = base.vertices.iter().filter(measured).map(|p| p + Vec3::z() * bump(p));
        let points = MeasuredPoint::from_cloud(&Cloud::from_points(positions.collect()), 0.1);
        let points = thin_over_list(&points, 100_000);
        let params = NicpParams::default();
        let limits = MatchLimits::new(&mesh, &params);
        let mut rounds = 0;
        let mut report = |error: f64| {
            rounds += 1;
            Ok(error)
        };
        let rms = refine_detail(&mut mesh, &points, &limits, &params, &mut report).unwrap();
        assert_eq!(rounds, ROUNDS.len());
        assert!(rms < 0.05, "{rms}");
        assert!((mesh.vertices[20 * 40 + 20].z - 0.6).abs() < 0.1);
        assert_eq!(mesh.vertices[0], base.vertices[0]);
    }
}
