//! Matches that no neighbour supports, and those far behind the subject.

use crate::camera::RectifiedRig;
use crate::math::{mad, median};

use super::LatticeParams;
use super::cues::Evidence;
use super::extend::Surface;
use super::regions::{ALIKE, Found, Paired};

/// Drops matches off the robust plane of their twelve neighbours unless some of the nearest share
/// their disparity (the far side of an edge), then connected pieces that are too small.
pub(super) fn outliers(evidence: &Evidence<'_>, params: &LatticeParams, found: &mut Found) {
    let spacing = evidence.spacing_px;
    for _ in 0..2 {
        let surface = Surface::new(evidence, &found.pairs);
        let residuals: Vec<Option<f64>> = (0..found.pairs.len())
            .map(|i| {
                let at = surface.point(i);
                let near = surface.near(at, 12, 3.5 * spacing, i);
                if near.len() < 4 {
                    return None;
                }
                surface.plane(at, &near, 0.05 * spacing).map(|p| surface.disparity(i) - p[0])
            })
            .collect();
        let known: Vec<f64> = residuals.iter().flatten().copied().collect();
        let spread = mad(&known).unwrap_or(0.0);
        let limit = (params.outlier_mads * spread).max(0.1 * spacing);
        let keep = |(pair, (i, residual)): (&Paired, (usize, &Option<f64>))| {
            let seen = evidence.alike(&(pair.left, pair.right)) >= ALIKE;
            residual.is_some_and(|r| r.abs() <= limit) || supported(&surface, i, spacing, seen)
        };
        let kept: Vec<bool> =
            found.pairs.iter().zip(residuals.iter().enumerate()).map(keep).collect();
        let mut keep = kept.iter();
        found.pairs.retain(|_| keep.next().is_some_and(|k| *k));
    }
    let sizes = pieces(evidence, params, found);
    let mut size = sizes.iter().map(|p| p.1);
    found.pairs.retain(|_| size.next().unwrap_or(0) >= params.min_component);
}

/// Whether some of the six nearest matches have about the same disparity: three, or two where the
/// plain pair bears it out.
fn supported(surface: &Surface, i: usize, spacing: f64, seen: bool) -> bool {
    let near = surface.near(surface.point(i), 6, 2.2 * spacing, i);
    let (needed, step) = if seen { (2, 0.3) } else { (3, 0.12) };
    let alike = |n: &&usize| (surface.disparity(**n) - surface.disparity(i)).abs() < step * spacing;
    near.iter().filter(alike).count() >= needed
}

/// Number and size of the smooth piece of every match.
fn pieces(evidence: &Evidence<'_>, params: &LatticeParams, found: &Found) -> Vec<(usize, usize)> {
    let surface = Surface::new(evidence, &found.pairs);
    let n = found.pairs.len();
    let step = params.max_step * evidence.spacing_px;
    let mut piece = vec![usize::MAX; n];
    let mut sizes = Vec::new();
    for start in 0..n {
        if piece[start] != usize::MAX {
            continue;
        }
        piece[start] = sizes.len();
        let mut stack = vec![start];
        let mut size = 0;
        while let Some(i) = stack.pop() {
            size += 1;
            for k in surface.near(surface.point(i), 8, 2.1 * evidence.spacing_px, i) {
                let smooth = (surface.disparity(k) - surface.disparity(i)).abs() < step;
                if smooth && piece[k] == usize::MAX {
                    piece[k] = sizes.len();
                    stack.push(k);
                }
            }
        }
        sizes.push(size);
    }
    piece.into_iter().map(|p| (p, sizes[p])).collect()
}

/// Drops the smooth pieces that lie far behind the subject, or before it, and tells how many
/// matches went.
pub(super) fn background(
    evidence: &Evidence<'_>,
    rig: Option<&RectifiedRig>,
    params: &LatticeParams,
    found: &mut Found,
) -> usize {
    let range = found.subject_range(rig, params, evidence.spacing_px);
    let pieces = pieces(evidence, params, found);
    let surface = Surface::new(evidence, &found.pairs);
    let mut disparities = vec![Vec::new(); found.pairs.len()];
    for (i, (piece, _)) in pieces.iter().enumerate() {
        disparities[*piece].push(surface.disparity(i));
    }
    let middle: Vec<f64> = disparities.iter().map(|d| median(d).unwrap_or(f64::NAN)).collect();
    let before = found.pairs.len();
    let mut keep = pieces.iter().map(|(piece, _)| range.contains(&middle[*piece]));
    found.pairs.retain(|_| keep.next().unwrap_or(false));
    before - found.pairs.len()
}
