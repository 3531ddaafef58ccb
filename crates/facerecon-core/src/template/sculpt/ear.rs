//! The ear: a stack of closed rings from its root on the head over the back of the auricle, the
//! rim (helix), the groove and ridge inside it (scapha, antihelix) into the bowl (concha).

use super::curve::{Curve, mix, smoothstep};
use crate::math::Vec3;
use std::f64::consts::TAU;

/// Shape of one direction around the bowl: distances from its middle in the plane of the ear and
/// heights over the side of the head, millimetres.
#[derive(Debug, Clone)]
pub(crate) struct Spoke {
    /// Direction in degrees: 0 up, 90 back, 180 down, 270 front.
    pub(crate) degrees: f64,
    /// Where the ear leaves the head.
    pub(crate) root: f64,
    /// Outline and its height.
    pub(crate) rim: f64,
    pub(crate) rim_height: f64,
    /// Breadth of the rolled rim and depth of the groove inside it.
    pub(crate) roll: f64,
    pub(crate) groove: f64,
    /// Ridge around the bowl: distance and height.
    pub(crate) ridge: f64,
    pub(crate) ridge_height: f64,
    /// Wall and floor of the bowl.
    pub(crate) wall: f64,
    pub(crate) floor: f64,
}

/// Shape of the whole auricle.
#[derive(Debug, Clone)]
pub(crate) struct EarShape {
    /// Middle of the bowl `[y, z]`.
    pub(crate) middle: [f64; 2],
    /// Backward tilt of the long axis, degrees.
    pub(crate) tilt: f64,
    pub(crate) scale: f64,
    /// Factor on the heights over the side of the head.
    pub(crate) protrusion: f64,
    pub(crate) spokes: Vec<Spoke>,
}

impl Default for EarShape {
    fn default() -> Self {
        let s = |degrees, root, rim, rim_height, roll, groove, ridge, ridge_height, wall, floor| {
            Spoke { degrees, root, rim, rim_height, roll, groove, ridge, ridge_height, wall, floor }
        };
        Self {
            middle: [-2.0, -9.0],
            tilt: 12.0,
            scale: 1.0,
            protrusion: 0.88,
            spokes: vec![
                //   deg  root  rim   h    roll groove ridge  h    wall floor
                s(0.0, 19.0, 33.0, 11.0, 4.5, 3.0, 17.0, 9.0, 11.0, 3.0),
                s(30.0, 18.0, 33.5, 14.0, 5.0, 3.5, 18.5, 12.0, 11.5, 3.0),
                s(60.0, 15.5, 29.5, 17.0, 5.0, 3.5, 18.0, 15.0, 12.0, 3.0),
                s(90.0, 13.0, 25.5, 18.0, 4.5, 3.0, 16.0, 16.0, 11.5, 2.5),
                s(120.0, 13.0, 23.5, 16.5, 4.0, 2.5, 14.5, 15.5, 10.5, 2.0),
                s(150.0, 16.0, 25.0, 12.5, 3.5, 1.2, 14.0, 12.5, 9.5, 2.0),
                s(175.0, 20.0, 28.5, 8.0, 3.5, 0.6, 13.5, 10.0, 9.0, 2.0),
                s(195.0, 22.0, 27.5, 5.0, 3.5, 0.5, 12.5, 9.0, 8.5, 2.0),
                s(215.0, 19.0, 20.0, 3.0, 3.0, 0.5, 11.0, 8.0, 7.5, 2.0),
                s(240.0, 13.5, 12.5, 3.5, 2.0, 0.0, 8.5, 6.5, 6.0, 1.5),
                s(265.0, 11.5, 10.0, 5.5, 1.8, 0.0, 6.5, 6.5, 4.5, 0.5),
                s(290.0, 13.0, 11.5, 4.0, 2.0, 0.3, 8.0, 3.5, 6.0, 1.0),
                s(315.0, 18.5, 18.0, 4.0, 3.0, 1.0, 11.5, 3.0, 8.5, 2.0),
                s(340.0, 20.0, 27.0, 7.5, 4.0, 2.2, 14.0, 5.5, 10.0, 2.5),
            ],
        }
    }
}

/// Positions of the rings between the root (1) and the middle of the bowl (0).
const LAYERS: [f64; 11] = [1.0, 0.90, 0.80, 0.74, 0.69, 0.63, 0.56, 0.46, 0.33, 0.17, 0.0];

/// The ear of a sculpt.
#[derive(Debug, Clone)]
pub struct Ear {
    middle: [f64; 2],
    tilt: f64,
    /// Distance and height of each ring over the direction in radians.
    rings: Vec<[Curve; 2]>,
    root: Curve,
}

impl Ear {
    pub(super) fn new(shape: &EarShape) -> Self {
        let (k, p) = (shape.scale, shape.protrusion);
        let ring = |f: &dyn Fn(&Spoke) -> [f64; 2]| -> [Curve; 2] {
            [0, 1].map(|i| {
                let scale = if i == 0 { k } else { k * p };
                let knots: Vec<(f64, f64)> = shape
                    .spokes
                    .iter()
                    .map(|s| (s.degrees.to_radians(), scale * f(s)[i]))
                    .collect();
                Curve::periodic(&knots, TAU)
            })
        };
        // Share of the back of the auricle in this direction: none in front.
        let free = |s: &Spoke| smoothstep(0.0, 7.0, s.rim - s.root);
        let rings = vec![
            ring(&|s| [s.root, 0.0]),
            ring(&|s| [s.root + mix(-0.5, 1.5, free(s)), mix(0.3, 0.45, free(s)) * s.rim_height]),
            ring(&|s| {
                [mix(s.rim + 0.8, s.rim - 1.6, free(s)), s.rim_height - mix(1.3, 4.4, free(s))]
            }),
            ring(&|s| [s.rim, s.rim_height - mix(0.4, 2.0, free(s))]),
            ring(&|s| [s.rim - 0.35 * s.roll, s.rim_height]),
            ring(&|s| [s.rim - s.roll, s.rim_height - 0.45 * s.groove]),
            ring(&|s| {
                [
                    mix(s.rim - s.roll, s.ridge, 0.35),
                    0.5 * (s.rim_height + s.ridge_height) - s.groove,
                ]
            }),
            ring(&|s| [s.ridge, s.ridge_height]),
            ring(&|s| [s.wall, mix(s.floor, s.ridge_height, 0.45)]),
            ring(&|s| [0.62 * s.wall, s.floor]),
            ring(&|_| [0.0, 1.2]),
        ];
        let root = Curve::periodic(
            &shape.spokes.iter().map(|s| (s.degrees.to_radians(), k * s.root)).collect::<Vec<_>>(),
            TAU,
        );
        Self { middle: shape.middle, tilt: shape.tilt.to_radians(), rings, root }
    }

    /// Polar coordinates of a side point (y, z) about the bowl: direction, and distance as a
    /// fraction of the root.
    pub(super) fn polar(&self, y: f64, z: f64) -> (f64, f64) {
        let (up, back) = (y - self.middle[0], self.middle[1] - z);
        let angle = (back.atan2(up) + self.tilt).rem_euclid(TAU);
        (angle, up.hypot(back) / self.root.at(angle))
    }

    /// Inverse of [`Self::polar`]: `[y, z]` at a direction (radians) and a fraction of the root.
    pub fn side_point(&self, angle: f64, fraction: f64) -> [f64; 2] {
        let r = fraction * self.root.at(angle);
        let a = angle - self.tilt;
        [self.middle[0] + r * a.cos(), self.middle[1] - r * a.sin()]
    }

    /// Side coordinates and height over the head of the auricle, at a fraction below 1.
    pub(super) fn auricle(&self, angle: f64, fraction: f64) -> Vec3 {
        let f = fraction.clamp(0.0, 1.0);
        // Catmull-Rom through the rings at this angle.
        let k = LAYERS.partition_point(|&l| l > f).clamp(1, LAYERS.len() - 1);
        let ring = |i: usize| {
            let i = i.min(LAYERS.len() - 1);
            Vec3::new(self.rings[i][0].at(angle), self.rings[i][1].at(angle), LAYERS[i])
        };
        let (p1, p2) = (ring(k - 1), ring(k));
        let before =
            if k >= 2 { ring(k - 2) } else { p1 + Vec3::new(p1.x - p2.x, 0.0, p1.z - p2.z) };
        // Past the middle the profile continues on the other side.
        let after = if k + 1 < LAYERS.len() { ring(k + 1) } else { Vec3::new(-p1.x, p1.y, -p1.z) };
        let slope = |a: Vec3, b: Vec3| {
            let dt = b.z - a.z;
            [(b.x - a.x) / dt, (b.y - a.y) / dt]
        };
        let (s1, s2) = (slope(before, p2), slope(p1, after));
        let h = p2.z - p1.z;
        let u = (f - p1.z) / h;
        let hermite = |a: f64, b: f64, da: f64, db: f64| {
            let (u2, u3) = (u * u, u * u * u);
            a * (2.0 * u3 - 3.0 * u2 + 1.0)
                + b * (3.0 * u2 - 2.0 * u3)
                + h * (da * (u3 - 2.0 * u2 + u) + db * (u3 - u2))
        };
        let r = hermite(p1.x, p2.x, s1[0], s2[0]);
        let height = hermite(p1.y, p2.y, s1[1], s2[1]);
        let a = angle - self.tilt;
        Vec3::new(height, self.middle[0] + r * a.cos(), self.middle[1] - r * a.sin())
    }
}
