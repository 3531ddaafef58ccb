//! The smooth displacement of the whole head that the landmarks suggest, before it bends.
//!
//! The differences between two heads are modelled as a random function of space: those of near
//! vertices are alike, and those of both sides of a face are. Given the landmarks and their
//! standard deviations, its expectation moves all vertices (universal kriging, Matheron 1969; a
//! smoothing spline). A landmark that contradicts the others is an outlier of the same model.

use faer::Mat;
use faer::prelude::Solve;
use rayon::prelude::*;

use super::super::LandmarkTarget;
use crate::data::Mesh;
use crate::math::{Vec3, median};
use crate::spatial::PointIndex;

/// Half the variance of the difference between the displacements of two vertices grows by this for
/// each mm of their distance, mm^2 per mm. With the next two constants it is the estimate of
/// greatest restricted likelihood from landmarks of heads in the size of the template: two
/// features, 30 mm apart, differ from the template's by a standard deviation of 4 mm in each
/// direction, and those of both sides are nearly alike.
const VARIANCE_PER_MM: f64 = 0.3;
/// Below this distance the displacement is smooth, mm.
const SMOOTH_MM: f64 = 5.0;
/// Standard deviation of the displacement of the whole head that registration leaves, mm.
const COMMON_SHIFT_MM: f64 = 5.0;
/// Correlation of the displacements of both sides of a symmetric template.
const SIDE_CORRELATION: f64 = 0.95;
/// A template is symmetric when half of its mirrored vertices have one within this distance, mm.
const SYMMETRY_TOLERANCE_MM: f64 = 5.0;
/// Squared deviation of a landmark from where the others expect it, in units of its variance and
/// summed over three directions, above which it is an outlier: 0.002 % of normal deviations.
const MAX_SQUARED_DEVIATION: f64 = 25.0;
/// At most this share of the landmarks are outliers.
const MAX_OUTLIER_SHARE: f64 = 0.34;
/// Least standard deviation of a landmark, mm: no vertex of a template is defined more exactly.
const MIN_SIGMA_MM: f64 = 0.3;

/// The mesh moved by the landmarks, and the landmarks with enlarged standard deviations where they
/// contradict the others. The mesh is at rest in the frame of the template.
pub(super) fn warp_by_landmarks(
    mesh: &Mesh,
    landmarks: &[LandmarkTarget],
) -> (Mesh, Vec<LandmarkTarget>) {
    let mut landmarks = landmarks.to_vec();
    landmarks.iter_mut().for_each(|l| l.sigma_mm = l.sigma_mm.max(MIN_SIGMA_MM));
    let field = Displacement::model(mesh, &landmarks);
    let most = (MAX_OUTLIER_SHARE * landmarks.len() as f64) as usize;
    for count in 0..=most {
        let Some(fit) = field.fit(mesh, &landmarks) else { break };
        if let Some((worst, distance_mm)) = fit.worst.filter(|_| count < most) {
            // as uncertain as it is wrong
            let own = &mut landmarks[worst];
            own.sigma_mm = own.sigma_mm.hypot(distance_mm);
            continue;
        }
        let moved = mesh.vertices.par_iter().map(|p| p + field.at(p, &fit.coefficients));
        let warped = mesh.with_vertices(moved.collect());
        return (warped, landmarks);
    }
    (mesh.clone(), landmarks)
}

/// The model of the displacements, with its centres at the landmarks of the mesh.
struct Displacement {
    centres: Vec<Vec3>,
    /// Correlation of mirrored positions: 0 for a template that is not symmetric.
    side_correlation: f64,
}

/// The displacement that fits the landmarks.
struct Fit {
    /// One for each centre, and the common shift.
    coefficients: Vec<Vec3>,
    /// The outlier that contradicts the others most: its position in the list, and its distance
    /// from where the others expect it, mm.
    worst: Option<(usize, f64)>,
}

impl Displacement {
    fn model(mesh: &Mesh, landmarks: &[LandmarkTarget]) -> Self {
        let centres = landmarks.iter().map(|l| mesh.vertices[l.vertex]).collect();
        Self { centres, side_correlation: if is_symmetric(mesh) { SIDE_CORRELATION } else { 0.0 } }
    }

    /// Generalised covariance of the displacements at two positions: along x, where mirrored
    /// displacements are opposite (`axis` 0), or along y and z.
    fn covariance(&self, a: &Vec3, b: &Vec3, axis: usize) -> f64 {
        let of_distance = |squared: f64| {
            -VARIANCE_PER_MM * ((squared + SMOOTH_MM * SMOOTH_MM).sqrt() - SMOOTH_MM)
        };
        let side = if axis == 0 { -self.side_correlation } else { self.side_correlation };
        of_distance((a - b).norm_squared()) + side * of_distance((a - mirrored(b)).norm_squared())
    }

    /// The equations of all landmarks in one direction, inverted.
    fn inverse(&self, landmarks: &[LandmarkTarget], axis: usize) -> Mat<f64> {
        let n = self.centres.len();
        let matrix = Mat::from_fn(n + 1, n + 1, |i, j| match (i < n, j < n) {
            (true, true) => {
                let noise = if i == j { landmarks[i].sigma_mm.powi(2) } else { 0.0 };
                noise + self.covariance(&self.centres[i], &self.centres[j], axis)
            }
            (false, false) => -1.0 / (COMMON_SHIFT_MM * COMMON_SHIFT_MM),
            _ => 1.0,
        });
        matrix.partial_piv_lu().solve(Mat::<f64>::identity(n + 1, n + 1))
    }

    /// The displacement that fits the landmarks best; `None` without a finite one.
    fn fit(&self, mesh: &Mesh, landmarks: &[LandmarkTarget]) -> Option<Fit> {
        let n = self.centres.len();
        let mut coefficients = vec![Vec3::zeros(); n + 1];
        let mut deviations = vec![(0.0, 0.0); n];
        let across = self.inverse(landmarks, 0);
        let along = self.inverse(landmarks, 1);
        for axis in 0..3 {
            let inverse = if axis == 0 { &across } else { &along };
            for i in 0..=n {
                let product = |(j, l): (usize, &LandmarkTarget)| {
                    inverse[(i, j)] * (l.position - mesh.vertices[l.vertex])[axis]
                };
                coefficients[i][axis] = landmarks.iter().enumerate().map(product).sum();
            }
            for (i, (squared, distance)) in deviations.iter_mut().enumerate() {
                // residual of the fit to the others, and its variance (Dubrule 1983)
                let variance = 1.0 / inverse[(i, i)].max(1e-12);
                let residual = coefficients[i][axis] * variance;
                *squared += residual * residual / variance;
                *distance = residual.hypot(*distance);
            }
        }
        let is_outlier = |(_, d): &(usize, &(f64, f64))| d.0 > MAX_SQUARED_DEVIATION;
        let worst = deviations
            .iter()
            .enumerate()
            .filter(is_outlier)
            .max_by(|a, b| a.1.0.total_cmp(&b.1.0))
            .map(|(i, d)| (i, d.1));
        let is_finite = coefficients.iter().all(|c| c.iter().all(|x| x.is_finite()));
        (n > 0 && is_finite).then_some(Fit { coefficients, worst })
    }

    fn at(&self, position: &Vec3, coefficients: &[Vec3]) -> Vec3 {
        let mut sum = coefficients[self.centres.len()];
        for (centre, c) in self.centres.iter().zip(coefficients) {
            let (across, along) =
                (self.covariance(position, centre, 0), self.covariance(position, centre, 1));
            sum += c.component_mul(&Vec3::new(across, along, along));
        }
        sum
    }
}

fn mirrored(p: &Vec3) -> Vec3 {
    Vec3::new(-p.x, p.y, p.z)
}

/// Whether the mesh is symmetric about the plane x = 0.
fn is_symmetric(mesh: &Mesh) -> bool {
    let Some(index) = PointIndex::<3>::new(&mesh.vertices) else { return false };
    let distance = |p: &Vec3| index.nearest(&mirrored(p).into()).map(|n| n.distance);
    let distances: Vec<f64> = mesh.vertices.par_iter().filter_map(distance).collect();
    median(&distances).is_some_and(|d| d < SYMMETRY_TOLERANCE_MM)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::template::head;

    /// The landmarks of the head as a smooth function moves them.
    fn moved_landmarks(motion: impl Fn(&Vec3) -> Vec3) -> (Mesh, Vec<LandmarkTarget>) {
        let head = head();
        let target = |&vertex: &usize| {
            let position = motion(&head.mesh.vertices[vertex]);
            LandmarkTarget { vertex, position, sigma_mm: 1.0 }
        };
        let landmarks = head.landmarks.values().map(target).collect();
        (head.mesh, landmarks)
    }

    /// A wider face with a lower jaw.
    fn wider(p: &Vec3) -> Vec3 {
        Vec3::new(1.06 * p.x, p.y - 0.04 * (20.0 - p.y).max(0.0), p.z + 1.0)
    }

    #[test]
    fn vertices_between_landmarks_follow_them_and_no_others_leave_the_head() {
        let (mesh, landmarks) = moved_landmarks(wider);
        let (warped, kept) = warp_by_landmarks(&mesh, &landmarks);
        assert_eq!(kept, landmarks);
        let mut far = Vec::new();
        for (p, q) in mesh.vertices.iter().zip(&warped.vertices) {
            if p.z > 60.0 && p.y.abs() < 70.0 {
                far.push((q - wider(p)).norm());
            }
            assert!((q - p).norm() < 12.0, "{p} {q}");
        }
        assert!(median(&far).unwrap() < 0.7, "{:?}", median(&far));
    }

    #[test]
    fn a_wrong_landmark_is_found_and_hardly_moves_the_head() {
        let (mesh, landmarks) = moved_landmarks(wider);
        let clean = warp_by_landmarks(&mesh, &landmarks).0;
        let mut wrong = landmarks.clone();
        wrong[7].position += Vec3::new(9.0, -14.0, 3.0);
        let (warped, kept) = warp_by_landmarks(&mesh, &wrong);
        for (i, l) in kept.iter().enumerate() {
            assert_eq!(l.sigma_mm > 5.0, i == 7, "{i}: {}", l.sigma_mm);
        }
        let apart = warped.vertices.iter().zip(&clean.vertices).map(|(a, b)| (a - b).norm());
        let apart = apart.fold(0.0, f64::max);
        assert!(apart < 1.5, "{apart}");
    }

    #[test]
    fn the_side_without_landmarks_follows_the_other() {
        let (mesh, landmarks) = moved_landmarks(wider);
        let one_side: Vec<LandmarkTarget> =
            landmarks.into_iter().filter(|l| mesh.vertices[l.vertex].x < 1.0).collect();
        let (warped, _) = warp_by_landmarks(&mesh, &one_side);
        let head = head();
        for name in ["eye_right_outer", "mouth_right"] {
            let v = head.landmarks[name];
            let (before, after) = (mesh.vertices[v], warped.vertices[v]);
            assert!(
                (after - wider(&before)).norm() < 0.6 * (wider(&before) - before).norm(),
                "{name}: {before} {after}"
            );
        }
        assert_eq!(warp_by_landmarks(&mesh, &[]).0, mesh);
    }
}
