//! Differences between the photos at a motion of the head, and their derivatives.

use nalgebra::SVector;
use rayon::prelude::*;

use super::super::posed_camera::PosedCamera;
use super::equations::{ARM_MM, NormalEquations, Row};
use super::images::DottedAndPlain;
use crate::data::{Gray, Raster};
use crate::math::{Similarity, Vec3};

/// All that is compared in one round.
pub(super) struct Comparison<'a> {
    /// Points of the surface, mesh frame.
    pub points: &'a [Vec3],
    pub cameras: &'a [PosedCamera],
    /// The plain pair.
    pub images: [Gray; 2],
    /// The pairs in the smoothness in which dots vanish.
    pub smooth: &'a DottedAndPlain,
    /// Mean of the points.
    pub centre: Vec3,
    /// Typical residuals by which the comparisons are weighted; `None`: those found.
    pub bounds: Option<Vec<f64>>,
}

impl Comparison<'_> {
    /// Normal equations of all residuals at a motion.
    pub fn equations(&self, motion: &Similarity) -> NormalEquations {
        let bounds = self.bounds.as_ref();
        let mut total = NormalEquations::default();
        total.add(&self.rows(|p| self.stereo_row(motion, p)), bounds);
        for (k, dotted) in self.smooth.dotted.iter().enumerate() {
            if let Some(dotted) = dotted {
                total.add(&self.rows(|p| self.dotted_row(motion, p, k, dotted)), bounds);
            }
        }
        total
    }

    fn rows(&self, row: impl Fn(&Vec3) -> Option<Row> + Sync + Send) -> Vec<Row> {
        self.points.par_iter().filter_map(row).collect()
    }

    /// Left against right plain photo at a moved point.
    fn stereo_row(&self, motion: &Similarity, point: &Vec3) -> Option<Row> {
        let moved = motion.apply(point);
        let (left, left_gradient) = sample(&self.images[0], &self.cameras[0], &moved)?;
        let (right, right_gradient) = sample(&self.images[1], &self.cameras[1], &moved)?;
        Some((self.derivative(motion, &moved, &(left_gradient - right_gradient)), right - left))
    }

    /// Plain photo `k` at a moved point against the dotted one at the point.
    fn dotted_row(
        &self,
        motion: &Similarity,
        point: &Vec3,
        k: usize,
        dotted: &Gray,
    ) -> Option<Row> {
        let moved = motion.apply(point);
        let (pixel, _) = self.cameras[k].project(point)?;
        let before = f64::from(dotted.bilinear(pixel.x, pixel.y)?);
        let (after, gradient) = sample(&self.smooth.plain[k], &self.cameras[k], &moved)?;
        Some((self.derivative(motion, &moved, &gradient), before - after))
    }

    /// Derivative of a value by rotation (about the moved centre) and translation.
    fn derivative(&self, motion: &Similarity, moved: &Vec3, gradient: &Vec3) -> SVector<f64, 6> {
        let arm = moved - motion.apply(&self.centre);
        let turn = arm.cross(gradient) / ARM_MM;
        let g = gradient;
        SVector::<f64, 6>::from([turn.x, turn.y, turn.z, g.x, g.y, g.z])
    }
}

/// Value of an image at a point of the mesh frame, and its gradient by the point's position.
fn sample(image: &Raster<f32>, camera: &PosedCamera, point: &Vec3) -> Option<(f64, Vec3)> {
    let placed = camera.camera_point(point);
    let pixel = camera.pinhole.project(&placed)?;
    let at = |dx: f64, dy: f64| image.bilinear(pixel.x + dx, pixel.y + dy).map(f64::from);
    let value = at(0.0, 0.0)?;
    let gx = (at(1.0, 0.0)? - at(-1.0, 0.0)?) / 2.0;
    let gy = (at(0.0, 1.0)? - at(0.0, -1.0)?) / 2.0;
    // lens distortion hardly changes over a step and is left out of the gradient
    let (fx, fy) = (camera.pinhole.fx / placed.z, camera.pinhole.fy / placed.z);
    let in_camera =
        Vec3::new(gx * fx, gy * fy, -(gx * fx * placed.x + gy * fy * placed.y) / placed.z);
    Some((value, camera.matrix.transpose() * in_camera))
}
