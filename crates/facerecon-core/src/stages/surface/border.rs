//! Taking the border off the lattice's steps.

use super::patch::{NONE, Node, Patch, Place, neighbours};
use crate::math::{Vec2, Vec3};

/// Faces keep at least this share of their area in the picture.
const LEAST_AREA: f64 = 0.1;

/// Moves the nodes on the border toward the middle of their two neighbours along it, in picture
/// and disparity at once, so that they stay on the surface. Where a face would fold its nodes stay.
pub(super) fn smooth(patch: &mut Patch, steps: usize, place: Place<'_>) {
    let beside = along_border(&patch.faces, patch.nodes.len());
    let border: Vec<usize> = (0..beside.len()).filter(|&n| !beside[n].contains(&NONE)).collect();
    let mut touched = vec![false; patch.nodes.len()];
    border.iter().for_each(|&n| touched[n] = true);
    let faces: Vec<[u32; 3]> = patch
        .faces
        .iter()
        .copied()
        .filter(|face| face.iter().any(|&n| touched[n as usize]))
        .collect();
    let least: Vec<f64> = faces.iter().map(|&f| LEAST_AREA * patch.double_area_px(f)).collect();
    for _ in 0..steps {
        let old = patch.nodes.clone();
        for &n in &border {
            let [a, b] = beside[n].map(|k| value(&old[k as usize]));
            let v = value(&old[n]) * 0.5 + (a + b) * 0.25;
            if let Some(node) = Node::new(Vec2::new(v.x, v.y), v.z, place) {
                patch.nodes[n] = node;
            }
        }
        // going back may fold a face that was good: look again until all are
        loop {
            let folded: Vec<[u32; 3]> = faces
                .iter()
                .zip(&least)
                .filter(|(face, least)| patch.double_area_px(**face) < **least)
                .map(|(face, _)| *face)
                .filter(|face| face.iter().any(|&n| patch.nodes[n as usize] != old[n as usize]))
                .collect();
            if folded.is_empty() {
                break;
            }
            folded.iter().flatten().for_each(|&n| patch.nodes[n as usize] = old[n as usize]);
        }
    }
}

fn value(node: &Node) -> Vec3 {
    Vec3::new(node.pixel.x, node.pixel.y, node.disparity)
}

/// For each node its two neighbours along the border; [`NONE`] inside.
fn along_border(faces: &[[u32; 3]], nodes: usize) -> Vec<[u32; 2]> {
    let mut beside = vec![[NONE; 2]; nodes];
    for (face, next) in faces.iter().zip(neighbours(faces)) {
        for k in 0..3 {
            if next[k] == NONE {
                let (a, b) = (face[k], face[(k + 1) % 3]);
                beside[a as usize][1] = b;
                beside[b as usize][0] = a;
            }
        }
    }
    beside
}
