//! Which connected parts belong to the subject.

use super::patch::{NONE, Patch, neighbours};
use crate::math::{Vec2, median};
use crate::spatial::PointIndex;

/// What became of the parts.
pub(super) struct Kept {
    pub(super) parts: usize,
    pub(super) left_out: usize,
}

/// Parts of at least this share of the largest one can be the subject.
const LARGE: f64 = 0.25;

/// Keeps the subject's parts: those on which most of the subject's dots lie, or, where these are
/// unknown, the nearest of the large ones and what lies no farther away than it reaches. Parts
/// with less than `min_part` of the greatest one's extent go as well.
pub(super) fn keep_subject(
    patch: &mut Patch,
    subject: &[Vec2],
    min_part: f64,
    pitch_px: f64,
) -> Kept {
    let (part_of, parts) = connected(&patch.faces);
    let extent = if subject.is_empty() {
        let mut areas = vec![0.0; parts];
        for (&face, &part) in patch.faces.iter().zip(&part_of) {
            areas[part as usize] += patch.double_area_px(face);
        }
        leave_background(patch, &part_of, areas)
    } else {
        dots_on(patch, &part_of, parts, subject, pitch_px)
    };
    let greatest = extent.iter().copied().fold(0.0, f64::max);
    let good: Vec<bool> = extent.iter().map(|&e| e > 0.0 && e >= min_part * greatest).collect();
    let mut part = part_of.iter();
    patch.faces.retain(|_| part.next().is_some_and(|&p| good[p as usize]));
    patch.drop_bare_nodes();
    let kept = good.iter().filter(|g| **g).count();
    Kept { parts: kept, left_out: parts - kept }
}

/// For each face the number of its part, and the number of parts.
fn connected(faces: &[[u32; 3]]) -> (Vec<u32>, usize) {
    let neighbours = neighbours(faces);
    let mut part = vec![NONE; faces.len()];
    let mut count = 0;
    for start in 0..faces.len() {
        if part[start] != NONE {
            continue;
        }
        let mut waiting = vec![start];
        while let Some(face) = waiting.pop() {
            if part[face] == NONE {
                part[face] = count;
                waiting
                    .extend(neighbours[face].iter().filter(|&&n| n != NONE).map(|&n| n as usize));
            }
        }
        count += 1;
    }
    (part, count as usize)
}

/// Areas of the parts, 0 for those behind the subject: a wall may be larger than a head, but it
/// is never nearer.
fn leave_background(patch: &Patch, part_of: &[u32], mut areas: Vec<f64>) -> Vec<f64> {
    let mut disparities = vec![Vec::new(); areas.len()];
    for (&face, &part) in patch.faces.iter().zip(part_of) {
        disparities[part as usize].push(patch.corners(face).map(|n| n.disparity)[0]);
    }
    let largest = areas.iter().copied().fold(0.0, f64::max);
    let typical: Vec<f64> =
        disparities.iter().map(|d| median(d).unwrap_or(f64::NEG_INFINITY)).collect();
    let subject = (0..areas.len())
        .filter(|&p| areas[p] >= LARGE * largest)
        .max_by(|&a, &b| typical[a].total_cmp(&typical[b]));
    let Some(subject) = subject else { return areas };
    let farthest = disparities[subject].iter().copied().fold(f64::INFINITY, f64::min);
    for (area, typical) in areas.iter_mut().zip(&typical) {
        if *typical < farthest {
            *area = 0.0;
        }
    }
    areas
}

/// How many of the subject's dots lie on each part.
fn dots_on(
    patch: &Patch,
    part_of: &[u32],
    parts: usize,
    subject: &[Vec2],
    pitch_px: f64,
) -> Vec<f64> {
    let mut counts = vec![0.0; parts];
    let mut part_of_node = vec![NONE; patch.nodes.len()];
    for (face, &part) in patch.faces.iter().zip(part_of) {
        face.iter().for_each(|&n| part_of_node[n as usize] = part);
    }
    let used: Vec<usize> = (0..part_of_node.len()).filter(|&n| part_of_node[n] != NONE).collect();
    let pixels: Vec<Vec2> = used.iter().map(|&n| patch.nodes[n].pixel).collect();
    let Some(index) = PointIndex::<2>::new(&pixels) else { return counts };
    for dot in subject {
        if let Some(near) = index.nearest(&[dot.x, dot.y]).filter(|n| n.distance < pitch_px) {
            counts[part_of_node[used[near.index]] as usize] += 1.0;
        }
    }
    counts
}
