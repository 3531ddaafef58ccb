//! The mouth: upper and lower lip around the lip line, Cupid's bow and philtrum.

use super::curve::{Curve, bell, smoothstep};
use crate::math::Vec3;

/// Measures of the mouth, millimetres in the model frame.
#[derive(Debug, Clone)]
pub(crate) struct MouthShape {
    /// Half of the width between the corners.
    pub(crate) half_width: f64,
    /// Height of the lip line at the middle and at the corners.
    pub(crate) line: f64,
    pub(crate) corner: f64,
    /// Heights of the vermilion above and below the lip line at the middle.
    pub(crate) upper: f64,
    pub(crate) lower: f64,
    /// Scale of the volume of both lips.
    pub(crate) fullness: f64,
}

impl Default for MouthShape {
    fn default() -> Self {
        Self { half_width: 26.0, line: -48.0, corner: -48.3, upper: 7.0, lower: 9.2, fullness: 1.0 }
    }
}

/// The mouth of a sculpt.
#[derive(Debug, Clone)]
pub struct Mouth {
    shape: MouthShape,
    /// Vermilion heights over `|x| / half_width`, as fractions of the middle.
    upper: Curve,
    lower: Curve,
    /// Relief in mm over the fraction of the vermilion height.
    upper_relief: Curve,
    lower_relief: Curve,
}

impl Mouth {
    pub(super) fn new(shape: &MouthShape) -> Self {
        Self {
            shape: shape.clone(),
            upper: Curve::flat_start(&[
                (0.0, 0.93),
                (0.10, 0.99),
                (0.21, 1.10),
                (0.34, 1.01),
                (0.6, 0.68),
                (0.85, 0.27),
                (1.0, 0.0),
            ]),
            lower: Curve::flat_start(&[
                (0.0, 1.0),
                (0.25, 0.97),
                (0.5, 0.82),
                (0.75, 0.5),
                (0.9, 0.22),
                (1.0, 0.0),
            ]),
            upper_relief: Curve::new(&[
                (0.0, -2.2),
                (0.08, -0.9),
                (0.2, 0.4),
                (0.4, 1.5),
                (0.65, 1.7),
                (0.9, 1.35),
                (1.02, 1.2),
                (1.2, 0.55),
                (1.6, 0.1),
                (2.2, 0.0),
            ]),
            lower_relief: Curve::new(&[
                (0.0, -2.2),
                (0.07, -0.8),
                (0.18, 0.6),
                (0.36, 1.9),
                (0.58, 2.1),
                (0.85, 0.9),
                (1.05, 0.0),
                (1.3, -0.7),
                (1.7, -0.5),
                (2.3, 0.0),
            ]),
        }
    }

    /// Height of the lip line at x.
    pub fn line(&self, x: f64) -> f64 {
        let s = &self.shape;
        let t = (x.abs() / s.half_width).min(1.15);
        // The tubercle of the upper lip lowers the middle.
        s.line + (s.corner - s.line) * t * t + 0.7 * (bell(t - 0.38, 0.18) + bell(t + 0.38, 0.18))
            - 0.5 * bell(t, 0.16)
    }

    /// Heights of the vermilion borders (upper, lower) at x.
    pub fn borders(&self, x: f64) -> (f64, f64) {
        let s = &self.shape;
        let t = x.abs() / s.half_width;
        let line = self.line(x);
        (line + s.upper * self.upper.at(t), line - s.lower * self.lower.at(t))
    }

    /// Half of the width between the corners, mm.
    pub fn half_width(&self) -> f64 {
        self.shape.half_width
    }

    /// Displacement at the mask point (x, y), x >= 0.
    pub(super) fn displacement(&self, x: f64, y: f64) -> Vec3 {
        let s = &self.shape;
        if x > 1.5 * s.half_width || (y - s.line).abs() > 30.0 {
            return Vec3::zeros();
        }
        let t = x / s.half_width;
        let line = self.line(x);
        let above = y > line;
        // Heights stay positive, so that the relief fades out beyond the corners.
        let (share, scale, relief) = if above {
            (self.upper.at(t), s.upper, &self.upper_relief)
        } else {
            (self.lower.at(t), s.lower, &self.lower_relief)
        };
        let height = scale * share.max(0.12);
        let u = (y - line).abs() / height;
        let along = (1.0 - t * t).max(0.0);
        let volume = s.fullness * along.powf(0.55);
        let crease = smoothstep(1.18, 0.86, t) * (0.35 + 0.65 * along.sqrt());
        let r = relief.at(u);
        let mut z = if u < 0.2 { r.min(0.0) * crease + r.max(0.0) * volume } else { r * volume };
        // Philtrum: a groove between two ridges that end at the peaks of Cupid's bow.
        let column = smoothstep(line + s.upper + 14.5, line + s.upper + 10.0, y)
            * smoothstep(line + 0.55 * s.upper, line + 1.05 * s.upper, y);
        let spread = 3.4 + 1.6 * smoothstep(line + s.upper + 12.0, line + s.upper, y);
        z += column * (0.55 * bell(x - spread, 1.7) - 0.85 * bell(x, 2.0));
        // The corners are deeper.
        z -= 0.8 * bell(t - 1.04, 0.10) * bell(y - line, 2.4);
        Vec3::new(0.0, 0.0, z)
    }
}
