//! Topology of a mesh: neighbours, borders, components.

use rayon::prelude::*;

use super::Mesh;

/// Neighbours and borders of a mesh's vertices.
#[derive(Clone, Debug, PartialEq)]
pub struct Topology {
    /// For each vertex its neighbours in ascending order.
    pub neighbours: Vec<Vec<u32>>,
    /// For each vertex whether it is on a border edge (an edge of one face).
    pub border: Vec<bool>,
    /// Number of edges that more than two faces share.
    pub non_manifold_edges: usize,
}

impl Topology {
    /// The topology of a valid mesh.
    pub fn new(mesh: &Mesh) -> Self {
        let sides = mesh.faces.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
        let mut edges: Vec<(u32, u32)> = sides.map(|(i, j)| (i.min(j), i.max(j))).collect();
        edges.par_sort_unstable();
        let mut neighbours = vec![Vec::new(); mesh.vertices.len()];
        let mut border = vec![false; mesh.vertices.len()];
        let mut non_manifold_edges = 0;
        for same in edges.chunk_by(|a, b| a == b) {
            let ((i, j), count) = (same[0], same.len());
            if i == j {
                continue;
            }
            neighbours[i as usize].push(j);
            neighbours[j as usize].push(i);
            if count == 1 {
                border[i as usize] = true;
                border[j as usize] = true;
            } else if count > 2 {
                non_manifold_edges += 1;
            }
        }
        neighbours.iter_mut().for_each(|n| n.sort_unstable());
        Self { neighbours, border, non_manifold_edges }
    }

    /// For each vertex the number of edges to the nearest border; `u32::MAX` where its connected
    /// component has no border.
    pub fn rings_from_border(&self) -> Vec<u32> {
        let mut ring = vec![u32::MAX; self.neighbours.len()];
        let mut current: Vec<u32> =
            (0..ring.len() as u32).filter(|&v| self.border[v as usize]).collect();
        current.iter().for_each(|&v| ring[v as usize] = 0);
        let mut depth = 0;
        while !current.is_empty() {
            depth += 1;
            let mut next = Vec::new();
            for &v in &current {
                for &n in &self.neighbours[v as usize] {
                    if ring[n as usize] == u32::MAX {
                        ring[n as usize] = depth;
                        next.push(n);
                    }
                }
            }
            current = next;
        }
        ring
    }

    /// For each vertex the index of its connected component, in the order of the components' first
    /// vertices.
    pub fn components(&self) -> Vec<u32> {
        let mut component = vec![u32::MAX; self.neighbours.len()];
        let mut count = 0;
        for start in 0..component.len() {
            if component[start] != u32::MAX {
                continue;
            }
            let mut stack = vec![start as u32];
            component[start] = count;
            while let Some(v) = stack.pop() {
                for &n in &self.neighbours[v as usize] {
                    if component[n as usize] == u32::MAX {
                        component[n as usize] = count;
                        stack.push(n);
                    }
                }
            }
            count += 1;
        }
        component
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;

    #[test]
    fn a_fan_has_one_inner_vertex() {
        let mut vertices = vec![Vec3::zeros()];
        for i in 0..6 {
            let a = f64::from(i);
            vertices.push(Vec3::new(a.cos(), a.sin(), 0.0));
        }
        let faces = (0..6).map(|i| [0, 1 + i, 1 + (i + 1) % 6]).collect();
        let topology = Topology::new(&Mesh { vertices, faces, ..Mesh::default() });
        assert_eq!(topology.neighbours[0].len(), 6);
        assert!(!topology.border[0] && topology.border[1]);
        assert_eq!(topology.rings_from_border()[0], 1);
        assert_eq!(topology.components(), vec![0; 7]);
        assert_eq!(topology.non_manifold_edges, 0);
    }
}
