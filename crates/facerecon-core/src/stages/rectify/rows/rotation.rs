//! Rotation of two uncalibrated cameras that makes rows level.

use nalgebra::{Rotation3, RowVector3, SMatrix, SVector};

use super::affine::RowAffine;
use super::corners::CornerPair;
use crate::math::{Mat3, Vec2, Vec3, median};

/// Assumed focal length in widths of the photo: face rigs use long lenses, two to four widths. Only
/// products of angle and 1 / focal length are observable, so a wrong value changes the angles, not
/// the pictures.
const FOCAL_WIDTHS: f64 = 3.0;
/// Standard deviation of half the toe-in before any corner is seen, radians. Few corners on a
/// narrow face hardly determine the toe-in; then it stays near 0. Set by hand.
const TOE_IN_SIGMA: f64 = 0.15;
/// A roll (degrees) or a zoom (logarithm) from which on windows of both photos look different.
/// Set by hand.
const LARGE_ROLL_DEG: f64 = 1.5;
const LARGE_ZOOM: f64 = 0.02;
/// Gauss-Newton: steps, step of the numerical derivatives, step that counts as converged.
const MAX_STEPS: usize = 15;
const DERIVATIVE_STEP: f64 = 1e-5;
const CONVERGED: f64 = 1e-9;
/// Samples of three corners in the consensus. With half of the corners wrong, 400 samples miss the
/// right model with a probability below 1e-20.
const SAMPLES: usize = 400;
/// Corners that the consensus needs: more than twice a sample.
const MIN_CONSENSUS_CORNERS: usize = 8;
/// Samples with more roll (radians) or relative scale than this are degenerate.
const MAX_SAMPLE_SLOPE: f64 = 0.3;

/// Two cameras of one unknown focal length rotated about their centres until rows are level (after
/// Fusiello and Irsara 2008): the right one pitches, rolls and zooms, and both turn inward by the
/// same angle. Toe-in curves rows and columns alike, so the toe-in seen in the rows also removes
/// the curvature of the disparities, whatever the focal length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LevellingRotation {
    size: (usize, usize),
    focal_px: f64,
    /// Pitch, half the toe-in, roll (radians), logarithm of the zoom.
    parameters: SVector<f64, 4>,
}

impl LevellingRotation {
    /// No rotation, for photos of a size.
    pub(super) fn none(size: (usize, usize)) -> Self {
        Self { size, focal_px: FOCAL_WIDTHS * size.0 as f64, parameters: SVector::zeros() }
    }

    pub(super) fn roll_deg(&self) -> f64 {
        self.parameters[2].to_degrees()
    }

    /// Whether it rolls or zooms so much that windows of the photos look different.
    pub(super) fn is_large(&self) -> bool {
        self.roll_deg().abs() > LARGE_ROLL_DEG || self.parameters[3].abs() > LARGE_ZOOM
    }

    pub(super) fn zoom(&self) -> f64 {
        self.parameters[3].exp()
    }

    /// Homographies from photo to level picture, `[left, right]`; the middle of each photo keeps
    /// its column.
    pub(super) fn homographies(&self) -> [Mat3; 2] {
        let middle =
            Vec3::new((self.size.0 as f64 - 1.0) / 2.0, (self.size.1 as f64 - 1.0) / 2.0, 1.0);
        let f = self.focal_px;
        let k = Mat3::new(f, 0.0, middle.x, 0.0, f, middle.y, 0.0, 0.0, 1.0);
        let inverse =
            Mat3::new(1.0 / f, 0.0, -middle.x / f, 0.0, 1.0 / f, -middle.y / f, 0.0, 0.0, 1.0);
        let [pitch, yaw, roll, zoom]: [f64; 4] = self.parameters.into();
        let keep_column = |h: Mat3| {
            let q = h * middle;
            let mut shift = Mat3::identity();
            shift[(0, 2)] = middle.x - q.x / q.z;
            shift * h
        };
        let rotation = |x: f64, y: f64, z: f64| Rotation3::from_euler_angles(x, y, z).into_inner();
        let zoomed = Mat3::from_diagonal(&Vec3::new(1.0 / zoom.exp(), 1.0 / zoom.exp(), 1.0));
        [
            keep_column(k * rotation(0.0, -yaw, 0.0) * inverse),
            keep_column(k * rotation(pitch, yaw, roll) * zoomed * inverse),
        ]
    }

    /// Row differences in the level pictures, pixels.
    fn differences(&self, corners: &[CornerPair]) -> Vec<f64> {
        let [left, right] = self.homographies();
        corners
            .iter()
            .map(|s| transformed(&right, s.right).y - transformed(&left, s.left).y)
            .collect()
    }

    /// Robust Gauss-Newton from this rotation, with weights of scale `width_px`.
    pub(super) fn fitted(mut self, corners: &[CornerPair], width_px: f64) -> Option<Self> {
        for _ in 0..MAX_STEPS {
            let now = self.differences(corners);
            let columns = self.derivatives(corners, &now);
            let mut normal = SMatrix::<f64, 4, 4>::zeros();
            let mut right = SVector::<f64, 4>::zeros();
            for (n, dy) in now.iter().enumerate() {
                let weight = 1.0 / (1.0 + (dy / width_px).powi(2)).powi(2);
                let j = SVector::<f64, 4>::from_fn(|i, _| columns[i][n]);
                normal += weight * j * j.transpose();
                right -= weight * dy * j;
            }
            normal[(1, 1)] += 1.0 / TOE_IN_SIGMA.powi(2);
            right[1] -= self.parameters[1] / TOE_IN_SIGMA.powi(2);
            let step = normal.cholesky()?.solve(&right);
            self.parameters += step;
            if !self.parameters.iter().all(|p| p.is_finite()) {
                return None;
            }
            if step.norm() < CONVERGED {
                break;
            }
        }
        Some(self)
    }

    /// Derivatives of the row differences by each parameter.
    fn derivatives(&self, corners: &[CornerPair], now: &[f64]) -> [Vec<f64>; 4] {
        std::array::from_fn(|i| {
            let mut other = *self;
            other.parameters[i] += DERIVATIVE_STEP;
            let there = other.differences(corners);
            there.iter().zip(now).map(|(a, b)| (a - b) / DERIVATIVE_STEP).collect()
        })
    }

    /// Median absolute row difference of the inliers (within `width_px`), and their number.
    pub(super) fn residual(&self, corners: &[CornerPair], width_px: f64) -> (f64, usize) {
        let within: Vec<f64> =
            self.differences(corners).into_iter().map(f64::abs).filter(|d| *d < width_px).collect();
        (median(&within).unwrap_or(f64::INFINITY), within.len())
    }

    /// The rotation with most inliers (within `width_px`) of those that samples of three corners
    /// determine by offset, roll and scale. The samples are the same in every run.
    pub(super) fn consensus(
        size: (usize, usize),
        corners: &[CornerPair],
        width_px: f64,
    ) -> Option<Self> {
        if corners.len() < MIN_CONSENSUS_CORNERS {
            return None;
        }
        let mut best: Option<(usize, Self)> = None;
        let mut pick = sampler(corners.len());
        let none = Self::none(size);
        let centre = Vec2::new((size.0 as f64 - 1.0) / 2.0, (size.1 as f64 - 1.0) / 2.0);
        for _ in 0..SAMPLES {
            let sample = [pick(), pick(), pick()].map(|i| corners[i]);
            let Some(model) = through(&sample, centre) else { continue };
            let is_inlier =
                |s: &&CornerPair| (s.right.y - s.left.y - model.at(s.right)).abs() < width_px;
            let count = corners.iter().filter(is_inlier).count();
            if best.as_ref().is_none_or(|b| count > b.0) {
                let mut rotation = none;
                rotation.parameters = SVector::from([
                    (model.offset / none.focal_px).atan(),
                    0.0,
                    -model.roll.atan(),
                    (1.0 + model.scale).ln(),
                ]);
                best = Some((count, rotation));
            }
        }
        best.map(|b| b.1)
    }
}

/// Pseudo-random indices below `count`, always the same (linear congruential, Knuth's MMIX).
fn sampler(count: usize) -> impl FnMut() -> usize {
    let mut state = 0x2545_F491_4F6C_DD1D_u64;
    move || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((state >> 33) as usize) % count
    }
}

/// The row model through three corners; `None` when they are degenerate.
fn through(sample: &[CornerPair; 3], centre: Vec2) -> Option<RowAffine> {
    let (mut a, mut b) = (Mat3::zeros(), Vec3::zeros());
    for (i, s) in sample.iter().enumerate() {
        let d = s.right - centre;
        a.set_row(i, &RowVector3::new(1.0, d.x, d.y));
        b[i] = s.right.y - s.left.y;
    }
    let [offset, roll, scale]: [f64; 3] = (a.try_inverse()? * b).into();
    let plausible = roll.abs() < MAX_SAMPLE_SLOPE && scale.abs() < MAX_SAMPLE_SLOPE;
    plausible.then_some(RowAffine { centre, offset, roll, scale })
}

/// A pixel transformed by a homography.
pub(super) fn transformed(h: &Mat3, p: Vec2) -> Vec2 {
    let q = h * Vec3::new(p.x, p.y, 1.0);
    Vec2::new(q.x / q.z, q.y / q.z)
}
