//! The frame of the head: x to the viewer's right, y up, z out of the face; origin at the tip of
//! the nose.

use nalgebra::Rotation3;

use super::nose_tip::NoseTip;
use super::surface_points::{SurfacePoints, viewer_axes};
use super::symmetry::{SymmetryPlane, plane_at};
use crate::math::{Mat3, Similarity, Vec3};

/// The level of the face is taken between these distances from the plane of symmetry, mm: beside
/// the nose and in front of the ears.
const LEVEL_MM: (f64, f64) = (14.0, 50.0);
/// And within this height of the nose, mm.
const LEVEL_HEIGHT_MM: f64 = 70.0;
/// Scale of the robust weights of that fit, mm: depth of eyes and lips.
const LEVEL_SCALE_MM: f64 = 5.0;
/// Greatest number of rounds, and the angle at which they end, radians.
const LEVEL_ROUNDS: usize = 10;
const LEVEL_CONVERGED_RAD: f64 = 1e-4;
/// Half size of the region in which the foremost point is the tip, mm.
const TIP_REGION_MM: (f64, f64) = (8.0, 22.0);

/// The frame of a head.
#[derive(Clone, Copy, Debug)]
pub(super) struct HeadFrame {
    /// Rows: the axes of the head in viewer axes.
    rotation: Mat3,
    /// Tip of the nose, viewer axes, mm.
    origin: Vec3,
    /// Share of the surface about the nose that is symmetric.
    pub symmetry: f64,
}

impl HeadFrame {
    /// The frame about a candidate for the tip of the nose; `None` where the surface is not symmetric.
    pub fn about(tip: &NoseTip, surface: &SurfacePoints) -> Option<Self> {
        let plane = plane_at(&tip.position, surface)?;
        Self::new(tip, &plane, surface)
    }

    fn new(tip: &NoseTip, plane: &SymmetryPlane, points: &SurfacePoints) -> Option<Self> {
        let x = plane.normal;
        let y = (Vec3::y() - x * x.y).try_normalize(1e-6)?;
        let start = Self {
            rotation: Mat3::from_rows(&[x.transpose(), y.transpose(), x.cross(&y).transpose()]),
            origin: tip.position - plane.distance(&tip.position) * x,
            symmetry: plane.share,
        };
        Some(start.levelled(points).at_tip(points))
    }

    /// Pitched so that the face beside the nose is upright.
    fn levelled(mut self, points: &SurfacePoints) -> Self {
        for _ in 0..LEVEL_ROUNDS {
            let beside: Vec<Vec3> = points
                .positions
                .iter()
                .map(|p| self.rotation * (p - self.origin))
                .filter(|p| (LEVEL_MM.0..LEVEL_MM.1).contains(&p.x.abs()))
                .filter(|p| p.y.abs() < LEVEL_HEIGHT_MM && p.z.abs() < LEVEL_HEIGHT_MM)
                .collect();
            let Some(slope) = upright_slope(&beside) else { return self };
            let angle = slope.atan();
            self.rotation = Rotation3::from_axis_angle(&Vec3::x_axis(), -angle) * self.rotation;
            if angle.abs() < LEVEL_CONVERGED_RAD {
                break;
            }
        }
        self
    }

    /// With the origin at the foremost point of the nose.
    fn at_tip(self, points: &SurfacePoints) -> Self {
        let tip = points
            .positions
            .iter()
            .map(|p| self.rotation * (p - self.origin))
            .filter(|p| p.x.abs() < TIP_REGION_MM.0 && p.y.abs() < TIP_REGION_MM.1)
            .filter(|p| p.z.abs() < LEVEL_HEIGHT_MM)
            .max_by(|a, b| a.z.total_cmp(&b.z));
        let Some(tip) = tip else { return self };
        let shift = self.rotation.transpose() * Vec3::new(0.0, tip.y, tip.z);
        Self { origin: self.origin + shift, ..self }
    }

    /// A position of the camera frame in the head's frame.
    pub fn place(&self, p: &Vec3) -> Vec3 {
        self.rotation * (viewer_axes(p) - self.origin)
    }

    /// The head's frame from the camera frame.
    pub fn head_from_camera(&self) -> Similarity {
        let viewer =
            Mat3::from_columns(&[Vec3::x(), Vec3::y(), Vec3::z()].map(|a| viewer_axes(&a)));
        Similarity::rigid(self.rotation * viewer, -(self.rotation * self.origin))
    }

    /// A direction of the camera frame in the head's frame.
    pub fn turn(&self, d: &Vec3) -> Vec3 {
        self.rotation * viewer_axes(d)
    }

    /// A position of the head's frame in the camera frame.
    pub fn to_camera(self, p: &Vec3) -> Vec3 {
        viewer_axes(&(self.rotation.transpose() * p + self.origin))
    }
}

/// Slope of z against y of the face: robust fit of `z = a + b y + c x^2`.
fn upright_slope(points: &[Vec3]) -> Option<f64> {
    let mut fitted = Vec3::zeros();
    for round in 0..LEVEL_ROUNDS {
        let (mut matrix, mut right) = (Mat3::zeros(), Vec3::zeros());
        for p in points {
            let row = Vec3::new(1.0, p.y, p.x * p.x);
            let residual = p.z - row.dot(&fitted);
            let robust = (1.0 + (residual / LEVEL_SCALE_MM).powi(2)).powi(-2);
            let weight = if round == 0 { 1.0 } else { robust };
            matrix += weight * row * row.transpose();
            right += weight * p.z * row;
        }
        fitted = matrix.try_inverse()? * right;
    }
    Some(fitted.y)
}
