//! Making a patch manifold.

use super::adjacency::{NONE, neighbours};
use super::patch::Patch;

/// Gives each fan of faces its own node where several meet in one node only, and removes nodes
/// without faces. The patch is manifold afterwards.
pub(super) fn split_shared_nodes(patch: &mut Patch) {
    let neighbours = neighbours(&patch.faces);
    let mut new_faces = vec![[NONE; 3]; patch.faces.len()];
    let mut nodes = Vec::with_capacity(patch.nodes.len());
    for start in 0..patch.faces.len() {
        for corner in 0..3 {
            if new_faces[start][corner] != NONE {
                continue;
            }
            let node = patch.faces[start][corner];
            let new_node = nodes.len() as u32;
            nodes.push(patch.nodes[node as usize]);
            let mut pending = vec![start];
            while let Some(face) = pending.pop() {
                let Some(k) = patch.faces[face].iter().position(|&n| n == node) else {
                    continue;
                };
                if new_faces[face][k] != NONE {
                    continue;
                }
                new_faces[face][k] = new_node;
                // across the two edges that meet in this corner
                for edge in [k, (k + 2) % 3] {
                    let next = neighbours[face][edge];
                    if next != NONE {
                        pending.push(next as usize);
                    }
                }
            }
        }
    }
    patch.nodes = nodes;
    patch.faces = new_faces;
}
