//! The eye: eyeball, lids, the fold above the upper lid and the groove below the lower lid.

use super::curve::{Curve, bell, mix, smooth_max, smoothstep};

/// Measures of the eye on the +x side, millimetres in the model frame.
#[derive(Debug, Clone)]
pub(crate) struct EyeShape {
    /// Inner and outer corner `[x, y]`.
    pub(crate) inner: [f64; 2],
    pub(crate) outer: [f64; 2],
    /// Heights of the lid margins over the line between the corners.
    pub(crate) upper: f64,
    pub(crate) lower: f64,
    /// Centre and radius of the eyeball.
    pub(crate) centre: [f64; 3],
    pub(crate) radius: f64,
    /// Thickness of the lids.
    pub(crate) lid: f64,
}

impl Default for EyeShape {
    fn default() -> Self {
        Self {
            inner: [16.5, 20.6],
            outer: [45.0, 22.8],
            upper: 5.1,
            lower: 4.4,
            centre: [31.0, 22.0, 76.0],
            radius: 12.1,
            lid: 1.7,
        }
    }
}

/// The eye of a sculpt.
#[derive(Debug, Clone)]
pub struct Eye {
    pub(crate) shape: EyeShape,
    upper: Curve,
    lower: Curve,
}

impl Eye {
    pub(super) fn new(shape: &EyeShape) -> Self {
        Self {
            shape: shape.clone(),
            upper: Curve::new(&[
                (0.0, 0.0),
                (0.06, 0.24),
                (0.14, 0.48),
                (0.28, 0.83),
                (0.45, 1.0),
                (0.62, 0.94),
                (0.8, 0.64),
                (0.92, 0.3),
                (1.0, 0.0),
            ]),
            lower: Curve::new(&[
                (0.0, 0.0),
                (0.08, 0.16),
                (0.2, 0.42),
                (0.4, 0.86),
                (0.58, 1.0),
                (0.76, 0.86),
                (0.9, 0.47),
                (1.0, 0.0),
            ]),
        }
    }

    /// Position along the line between the corners: 0 inner, 1 outer.
    fn along(&self, x: f64) -> f64 {
        let s = &self.shape;
        (x - s.inner[0]) / (s.outer[0] - s.inner[0])
    }

    /// Inner and outer corner `[x, y]`.
    pub fn corners(&self) -> [[f64; 2]; 2] {
        [self.shape.inner, self.shape.outer]
    }

    /// Heights of the upper and the lower lid margin at x.
    pub fn margins(&self, x: f64) -> (f64, f64) {
        let s = &self.shape;
        let t = self.along(x).clamp(0.0, 1.0);
        let line = mix(s.inner[1], s.outer[1], t);
        (line + s.upper * self.upper.at(t), line - s.lower * self.lower.at(t))
    }

    /// Distance inside the opening between the lids, mm, negative outside (approximate away from
    /// the margins).
    pub(crate) fn inside(&self, x: f64, y: f64) -> f64 {
        let s = &self.shape;
        let (up, low) = self.margins(x);
        let beyond = (s.inner[0] - x).max(x - s.outer[0]).max(0.0);
        (up - y).min(y - low) * 0.9 - beyond
    }

    /// Height of the fold above the upper lid at x.
    pub fn fold(&self, x: f64) -> f64 {
        let t = self.along(x).clamp(0.0, 1.0);
        self.margins(x).0 + 2.2 + 2.0 * (std::f64::consts::PI * t).sin()
    }

    /// Height of the face at (x, y), x >= 0, given the height of the mask without eyes there.
    pub(super) fn height(&self, x: f64, y: f64, mask: f64) -> f64 {
        let s = &self.shape;
        let (dx, dy) = (x - s.centre[0], y - s.centre[1]);
        let d2 = dx * dx + dy * dy;
        let near = smoothstep(25.0, 17.0, d2.sqrt());
        if near == 0.0 {
            return mask;
        }
        let sphere = |r: f64| s.centre[2] + (r * r - d2).max(0.0).sqrt() - (d2.sqrt() - r).max(0.0);
        let low = self.margins(x).1;
        let inside = self.inside(x, y);

        // Lids: a shell around the eyeball, blended into the socket.
        let thin = 0.6 * smoothstep(2.0, -8.0, dy);
        let shell = sphere(s.radius + s.lid - thin) - 0.02 * dx * dx.abs().min(8.0);
        let mut lid = smooth_max(mask, shell, mix(6.0, 11.0, smoothstep(3.0, -6.0, dy)));
        let in_span = smoothstep(-0.25, 0.05, self.along(x)) * smoothstep(1.3, 0.9, self.along(x));
        // Fold of the upper lid: a groove with a bulge above it.
        let fold = self.fold(x);
        lid -= in_span * (1.5 * bell(y - fold, 1.0) - 0.9 * bell(y - fold - 3.2, 2.0));
        // Groove under the lower lid.
        lid -= in_span * (0.5 * bell(y - low + 6.0, 1.8) - 0.35 * bell(y - low + 2.4, 1.5));
        // The inner corner is deeper.
        lid -= 1.2 * bell(x - s.inner[0] + 1.5, 3.0) * bell(y - s.inner[1], 3.5);
        // Rounded edge of the lids.
        lid -= 0.35 * smoothstep(-0.7, 0.0, inside);

        // Eyeball with cornea; tissue of the socket toward the corners.
        let cornea = 0.7 * smoothstep(6.5, 3.0, d2.sqrt());
        let ball = smooth_max(sphere(s.radius) + cornea, lid - 3.2, 1.5);
        let eye = mix(lid, ball.min(lid - 0.5), smoothstep(0.0, 0.45, inside));
        mix(mask, eye, near)
    }
}
