//! Thin parts (ears, the wings of the nose) stay thin sheets of flesh.
//!
//! The photos measure one side of them. The other has few data or none, and along the skin the way
//! from one to the other is long: the measured side could be pushed through it.

use rayon::prelude::*;

use super::matching::Found;
use crate::data::{Mesh, Topology};
use crate::math::Vec3;
use crate::spatial::SurfaceIndex;

/// Flesh thicker than this is no thin part, mm.
const THICK_MM: f64 = 6.0;
/// Steps into the flesh in search of the other side, mm.
const STEP_MM: f64 = 1.0;
/// Greatest cosine between the normals of both sides.
const OPPOSITE: f64 = -0.5;
/// Part of its thickness that a sheet keeps.
const KEPT: f64 = 0.6;
/// Rounds in which neighbours follow, so that the unmeasured side stays smooth.
const ROUNDS: usize = 8;

/// The place on the other side of the flesh behind a vertex, on the mesh at rest.
struct Behind {
    corners: [usize; 3],
    barycentric: [f64; 3],
    thickness: f64,
}

/// Moves the side of thin parts that has fewer data out of the way of the other. `normals` and
/// `topology` are those of the mesh at rest.
pub(super) fn keep_apart(
    rest: &Mesh,
    normals: &[Vec3],
    topology: &Topology,
    bent: &mut Mesh,
    found: &[Found],
) {
    let Some(index) = SurfaceIndex::new(rest) else { return };
    let mut data = vec![0.0; rest.vertices.len()];
    for f in found {
        (0..3).for_each(|k| data[f.corners[k]] += f.weight * f.barycentric[k]);
    }
    let behind = |v: usize| -> Option<Behind> {
        let (at, inward) = (rest.vertices[v], -normals[v]);
        let steps = (THICK_MM / STEP_MM) as usize;
        (1..=steps).find_map(|k| {
            let depth = k as f64 * STEP_MM;
            let hit = index.closest_within(&(at + inward * depth), STEP_MM)?;
            let corners = rest.faces[hit.face].map(|i| i as usize);
            let normal: Vec3 = (0..3).map(|k| normals[corners[k]] * hit.barycentric[k]).sum();
            let more: f64 = (0..3).map(|k| data[corners[k]] * hit.barycentric[k]).sum();
            let thickness = (hit.point - at).dot(&inward);
            let other = normal.dot(&normals[v]) < OPPOSITE * normal.norm()
                && thickness > 0.0
                && more > data[v];
            other.then_some(Behind { corners, barycentric: hit.barycentric, thickness })
        })
    };
    let outward = bent.vertex_normals();
    let mut pushed: Vec<f64> = (0..rest.vertices.len())
        .into_par_iter()
        .map(|v| {
            let Some(b) = behind(v) else { return 0.0 };
            let foot: Vec3 = (0..3).map(|k| bent.vertices[b.corners[k]] * b.barycentric[k]).sum();
            let left = (bent.vertices[v] - foot).dot(&outward[v]);
            (KEPT * b.thickness - left).clamp(0.0, THICK_MM)
        })
        .collect();
    if pushed.iter().all(|p| *p == 0.0) {
        return;
    }
    for _ in 0..ROUNDS {
        let last = pushed.clone();
        for (v, near) in topology.neighbours.iter().enumerate().filter(|(v, _)| data[*v] == 0.0) {
            let around: f64 = near.iter().map(|&n| last[n as usize]).sum();
            pushed[v] = pushed[v].max(around / near.len().max(1) as f64);
        }
    }
    for (v, push) in pushed.iter().enumerate() {
        bent.vertices[v] += outward[v] * *push;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A slab of 13x13 vertices a side, 2 mm apart, 3 mm thick: front (+z) first, then back.
    fn slab() -> Mesh {
        let n = 13u32;
        let mut mesh = Mesh::default();
        for z in [0.0, -3.0] {
            let row =
                |y: u32| (0..n).map(move |x| Vec3::new(f64::from(2 * x), f64::from(2 * y), z));
            mesh.vertices.extend((0..n).flat_map(row));
        }
        for (first, turned) in [(0, false), (n * n, true)] {
            for y in 0..n - 1 {
                for x in 0..n - 1 {
                    let [a, b] = [first + y * n + x, first + (y + 1) * n + x];
                    for [i, j, k] in [[a, a + 1, b], [a + 1, b + 1, b]] {
                        mesh.faces.push(if turned { [i, k, j] } else { [i, j, k] });
                    }
                }
            }
        }
        mesh
    }

    #[test]
    fn the_back_of_a_sheet_gives_way_to_its_measured_front() {
        let rest = slab();
        let half = rest.vertices.len() / 2;
        let found: Vec<Found> = (0..half)
            .map(|v| Found {
                data: rest.vertices[v],
                corners: [v; 3],
                barycentric: [1.0, 0.0, 0.0],
                foot: rest.vertices[v],
                normal: Vec3::z(),
                weight: 1.0,
                cell: 0,
                island: None,
            })
            .collect();
        let mut bent = rest.clone();
        bent.vertices[..half].iter_mut().for_each(|v| v.z -= 4.0);
        let before = bent.clone();
        let (normals, topology) = (rest.vertex_normals(), Topology::new(&rest));
        keep_apart(&rest, &normals, &topology, &mut bent, &found);
        assert_eq!(bent.vertices[..half], before.vertices[..half], "the measured side moved");
        for (front, back) in bent.vertices[..half].iter().zip(&bent.vertices[half..]) {
            assert!(front.z - back.z > 0.99 * KEPT * 3.0, "{front} {back}");
        }
        // a sheet that kept its thickness stays as it is
        let mut calm = rest.clone();
        keep_apart(&rest, &normals, &topology, &mut calm, &found);
        assert_eq!(calm, rest);
    }
}
