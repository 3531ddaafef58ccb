//! Candidates for the tip of the nose: points that stand out from everything about them.

use rayon::prelude::*;

use super::surface_points::SurfacePoints;
use crate::math::{Vec3, percentile};
use crate::spatial::PointIndex;

/// Radius about a point from which it must stand out, mm: more than half the width of a nose and
/// less than the distance from its tip to the chin.
const RADIUS_MM: f64 = 40.0;
/// Points nearer than this belong to the tip itself, mm.
const TIP_RADIUS_MM: f64 = 18.0;
/// Fewest points about a candidate.
const MIN_POINTS: usize = 60;
/// The surroundings may stand out at most this much beyond a tip, mm, save for a few wrong points.
const MAX_RISE_MM: f64 = 2.0;
const RISE_QUANTILE: f64 = 0.97;
/// A tip's height above its surroundings is measured to this quantile of theirs.
const LEVEL_QUANTILE: f64 = 0.6;
/// Least height of a nose above its surroundings, mm.
const MIN_HEIGHT_MM: f64 = 6.0;
/// Every so many-th point is tried; the tip itself is found later.
const STRIDE: usize = 2;
/// Candidates are at least this far apart, mm.
const SEPARATION_MM: f64 = 15.0;

/// A candidate for the tip of the nose.
#[derive(Clone, Copy, Debug)]
pub(super) struct NoseTip {
    pub position: Vec3,
    /// Height above its surroundings, mm.
    pub height_mm: f64,
}

/// The highest candidates, at most `count`.
pub(super) fn candidates(points: &SurfacePoints, count: usize) -> Vec<NoseTip> {
    let Some(index) = &points.index else { return Vec::new() };
    let tried: Vec<&Vec3> = points.positions.iter().step_by(STRIDE).collect();
    let found: Vec<Option<NoseTip>> =
        tried.par_iter().map(|p| candidate(p, points, index)).collect();
    let mut found: Vec<NoseTip> = found.into_iter().flatten().collect();
    found.sort_by(|a, b| b.height_mm.total_cmp(&a.height_mm)); // stable: ties keep their order
    let mut apart: Vec<NoseTip> = Vec::new();
    for tip in found {
        if apart.len() == count {
            break;
        }
        if apart.iter().all(|a| (a.position - tip.position).norm() > SEPARATION_MM) {
            apart.push(tip);
        }
    }
    apart
}

fn candidate(p: &Vec3, points: &SurfacePoints, index: &PointIndex<3>) -> Option<NoseTip> {
    let near = index.within(&[p.x, p.y, p.z], RADIUS_MM);
    let normal = near.iter().map(|n| points.normals[n.index]).sum::<Vec3>().try_normalize(1e-9)?;
    let heights: Vec<f64> = near
        .iter()
        .filter(|n| n.distance > TIP_RADIUS_MM)
        .map(|n| (points.positions[n.index] - p).dot(&normal))
        .collect();
    if heights.len() < MIN_POINTS || percentile(&heights, RISE_QUANTILE)? > MAX_RISE_MM {
        return None;
    }
    let height_mm = -percentile(&heights, LEVEL_QUANTILE)?;
    (height_mm >= MIN_HEIGHT_MM).then_some(NoseTip { position: *p, height_mm })
}
