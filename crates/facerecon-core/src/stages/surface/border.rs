//! Smoothing the border, which follows the steps of the lattice.

use super::adjacency::{NONE, neighbours};
use super::patch::{Node, Patch, Unproject};
use crate::math::{Vec2, Vec3};

/// Faces keep at least this share of their area in the photo.
const MIN_AREA_SHARE: f64 = 0.1;

/// Moves the nodes on the border toward the mean of their two neighbours along it, in position and
/// disparity at once, so that they stay on the surface. Nodes whose move would fold a face stay.
pub(super) fn smooth(patch: &mut Patch, steps: usize, unproject: Unproject<'_>) {
    let along = along_border(&patch.faces, patch.nodes.len());
    let border: Vec<usize> = (0..along.len()).filter(|&n| !along[n].contains(&NONE)).collect();
    let mut movable = vec![false; patch.nodes.len()];
    border.iter().for_each(|&n| movable[n] = true);
    let faces: Vec<[u32; 3]> = patch
        .faces
        .iter()
        .copied()
        .filter(|face| face.iter().any(|&n| movable[n as usize]))
        .collect();
    let min_areas: Vec<f64> =
        faces.iter().map(|&f| MIN_AREA_SHARE * patch.double_area_px2(f)).collect();
    for _ in 0..steps {
        let old = patch.nodes.clone();
        for &n in &border {
            let [a, b] = along[n].map(|k| coordinates(&old[k as usize]));
            let v = coordinates(&old[n]) * 0.5 + (a + b) * 0.25;
            if let Some(node) = Node::new(Vec2::new(v.x, v.y), v.z, unproject) {
                patch.nodes[n] = node;
            }
        }
        undo_folds(patch, &old, &faces, &min_areas);
    }
}

/// Moves the nodes of folded faces back to their old positions. This may fold a neighbouring face,
/// so it is repeated until none is folded.
fn undo_folds(patch: &mut Patch, old: &[Node], faces: &[[u32; 3]], min_areas: &[f64]) {
    loop {
        let folded: Vec<[u32; 3]> = faces
            .iter()
            .zip(min_areas)
            .filter(|(face, min)| patch.double_area_px2(**face) < **min)
            .map(|(face, _)| *face)
            .filter(|face| face.iter().any(|&n| patch.nodes[n as usize] != old[n as usize]))
            .collect();
        if folded.is_empty() {
            break;
        }
        folded.iter().flatten().for_each(|&n| patch.nodes[n as usize] = old[n as usize]);
    }
}

/// Position and disparity of a node, pixels.
fn coordinates(node: &Node) -> Vec3 {
    Vec3::new(node.pixel.x, node.pixel.y, node.disparity)
}

/// For each node its two neighbours along the border; [`NONE`] inside.
fn along_border(faces: &[[u32; 3]], nodes: usize) -> Vec<[u32; 2]> {
    let mut along = vec![[NONE; 2]; nodes];
    for (face, next) in faces.iter().zip(neighbours(faces)) {
        for k in 0..3 {
            if next[k] == NONE {
                let (a, b) = (face[k], face[(k + 1) % 3]);
                along[a as usize][1] = b;
                along[b as usize][0] = a;
            }
        }
    }
    along
}
