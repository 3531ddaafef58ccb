//! The pinhole camera with radial and tangential distortion (Brown 1971; OpenCV's model).

use serde::{Deserialize, Serialize};

use crate::math::{Mat3, Vec2, Vec3};

/// Iterations of the inverse distortion. Usual lenses need about ten; the rest is for strong ones.
const MAX_ITERATIONS: usize = 60;
/// Squared error of the inverse distortion at which it has converged, normalised coordinates: 1e-12
/// is about 1e-9 pixels.
const CONVERGED_SQUARED: f64 = 1e-24;
/// Points nearer than this to the camera's plane, in their own unit, are not projected.
const MIN_DEPTH: f64 = 1e-9;

/// Lens distortion `k1 k2 p1 p2 k3 k4 k5 k6` (OpenCV's order; the last three are the denominator
/// of the rational model).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Distortion(pub [f64; 8]);

impl Distortion {
    /// Whether all coefficients are 0.
    pub fn is_none(&self) -> bool {
        self.0.iter().all(|c| *c == 0.0)
    }

    /// Distorts normalised coordinates.
    pub fn distort(&self, n: Vec2) -> Vec2 {
        let [k1, k2, p1, p2, k3, k4, k5, k6] = self.0;
        let r2 = n.norm_squared();
        let radial =
            (1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1.0 + r2 * (k4 + r2 * (k5 + r2 * k6)));
        let xy = n.x * n.y;
        Vec2::new(
            n.x * radial + 2.0 * p1 * xy + p2 * (r2 + 2.0 * n.x * n.x),
            n.y * radial + p1 * (r2 + 2.0 * n.y * n.y) + 2.0 * p2 * xy,
        )
    }

    /// Inverts [`Distortion::distort`] by fixed-point iteration. Far outside the field of view it may
    /// not converge; then the last iterate is returned.
    pub fn undistort(&self, distorted: Vec2) -> Vec2 {
        if self.is_none() {
            return distorted;
        }
        let mut n = distorted;
        for _ in 0..MAX_ITERATIONS {
            let error = self.distort(n) - distorted;
            n -= error;
            if error.norm_squared() < CONVERGED_SQUARED {
                break;
            }
        }
        n
    }
}

/// A camera: focal lengths and principal point in pixels, and lens distortion.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pinhole {
    /// Focal length along x, pixels.
    pub fx: f64,
    /// Focal length along y, pixels.
    pub fy: f64,
    /// Principal point, x.
    pub cx: f64,
    /// Principal point, y.
    pub cy: f64,
    /// Lens distortion.
    pub distortion: Distortion,
}

impl Pinhole {
    /// A camera without distortion and with square pixels.
    pub fn ideal(focal_px: f64, principal: Vec2) -> Self {
        Self {
            fx: focal_px,
            fy: focal_px,
            cx: principal.x,
            cy: principal.y,
            distortion: Distortion::default(),
        }
    }

    /// The camera matrix `K`.
    pub fn matrix(&self) -> Mat3 {
        Mat3::new(self.fx, 0.0, self.cx, 0.0, self.fy, self.cy, 0.0, 0.0, 1.0)
    }

    /// Projects a point of the camera frame to pixels; `None` behind the camera.
    pub fn project(&self, point: &Vec3) -> Option<Vec2> {
        (point.z > MIN_DEPTH).then(|| {
            let n = self.distortion.distort(Vec2::new(point.x / point.z, point.y / point.z));
            Vec2::new(self.fx * n.x + self.cx, self.fy * n.y + self.cy)
        })
    }

    /// Direction `(x, y, 1)` of the ray through a pixel, in the camera frame.
    pub fn ray(&self, pixel: Vec2) -> Vec3 {
        let n = self
            .distortion
            .undistort(Vec2::new((pixel.x - self.cx) / self.fx, (pixel.y - self.cy) / self.fy));
        Vec3::new(n.x, n.y, 1.0)
    }

    /// Whether the focal lengths are above 0 and all numbers finite.
    pub fn is_plausible(&self) -> bool {
        let finite = [self.fx, self.fy, self.cx, self.cy]
            .iter()
            .chain(&self.distortion.0)
            .all(|v| v.is_finite());
        finite && self.fx > 0.0 && self.fy > 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ray_projects_back_to_its_pixel_through_a_distorting_lens() {
        let camera = Pinhole {
            distortion: Distortion([-0.12, 0.25, 0.001, -0.002, 0.1, 0.0, 0.0, 0.0]),
            ..Pinhole::ideal(900.0, Vec2::new(383.5, 287.5))
        };
        for (x, y) in [(0.0, 0.0), (767.0, 575.0), (400.0, 100.0)] {
            let pixel = Vec2::new(x, y);
            let point = camera.ray(pixel) * 1234.0;
            assert!((camera.project(&point).unwrap() - pixel).norm() < 1e-8);
        }
        assert!(camera.project(&Vec3::new(0.0, 0.0, -1.0)).is_none());
    }
}
