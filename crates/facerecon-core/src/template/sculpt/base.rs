//! The large form: skull, facial mask, jaw and neck as a loft through horizontal loops.
//!
//! Each loop is a rounded superellipse. Its half breadth and its depth in front and at the back come
//! from anthropometric tables (see `proportions`). Its height may differ at front, side and back, so
//! that the loop of the jaw follows the jaw line.

use super::curve::{Curve, mix};
use super::proportions::Loop;
use crate::math::Vec3;

/// Softening of the superellipse at its axes, in units of sine: no ridge on the midline.
const AXIS_SOFTENING: f64 = 0.22;

#[derive(Debug, Clone)]
pub(super) struct Base {
    y: [Curve; 3],
    half_breadth: Curve,
    front: Curve,
    back: Curve,
    centre: Curve,
    squareness: [Curve; 2],
}

impl Base {
    pub(super) fn new(loops: &[Loop]) -> Self {
        let mut v = vec![0.0];
        for pair in loops.windows(2) {
            let (a, b) = (&pair[0], &pair[1]);
            // Knots spaced by the mean length between loops at front, side and back.
            let step = [
                (b.y[0] - a.y[0], b.front - a.front),
                (b.y[1] - a.y[1], b.half_breadth - a.half_breadth),
                (b.y[2] - a.y[2], b.back - a.back),
            ]
            .iter()
            .map(|(dy, dr)| dy.hypot(*dr))
            .sum::<f64>();
            v.push(v[v.len() - 1] + step);
        }
        let total = v[v.len() - 1];
        let knots = |f: &dyn Fn(&Loop) -> f64| -> Vec<(f64, f64)> {
            v.iter().zip(loops).map(|(v, l)| (v / total, f(l))).collect()
        };
        Self {
            y: [0, 1, 2].map(|k| Curve::flat_start(&knots(&|l| l.y[k]))),
            half_breadth: Curve::new(&knots(&|l| l.half_breadth)),
            front: Curve::new(&knots(&|l| l.front)),
            back: Curve::new(&knots(&|l| l.back)),
            centre: Curve::new(&knots(&|l| l.centre)),
            squareness: [0, 1].map(|k| Curve::new(&knots(&|l| l.squareness[k]))),
        }
    }

    /// Point at height parameter `v` (0 crown, 1 neck border) in the horizontal direction
    /// `(sine, cosine)` from the vertical axis: sine toward +x, cosine toward +z.
    pub(super) fn point(&self, sine: f64, cosine: f64, v: f64) -> Vec3 {
        let centre = self.centre.at(v);
        let (depth, n) = if cosine >= 0.0 {
            (self.front.at(v) - centre, self.squareness[0].at(v))
        } else {
            (centre - self.back.at(v), self.squareness[1].at(v))
        };
        let breadth = self.half_breadth.at(v);
        if breadth < 1e-9 || depth < 1e-9 {
            return Vec3::new(0.0, self.y[1].at(v), centre);
        }
        let e = AXIS_SOFTENING;
        let one = (1.0 + e * e).powf(0.5 * n) - e.powf(n);
        let soft = |s: f64| ((s * s + e * e).powf(0.5 * n) - e.powf(n)) / one;
        let r = (soft(sine) / breadth.powf(n) + soft(cosine) / depth.powf(n)).powf(-1.0 / n);
        let [yf, ys, yb] = [0, 1, 2].map(|k| self.y[k].at(v));
        let y = mix(ys, if cosine >= 0.0 { yf } else { yb }, cosine * cosine);
        Vec3::new(r * sine, y, centre + r * cosine)
    }
}
