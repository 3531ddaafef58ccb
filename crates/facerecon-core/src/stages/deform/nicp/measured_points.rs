//! The measured points as non-rigid ICP uses them: weighted, thinned, and sorted into grid cells.

use std::collections::HashMap;

use crate::data::Cloud;
use crate::math::{Similarity, Vec3, median};

/// A measured point; the normal is zero where unknown.
#[derive(Clone, Copy, Debug)]
pub(super) struct MeasuredPoint {
    pub position: Vec3,
    pub normal: Vec3,
    /// Weight from the point's own uncertainty; 1 for the typical point.
    pub weight: f64,
    /// Grid cell, for comparing the point with its neighbours.
    pub cell: u32,
    /// Number of the small component of the data it belongs to; `None` in the large ones.
    pub small_component: Option<u32>,
}

/// Bounds of a point's weight: a point that is far noisier than the rest still counts a little,
/// and no point counts for more than four.
const WEIGHT_RANGE: (f64, f64) = (0.02, 4.0);

/// Points of a neighbourhood (a grid cell), on average: enough for a median and a deviation.
const NEIGHBOURHOOD_POINTS: f64 = 20.0;

/// Diameter of a grid cell that holds one point, relative to the diagonal of the bounding box over
/// the root of the number of points: the first guess for points on a surface.
const FIRST_CELL: f64 = 0.6;
/// Corrections of the cell size after the first guess, and the bounds of the factor of each.
const CELL_CORRECTIONS: usize = 3;
const CELL_FACTOR: (f64, f64) = (0.3, 3.0);

impl MeasuredPoint {
    /// The points of a cloud whose numbers are finite. `default_sigma_mm` is the standard deviation
    /// of points without a known one.
    pub fn from_cloud(data: &Cloud, default_sigma_mm: f64) -> Vec<Self> {
        let n = data.points.len();
        let sigma = |i: usize| match data.sigmas.get(i) {
            Some(s) if *s > 0.0 && s.is_finite() && data.sigmas.len() == n => *s,
            _ => default_sigma_mm,
        };
        let typical = median(&(0..n).map(sigma).collect::<Vec<_>>()).unwrap_or(default_sigma_mm);
        (0..n)
            .map(|i| Self {
                position: data.points[i],
                normal: if data.normals.len() == n { data.normals[i] } else { Vec3::zeros() },
                weight: (typical / sigma(i)).powi(2).clamp(WEIGHT_RANGE.0, WEIGHT_RANGE.1),
                cell: 0,
                small_component: None,
            })
            .filter(|p| p.position.iter().chain(p.normal.iter()).all(|c| c.is_finite()))
            .collect()
    }

    pub fn transformed(&self, target_from_source: &Similarity) -> Self {
        Self {
            position: target_from_source.apply(&self.position),
            normal: target_from_source.rotate(&self.normal),
            ..*self
        }
    }
}

/// About `count` points, evenly over space: one in each cell of a grid.
pub(super) fn thin_over_space(points: &[MeasuredPoint], count: usize) -> Vec<MeasuredPoint> {
    if points.len() <= count {
        return with_cells(points.to_vec());
    }
    let mut cell = first_cell_size(points, 1.0) * (points.len() as f64 / count as f64).sqrt();
    for _ in 0..CELL_CORRECTIONS {
        let got = grid_cells(points, cell).1.len() as f64;
        // on a surface the number of cells is proportional to the inverse square of their size
        cell *= (got / count as f64).sqrt().clamp(CELL_FACTOR.0, CELL_FACTOR.1);
    }
    with_cells(grid_cells(points, cell).1.iter().map(|&i| points[i]).collect())
}

/// At most `count` points, evenly over the list.
pub(super) fn thin_over_list(points: &[MeasuredPoint], count: usize) -> Vec<MeasuredPoint> {
    if points.len() <= count {
        return with_cells(points.to_vec());
    }
    with_cells((0..count).map(|k| points[k * points.len() / count]).collect())
}

/// Sets the neighbourhood of each point.
fn with_cells(mut points: Vec<MeasuredPoint>) -> Vec<MeasuredPoint> {
    let cell = cell_size(&points, NEIGHBOURHOOD_POINTS);
    let (cells, _) = grid_cells(&points, cell);
    points.iter_mut().zip(cells).for_each(|(p, c)| p.cell = c);
    points
}

/// Size of the grid cells that hold about `count` points on average.
pub(super) fn cell_size(points: &[MeasuredPoint], count: f64) -> f64 {
    let mut cell = first_cell_size(points, count);
    for _ in 0..CELL_CORRECTIONS {
        let got = points.len() as f64 / grid_cells(points, cell).1.len().max(1) as f64;
        cell *= (count / got.max(1e-9)).sqrt().clamp(CELL_FACTOR.0, CELL_FACTOR.1);
    }
    cell
}

fn first_cell_size(points: &[MeasuredPoint], count: f64) -> f64 {
    let low = points.iter().fold(Vec3::repeat(f64::INFINITY), |a, p| a.inf(&p.position));
    let high = points.iter().fold(Vec3::repeat(f64::NEG_INFINITY), |a, p| a.sup(&p.position));
    let diagonal = if points.is_empty() { 1.0 } else { (high - low).norm() };
    (FIRST_CELL * diagonal * (count / points.len().max(1) as f64).sqrt()).max(1e-9)
}

/// The grid coordinates of a position.
pub(super) fn grid_key(position: &Vec3, cell: f64) -> [i64; 3] {
    let k = position.map(|c| (c / cell).floor() as i64);
    [k.x, k.y, k.z]
}

/// The cell of each point, numbered in the order of the points, and the first point of each cell.
fn grid_cells(points: &[MeasuredPoint], cell: f64) -> (Vec<u32>, Vec<usize>) {
    let mut numbers: HashMap<[i64; 3], u32> = HashMap::new();
    let mut first = Vec::new();
    let mut cells = Vec::with_capacity(points.len());
    for (i, p) in points.iter().enumerate() {
        let number = *numbers.entry(grid_key(&p.position, cell)).or_insert_with(|| {
            first.push(i);
            first.len() as u32 - 1
        });
        cells.push(number);
    }
    (cells, first)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square sheet of `n` x `n` points, 1 mm apart.
    fn sheet(n: usize) -> Cloud {
        let point = |i: usize| Vec3::new((i % n) as f64, (i / n) as f64, 0.0);
        Cloud::from_points((0..n * n).map(point).collect())
    }

    #[test]
    fn weights_follow_the_standard_deviations_within_bounds() {
        let mut cloud = sheet(3);
        cloud.sigmas = vec![0.1; 9];
        (cloud.sigmas[0], cloud.sigmas[1], cloud.sigmas[2]) = (0.2, 100.0, 0.0001);
        cloud.sigmas[3] = f64::NAN;
        let weights: Vec<f64> =
            MeasuredPoint::from_cloud(&cloud, 0.2).iter().map(|p| p.weight).collect();
        for (weight, expected) in weights.iter().zip([0.25, 0.02, 4.0, 0.25, 1.0]) {
            assert!((weight - expected).abs() < 1e-9, "{weights:?}");
        }
        cloud.points[4].x = f64::NAN;
        assert_eq!(MeasuredPoint::from_cloud(&cloud, 0.2).len(), 8);
    }

    #[test]
    fn thinning_keeps_about_the_wanted_number_evenly() {
        let points = MeasuredPoint::from_cloud(&sheet(60), 0.2);
        let few = thin_over_space(&points, 400);
        assert!((250..=650).contains(&few.len()), "{}", few.len());
        let quarter = |p: &&MeasuredPoint| p.position.x < 30.0 && p.position.y < 30.0;
        let share = few.iter().filter(quarter).count() as f64 / few.len() as f64;
        assert!((share - 0.25).abs() < 0.06, "{share}");
        assert_eq!(thin_over_list(&points, 400).len(), 400);
        assert_eq!(thin_over_list(&points, 5000).len(), 3600);
        assert!(thin_over_space(&[], 10).is_empty());
    }

    #[test]
    fn a_neighbourhood_holds_about_twenty_points() {
        let points = thin_over_list(&MeasuredPoint::from_cloud(&sheet(60), 0.2), 5000);
        let cells = points.iter().map(|p| p.cell as usize + 1).max().unwrap();
        assert!((10.0..40.0).contains(&(3600.0 / cells as f64)), "{cells}");
    }
}
