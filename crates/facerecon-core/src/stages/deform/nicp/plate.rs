//! The thin plate on a mesh: displacements that bend as little as the data allow.
//!
//! The bending energy is the integral of the squared Laplacian of the displacement, so stiffness
//! is a length: where the data weigh 1 per mm^2, a wave exp(i k x) of the displacement comes out
//! at 1 / (1 + (stiffness k)^4), whatever the mesh's resolution.

use faer::linalg::solvers::Solve;
use faer::sparse::linalg::solvers::{Llt, SymbolicLlt};
use faer::sparse::{SparseColMat, SymbolicSparseColMat};
use faer::{Mat, Side};

use super::super::{DeformError, LandmarkTarget};
use super::laplacian::Laplacian;
use super::surface_match::{SurfaceMatch, area_per_match};
use crate::data::Mesh;
use crate::math::Vec3;

/// Length over which the displacement fades beyond the data, mm: about the depth of half a head, so
/// that its back keeps its shape.
const FADE_MM: f64 = 80.0;
/// Length over which a slope of the displacement levels out beyond the data, mm: a plate alone
/// would continue the slope at the last data to the border of the neck. Shorter
/// lengths flatten what is measured.
const LEVEL_MM: f64 = 20.0;
/// Bounds of the cotangents: below, so that no edge has a negative weight; above, for triangles
/// without area (3 and 87 degrees).
const COTANGENT_RANGE: (f64, f64) = (0.05, 20.0);
/// Standard deviation of the distance of a landmark's vertex from its measured position that the
/// bending leaves, mm: a landmark as uncertain as this is followed half way.
const LANDMARK_PRIOR_MM: f64 = 3.0;
/// A force on a plate of stiffness `s` (a length) that rests on data of weight 1 per mm^2 moves it
/// by the force over this times `s^2` (Hertz 1884).
const POINT_FORCE: f64 = 8.0;
/// Least standard deviation of a landmark, mm: keeps its weight finite.
const MIN_LANDMARK_SIGMA_MM: f64 = 0.1;
/// Solutions with one factorisation; more are closer to the coupled solution.
const REPEATS: usize = 4;
/// Weight of the distance to the point itself relative to that to the plane: keeps the surface from
/// sliding.
const POINT_WEIGHT: f64 = 0.03;

/// One column of a matrix as `(row, value)`.
type Column = Vec<(u32, f64)>;

/// What the displacements are fitted to.
#[derive(Clone, Copy)]
pub(super) struct PlateData<'a> {
    pub matches: &'a [SurfaceMatch],
    /// Vertices of landmarks with their measured positions.
    pub landmarks: &'a [LandmarkTarget],
}

/// The bending system of one mesh at rest; factorised for each set of matches.
pub(super) struct Plate {
    symbolic: SymbolicSparseColMat<usize>,
    /// Bending energy, lower triangle, in the order of `symbolic`.
    energy: Vec<f64>,
    order: SymbolicLlt<usize>,
}

impl Plate {
    pub fn new(mesh: &Mesh) -> Result<Self, DeformError> {
        let laplacian = Laplacian::new(mesh);
        let n = mesh.vertices.len();
        let (starts, indices, energy) = merged(energy_columns(mesh, &laplacian));
        // sorted and in range by construction, which is all that this checks
        let symbolic = SymbolicSparseColMat::new_checked(n, n, starts, None, indices);
        let order = SymbolicLlt::try_new(symbolic.as_ref(), Side::Lower)
            .map_err(|e| unsolved(format!("{e:?}")))?;
        Ok(Self { symbolic, energy, order })
    }

    /// One round: updates `displacements` of the vertices of `rest` to fit the data.
    ///
    /// The three coordinates are decoupled: each match pulls toward its tangent plane at the present
    /// position, and this is repeated with the same factorisation. The repeats converge to the
    /// coupled point-to-plane solution at a thirtieth of its cost.
    pub fn bend(
        &self,
        rest: &Mesh,
        displacements: &mut [Vec3],
        data: &PlateData<'_>,
        stiffness_mm: f64,
    ) -> Result<(), DeformError> {
        let area = area_per_match(rest, data.matches);
        let matrix =
            SparseColMat::new(self.symbolic.clone(), self.system_values(data, area, stiffness_mm));
        let factor = Llt::try_new_with_symbolic(self.order.clone(), matrix.as_ref(), Side::Lower)
            .map_err(|e| unsolved(format!("{e:?}")))?;
        for _ in 0..REPEATS {
            let mut right = self.right_side(rest, displacements, data, area, stiffness_mm);
            factor.solve_in_place(right.as_mut());
            for (v, d) in displacements.iter_mut().enumerate() {
                *d = Vec3::new(right[(v, 0)], right[(v, 1)], right[(v, 2)]);
            }
        }
        if displacements.iter().all(|d| d.iter().all(|c| c.is_finite())) {
            Ok(())
        } else {
            Err(unsolved("the solution is not finite".to_owned()))
        }
    }

    /// The values of the system's matrix: bending energy, matches and landmarks.
    fn system_values(&self, data: &PlateData<'_>, area: f64, stiffness_mm: f64) -> Vec<f64> {
        let mut values: Vec<f64> = self.energy.iter().map(|e| e * stiffness_mm.powi(4)).collect();
        let starts = self.symbolic.col_ptr();
        let indices = self.symbolic.row_idx();
        let mut add = |i: usize, j: usize, value: f64| {
            let (column, row) = (i.min(j), i.max(j));
            let range = starts[column]..starts[column + 1];
            if let Ok(at) = indices[range.clone()].binary_search(&row) {
                values[range.start + at] += value;
            }
        };
        for m in data.matches {
            for a in 0..3 {
                for b in 0..=a {
                    let value = m.weight * area * m.barycentric[a] * m.barycentric[b];
                    add(m.corners[a], m.corners[b], value);
                }
            }
        }
        for l in data.landmarks {
            add(l.vertex, l.vertex, landmark_weight(l, stiffness_mm));
        }
        values
    }

    /// The right-hand side: where the matches and landmarks pull at the present displacements.
    fn right_side(
        &self,
        rest: &Mesh,
        displacements: &[Vec3],
        data: &PlateData<'_>,
        area: f64,
        stiffness_mm: f64,
    ) -> Mat<f64> {
        let mut right = Mat::<f64>::zeros(displacements.len(), 3);
        for m in data.matches {
            let present = m.interpolate(displacements);
            let residual = m.data - m.interpolate(&rest.vertices) - present;
            let along_normal = m.normal * m.normal.dot(&residual);
            let target = present + along_normal * (1.0 - POINT_WEIGHT) + residual * POINT_WEIGHT;
            for k in 0..3 {
                for axis in 0..3 {
                    right[(m.corners[k], axis)] +=
                        m.weight * area * m.barycentric[k] * target[axis];
                }
            }
        }
        for l in data.landmarks {
            let weight = landmark_weight(l, stiffness_mm);
            let displacement = l.position - rest.vertices[l.vertex];
            for axis in 0..3 {
                right[(l.vertex, axis)] += weight * displacement[axis];
            }
        }
        right
    }
}

/// Weight of a landmark: its share of the way follows from its standard deviation, whatever the
/// stiffness.
fn landmark_weight(landmark: &LandmarkTarget, stiffness_mm: f64) -> f64 {
    let ratio = LANDMARK_PRIOR_MM / landmark.sigma_mm.max(MIN_LANDMARK_SIGMA_MM);
    POINT_FORCE * (stiffness_mm * ratio).powi(2)
}

/// The lower triangle of the bending energy and of what holds the displacement beyond the data, by
/// columns, unsorted, with several entries for one value. All edges have an entry.
fn energy_columns(mesh: &Mesh, laplacian: &Laplacian) -> Vec<Column> {
    let mut columns: Vec<Column> = vec![Vec::new(); mesh.vertices.len()];
    for row in &laplacian.rows {
        for &(i, a) in row {
            columns[i as usize]
                .extend(row.iter().filter(|(j, _)| *j >= i).map(|&(j, b)| (j, a * b)));
        }
    }
    for (v, column) in columns.iter_mut().enumerate() {
        let fade = laplacian.areas[v].max(1e-6) / FADE_MM.powi(4);
        column.push((v as u32, fade));
    }
    for face in &mesh.faces {
        for k in 0..3 {
            let (i, j) = (face[k], face[(k + 1) % 3]);
            let level = cotangent(mesh, i, j, face[(k + 2) % 3]) / (2.0 * LEVEL_MM.powi(2));
            columns[i as usize].push((i, level));
            columns[j as usize].push((j, level));
            columns[i.min(j) as usize].push((i.max(j), -level));
        }
    }
    columns
}

/// Cotangent of the angle of a face at `apex` across the edge `i` `j`, bounded. Half of it weighs
/// the squared difference along that edge in the integral of the squared gradient (Pinkall and
/// Polthier 1993).
fn cotangent(mesh: &Mesh, i: u32, j: u32, apex: u32) -> f64 {
    let at = |v: u32| mesh.vertices[v as usize];
    let (a, b) = (at(i) - at(apex), at(j) - at(apex));
    (a.dot(&b) / a.cross(&b).norm().max(1e-9)).clamp(COTANGENT_RANGE.0, COTANGENT_RANGE.1)
}

/// The columns as compressed sparse columns: starts, row indices, values; equal rows are added.
fn merged(mut columns: Vec<Column>) -> (Vec<usize>, Vec<usize>, Vec<f64>) {
    let mut starts = vec![0usize];
    let (mut indices, mut values): (Vec<usize>, Vec<f64>) = (Vec::new(), Vec::new());
    for column in &mut columns {
        column.sort_by_key(|e| e.0); // stable: equal rows add in a fixed order
        for &(i, value) in column.iter() {
            let begun = indices.len() > starts[starts.len() - 1];
            match values.last_mut() {
                Some(last) if begun && indices[indices.len() - 1] == i as usize => *last += value,
                _ => {
                    indices.push(i as usize);
                    values.push(value);
                }
            }
        }
        starts.push(indices.len());
    }
    (starts, indices, values)
}

fn unsolved(reason: String) -> DeformError {
    DeformError::Plate { reason }
}

#[cfg(test)]
mod tests {
    use super::super::surface_match::fixtures::{match_at, sheet};
    use super::*;

    fn bent(
        matches: &[SurfaceMatch],
        landmarks: &[LandmarkTarget],
        stiffness_mm: f64,
    ) -> Vec<Vec3> {
        let rest = sheet(21, 2.0);
        let mut displacements = vec![Vec3::zeros(); rest.vertices.len()];
        let data = PlateData { matches, landmarks };
        Plate::new(&rest).unwrap().bend(&rest, &mut displacements, &data, stiffness_mm).unwrap();
        displacements
    }

    /// Matches at every vertex of the sheet, with heights from `height`.
    fn matches_at_heights(height: impl Fn(&Vec3) -> f64) -> Vec<SurfaceMatch> {
        let rest = sheet(21, 2.0);
        let lifted = |p: &Vec3| p + Vec3::z() * height(p);
        (0..441).map(|v| match_at(&rest, v, lifted(&rest.vertices[v]))).collect()
    }

    #[test]
    fn a_common_shift_is_followed_at_any_stiffness() {
        for stiffness_mm in [0.5, 3.0, 10.0] {
            let displacements = bent(&matches_at_heights(|_| 1.5), &[], stiffness_mm);
            for d in displacements {
                assert!((d - Vec3::z() * 1.5).norm() < 0.01, "{stiffness_mm}: {d}");
            }
        }
    }

    #[test]
    fn a_wave_is_damped_as_its_length_and_the_stiffness_say() {
        let wave_number = std::f64::consts::TAU / 20.0;
        let matches = matches_at_heights(|p| (wave_number * (p.x - 20.0)).cos());
        for stiffness_mm in [1.0, 3.0, 6.0] {
            let displacements = bent(&matches, &[], stiffness_mm);
            let expected = 1.0 / (1.0 + f64::powi(stiffness_mm * wave_number, 4));
            let centre = displacements[10 * 21 + 10].z;
            assert!((centre - expected).abs() < 0.12, "{stiffness_mm}: {centre} {expected}");
        }
    }

    #[test]
    fn a_landmark_pulls_its_vertex() {
        let rest = sheet(21, 2.0);
        let v = 10 * 21 + 10;
        let goal = rest.vertices[v] + Vec3::new(0.0, 1.0, 2.0);
        let landmark = LandmarkTarget { vertex: v, position: goal, sigma_mm: 1.0 };
        let displacements = bent(&[], &[landmark], 1.0);
        assert!((rest.vertices[v] + displacements[v] - goal).norm() < 0.2, "{}", displacements[v]);
        assert!(displacements.iter().all(|d| d.norm() < 2.4), "no vertex moves farther");
    }
}
