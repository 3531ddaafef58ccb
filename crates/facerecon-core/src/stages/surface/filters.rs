//! Removing triangles that are not part of a surface.

use super::adjacency::{NONE, neighbours};
use super::patch::{Patch, Unproject};
use crate::math::{Vec2, Vec3};

/// Faces on the border with a smaller angle than this in the photo are removed as slivers,
/// degrees. The faces of the grid have 60.
const MIN_ANGLE_DEG: f64 = 10.0;
/// Most rings of faces that [`remove_narrow`] counts: as many remove any patch completely.
const MAX_RINGS: usize = 1000;
/// Step of the disparity for the viewing direction, pixels.
const DIRECTION_STEP_PX: f64 = 0.5;

/// Removes faces with an edge longer than `max_edge_px` in the photo.
pub(super) fn remove_long(patch: &mut Patch, max_edge_px: f64) {
    let nodes = &patch.nodes;
    let at = |i: u32| nodes[i as usize].pixel;
    patch.faces.retain(|&[a, b, c]| {
        [(a, b), (b, c), (c, a)].iter().all(|&(i, j)| (at(i) - at(j)).norm() <= max_edge_px)
    });
}

/// Removes faces tilted by more than `max_tilt_deg` away from the viewing direction midway between
/// the cameras, and those seen from behind. Returns their number.
pub(super) fn remove_tilted(
    patch: &mut Patch,
    max_tilt_deg: f64,
    unproject: Unproject<'_>,
) -> usize {
    let min_cosine = max_tilt_deg.to_radians().cos();
    let before = patch.faces.len();
    let nodes = &patch.nodes;
    patch.faces.retain(|face| {
        let [a, b, c] = face.map(|i| &nodes[i as usize]);
        let normal = (b.point - a.point).cross(&(c.point - a.point));
        let pixel = (a.pixel + b.pixel + c.pixel) / 3.0;
        let disparity = (a.disparity + b.disparity + c.disparity) / 3.0;
        let cosine = toward_cameras(pixel, disparity, unproject)
            .map_or(0.0, |t| normal.dot(&t) / (normal.norm() * t.norm()).max(1e-300));
        cosine >= min_cosine
    });
    before - patch.faces.len()
}

/// Direction from a point toward the middle between the cameras: the way it moves when its
/// disparity grows and its mean position in both photos stays.
fn toward_cameras(pixel: Vec2, disparity: f64, unproject: Unproject<'_>) -> Option<Vec3> {
    let shift = Vec2::new(0.25 * DIRECTION_STEP_PX, 0.0);
    let near = unproject(pixel + shift, disparity + 0.5 * DIRECTION_STEP_PX)?;
    let far = unproject(pixel - shift, disparity - 0.5 * DIRECTION_STEP_PX)?;
    Some(near - far)
}

/// Removes the regions of the patch that a disc of diameter `width_px` inside it does not reach: a
/// morphological opening, counted in rings of faces.
pub(super) fn remove_narrow(patch: &mut Patch, width_px: f64) {
    let lengths = patch
        .faces
        .iter()
        .map(|&[a, b, _]| (patch.nodes[a as usize].pixel - patch.nodes[b as usize].pixel).norm());
    let edge_px = lengths.sum::<f64>() / patch.faces.len().max(1) as f64;
    let rings = ((0.5 * width_px / edge_px).round() as usize).min(MAX_RINGS);
    if rings == 0 || patch.faces.is_empty() {
        return;
    }
    let mut outside = vec![false; patch.nodes.len()];
    for (face, neighbours) in patch.faces.iter().zip(neighbours(&patch.faces)) {
        for k in (0..3).filter(|&k| neighbours[k] == NONE) {
            outside[face[k] as usize] = true;
            outside[face[(k + 1) % 3] as usize] = true;
        }
    }
    (1..rings).for_each(|_| dilate(&patch.faces, &mut outside));
    let mut inside: Vec<bool> = outside.iter().map(|o| !o).collect();
    (0..rings).for_each(|_| dilate(&patch.faces, &mut inside));
    patch.faces.retain(|face| face.iter().all(|&n| inside[n as usize]));
}

/// Marks the nodes that share a face with a marked one.
fn dilate(faces: &[[u32; 3]], marked: &mut [bool]) {
    let before = marked.to_vec();
    for face in faces {
        if face.iter().any(|&n| before[n as usize]) {
            face.iter().for_each(|&n| marked[n as usize] = true);
        }
    }
}

/// Removes, from the border inward, faces with at most one neighbour (ears) and slivers on the
/// border.
pub(super) fn remove_ears(patch: &mut Patch) {
    let neighbours = neighbours(&patch.faces);
    let mut kept = vec![true; patch.faces.len()];
    let mut pending: Vec<u32> = (0..patch.faces.len() as u32).rev().collect();
    while let Some(face) = pending.pop() {
        let f = face as usize;
        let beside = neighbours[f].iter().filter(|&&n| n != NONE && kept[n as usize]);
        let count = beside.clone().count();
        if !kept[f] || count == 3 || (count == 2 && !is_sliver(patch, patch.faces[f])) {
            continue;
        }
        pending.extend(beside);
        kept[f] = false;
    }
    let mut kept = kept.into_iter();
    patch.faces.retain(|_| kept.next() == Some(true));
}

fn is_sliver(patch: &Patch, face: [u32; 3]) -> bool {
    let p = patch.corners(face).map(|n| n.pixel);
    let min_angle = (0..3)
        .map(|k| (p[(k + 1) % 3] - p[k]).angle(&(p[(k + 2) % 3] - p[k])))
        .fold(f64::INFINITY, f64::min);
    min_angle < MIN_ANGLE_DEG.to_radians()
}
