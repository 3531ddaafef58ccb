//! A camera and the pose of the mesh in its frame.

use super::super::error::TextureError;
use super::super::input::TexturePhoto;
use crate::camera::{Pinhole, Projection, resect};
use crate::math::{Mat3, Similarity, Vec2, Vec3};

/// Largest RMS residual of a camera that is found from the dots, pixels: a larger one would show as
/// double contours where photos are blended.
const MAX_RESECTION_RMS_PX: f64 = 1.5;

/// A camera and the pose of the mesh: camera frame = `matrix` * mesh frame + `shift`.
#[derive(Clone, Copy, Debug)]
pub(super) struct PosedCamera {
    pub pinhole: Pinhole,
    pub matrix: Mat3,
    pub shift: Vec3,
}

impl PosedCamera {
    /// The camera of a photo: given, or resected from its dots.
    ///
    /// # Errors
    /// [`TextureError::NoCamera`] when the dots do not determine one.
    pub fn of_photo(index: usize, photo: &TexturePhoto<'_>) -> Result<Self, TextureError> {
        if let Some((pinhole, pose)) = photo.camera {
            let (matrix, shift) = (pose.rotation * pose.scale, pose.translation);
            return Ok(Self { pinhole, matrix, shift });
        }
        let points: Vec<Vec3> = photo.dots.iter().map(|d| d.point).collect();
        let pixels: Vec<Vec2> = photo.dots.iter().map(|d| d.pixel).collect();
        match resect(&points, &pixels) {
            Some((Projection { matrix, shift }, rms)) if rms <= MAX_RESECTION_RMS_PX => {
                Ok(Self { pinhole: Pinhole::ideal(1.0, Vec2::zeros()), matrix, shift })
            }
            found => Err(TextureError::NoCamera {
                photo: index,
                dots: points.len(),
                rms: found.map_or(f64::INFINITY, |f| f.1),
                limit: MAX_RESECTION_RMS_PX,
            }),
        }
    }

    /// A point of the mesh frame in the camera frame.
    #[inline]
    pub fn camera_point(&self, point: &Vec3) -> Vec3 {
        self.matrix * point + self.shift
    }

    /// Pixel and depth of a point of the mesh frame; `None` behind the camera.
    #[inline]
    pub fn project(&self, point: &Vec3) -> Option<(Vec2, f64)> {
        let placed = self.camera_point(point);
        Some((self.pinhole.project(&placed)?, placed.z))
    }

    /// The camera's centre in the mesh frame.
    pub fn centre(&self) -> Vec3 {
        self.matrix.try_inverse().map_or(Vec3::repeat(f64::NAN), |m| -(m * self.shift))
    }

    /// Whether `matrix` projects to pixels and the pinhole does nothing: so a resected camera is
    /// represented.
    fn is_resected(&self) -> bool {
        self.pinhole.fx == 1.0
    }

    /// The width of a pixel as a function of depth, in the unit of the mesh.
    pub fn pixel_width(&self) -> impl Fn(f32) -> f32 + Sync + use<> {
        let resected = self.is_resected();
        let norm = self.matrix.row(0).norm() as f32;
        let scale = self.matrix.determinant().abs().cbrt();
        let focal = (self.pinhole.fx * self.pinhole.fy).sqrt();
        let per_depth = (scale / focal.max(1e-12)) as f32;
        move |depth| if resected { depth / norm } else { depth * per_depth }
    }

    /// The camera of the photo at half the size. Pixel centres are at integers: pixel `u` becomes
    /// `(u + 0.5) / 2 - 0.5`.
    pub fn halved(&self) -> Self {
        if self.is_resected() {
            let half = Mat3::new(0.5, 0.0, -0.25, 0.0, 0.5, -0.25, 0.0, 0.0, 1.0);
            return Self { matrix: half * self.matrix, shift: half * self.shift, ..*self };
        }
        let c = self.pinhole;
        let pinhole = Pinhole {
            fx: c.fx / 2.0,
            fy: c.fy / 2.0,
            cx: c.cx / 2.0 - 0.25,
            cy: c.cy / 2.0 - 0.25,
            ..c
        };
        Self { pinhole, ..*self }
    }

    /// Applies a rigid motion of the head (mesh frame) before the camera.
    pub fn follow(&mut self, moved_from_mesh: &Similarity) {
        self.shift += self.matrix * moved_from_mesh.translation;
        self.matrix *= moved_from_mesh.rotation;
    }
}
