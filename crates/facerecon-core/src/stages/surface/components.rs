//! Which connected components belong to the subject.

use super::adjacency::{NONE, neighbours};
use super::patch::Patch;
use crate::math::{Vec2, median};
use crate::spatial::PointIndex;

/// A component of at least this share of the largest one's area can be the subject.
const MIN_SUBJECT_AREA: f64 = 0.25;

/// Numbers of components.
pub(super) struct ComponentCounts {
    pub(super) kept: usize,
    pub(super) removed: usize,
}

/// Keeps the components of the subject. With known dots on the subject (`subject`, left pixels)
/// the extent of a component is the number of these dots on it. Without them it is the area in the
/// photo, and components behind the subject are removed. Components of less than `min_share` of
/// the largest extent are removed as well.
pub(super) fn keep_subject(
    patch: &mut Patch,
    subject: &[Vec2],
    min_share: f64,
    pitch_px: f64,
) -> ComponentCounts {
    let (component_of, count) = connected(&patch.faces);
    let extents = if subject.is_empty() {
        let mut areas = vec![0.0; count];
        for (&face, &component) in patch.faces.iter().zip(&component_of) {
            areas[component as usize] += patch.double_area_px2(face);
        }
        without_background(patch, &component_of, areas)
    } else {
        dots_on(patch, &component_of, count, subject, pitch_px)
    };
    let largest = extents.iter().copied().fold(0.0, f64::max);
    let keep: Vec<bool> = extents.iter().map(|&e| e > 0.0 && e >= min_share * largest).collect();
    let mut component = component_of.iter();
    patch.faces.retain(|_| component.next().is_some_and(|&c| keep[c as usize]));
    patch.remove_unused_nodes();
    let kept = keep.iter().filter(|k| **k).count();
    ComponentCounts { kept, removed: count - kept }
}

/// For each face the number of its component, and the number of components.
fn connected(faces: &[[u32; 3]]) -> (Vec<u32>, usize) {
    let neighbours = neighbours(faces);
    let mut component = vec![NONE; faces.len()];
    let mut count = 0;
    for start in 0..faces.len() {
        if component[start] != NONE {
            continue;
        }
        let mut pending = vec![start];
        while let Some(face) = pending.pop() {
            if component[face] == NONE {
                component[face] = count;
                pending
                    .extend(neighbours[face].iter().filter(|&&n| n != NONE).map(|&n| n as usize));
            }
        }
        count += 1;
    }
    (component, count as usize)
}

/// Areas of the components, 0 for those behind the subject. A wall may be larger than a head but
/// is never nearer, so the subject is the nearest of the large components.
fn without_background(patch: &Patch, component_of: &[u32], mut areas: Vec<f64>) -> Vec<f64> {
    let mut disparities = vec![Vec::new(); areas.len()];
    for (&face, &component) in patch.faces.iter().zip(component_of) {
        disparities[component as usize].push(patch.corners(face).map(|n| n.disparity)[0]);
    }
    let largest = areas.iter().copied().fold(0.0, f64::max);
    let medians: Vec<f64> =
        disparities.iter().map(|d| median(d).unwrap_or(f64::NEG_INFINITY)).collect();
    let subject = (0..areas.len())
        .filter(|&c| areas[c] >= MIN_SUBJECT_AREA * largest)
        .max_by(|&a, &b| medians[a].total_cmp(&medians[b]));
    let Some(subject) = subject else { return areas };
    let farthest = disparities[subject].iter().copied().fold(f64::INFINITY, f64::min);
    for (area, median) in areas.iter_mut().zip(&medians) {
        if *median < farthest {
            *area = 0.0;
        }
    }
    areas
}

/// Number of the subject's dots on each component.
fn dots_on(
    patch: &Patch,
    component_of: &[u32],
    count: usize,
    subject: &[Vec2],
    pitch_px: f64,
) -> Vec<f64> {
    let mut dots = vec![0.0; count];
    let mut component_of_node = vec![NONE; patch.nodes.len()];
    for (face, &component) in patch.faces.iter().zip(component_of) {
        face.iter().for_each(|&n| component_of_node[n as usize] = component);
    }
    let used: Vec<usize> =
        (0..component_of_node.len()).filter(|&n| component_of_node[n] != NONE).collect();
    let pixels: Vec<Vec2> = used.iter().map(|&n| patch.nodes[n].pixel).collect();
    let Some(index) = PointIndex::<2>::new(&pixels) else { return dots };
    for dot in subject {
        if let Some(near) = index.nearest(&[dot.x, dot.y]).filter(|n| n.distance < pitch_px) {
            dots[component_of_node[used[near.index]] as usize] += 1.0;
        }
    }
    dots
}
