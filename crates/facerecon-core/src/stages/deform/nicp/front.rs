//! Nothing stands in front of what was measured: it would have been seen instead.
//!
//! Points look for the nearest surface, so a ridge higher than the subject's (a nose) finds no
//! partner at its crest and would be pinched from both sides. Its vertices look for points.

use rayon::prelude::*;

use super::matching::{Found, Point};
use crate::data::Mesh;
use crate::math::Vec3;
use crate::spatial::PointIndex;

/// Vertices less far in front are left to the points, mm.
const CLEAR_MM: f64 = 1.0;
/// A vertex stands over a point when the way to it is no more oblique than this (tangent).
const OBLIQUE: f64 = 0.35;
/// Least cosine between the normals.
const AGREE: f64 = 0.5;
/// Weight of such a match against that of a point.
const WEIGHT: f64 = 0.5;

/// The places of measured points, for all rounds.
pub(super) struct Front<'a> {
    points: &'a [Point],
    index: Option<PointIndex<3>>,
}

impl<'a> Front<'a> {
    pub fn new(points: &'a [Point]) -> Self {
        let places: Vec<_> = points.iter().map(|p| p.at).collect();
        Self { points, index: PointIndex::<3>::new(&places) }
    }

    /// Matches of the vertices that stand in front of the points, within reach.
    pub fn find(&self, mesh: &Mesh, reach: f64) -> Vec<Found> {
        let Some(index) = &self.index else { return Vec::new() };
        let normals = mesh.vertex_normals();
        let one = |(v, at): (usize, &Vec3)| {
            let near = index.nearest(&(*at).into())?;
            let point = &self.points[near.index];
            let offset = at - point.at;
            let height = offset.dot(&point.normal);
            let aside = (offset - point.normal * height).norm();
            let stands = height > CLEAR_MM && height < reach && aside < OBLIQUE * height;
            let agrees = point.island.is_none() && point.normal.dot(&normals[v]) > AGREE;
            (stands && agrees).then_some(Found {
                data: point.at,
                corners: [v; 3],
                barycentric: [1.0, 0.0, 0.0],
                foot: *at,
                normal: point.normal,
                weight: WEIGHT * point.weight,
                cell: point.cell,
                island: None,
            })
        };
        mesh.vertices.par_iter().enumerate().filter_map(one).collect()
    }
}
