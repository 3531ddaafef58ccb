//! Similarity transforms; a rigid motion is one with scale 1.

use serde::{Deserialize, Serialize};

use super::{Mat3, Vec3};

/// `target = scale * rotation * source + translation`. Values are named `target_from_source`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Similarity {
    /// Uniform scale, above 0; 1 for a rigid motion.
    pub scale: f64,
    /// Rotation matrix (orthonormal, determinant +1).
    pub rotation: Mat3,
    /// Translation in target units.
    pub translation: Vec3,
}

impl Default for Similarity {
    fn default() -> Self {
        Self::identity()
    }
}

impl Similarity {
    /// The transform that changes nothing.
    pub fn identity() -> Self {
        Self::rigid(Mat3::identity(), Vec3::zeros())
    }

    /// A rigid motion.
    pub fn rigid(rotation: Mat3, translation: Vec3) -> Self {
        Self { scale: 1.0, rotation, translation }
    }

    /// Maps a point.
    pub fn apply(&self, source: &Vec3) -> Vec3 {
        self.rotation * source * self.scale + self.translation
    }

    /// Maps a direction: rotation only.
    pub fn rotate(&self, source: &Vec3) -> Vec3 {
        self.rotation * source
    }

    /// `c_from_a = c_from_b.compose(&b_from_a)`.
    pub fn compose(&self, inner: &Self) -> Self {
        Self {
            scale: self.scale * inner.scale,
            rotation: self.rotation * inner.rotation,
            translation: self.apply(&inner.translation),
        }
    }

    /// `source_from_target`.
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.transpose();
        let scale = 1.0 / self.scale;
        Self { scale, rotation, translation: -(rotation * self.translation) * scale }
    }

    /// The 4x4 matrix, row by row.
    pub fn to_rows(&self) -> [[f64; 4]; 4] {
        let m = self.rotation * self.scale;
        let t = self.translation;
        [
            [m[(0, 0)], m[(0, 1)], m[(0, 2)], t.x],
            [m[(1, 0)], m[(1, 1)], m[(1, 2)], t.y],
            [m[(2, 0)], m[(2, 1)], m[(2, 2)], t.z],
            [0.0, 0.0, 0.0, 1.0],
        ]
    }

    /// The transform of a 4x4 matrix, row by row; `None` when it is not a similarity.
    pub fn from_rows(rows: &[[f64; 4]; 4]) -> Option<Self> {
        let m = Mat3::from_fn(|i, j| rows[i][j]);
        let translation = Vec3::new(rows[0][3], rows[1][3], rows[2][3]);
        let scale = m.determinant().cbrt();
        let rotation = m / scale;
        let skew = (rotation * rotation.transpose() - Mat3::identity()).abs().max();
        let is_similarity = scale > 0.0
            && skew < 1e-6
            && rows[3] == [0.0, 0.0, 0.0, 1.0]
            && translation.iter().all(|v| v.is_finite());
        is_similarity.then_some(Self { scale, rotation, translation })
    }

    /// Angle of the rotation, radians.
    pub fn angle(&self) -> f64 {
        ((self.rotation.trace() - 1.0) / 2.0).clamp(-1.0, 1.0).acos()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Rotation3;

    #[test]
    fn inverse_and_composition_are_consistent() {
        let a = Similarity {
            scale: 1.7,
            rotation: Rotation3::from_euler_angles(0.4, -1.1, 2.0).into_inner(),
            translation: Vec3::new(10.0, -4.0, 3.0),
        };
        let p = Vec3::new(-3.0, 7.0, 11.0);
        assert!((a.inverse().apply(&a.apply(&p)) - p).norm() < 1e-12);
        assert!((a.compose(&a).apply(&p) - a.apply(&a.apply(&p))).norm() < 1e-12);
    }
}
