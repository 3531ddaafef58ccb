//! Check of rotation matrices.

use std::fmt;

use crate::math::Mat3;

/// Largest deviation of `R R^T` from the identity: files round to at least 5 digits.
const TOLERANCE: f64 = 1e-4;

/// Why a matrix is not a rotation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RotationFault {
    /// `R R^T` differs from the identity by this much.
    NotOrthonormal(f64),
    /// The determinant is negative: a reflection.
    Reflection,
}

impl fmt::Display for RotationFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotOrthonormal(deviation) => write!(
                f,
                "R R^T differs from the identity by {deviation:.2e} (at most {TOLERANCE:.0e} expected)"
            ),
            Self::Reflection => f.write_str("it is a reflection (determinant -1, +1 expected)"),
        }
    }
}

/// Why a matrix is not a rotation; `None` for a rotation.
pub(crate) fn rotation_fault(r: &Mat3) -> Option<RotationFault> {
    let deviation = (r * r.transpose() - Mat3::identity()).amax();
    if !(deviation < TOLERANCE) {
        return Some(RotationFault::NotOrthonormal(deviation));
    }
    (r.determinant() <= 0.0).then_some(RotationFault::Reflection)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_rotations_pass() {
        let r = nalgebra::Rotation3::from_euler_angles(0.1, 0.2, 0.3).into_inner();
        assert_eq!(rotation_fault(&r), None);
        assert_eq!(rotation_fault(&-r), Some(RotationFault::Reflection));
        assert!(matches!(rotation_fault(&(r * 1.1)), Some(RotationFault::NotOrthonormal(_))));
        assert!(rotation_fault(&(r * f64::NAN)).is_some());
    }
}
