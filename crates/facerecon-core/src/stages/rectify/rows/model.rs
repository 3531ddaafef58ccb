//! How the rows of the right photo lie against those of the left.

use nalgebra::{Rotation3, SMatrix, SVector};

use crate::math::{Mat3, Vec2, Vec3, median};

use super::features::Spot;

/// Row difference `yr - yl = offset + roll (xr - cx) + scale (yr - cy)`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Affine {
    pub centre: Vec2,
    pub offset: f64,
    pub roll: f64,
    pub scale: f64,
}

impl Affine {
    pub(super) fn at(&self, right: Vec2) -> f64 {
        let d = right - self.centre;
        self.offset + self.roll * d.x + self.scale * d.y
    }

    /// Robust fit (Cauchy weights) about a centre; roll and scale only where they change any spot's
    /// row by at least `least_px`, or noise would tilt the rows.
    pub(super) fn fit(spots: &[Spot], centre: Vec2, least_px: f64) -> Option<Self> {
        let differences: Vec<f64> = spots.iter().map(|s| s.right.y - s.left.y).collect();
        let mut fit = Self { centre, offset: median(&differences)?, roll: 0.0, scale: 0.0 };
        for round in 0..12 {
            // wide at first: the median knows no slope
            let width = if round < 4 { 1.5 } else { 0.25 };
            let (mut normal, mut right) = (Mat3::zeros(), Vec3::zeros());
            for s in spots {
                let dy = s.right.y - s.left.y;
                let weight = 1.0 / (1.0 + ((dy - fit.at(s.right)) / width).powi(2));
                let d = s.right - centre;
                let j = Vec3::new(1.0, d.x, d.y);
                normal += weight * j * j.transpose();
                right += weight * dy * j;
            }
            normal += Mat3::from_diagonal(&Vec3::new(1e-9, 1.0, 1.0));
            let p = normal.try_inverse()? * right;
            (fit.offset, fit.roll, fit.scale) = (p.x, p.y, p.z);
        }
        let extent = |f: &dyn Fn(&Spot) -> f64| spots.iter().map(f).fold(0.0, f64::max);
        let across = extent(&|s| (s.right.x - centre.x).abs()) * fit.roll.abs();
        let down = extent(&|s| (s.right.y - centre.y).abs()) * fit.scale.abs();
        if across.max(down) < least_px {
            fit.offset = median(&differences)?;
            (fit.roll, fit.scale) = (0.0, 0.0);
        }
        Some(fit)
    }

    /// Median absolute row difference left.
    pub(super) fn residual(&self, spots: &[Spot]) -> f64 {
        let left: Vec<f64> =
            spots.iter().map(|s| (s.right.y - s.left.y - self.at(s.right)).abs()).collect();
        median(&left).unwrap_or(f64::INFINITY)
    }
}

/// Two cameras of one unknown focal length that turn about their centres until rows are level
/// (after Fusiello and Irsara 2008): the right one pitches, rolls and zooms, and both turn inward
/// by the same angle. A turn curves rows and columns alike, so the toe-in seen in the rows takes
/// the bow out of the disparities as well, whatever the focal length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Turn {
    size: (usize, usize),
    focal_px: f64,
    /// Pitch, half the toe-in, roll (radians), logarithm of the zoom.
    parameters: SVector<f64, 4>,
}

impl Turn {
    pub(super) fn none(size: (usize, usize)) -> Self {
        // Face rigs look through long lenses: two to four widths. Only products of angle and
        // 1 / focal length are seen, so that a wrong guess turns the angles, not the pictures.
        Self { size, focal_px: 3.0 * size.0 as f64, parameters: SVector::zeros() }
    }

    pub(super) fn roll_deg(&self) -> f64 {
        self.parameters[2].to_degrees()
    }

    /// Whether it turns or zooms so much that windows of the photos look different.
    pub(super) fn is_large(&self) -> bool {
        self.roll_deg().abs() > 1.5 || self.parameters[3].abs() > 0.02
    }

    pub(super) fn zoom(&self) -> f64 {
        self.parameters[3].exp()
    }

    /// Level pictures from the photos, `[left, right]`; the middle of each keeps its column.
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
        let turn = |x: f64, y: f64, z: f64| Rotation3::from_euler_angles(x, y, z).into_inner();
        let zoomed = Mat3::from_diagonal(&Vec3::new(1.0 / zoom.exp(), 1.0 / zoom.exp(), 1.0));
        [
            keep_column(k * turn(0.0, -yaw, 0.0) * inverse),
            keep_column(k * turn(pitch, yaw, roll) * zoomed * inverse),
        ]
    }

    /// Row differences of the level pictures.
    fn differences(&self, spots: &[Spot]) -> Vec<f64> {
        let [left, right] = self.homographies();
        spots.iter().map(|s| map(&right, s.right).y - map(&left, s.left).y).collect()
    }

    /// Robust Gauss-Newton from this turn, with weights of scale `width_px`.
    pub(super) fn fitted(mut self, spots: &[Spot], width_px: f64) -> Option<Self> {
        let steps = [1e-5, 1e-5, 1e-5, 1e-5];
        for _ in 0..15 {
            let now = self.differences(spots);
            let columns = (0..4)
                .map(|i| {
                    let mut other = self;
                    other.parameters[i] += steps[i];
                    let there = other.differences(spots);
                    there.iter().zip(&now).map(|(a, b)| (a - b) / steps[i]).collect::<Vec<_>>()
                })
                .collect::<Vec<_>>();
            let mut normal = SMatrix::<f64, 4, 4>::zeros();
            let mut right = SVector::<f64, 4>::zeros();
            for (n, dy) in now.iter().enumerate() {
                let weight = 1.0 / (1.0 + (dy / width_px).powi(2)).powi(2);
                let j = SVector::<f64, 4>::from_fn(|i, _| columns[i][n]);
                normal += weight * j * j.transpose();
                right -= weight * dy * j;
            }
            // Few spots on a narrow face say little about the toe-in: then it is none.
            normal[(1, 1)] += 1.0 / 0.15_f64.powi(2);
            right[1] -= self.parameters[1] / 0.15_f64.powi(2);
            let step = normal.cholesky()?.solve(&right);
            self.parameters += step;
            if !self.parameters.iter().all(|p| p.is_finite()) {
                return None;
            }
            if step.norm() < 1e-9 {
                break;
            }
        }
        Some(self)
    }

    /// Median absolute row difference of the spots that agree, and how many do (within `width_px`).
    pub(super) fn residual(&self, spots: &[Spot], width_px: f64) -> (f64, usize) {
        let within: Vec<f64> =
            self.differences(spots).into_iter().map(f64::abs).filter(|d| *d < width_px).collect();
        (median(&within).unwrap_or(f64::INFINITY), within.len())
    }

    /// The turn that most spots agree with: three spots at a time say offset, roll and zoom.
    pub(super) fn consensus(size: (usize, usize), spots: &[Spot], width_px: f64) -> Option<Self> {
        let mut best: Option<(usize, Self)> = None;
        let mut state = 0x2545_F491_4F6C_DD1D_u64;
        let mut pick = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            ((state >> 33) as usize) % spots.len()
        };
        if spots.len() < 8 {
            return None;
        }
        let none = Self::none(size);
        let centre = Vec2::new((size.0 as f64 - 1.0) / 2.0, (size.1 as f64 - 1.0) / 2.0);
        for _ in 0..400 {
            let chosen = [pick(), pick(), pick()].map(|i| spots[i]);
            let (mut a, mut b) = (Mat3::zeros(), Vec3::zeros());
            for (i, s) in chosen.iter().enumerate() {
                let d = s.right - centre;
                a.set_row(i, &nalgebra::RowVector3::new(1.0, d.x, d.y));
                b[i] = s.right.y - s.left.y;
            }
            let Some(p) = a.try_inverse().map(|inverse| inverse * b) else {
                continue;
            };
            let [offset, roll, scale]: [f64; 3] = p.into();
            if !(roll.abs() < 0.3 && scale.abs() < 0.3) {
                continue;
            }
            let model = Affine { centre, offset, roll, scale };
            let agree = |s: &&Spot| (s.right.y - s.left.y - model.at(s.right)).abs() < width_px;
            let count = spots.iter().filter(agree).count();
            if best.as_ref().is_none_or(|b| count > b.0) {
                let mut turn = none;
                turn.parameters = SVector::from([
                    (offset / none.focal_px).atan(),
                    0.0,
                    -roll.atan(),
                    (1.0 + scale).ln(),
                ]);
                best = Some((count, turn));
            }
        }
        best.map(|b| b.1)
    }
}

/// A pixel through a homography.
pub(super) fn map(h: &Mat3, p: Vec2) -> Vec2 {
    let q = h * Vec3::new(p.x, p.y, 1.0);
    Vec2::new(q.x / q.z, q.y / q.z)
}
