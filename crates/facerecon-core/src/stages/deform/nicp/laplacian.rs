//! The discrete Laplacian of a mesh, scaled so that its squared norm is the bending energy.

use rayon::prelude::*;

use super::surface_match::face_area;
use crate::data::{Mesh, Topology};

/// Weight of the bending energy at vertices on an open border relative to inner ones: the border
/// bends almost freely, as nothing beyond it would resist. 0 would leave the border
/// undetermined.
const BORDER_STIFFNESS: f64 = 0.05;
/// Greatest tangent of half an angle at a vertex: bounds the weights of triangles without area
/// (20 is an angle of 174 degrees).
const MAX_HALF_TANGENT: f64 = 20.0;

/// A sparse matrix with one row for each vertex.
pub(super) struct Laplacian {
    /// For each vertex its row as `(column, value)`: neighbours in ascending order, itself last.
    pub rows: Vec<Vec<(u32, f64)>>,
    /// Area of each vertex, mm^2.
    pub areas: Vec<f64>,
}

impl Laplacian {
    /// Mean value weights (Floater 2003): positive, and exact for linear functions on flat parts,
    /// so that uneven triangles do not bend a plate that is only tilted.
    pub fn new(mesh: &Mesh) -> Self {
        let topology = Topology::new(mesh);
        let (mut rows, areas) = mean_value_weights(mesh, &topology);
        for (v, row) in rows.iter_mut().enumerate() {
            let total: f64 = row.iter().map(|r| r.1).sum();
            if !(total > 0.0) {
                row.clear();
                continue;
            }
            let centre = mesh.vertices[v];
            let squared_radius: f64 = row
                .iter()
                .map(|r| r.1 / total * (mesh.vertices[r.0 as usize] - centre).norm_squared())
                .sum();
            // mean over the ring - centre = squared radius / 4 * Laplacian
            let stiffness = if topology.border[v] { BORDER_STIFFNESS } else { 1.0 };
            let scale = stiffness * 4.0 / squared_radius.max(1e-9) * areas[v].sqrt();
            row.iter_mut().for_each(|r| r.1 *= scale / total);
            row.push((v as u32, -scale));
        }
        Self { rows, areas }
    }

    /// The values of each column, in the same positions as those of the row: neighbourhood is
    /// mutual.
    pub fn columns(&self) -> Vec<Vec<f64>> {
        let value = |row: u32, column: usize| {
            let row = &self.rows[row as usize];
            position_in_row(row, column).map_or(0.0, |at| row[at].1)
        };
        let column = |v: usize| self.rows[v].iter().map(|&(j, _)| value(j, v)).collect();
        (0..self.rows.len()).into_par_iter().map(column).collect()
    }
}

/// For each vertex its neighbours with mean value weights, and its area.
fn mean_value_weights(mesh: &Mesh, topology: &Topology) -> (Vec<Vec<(u32, f64)>>, Vec<f64>) {
    let mut rows: Vec<Vec<(u32, f64)>> =
        topology.neighbours.iter().map(|near| near.iter().map(|&j| (j, 0.0)).collect()).collect();
    let mut areas = vec![0.0; mesh.vertices.len()];
    for face in &mesh.faces {
        let third = face_area(mesh, face) / 3.0;
        for k in 0..3 {
            let [v, a, b] = [face[k], face[(k + 1) % 3], face[(k + 2) % 3]];
            areas[v as usize] += third;
            let (ea, eb) = (
                mesh.vertices[a as usize] - mesh.vertices[v as usize],
                mesh.vertices[b as usize] - mesh.vertices[v as usize],
            );
            let (cross, dot) = (ea.cross(&eb).norm(), ea.dot(&eb));
            let half_tangent =
                (cross / (ea.norm() * eb.norm() + dot).max(1e-12)).min(MAX_HALF_TANGENT);
            for (j, edge) in [(a, ea), (b, eb)] {
                if let Ok(at) = rows[v as usize].binary_search_by_key(&j, |r| r.0) {
                    rows[v as usize][at].1 += half_tangent / edge.norm().max(1e-6);
                }
            }
        }
    }
    (rows, areas)
}

/// Position of a column's value in a row of the Laplacian.
pub(super) fn position_in_row(row: &[(u32, f64)], column: usize) -> Option<usize> {
    let last = row.len().checked_sub(1)?;
    if row[last].0 as usize == column {
        return Some(last);
    }
    row[..last].binary_search_by_key(&column, |r| r.0 as usize).ok()
}

#[cfg(test)]
mod tests {
    use super::super::surface_match::fixtures::sheet;
    use super::*;

    fn applied(laplacian: &Laplacian, f: &[f64]) -> Vec<f64> {
        let row = |r: &Vec<(u32, f64)>| r.iter().map(|(j, l)| l * f[*j as usize]).sum();
        laplacian.rows.iter().map(row).collect()
    }

    #[test]
    fn it_vanishes_on_linear_functions_and_measures_the_curvature_of_others() {
        let mesh = sheet(9, 2.0);
        let laplacian = Laplacian::new(&mesh);
        let border = Topology::new(&mesh).border;
        let linear: Vec<f64> = mesh.vertices.iter().map(|p| 3.0 * p.x - p.y + 4.0).collect();
        let bowl: Vec<f64> = mesh.vertices.iter().map(|p| p.x * p.x + p.y * p.y).collect();
        let (flat, curved) = (applied(&laplacian, &linear), applied(&laplacian, &bowl));
        for v in (0..81).filter(|&v| !border[v]) {
            assert!(flat[v].abs() < 1e-9, "{}", flat[v]);
            // the Laplacian of x^2 + y^2 is 4, times the root of the vertex' area of 4 mm^2
            assert!((curved[v] - 8.0).abs() < 0.1, "{}", curved[v]);
        }
        assert!((laplacian.areas.iter().sum::<f64>() - 256.0).abs() < 1e-9);
    }

    #[test]
    fn columns_are_the_transpose() {
        let laplacian = Laplacian::new(&sheet(5, 1.0));
        let columns = laplacian.columns();
        for v in 0..25 {
            for (&(j, _), value) in laplacian.rows[v].iter().zip(&columns[v]) {
                let row = &laplacian.rows[j as usize];
                assert_eq!(*value, row[position_in_row(row, v).unwrap()].1);
            }
        }
        assert_eq!(position_in_row(&laplacian.rows[0], 24), None);
        assert_eq!(position_in_row(&[], 0), None);
    }
}
