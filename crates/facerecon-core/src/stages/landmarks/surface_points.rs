//! The measured surface, thinned, in axes of the viewer.

use std::collections::BTreeMap;

use crate::data::Cloud;
use crate::math::Vec3;
use crate::spatial::PointIndex;

/// Distance between the points that are used, mm.
const THINNED_MM: f64 = 3.0;
/// What lies farther behind the nearest points is not the head, mm.
const HEAD_DEPTH_MM: f64 = 170.0;
/// Share of the points that may be nearer by mistake.
const NEAREST_SHARE: f64 = 0.03;

/// The measured surface, thinned; axes of the viewer (x right, y up, z toward the camera), mm.
pub(super) struct SurfacePoints {
    pub positions: Vec<Vec3>,
    pub normals: Vec<Vec3>,
    /// Finds positions; `None` without any.
    pub index: Option<PointIndex<3>>,
}

/// Between camera axes (y down, z away) and viewer axes; its own inverse.
pub(super) fn viewer_axes(p: &Vec3) -> Vec3 {
    Vec3::new(p.x, -p.y, -p.z)
}

impl SurfacePoints {
    /// One point for each cell of a grid, as far back as a head is deep.
    pub fn new(surface: &Cloud) -> Self {
        let mut cells: BTreeMap<[i64; 3], usize> = BTreeMap::new();
        for (i, p) in surface.points.iter().enumerate() {
            let cell = [p.x, p.y, p.z].map(|c| (c / THINNED_MM).floor() as i64);
            cells.entry(cell).or_insert(i);
        }
        let mut depths: Vec<f64> = cells.values().map(|&i| surface.points[i].z).collect();
        depths.sort_by(f64::total_cmp);
        let nearest = depths.get((NEAREST_SHARE * depths.len() as f64) as usize).copied();
        let limit = nearest.unwrap_or(0.0) + HEAD_DEPTH_MM;
        let mut kept: Vec<usize> = cells.into_values().collect();
        kept.sort_unstable();
        let with_normal = |i: &usize| surface.normals.get(*i).is_some_and(|n| n.norm() > 0.5);
        kept.retain(|i| surface.points[*i].z < limit && with_normal(i));
        let positions: Vec<Vec3> = kept.iter().map(|&i| viewer_axes(&surface.points[i])).collect();
        let normals = kept.iter().map(|&i| viewer_axes(&surface.normals[i])).collect();
        let index = PointIndex::<3>::new(&positions);
        Self { positions, normals, index }
    }
}
