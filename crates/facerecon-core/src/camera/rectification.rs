//! Rectification: both photos as seen by cameras whose rows correspond.
//!
//! The rectified rig keeps the cameras' centres and rotates both to one orientation whose x axis is
//! the baseline (Fusiello et al. 2000). Views without calibration are plane homographies.

use super::pinhole::Pinhole;
use super::rig::StereoRig;
use crate::math::{Mat3, Similarity, Vec2, Vec3};

/// Points nearer than this to the camera's plane (mm, or parallax in pixels) are at infinity or behind.
const MIN_DEPTH: f64 = 1e-9;
/// Differences below this are rounding: a rig within it is parallel.
const PARALLEL_TOLERANCE: f64 = 1e-9;
/// Largest displacement of an identity view, pixels.
const IDENTITY_PX: f64 = 1e-6;
/// Samples of each side of a photo for the outline of its rectified image.
const OUTLINE_SAMPLES: u32 = 16;
/// Largest size of the rectified images over that of the photos, per side; bounds the memory for a
/// calibration of other photos.
const MAX_ENLARGEMENT: usize = 2;

/// The mapping between the pixels of a photo and those of its rectified image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum View {
    /// A calibrated camera rotated about its centre.
    Camera {
        /// The camera of the photo.
        camera: Pinhole,
        /// Rotation from the camera's frame to the rectified frame.
        rectified_from_camera: Mat3,
        /// The rectified camera, without distortion.
        rectified: Pinhole,
    },
    /// A plane homography, for photos without calibration.
    Plane {
        /// Homography from photo pixels to rectified pixels.
        rectified_from_photo: Mat3,
        /// Homography from rectified pixels to photo pixels.
        photo_from_rectified: Mat3,
    },
}

impl View {
    /// A view that does not change the photo.
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
                // Rays of rectified pixels point forward; the bound keeps other numbers finite.
                let n = ray / ray.z.max(MIN_DEPTH);
                let d = camera.distortion.distort(Vec2::new(n.x, n.y));
                Vec2::new(camera.fx * d.x + camera.cx, camera.fy * d.y + camera.cy)
            }
            Self::Plane { photo_from_rectified, .. } => homography(photo_from_rectified, pixel),
        }
    }

    /// Whether photo and rectified image are the same, pixel by pixel.
    pub fn is_identity(&self) -> bool {
        let probes = [(0.0, 0.0), (1000.0, 0.0), (0.0, 1000.0), (700.0, 900.0)];
        probes.iter().all(|&(x, y)| {
            let p = Vec2::new(x, y);
            (self.to_photo(p) - p).norm() < IDENTITY_PX
        })
    }
}

fn homography(h: &Mat3, p: Vec2) -> Vec2 {
    let q = h * Vec3::new(p.x, p.y, 1.0);
    Vec2::new(q.x / q.z, q.y / q.z)
}

/// Focal length, baseline and principal points of a rectified pair.
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
    /// Rotation from the rectified frame to the left camera's frame (same centre).
    pub camera_from_rectified: Mat3,
    /// Whether `baseline_mm` is known; if not, the unit of lengths is only about a millimetre.
    pub metric: bool,
}

impl RectifiedRig {
    /// Depth in the rectified frame for a disparity `xl - xr`, mm; `None` at infinity or beyond.
    pub fn depth_mm(&self, disparity_px: f64) -> Option<f64> {
        let parallax = disparity_px - (self.principal_left.x - self.principal_right.x);
        (parallax > MIN_DEPTH).then(|| self.focal_px * self.baseline_mm / parallax)
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

    /// Centres of the left and the right camera, left camera's frame, mm.
    pub fn camera_centres(&self) -> [Vec3; 2] {
        [Vec3::zeros(), self.camera_from_rectified * Vec3::new(self.baseline_mm, 0.0, 0.0)]
    }

    /// Rectified left and right pixels of a point of the left camera's frame; `None` behind it.
    pub fn pixels(&self, point: &Vec3) -> Option<(Vec2, Vec2)> {
        let p = self.camera_from_rectified.transpose() * point;
        (p.z > MIN_DEPTH).then(|| {
            let k = self.focal_px / p.z;
            let y = k * p.y + self.principal_left.y;
            let left = Vec2::new(k * p.x + self.principal_left.x, y);
            let right = Vec2::new(k * (p.x - self.baseline_mm) + self.principal_right.x, y);
            (left, right)
        })
    }
}

/// A pair of views in which a point has the same row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectification {
    /// The left view.
    pub left: View,
    /// The right view.
    pub right: View,
    /// `(width, height)` of both rectified images.
    pub size: (usize, usize),
    /// The rectified rig; `None` without calibration.
    pub rig: Option<RectifiedRig>,
}

impl Rectification {
    /// Photos that are rectified already, without calibration.
    pub fn identity(size: (usize, usize)) -> Self {
        Self { left: View::identity(), right: View::identity(), size, rig: None }
    }

    /// Rectifies a calibrated rig, for which [`StereoRig::validate`] passes. Photos of a parallel rig
    /// are not changed; otherwise the rectified images are large enough for both photos.
    pub fn from_rig(rig: &StereoRig, photo_size: (usize, usize)) -> Self {
        let rotation = rig.right_from_left.rotation;
        let x = rig.right_centre().normalize();
        // The mean optical axis in the left camera's frame, made orthogonal to the baseline.
        let axis = Vec3::z() + rotation.transpose() * Vec3::z();
        let z = (axis - x * x.dot(&axis)).normalize();
        let rectified_from_left = Mat3::from_columns(&[x, z.cross(&x), z]).transpose();
        let rectified_from_right = rectified_from_left * rotation.transpose();
        let focal_px = (rig.left.fx + rig.left.fy + rig.right.fx + rig.right.fy) / 4.0;
        let baseline_mm = rig.baseline_mm();

        let unchanged = |camera: &Pinhole, rotation: &Mat3| {
            camera.distortion.is_none()
                && (rotation - Mat3::identity()).amax() < PARALLEL_TOLERANCE
                && (camera.fx - focal_px).abs() < PARALLEL_TOLERANCE
                && (camera.fy - focal_px).abs() < PARALLEL_TOLERANCE
        };
        let parallel = unchanged(&rig.left, &rectified_from_left)
            && unchanged(&rig.right, &rectified_from_right)
            && (rig.left.cy - rig.right.cy).abs() < PARALLEL_TOLERANCE;
        let (principal_left, principal_right, size) = if parallel {
            let left = Vec2::new(rig.left.cx, rig.left.cy);
            (left, Vec2::new(rig.right.cx, rig.right.cy), photo_size)
        } else {
            let left = outline(&rig.left, &rectified_from_left, focal_px, photo_size);
            let right = outline(&rig.right, &rectified_from_right, focal_px, photo_size);
            let top = left.0.y.min(right.0.y);
            let bottom = left.1.y.max(right.1.y);
            let width = (left.1.x - left.0.x).max(right.1.x - right.0.x);
            let fit = |length: f64, photo: usize| {
                (length.ceil().max(1.0) as usize + 1).min(photo.saturating_mul(MAX_ENLARGEMENT))
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

    /// Transform from the rectified frame to the left camera's frame, where calibrated.
    pub fn camera_from_rectified(&self) -> Option<Similarity> {
        self.rig.map(|r| Similarity::rigid(r.camera_from_rectified, Vec3::zeros()))
    }
}

/// Bounds of a photo's border in the rectified image, relative to the principal point.
fn outline(camera: &Pinhole, rotation: &Mat3, focal_px: f64, size: (usize, usize)) -> (Vec2, Vec2) {
    let (w, h) = (size.0 as f64 - 1.0, size.1 as f64 - 1.0);
    let mut low = Vec2::repeat(f64::INFINITY);
    let mut high = -low;
    for i in 0..=OUTLINE_SAMPLES {
        let t = f64::from(i) / f64::from(OUTLINE_SAMPLES);
        for p in [(w * t, 0.0), (w * t, h), (0.0, h * t), (w, h * t)] {
            let ray = rotation * camera.ray(Vec2::new(p.0, p.1));
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
    fn rows_correspond_and_depth_is_recovered() {
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
    fn photos_of_a_parallel_rig_are_not_changed() {
        let rig =
            StereoRig::parallel(150.0, 2766.0, Vec2::new(300.0, 287.5), Vec2::new(460.0, 287.5));
        let rectification = Rectification::from_rig(&rig, (768, 576));
        assert!(rectification.left.is_identity() && rectification.right.is_identity());
        assert_eq!(rectification.size, (768, 576));
        let z = rectification.rig.unwrap().depth_mm(300.0 - 460.0 + 319.0).unwrap();
        assert!((z - 2766.0 * 150.0 / 319.0).abs() < 1e-9);
    }
}
