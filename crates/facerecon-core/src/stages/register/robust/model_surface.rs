//! Closest points on the model, their robust weights, and the error of a pose.

use rayon::prelude::*;

use super::samples::{Sample, median_position};
use crate::data::Mesh;
use crate::math::{PlanePair, Similarity, Vec3, interpolate, median};
use crate::spatial::SurfaceIndex;

/// Distances count up to this much, mm; points beyond it are not on the head. A head that
/// differs from the model should lie within it, hair and collar should not.
const MAX_DISTANCE_MM: f64 = 12.0;
/// Least cosine between the normals of point and surface; a larger angle than 60 degrees is another
/// part of the head.
const MIN_COSINE: f64 = 0.5;
/// Width of the Geman-McClure weights, in median distances, and its bounds, mm: below one millimetre
/// noise would decide, above 60 everything counts.
const WEIGHT_WIDTH: f64 = 2.5;
const WIDTH_RANGE_MM: (f64, f64) = (1.0, 60.0);
/// Vertices whose normal has at least this component toward the viewer are the model's front.
const FRONT_COSINE: f64 = 0.3;

/// The model's surface, searchable by position.
pub(super) struct ModelSurface {
    index: SurfaceIndex,
    faces: Vec<[u32; 3]>,
    normals: Vec<Vec3>,
    /// Median position of the part that faces the viewer.
    pub(super) front: Vec3,
}

/// A sample under a pose with its closest point.
#[derive(Clone, Copy)]
struct ClosestPoint {
    sample: Vec3,
    point: Vec3,
    /// Smooth unit normal of the surface.
    normal: Vec3,
}

impl ClosestPoint {
    fn distance(&self) -> f64 {
        (self.sample - self.point).norm()
    }
}

impl ModelSurface {
    pub(super) fn new(model: &Mesh) -> Option<Self> {
        let index = SurfaceIndex::new(model)?;
        let normals = model.vertex_normals();
        let facing: Vec<Sample> = model
            .vertices
            .iter()
            .zip(&normals)
            .filter(|(_, n)| n.z > FRONT_COSINE)
            .map(|(p, n)| Sample { point: *p, normal: *n })
            .collect();
        let front = median_position(&facing);
        Some(Self { index, faces: model.faces.clone(), normals, front })
    }

    /// The closest point of each sample under a pose; `None` where the normals disagree.
    fn closest(&self, samples: &[Sample], pose: &Similarity) -> Vec<Option<ClosestPoint>> {
        let one = |s: &Sample| {
            let sample = pose.apply(&s.point);
            let found = self.index.closest(&sample)?;
            let corners = self.faces[found.face];
            let normal = interpolate(corners.map(|v| self.normals[v as usize]), found.barycentric);
            let normal = normal.try_normalize(1e-12)?;
            let of_sample = pose.rotate(&s.normal);
            let agrees = of_sample == Vec3::zeros() || of_sample.dot(&normal) > MIN_COSINE;
            agrees.then_some(ClosestPoint { sample, point: found.point, normal })
        };
        samples.par_iter().map(one).collect()
    }

    /// Pairs with Geman-McClure weights whose width follows the median distance.
    pub(super) fn pairs(&self, samples: &[Sample], pose: &Similarity) -> Vec<PlanePair> {
        let found: Vec<ClosestPoint> = self.closest(samples, pose).into_iter().flatten().collect();
        let distances: Vec<f64> = found.iter().map(ClosestPoint::distance).collect();
        let width = WEIGHT_WIDTH * median(&distances).unwrap_or_default();
        let width = width.clamp(WIDTH_RANGE_MM.0, WIDTH_RANGE_MM.1);
        let pair = |(c, distance): (&ClosestPoint, &f64)| PlanePair {
            point: c.sample,
            closest_point: c.point,
            normal: c.normal,
            weight: (1.0 + (distance / width).powi(2)).powi(-2),
        };
        found.iter().zip(&distances).map(pair).collect()
    }

    /// Indices of the points on the head.
    pub(super) fn near(&self, points: &[Vec3], pose: &Similarity) -> Vec<usize> {
        let max_distance = MAX_DISTANCE_MM * pose.scale;
        let close =
            |i: &usize| self.index.closest_within(&pose.apply(&points[*i]), max_distance).is_some();
        (0..points.len()).into_par_iter().filter(close).collect()
    }

    /// Mean squared bounded distance, in the unit of the samples. Where the normals disagree, the
    /// bound counts.
    pub(super) fn bounded_error(&self, samples: &[Sample], pose: &Similarity) -> f64 {
        let found = self.closest(samples, pose);
        let scale = pose.scale.max(1e-9);
        let bounded = found.iter().map(|c| {
            let distance = c.map_or(f64::INFINITY, |c| c.distance());
            (distance / scale).min(MAX_DISTANCE_MM).powi(2)
        });
        bounded.sum::<f64>() / found.len().max(1) as f64
    }
}
