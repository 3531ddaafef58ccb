//! Rectification: both photos as seen by cameras with level rows.
//!
//! The rectified rig keeps the cameras' centres and turns both to one orientation whose x axis is
//! the baseline (Fusiello et al. 2000). Views without calibration are plane homographies.

use super::{Pinhole, StereoRig};
use crate::math::{Mat3, Similarity, Vec2, Vec3};

/// How pixels of one photo and of its rectified picture belong together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum View {
    /// A calibrated camera turned about its centre.
    Camera {
        /// The real camera.
        camera: Pinhole,
        /// Rectified axes from the camera's axes.
        rectified_from_camera: Mat3,
        /// The rectified camera, without distortion.
        rectified: Pinhole,
    },
    /// A plane homography, for photos without calibration.
    Plane {
        /// Rectified pixel from photo pixel.
        rectified_from_photo: Mat3,
        /// Photo pixel from rectified pixel.
        photo_from_rectified: Mat3,
    },
}

impl View {
    /// A view that leaves the photo as it is.
    pub fn identity() -> Self {
        Self::Plane {
            rectified_from_photo: Mat3::identity(),
            photo_from_rectified: Mat3::identity(),
        }
    }

    /// A plane homography; `None` when it cannot be inverted.
    pub fn plane(rectified_from_photo: Mat3) -> Option<Self> {
        let photo_from_rectified = rectified_from_photo.try_inverse()?;
        Some(Self::Plane { rectified_from_photo, photo_from_rectified })
    }

    /// Rectified pixel of a photo pixel.
    pub fn to_rectified(&self, photo: Vec2) -> Vec2 {
        match self {
            Self::Camera { camera, rectified_from_camera, rectified } => {
                let ray = rectified_from_camera * camera.ray(photo);
                Vec2::new(
                    rectified.fx * ray.x / ray.z + rectified.cx,
                    rectified.fy * ray.y / ray.z + rectified.cy,
                )
            }
            Self::Plane { rectified_from_photo, .. } => homography(rectified_from_photo, photo),
        }
    }

    /// Photo pixel of a rectified pixel.
    pub fn to_photo(&self, pixel: Vec2) -> Vec2 {
        match self {
            Self::Camera { camera, rectified_from_camera, rectified } => {
                let ray = rectified_from_camera.transpose() * rectified.ray(pixel);
                // a rectified pixel always looks forward; the guard keeps numbers finite
                let n = ray / ray.z.max(1e-9);
                let d = camera.distortion.distort(Vec2::new(n.x, n.y));
                Vec2::new(camera.fx * d.x + camera.cx, camera.fy * d.y + camera.cy)
            }
            Self::Plane { photo_from_rectified, .. } => homography(photo_from_rectified, pixel),
        }
    }

    /// Whether photo and rectified picture are the same pixels.
    pub fn is_identity(&self) -> bool {
        let probes = [(0.0, 0.0), (1000.0, 0.0), (0.0, 1000.0), (700.0, 900.0)];
        probes.iter().all(|&(x, y)| {
            let p = Vec2::new(x, y);
            (self.to_photo(p) - p).norm() < 1e-6
        })
    }
}

fn homography(h: &Mat3, p: Vec2) -> Vec2 {
    let q = h * Vec3::new(p.x, p.y, 1.0);
    Vec2::new(q.x / q.z, q.y / q.z)
}

/// The metric facts of a rectified pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RectifiedRig {
    /// Common focal length, pixels.
    pub focal_px: f64,
    /// Distance between the cameras, mm.
    pub baseline_mm: f64,
    /// Principal point of the left view.
    pub principal_left: Vec2,
    /// Principal point of the right view (same y).
    pub principal_right: Vec2,
    /// Left camera frame from the rectified frame (same centre).
    pub camera_from_rectified: Mat3,
    /// Whether `baseline_mm` is known; else lengths are in a unit that is only about a millimetre.
    pub metric: bool,
}

impl RectifiedRig {
    /// Depth in the rectified frame for a disparity `xl - xr`, mm; `None` at or behind infinity.
    pub fn depth_mm(&self, disparity_px: f64) -> Option<f64> {
        let parallax = disparity_px - (self.principal_left.x - self.principal_right.x);
        (parallax > 1e-9).then(|| self.focal_px * self.baseline_mm / parallax)
    }

    /// Disparity of a point at a depth in the rectified frame, pixels.
    pub fn disparity_px(&self, depth_mm: f64) -> f64 {
        self.focal_px * self.baseline_mm / depth_mm + self.principal_left.x - self.principal_right.x
    }

    /// Point in the left camera frame, mm, of a rectified left pixel and its disparity.
    pub fn point(&self, left: Vec2, disparity_px: f64) -> Option<Vec3> {
        let z = self.depth_mm(disparity_px)?;
        let x = (left.x - self.principal_left.x) * z / self.focal_px;
        let y = (left.y - self.principal_left.y) * z / self.focal_px;
        Some(self.camera_from_rectified * Vec3::new(x, y, z))
    }

    /// Rectified left and right pixels of a point of the left camera frame; `None` behind it.
    pub fn pixels(&self, point: &Vec3) -> Option<(Vec2, Vec2)> {
        let p = self.camera_from_rectified.transpose() * point;
        (p.z > 1e-9).then(|| {
            let k = self.focal_px / p.z;
            let y = k * p.y + self.principal_left.y;
            let left = Vec2::new(k * p.x + self.principal_left.x, y);
            let right = Vec2::new(k * (p.x - self.baseline_mm) + self.principal_right.x, y);
            (left, right)
        })
    }
}

/// A pair of views with level rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectification {
    /// The left view.
    pub left: View,
    /// The right view.
    pub right: View,
    /// `(width, height)` of both rectified pictures.
    pub size: (usize, usize),
    /// Metric facts; `None` without calibration.
    pub rig: Option<RectifiedRig>,
}

impl Rectification {
    /// Photos that are level already, without calibration.
    pub fn identity(size: (usize, usize)) -> Self {
        Self { left: View::identity(), right: View::identity(), size, rig: None }
    }

    /// Rectifies a calibrated rig ([`StereoRig::validate`] must hold). A parallel rig is left as
    /// it is, pixel for pixel; else the canvas is laid so that both photos fit on it.
    pub fn from_rig(rig: &StereoRig, photo_size: (usize, usize)) -> Self {
        let rotation = rig.right_from_left.rotation;
        let x = rig.right_centre().normalize();
        // Mean optical axis, seen from the left camera, made square to the baseline.
        let axis = Vec3::z() + rotation.transpose() * Vec3::z();
        let z = (axis - x * x.dot(&axis)).normalize();
        let rectified_from_left = Mat3::from_columns(&[x, z.cross(&x), z]).transpose();
        let rectified_from_right = rectified_from_left * rotation.transpose();
        let focal_px = (rig.left.fx + rig.left.fy + rig.right.fx + rig.right.fy) / 4.0;
        let baseline_mm = rig.baseline_mm();

        let untouched = |camera: &Pinhole, turn: &Mat3| {
            camera.distortion.is_none()
                && (turn - Mat3::identity()).amax() < 1e-9
                && (camera.fx - focal_px).abs() < 1e-9
                && (camera.fy - focal_px).abs() < 1e-9
        };
        let parallel = untouched(&rig.left, &rectified_from_left)
            && untouched(&rig.right, &rectified_from_right)
            && (rig.left.cy - rig.right.cy).abs() < 1e-9;
        let (principal_left, principal_right, size) = if parallel {
            let left = Vec2::new(rig.left.cx, rig.left.cy);
            (left, Vec2::new(rig.right.cx, rig.right.cy), photo_size)
        } else {
            let left = outline(&rig.left, &rectified_from_left, focal_px, photo_size);
            let right = outline(&rig.right, &rectified_from_right, focal_px, photo_size);
            let top = left.0.y.min(right.0.y);
            let bottom = left.1.y.max(right.1.y);
            let width = (left.1.x - left.0.x).max(right.1.x - right.0.x);
            // A wild calibration must not ask for a wild canvas.
            let fit = |length: f64, photo: usize| {
                (length.ceil().max(1.0) as usize + 1).min(photo.saturating_mul(2))
            };
            let size = (fit(width, photo_size.0), fit(bottom - top, photo_size.1));
            (Vec2::new(-left.0.x, -top), Vec2::new(-right.0.x, -top), size)
        };
        let view = |camera: Pinhole, rectified_from_camera: Mat3, principal: Vec2| View::Camera {
            camera,
            rectified_from_camera,
            rectified: Pinhole::ideal(focal_px, principal),
        };
        Self {
            left: view(rig.left, rectified_from_left, principal_left),
            right: view(rig.right, rectified_from_right, principal_right),
            size,
            rig: Some(RectifiedRig {
                focal_px,
                baseline_mm,
                principal_left,
                principal_right,
                camera_from_rectified: rectified_from_left.transpose(),
                metric: true,
            }),
        }
    }

    /// Left camera frame from the rectified frame, where calibrated.
    pub fn camera_from_rectified(&self) -> Option<Similarity> {
        self.rig.map(|r| Similarity::rigid(r.camera_from_rectified, Vec3::zeros()))
    }
}

/// Bounds of a photo's border in the rectified picture, principal point at the origin.
fn outline(camera: &Pinhole, turn: &Mat3, focal_px: f64, size: (usize, usize)) -> (Vec2, Vec2) {
    let (w, h) = (size.0 as f64 - 1.0, size.1 as f64 - 1.0);
    let mut low = Vec2::repeat(f64::INFINITY);
    let mut high = -low;
    for i in 0..=16 {
        let t = f64::from(i) / 16.0;
        for p in [(w * t, 0.0), (w * t, h), (0.0, h * t), (w, h * t)] {
            let ray = turn * camera.ray(Vec2::new(p.0, p.1));
            let q = Vec2::new(focal_px * ray.x / ray.z, focal_px * ray.y / ray.z);
            low = low.inf(&q);
            high = high.sup(&q);
        }
    }
    (low, high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Distortion;
    use nalgebra::Rotation3;

    fn toed_in() -> StereoRig {
        let rotation = Rotation3::from_euler_angles(0.01, 0.145, -0.016).into_inner();
        let centre = Vec3::new(170.0, -1.5, 4.0);
        StereoRig {
            left: Pinhole {
                distortion: Distortion([-0.12, 0.25, 0.001, 0.0, 0.0, 0.0, 0.0, 0.0]),
                ..Pinhole::ideal(2526.0, Vec2::new(380.0, 290.0))
            },
            right: Pinhole { fy: 2530.0, ..Pinhole::ideal(2536.0, Vec2::new(387.0, 285.0)) },
            right_from_left: Similarity::rigid(rotation, -(rotation * centre)),
            image_size: Some((768, 576)),
        }
    }

    #[test]
    fn rows_are_level_and_depth_comes_back() {
        let rig = toed_in();
        rig.validate((768, 576)).unwrap();
        let rectification = Rectification::from_rig(&rig, (768, 576));
        let metric = rectification.rig.unwrap();
        for (x, y, z) in [(0.0, 0.0, 1200.0), (80.0, -90.0, 1150.0), (-60.0, 100.0, 1300.0)] {
            let point = Vec3::new(x, y, z);
            let left = rig.left.project(&point).unwrap();
            let right = rig.right.project(&rig.right_from_left.apply(&point)).unwrap();
            let l = rectification.left.to_rectified(left);
            let r = rectification.right.to_rectified(right);
            assert!((l.y - r.y).abs() < 1e-6, "{l} {r}");
            assert!((rectification.left.to_photo(l) - left).norm() < 1e-6);
            assert!((metric.point(l, l.x - r.x).unwrap() - point).norm() < 1e-5);
            let (l2, r2) = metric.pixels(&point).unwrap();
            assert!((l2 - l).norm() < 1e-6 && (r2 - r).norm() < 1e-6);
        }
    }

    #[test]
    fn a_parallel_rig_is_left_alone() {
        let rig =
            StereoRig::parallel(150.0, 2766.0, Vec2::new(300.0, 287.5), Vec2::new(460.0, 287.5));
        let rectification = Rectification::from_rig(&rig, (768, 576));
        assert!(rectification.left.is_identity() && rectification.right.is_identity());
        assert_eq!(rectification.size, (768, 576));
        let z = rectification.rig.unwrap().depth_mm(300.0 - 460.0 + 319.0).unwrap();
        assert!((z - 2766.0 * 150.0 / 319.0).abs() < 1e-9);
    }
}
