//! How well each vertex of the finished mesh is known.
//!
//! A vertex is measured where measured points lie close to it on the side of the surface that the
//! cameras see. Its standard deviation along the normal has three parts: that of the points near it,
//! projected onto the normal; that of the whole surface, because the errors of neighbouring points
//! are correlated and one patch alone does not show them; and the distances of these points from the
//! tangent plane of the mesh. For all other vertices the standard deviation of the nearest measured
//! vertex grows with the way along the mesh, up to the spread of human heads.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use rayon::prelude::*;

use crate::data::{Cloud, Mesh, Topology};
use crate::math::{Vec3, median};
use crate::spatial::PointIndex;

/// Points near a vertex that tell its uncertainty: about two pixels around it.
const NEIGHBOURS: usize = 12;
/// A vertex is measured when a point lies within this many spacings of the points: holes of single
/// pixels are bridged.
const SUPPORT_SPACINGS: f64 = 2.0;
/// Points whose spacing is measured; the median of more is the same.
const SPACING_SAMPLES: usize = 2000;
/// Weight of the variance of the points near the vertex.
const LOCAL_VARIANCE: f64 = 0.2;
/// Weight of the median variance of the surface. Together with the misfit the two weights give a
/// median of the error over sigma of about 0.67, that of a normal distribution, on captures with
/// known truth.
const SURFACE_VARIANCE: f64 = 0.6;
/// Increase of the standard deviation for each mm of way along the mesh from the measured region:
/// the median error of extrapolated skin and hair at 1 to 20 mm is 0.3 to 0.4 mm for each mm.
const GROWTH: f64 = 0.5;
/// Spread of the skull, mm: standard deviation of the length of adult heads (ANSUR II, 2012: 7.1 mm
/// for men, 6.9 mm for women).
const SKULL_SPREAD_MM: f64 = 7.0;
/// Spread of the thickness of hair, mm: from none to about 30.
const HAIR_SPREAD_MM: f64 = 10.0;

/// A mesh with the standard deviation and the measured flag of its vertices. `points` are the
/// measured points and `camera` the centre of the left camera, both in the frame of the mesh.
/// Without points nothing is measured.
pub(super) fn with_uncertainty(mesh: Mesh, points: &Cloud, camera: &Vec3) -> Mesh {
    let supports = supports(&mesh, points, camera);
    let typical = |pick: fn(&Support) -> f64| {
        let values: Vec<f64> = supports.iter().flatten().map(pick).collect();
        median(&values).unwrap_or(0.0)
    };
    // without standard deviations of the points, the misfit alone tells the errors
    let surface =
        if points.sigmas.is_empty() { typical(|s| s.misfit) } else { typical(|s| s.sigma) };
    let variance = |s: &Support| {
        LOCAL_VARIANCE * s.sigma.powi(2) + SURFACE_VARIANCE * surface.powi(2) + s.misfit.powi(2)
    };
    let measured_sigmas: Vec<Option<f64>> =
        supports.iter().map(|s| s.as_ref().map(|s| variance(s).sqrt())).collect();
    let reached = reach(&mesh, &measured_sigmas);
    let spread = SKULL_SPREAD_MM.hypot(HAIR_SPREAD_MM);
    let sigmas = measured_sigmas.iter().zip(&reached).map(|(own, reached)| match (own, reached) {
        (Some(sigma), _) => *sigma,
        (None, Some((way, sigma))) => sigma.hypot(spread * (1.0 - (-GROWTH * way / spread).exp())),
        (None, None) => spread,
    });
    Mesh {
        sigmas: sigmas.collect(),
        measured: measured_sigmas.iter().map(Option::is_some).collect(),
        ..mesh
    }
}

/// What the points near a measured vertex say, in the unit of the mesh.
struct Support {
    /// Median standard deviation of the points along the normal; 0 where it is unknown.
    sigma: f64,
    /// Root mean square distance of the points from the tangent plane.
    misfit: f64,
}

/// The support of each vertex; `None` where it is not measured.
fn supports(mesh: &Mesh, points: &Cloud, camera: &Vec3) -> Vec<Option<Support>> {
    let Some(index) = PointIndex::<3>::new(&points.points) else {
        return mesh.vertices.iter().map(|_| None).collect();
    };
    let radius = SUPPORT_SPACINGS * spacing(&index, &points.points);
    let normals = mesh.vertex_normals();
    let of_vertex = |(vertex, normal): (&Vec3, &Vec3)| {
        let near = index.nearest_n(&[vertex.x, vertex.y, vertex.z], NEIGHBOURS);
        let cosine = normal.dot(&(camera - vertex).try_normalize(f64::MIN_POSITIVE)?);
        if cosine <= 0.0 || near.first()?.distance > radius {
            return None;
        }
        let offsets = near.iter().filter_map(|n| points.points.get(n.index));
        let squares: f64 = offsets.map(|p| normal.dot(&(p - vertex)).powi(2)).sum();
        let sigmas: Vec<f64> =
            near.iter().filter_map(|n| points.sigmas.get(n.index).copied()).collect();
        Some(Support {
            sigma: median(&sigmas).unwrap_or(0.0) * cosine,
            misfit: (squares / near.len() as f64).sqrt(),
        })
    };
    mesh.vertices.par_iter().zip(&normals).map(of_vertex).collect()
}

/// Median distance of a point from the next one.
fn spacing(index: &PointIndex<3>, points: &[Vec3]) -> f64 {
    let step = points.len().div_ceil(SPACING_SAMPLES).max(1);
    let next = |p: &Vec3| index.distance_to_next(&[p.x, p.y, p.z]);
    let distances: Vec<f64> = points.iter().step_by(step).filter_map(next).collect();
    median(&distances).unwrap_or(0.0)
}

/// For each vertex the way along the edges from the nearest measured one, with the standard
/// deviation there; `None` where no way leads to one.
fn reach(mesh: &Mesh, sigmas: &[Option<f64>]) -> Vec<Option<(f64, f64)>> {
    let neighbours = Topology::new(mesh).neighbours;
    let mut reached: Vec<Option<(f64, f64)>> = sigmas.iter().map(|s| Some((0.0, (*s)?))).collect();
    // ways are not negative, so that the order of their bits is the order of their lengths
    let start = |(v, r): (usize, &Option<(f64, f64)>)| r.is_some().then_some(Reverse((0_u64, v)));
    let mut queue: BinaryHeap<_> = reached.iter().enumerate().filter_map(start).collect();
    while let Some(Reverse((bits, vertex))) = queue.pop() {
        let Some((way, sigma)) = reached[vertex] else { continue };
        if way.to_bits() != bits {
            continue; // a shorter way was found
        }
        for &next in &neighbours[vertex] {
            let next = next as usize;
            let longer = way + (mesh.vertices[next] - mesh.vertices[vertex]).norm();
            if longer.is_finite() && reached[next].is_none_or(|(known, _)| longer < known) {
                reached[next] = Some((longer, sigma));
                queue.push(Reverse((longer.to_bits(), next)));
            }
        }
    }
    reached
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::test_meshes::open_grid;

    const CAMERA: Vec3 = Vec3::new(50.0, 50.0, 1000.0);

    /// A sheet of 100 x 100 mm that faces the camera, and points on its left half, `lift` above it.
    fn sheet(lift: f64, sigma: f64) -> (Mesh, Cloud) {
        let mesh = open_grid(50, 50, |x, y| Vec3::new(x, y, 0.0) * (100.0 / 49.0));
        let at = |i: i32| f64::from(i) + 0.5;
        let points: Vec<Vec3> = (0..5000)
            .map(|i| Vec3::new(at(i % 50), at(i / 50), if i % 2 == 0 { lift } else { -lift }))
            .collect();
        let sigmas = vec![sigma; points.len()];
        (mesh, Cloud { points, sigmas, ..Cloud::default() })
    }

    fn at(mesh: &Mesh, x: f64, y: f64) -> usize {
        let far = |v: &Vec3| (v - Vec3::new(x, y, 0.0)).norm();
        (0..mesh.vertices.len())
            .min_by(|a, b| far(&mesh.vertices[*a]).total_cmp(&far(&mesh.vertices[*b])))
            .unwrap()
    }

    #[test]
    fn measured_vertices_follow_the_points_and_others_the_way_to_them() {
        let (mesh, cloud) = sheet(0.0, 0.2);
        let mesh = with_uncertainty(mesh, &cloud, &CAMERA);
        assert!(mesh.has_uncertainty() && mesh.validate().is_ok());
        let (inside, near, far) =
            (at(&mesh, 25.0, 50.0), at(&mesh, 60.0, 50.0), at(&mesh, 98.0, 50.0));
        assert_eq!([inside, near, far].map(|v| mesh.measured[v]), [true, false, false]);
        assert!(
            (mesh.sigmas[inside] - 0.2 * 0.8_f64.sqrt()).abs() < 0.01,
            "{}",
            mesh.sigmas[inside]
        );
        assert!((3.0..6.0).contains(&mesh.sigmas[near]), "{}", mesh.sigmas[near]);
        assert!(mesh.sigmas[far] > mesh.sigmas[near] && mesh.sigmas[far] < 12.3);
    }

    #[test]
    fn a_misfit_of_the_points_raises_the_standard_deviation() {
        let (mesh, cloud) = sheet(1.5, 0.2);
        let v = at(&mesh, 25.0, 50.0);
        assert!(with_uncertainty(mesh, &cloud, &CAMERA).sigmas[v] > 1.5);
    }

    #[test]
    fn a_surface_that_faces_away_or_without_points_is_not_measured() {
        let (mesh, cloud) = sheet(0.0, 0.2);
        let behind = with_uncertainty(mesh.clone(), &cloud, &Vec3::new(50.0, 50.0, -1000.0));
        assert!(behind.measured.iter().all(|m| !m));
        let bare = with_uncertainty(mesh, &Cloud::default(), &CAMERA);
        assert!(bare.measured.iter().all(|m| !m) && bare.sigmas.iter().all(|s| *s > 10.0));
    }
}
