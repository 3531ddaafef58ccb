//! A measured point with its closest point on the template, and sums over such matches.

use crate::data::Mesh;
use crate::math::{PlanePair, Vec3, interpolate, plane_rms};

/// A measured point and its closest point on the surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfaceMatch {
    /// Position of the measured point.
    pub data: Vec3,
    /// Vertices of the face that the closest point lies on.
    pub corners: [usize; 3],
    pub barycentric: [f64; 3],
    pub closest_point: Vec3,
    /// Smooth unit normal of the surface at the closest point.
    pub normal: Vec3,
    /// Weight from uncertainty and residual.
    pub weight: f64,
    /// Grid cell of the measured point.
    pub cell: u32,
    /// Small component of the measured point.
    pub small_component: Option<u32>,
}

impl SurfaceMatch {
    /// The value at the closest point, from one value for each vertex.
    #[inline]
    pub fn interpolate(&self, values: &[Vec3]) -> Vec3 {
        interpolate(self.corners.map(|v| values[v]), self.barycentric)
    }

    /// The signed distance from the surface along its normal.
    pub fn residual(&self) -> f64 {
        self.normal.dot(&(self.data - self.closest_point))
    }
}

/// The matches as pairs for a rigid or similarity step.
pub(super) fn plane_pairs(matches: &[SurfaceMatch]) -> Vec<PlanePair> {
    matches
        .iter()
        .map(|m| PlanePair {
            point: m.data,
            closest_point: m.closest_point,
            normal: m.normal,
            weight: m.weight,
        })
        .collect()
}

/// Weighted RMS distance along the normals to the same surface points on a moved mesh.
pub(super) fn rms_on(mesh: &Mesh, matches: &[SurfaceMatch]) -> f64 {
    let mut pairs = plane_pairs(matches);
    for (pair, m) in pairs.iter_mut().zip(matches) {
        pair.closest_point = m.interpolate(&mesh.vertices);
    }
    plane_rms(&pairs)
}

/// Weight of each match in an integral over the surface: the area of the faces that have matches
/// or touch one that does, for each match, mm^2. A sum over points with it becomes an integral
/// over the surface, whatever the density of the points.
pub(super) fn area_per_match(mesh: &Mesh, matches: &[SurfaceMatch]) -> f64 {
    let mut near = vec![false; mesh.vertices.len()];
    matches.iter().flat_map(|m| m.corners).for_each(|v| near[v] = true);
    let covered = |f: &&[u32; 3]| f.iter().all(|&v| near[v as usize]);
    let area: f64 = mesh.faces.iter().filter(covered).map(|f| face_area(mesh, f)).sum();
    area / matches.len().max(1) as f64
}

/// Area of one face, mm^2.
pub(super) fn face_area(mesh: &Mesh, face: &[u32; 3]) -> f64 {
    let [a, b, c] = face.map(|i| mesh.vertices[i as usize]);
    (b - a).cross(&(c - a)).norm() / 2.0
}

/// Test meshes and matches that the modules of non-rigid ICP share.
#[cfg(test)]
pub(super) mod fixtures {
    use super::*;
    use crate::data::test_meshes::open_grid;

    /// A flat sheet of `n` x `n` vertices, `step` mm apart, facing +z.
    pub(in super::super) fn sheet(n: u32, step: f64) -> Mesh {
        open_grid(n, n, |x, y| Vec3::new(x, y, 0.0) * step)
    }

    /// A match of weight 1 at a vertex, with the measured point at `data`.
    pub(in super::super) fn match_at(mesh: &Mesh, vertex: usize, data: Vec3) -> SurfaceMatch {
        SurfaceMatch {
            data,
            corners: [vertex; 3],
            barycentric: [1.0, 0.0, 0.0],
            closest_point: mesh.vertices[vertex],
            normal: Vec3::z(),
            weight: 1.0,
            cell: 0,
            small_component: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::fixtures::{match_at, sheet};
    use super::*;

    #[test]
    fn the_rms_distance_is_measured_along_the_normals() {
        let mesh = sheet(4, 2.0);
        let mut matches: Vec<SurfaceMatch> = (0..16)
            .map(|v| match_at(&mesh, v, mesh.vertices[v] + Vec3::new(0.7, -0.4, 0.5)))
            .collect();
        assert!((rms_on(&mesh, &matches) - 0.5).abs() < 1e-12);
        let raised = mesh.vertices.iter().map(|p| p + Vec3::z() * 2.0).collect();
        assert!((rms_on(&mesh.with_vertices(raised), &matches) - 1.5).abs() < 1e-12);
        assert!((matches[3].residual() - 0.5).abs() < 1e-12);
        // a match without weight does not count
        matches[0].data.z = 90.0;
        matches[0].weight = 0.0;
        assert!((rms_on(&mesh, &matches) - 0.5).abs() < 1e-12);
    }

    #[test]
    fn the_area_of_a_match_is_the_covered_area_over_their_number() {
        let mesh = sheet(5, 3.0);
        let all: Vec<SurfaceMatch> =
            (0..25).map(|v| match_at(&mesh, v, mesh.vertices[v])).collect();
        assert!((area_per_match(&mesh, &all) - 144.0 / 25.0).abs() < 1e-9);
        // the vertices of one square of 3 mm
        let square: Vec<SurfaceMatch> = [0, 1, 5, 6].map(|v| all[v]).to_vec();
        assert!((area_per_match(&mesh, &square) - 9.0 / 4.0).abs() < 1e-9);
        assert_eq!(area_per_match(&mesh, &[]), 0.0);
    }
}
