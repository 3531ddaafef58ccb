//! The plane of symmetry of a face, by ICP of the surface with its mirror image.

use nalgebra::Rotation3;
use rayon::prelude::*;

use super::surface_points::SurfacePoints;
use crate::math::{Mat3, Vec3};
use crate::spatial::PointIndex;

/// Radius of the region about the nose that is compared with its mirror image, mm.
const RADIUS_MM: f64 = 75.0;
/// Greatest distance of a pair, mm, and least cosine between its normals, while the plane moves.
const PAIR_MM: f64 = 12.0;
const PAIR_COSINE: f64 = 0.6;
/// The same for points that count as symmetric.
const SYMMETRIC_MM: f64 = 4.0;
const SYMMETRIC_COSINE: f64 = 0.7;
/// Scale of the robust weights, mm: faces are asymmetric by one or two millimetres.
const ASYMMETRY_MM: f64 = 2.0;
/// Scale at which the symmetry of a point counts half, mm.
const HALF_SYMMETRY_MM: f64 = 1.5;
/// Fewest pairs that determine a plane.
const MIN_PAIRS: usize = 60;
/// Starts: turns of the head about the vertical and toward a shoulder, degrees.
const YAWS_DEG: [f64; 5] = [0.0, -20.0, 20.0, -40.0, 40.0];
const ROLLS_DEG: [f64; 3] = [0.0, -30.0, 30.0];
/// Steps from each start, and of the best one.
const TRIAL_STEPS: usize = 8;
const STEPS: usize = 25;
/// A start uses every so many-th point.
const TRIAL_STRIDE: usize = 4;
/// The iteration ends when the plane's normal turns by less than this, radians.
const CONVERGED_RAD: f64 = 1e-5;
/// Damping of the steps, relative to the diagonal.
const DAMPING: f64 = 1e-3;

/// The plane `normal . (p - centre) = offset`.
#[derive(Clone, Copy, Debug)]
pub(super) struct SymmetryPlane {
    /// Unit normal, to the right as seen by the viewer.
    pub normal: Vec3,
    /// Signed distance of the plane from `centre`, mm.
    pub offset: f64,
    /// A point near the plane.
    pub centre: Vec3,
    /// Share of the region that is symmetric, 0 to 1.
    pub share: f64,
}

impl SymmetryPlane {
    /// Signed distance of a point, mm.
    pub fn distance(&self, p: &Vec3) -> f64 {
        self.normal.dot(&(p - self.centre)) - self.offset
    }

    fn mirror(&self, p: &Vec3) -> Vec3 {
        p - 2.0 * self.distance(p) * self.normal
    }

    fn mirror_direction(&self, d: &Vec3) -> Vec3 {
        d - 2.0 * self.normal.dot(d) * self.normal
    }
}

/// The plane of symmetry near a point; `None` where too little is symmetric.
pub(super) fn plane_at(centre: &Vec3, points: &SurfacePoints) -> Option<SymmetryPlane> {
    let index = points.index.as_ref()?;
    let mut region: Vec<usize> =
        index.within(&[centre.x, centre.y, centre.z], RADIUS_MM).iter().map(|n| n.index).collect();
    region.sort_unstable();
    let few: Vec<usize> = region.iter().copied().step_by(TRIAL_STRIDE).collect();
    let starts: Vec<(f64, f64)> =
        YAWS_DEG.iter().flat_map(|&yaw| ROLLS_DEG.map(|roll| (yaw, roll))).collect();
    let trials: Vec<Option<SymmetryPlane>> = starts
        .par_iter()
        .map(|(yaw, roll)| {
            let turn = Rotation3::from_euler_angles(0.0, yaw.to_radians(), roll.to_radians());
            let normal = turn * Vec3::x();
            let start = SymmetryPlane { normal, offset: 0.0, centre: *centre, share: 0.0 };
            fit(start, &few, points, index, TRIAL_STEPS)
        })
        .collect();
    let mut best: Option<SymmetryPlane> = None;
    for plane in trials.into_iter().flatten() {
        if best.is_none_or(|b| plane.share > b.share) {
            best = Some(plane);
        }
    }
    let plane = fit(best?, &region, points, index, STEPS)?;
    // the viewer's right; a head on its side has no right
    Some(if plane.normal.x < 0.0 {
        SymmetryPlane { normal: -plane.normal, offset: -plane.offset, ..plane }
    } else {
        plane
    })
}

/// Moves a plane until the region lies best on its own mirror image.
fn fit(
    start: SymmetryPlane,
    region: &[usize],
    points: &SurfacePoints,
    index: &PointIndex<3>,
    steps: usize,
) -> Option<SymmetryPlane> {
    let mut plane = start;
    for _ in 0..steps {
        let helper = if plane.normal.y.abs() < 0.8 { Vec3::y() } else { Vec3::z() };
        let u = plane.normal.cross(&helper).try_normalize(1e-9)?;
        let v = plane.normal.cross(&u);
        let (mut matrix, mut right, mut pairs) = (Mat3::zeros(), Vec3::zeros(), 0);
        for &i in region {
            let (p, n) = (&points.positions[i], &points.normals[i]);
            let mirrored = plane.mirror(p);
            let Some(near) = index.nearest(&[mirrored.x, mirrored.y, mirrored.z]) else { continue };
            let other = points.normals[near.index];
            let agrees = plane.mirror_direction(n).dot(&other) > PAIR_COSINE;
            if near.distance > PAIR_MM || !agrees {
                continue;
            }
            pairs += 1;
            let residual = (mirrored - points.positions[near.index]).dot(&other);
            let weight = (1.0 + (residual / ASYMMETRY_MM).powi(2)).powi(-2);
            // derivative of the mirrored point along `other`, by u, v and the offset
            let (along, local, distance) =
                (other.dot(&plane.normal), p - plane.centre, plane.distance(p));
            let by = |t: &Vec3| -2.0 * (local.dot(t) * along + distance * other.dot(t));
            let row = Vec3::new(by(&u), by(&v), 2.0 * along);
            matrix += weight * row * row.transpose();
            right += weight * residual * row;
        }
        if pairs < MIN_PAIRS.min(region.len() / 3) {
            return None;
        }
        (0..3).for_each(|k| matrix[(k, k)] *= 1.0 + DAMPING);
        let step = -(matrix.try_inverse()? * right);
        let normal = plane.normal + step.x * u + step.y * v;
        let length = normal.norm();
        plane.normal = normal / length;
        plane.offset = (plane.offset + step.z) / length;
        if step.x.abs().max(step.y.abs()) < CONVERGED_RAD {
            break;
        }
    }
    plane.share = symmetric_share(&plane, region, points, index);
    plane.normal.iter().all(|c| c.is_finite()).then_some(plane)
}

/// Share of the region that its mirror image covers; points count less the less they agree.
fn symmetric_share(
    plane: &SymmetryPlane,
    region: &[usize],
    points: &SurfacePoints,
    index: &PointIndex<3>,
) -> f64 {
    let of = |&i: &usize| {
        let mirrored = plane.mirror(&points.positions[i]);
        let near = index.nearest(&[mirrored.x, mirrored.y, mirrored.z])?;
        let other = points.normals[near.index];
        let cosine = plane.mirror_direction(&points.normals[i]).dot(&other);
        let residual = (mirrored - points.positions[near.index]).dot(&other);
        (near.distance < SYMMETRIC_MM && cosine > SYMMETRIC_COSINE)
            .then(|| 1.0 / (1.0 + (residual / HALF_SYMMETRY_MM).powi(2)))
    };
    region.iter().filter_map(of).sum::<f64>() / region.len().max(1) as f64
}
