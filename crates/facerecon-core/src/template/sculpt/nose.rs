//! The nose: a ridge with a given profile, bulges for the wings (alae), hollows for the nostrils.

use super::curve::{Curve, bell, mix, smooth_max, smoothstep};
use crate::math::Vec3;

/// Measures of the nose, millimetres in the model frame.
#[derive(Debug, Clone)]
pub(crate) struct NoseShape {
    /// Midline profile `(y, z)` from above the sellion to the upper lip, y increasing.
    pub(crate) profile: Vec<(f64, f64)>,
    /// Half width of the cone of the nose at heights `(y, half width)`.
    pub(crate) half_width: Vec<(f64, f64)>,
    /// Centre of the wing, its semi-axes across and along, and its height.
    pub(crate) wing: [f64; 2],
    pub(crate) wing_radii: [f64; 2],
    pub(crate) wing_rise: f64,
    pub(crate) nostril: [f64; 2],
    pub(crate) nostril_radii: [f64; 2],
    pub(crate) nostril_depth: f64,
}

impl Default for NoseShape {
    fn default() -> Self {
        Self {
            profile: vec![
                (-36.0, 97.2),
                (-32.0, 97.8),
                (-29.0, 99.0),
                (-26.5, 102.0),
                (-23.5, 107.8),
                (-20.5, 114.3),
                (-17.0, 118.2),
                (-13.5, 119.0),
                (-9.0, 116.8),
                (0.0, 111.6),
                (9.0, 106.3),
                (18.0, 101.5),
                (27.0, 99.8),
                (36.0, 102.6),
                (46.0, 104.0),
            ],
            half_width: vec![
                (-36.0, 9.0),
                (-29.0, 9.5),
                (-23.0, 12.0),
                (-15.0, 15.0),
                (-6.0, 17.5),
                (6.0, 16.0),
                (16.0, 13.5),
                (26.0, 11.5),
                (34.0, 12.5),
                (46.0, 18.0),
            ],
            wing: [10.7, -18.2],
            wing_radii: [6.1, 8.0],
            wing_rise: 11.5,
            nostril: [6.2, -24.6],
            nostril_radii: [3.7, 2.3],
            nostril_depth: 7.5,
        }
    }
}

/// Cosine and sine of the tilt of the nostrils' axes.
const TILT: (f64, f64) = (0.90, 0.436);

/// The nose of a sculpt.
#[derive(Debug, Clone)]
pub struct Nose {
    shape: NoseShape,
    ridge: Curve,
    half_width: Curve,
}

impl Nose {
    pub(super) fn new(shape: &NoseShape) -> Self {
        Self {
            ridge: Curve::new(&shape.profile),
            half_width: Curve::new(&shape.half_width),
            shape: shape.clone(),
        }
    }

    /// Mask point `[x, y]` on the ring of relative radius `r` around the nostril.
    pub fn nostril_point(&self, angle: f64, r: f64) -> [f64; 2] {
        let s = &self.shape;
        let (a, b) = (r * angle.cos() * s.nostril_radii[0], r * angle.sin() * s.nostril_radii[1]);
        [s.nostril[0] + TILT.0 * a + TILT.1 * b, s.nostril[1] - TILT.1 * a + TILT.0 * b]
    }

    /// Mask point `[x, y]` on the ring of relative radius `r` around the wing (angle 0 to the side).
    pub fn wing_point(&self, angle: f64, r: f64) -> [f64; 2] {
        let s = &self.shape;
        let (u, v) = (r * angle.cos(), r * angle.sin());
        [s.wing[0] + (u + 0.25 * v) * s.wing_radii[0], s.wing[1] + v * s.wing_radii[1]]
    }

    /// Displacement at the mask point (x, y), x >= 0; `mid` is the z of the mask on the midline
    /// at the same height.
    pub(super) fn displacement(&self, x: f64, y: f64, mid: f64) -> Vec3 {
        if !(-40.0..50.0).contains(&y) || x > 32.0 {
            return Vec3::zeros();
        }
        let s = &self.shape;
        // Fades the absolute profile into the mask at both ends.
        let fade = smoothstep(-37.0, -29.0, y) * smoothstep(48.0, 34.0, y);
        let rise = (self.ridge.at(y) - mid) * fade;
        let t = (x / self.half_width.at(y)).min(1.0);
        let cone = 0.5 + 0.5 * (std::f64::consts::PI * t).cos();
        // Rounder near the tip.
        let lobule = bell(y + 14.0, 7.0);
        let section = mix(cone, 1.0 - t * t * (1.6 - 0.6 * t * t), 0.5 * lobule);
        let mut d = Vec3::new(0.0, 0.0, rise * section);

        // Wing: a bulge with a steep outer wall.
        let (u, v) = ((x - s.wing[0]) / s.wing_radii[0], (y - s.wing[1]) / s.wing_radii[1]);
        let (u, v) = (u - 0.25 * v, v);
        let r = u.hypot(v);
        // Very steep outside, so that the maximum below keeps it only where it exceeds the cone.
        let dome = s.wing_rise * (1.0 - r.powf(2.6)).max(-3.0);
        let outer = smoothstep(-0.5, 0.7, u);
        d.z = smooth_max(d.z, dome, mix(13.0, 2.5, outer));
        d.x += 1.2 * bell(r - 0.85, 0.3) * u.max(0.0);
        // Groove behind and above the wing.
        d.z -= 1.0 * bell(r - 1.12, 0.18) * smoothstep(-0.5, 0.3, u + 0.4 * v);

        // Nostril: the base of the nose displaced upward and backward.
        let (u, v) = (x - s.nostril[0], y - s.nostril[1]);
        let (u, v) = (
            (TILT.0 * u - TILT.1 * v) / s.nostril_radii[0],
            (TILT.1 * u + TILT.0 * v) / s.nostril_radii[1],
        );
        let hollow = smoothstep(1.1, 0.35, u.hypot(v));
        d + Vec3::new(0.3, 3.4, -6.0) * (hollow * s.nostril_depth / 7.5)
    }
}
