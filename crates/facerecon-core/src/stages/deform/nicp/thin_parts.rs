//! Thin parts (ears, the wings of the nose) keep their thickness.
//!
//! The photos measure one side of them. The other side has few data or none, and along the skin the
//! two sides are far apart: the measured side could be pushed through the other.

use rayon::prelude::*;

use super::surface_match::SurfaceMatch;
use crate::data::{Mesh, Topology};
use crate::math::{Vec3, interpolate};
use crate::spatial::SurfaceIndex;

/// Greatest thickness of a thin part, mm: that of an ear.
const MAX_THICKNESS_MM: f64 = 6.0;
/// Step of the search for the opposite side, mm.
const STEP_MM: f64 = 1.0;
/// Greatest cosine between the normals of opposite sides.
const MAX_COSINE: f64 = -0.5;
/// Share of its thickness that a thin part keeps at least. More would not let a thinner ear
/// than the template's be fitted.
const KEPT_SHARE: f64 = 0.6;
/// Rounds in which the neighbours follow, so that the unmeasured side stays smooth.
const SMOOTHING_ROUNDS: usize = 8;

/// The closest point on the opposite side of a vertex, on the mesh at rest.
struct OppositePoint {
    corners: [usize; 3],
    barycentric: [f64; 3],
    thickness_mm: f64,
}

/// Moves the less measured side of thin parts out of the way of the other. `normals` and
/// `topology` are those of the mesh at rest.
pub(super) fn keep_thickness(
    rest: &Mesh,
    normals: &[Vec3],
    topology: &Topology,
    bent: &mut Mesh,
    matches: &[SurfaceMatch],
) {
    let Some(index) = SurfaceIndex::new(rest) else { return };
    let mut support = vec![0.0; rest.vertices.len()];
    for m in matches {
        (0..3).for_each(|k| support[m.corners[k]] += m.weight * m.barycentric[k]);
    }
    let outward = bent.vertex_normals();
    let mut pushed_mm: Vec<f64> = (0..rest.vertices.len())
        .into_par_iter()
        .map(|v| {
            let opposite = opposite_point(rest, normals, &support, &index, v);
            let Some(o) = opposite else { return 0.0 };
            let other_side = interpolate(o.corners.map(|c| bent.vertices[c]), o.barycentric);
            let thickness_mm = (bent.vertices[v] - other_side).dot(&outward[v]);
            (KEPT_SHARE * o.thickness_mm - thickness_mm).clamp(0.0, MAX_THICKNESS_MM)
        })
        .collect();
    if pushed_mm.iter().all(|p| *p == 0.0) {
        return;
    }
    for _ in 0..SMOOTHING_ROUNDS {
        let last = pushed_mm.clone();
        let unmeasured = topology.neighbours.iter().enumerate().filter(|(v, _)| support[*v] == 0.0);
        for (v, near) in unmeasured {
            let sum: f64 = near.iter().map(|&n| last[n as usize]).sum();
            pushed_mm[v] = pushed_mm[v].max(sum / near.len().max(1) as f64);
        }
    }
    for (v, push) in pushed_mm.iter().enumerate() {
        bent.vertices[v] += outward[v] * *push;
    }
}

/// The opposite side of a thin part at a vertex, where that side has more data.
fn opposite_point(
    rest: &Mesh,
    normals: &[Vec3],
    support: &[f64],
    index: &SurfaceIndex,
    v: usize,
) -> Option<OppositePoint> {
    let (vertex, inward) = (rest.vertices[v], -normals[v]);
    let steps = (MAX_THICKNESS_MM / STEP_MM) as usize;
    (1..=steps).find_map(|k| {
        let depth_mm = k as f64 * STEP_MM;
        let closest = index.closest_within(&(vertex + inward * depth_mm), STEP_MM)?;
        let corners = rest.faces[closest.face].map(|i| i as usize);
        let normal = interpolate(corners.map(|c| normals[c]), closest.barycentric);
        let its_support = interpolate(corners.map(|c| support[c]), closest.barycentric);
        let thickness_mm = (closest.point - vertex).dot(&inward);
        let is_opposite = normal.dot(&normals[v]) < MAX_COSINE * normal.norm()
            && thickness_mm > 0.0
            && its_support > support[v];
        is_opposite.then_some(OppositePoint {
            corners,
            barycentric: closest.barycentric,
            thickness_mm,
        })
    })
}

#[cfg(test)]
mod tests {
    use super::super::surface_match::fixtures::match_at;
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
    fn the_back_of_a_sheet_moves_away_from_its_measured_front() {
        let rest = slab();
        let half = rest.vertices.len() / 2;
        let matches: Vec<SurfaceMatch> =
            (0..half).map(|v| match_at(&rest, v, rest.vertices[v])).collect();
        let mut bent = rest.clone();
        bent.vertices[..half].iter_mut().for_each(|v| v.z -= 4.0);
        let before = bent.clone();
        let (normals, topology) = (rest.vertex_normals(), Topology::new(&rest));
        keep_thickness(&rest, &normals, &topology, &mut bent, &matches);
        assert_eq!(bent.vertices[..half], before.vertices[..half], "the measured side moved");
        for (front, back) in bent.vertices[..half].iter().zip(&bent.vertices[half..]) {
            assert!(front.z - back.z > 0.99 * KEPT_SHARE * 3.0, "{front} {back}");
        }
        // a sheet that kept its thickness stays as it is
        let mut unchanged = rest.clone();
        keep_thickness(&rest, &normals, &topology, &mut unchanged, &matches);
        assert_eq!(unchanged, rest);
    }
}
