//! The light of the pattern at any point of its plane, independent of resolution.

use super::PatternParams;
use super::stripes::{PALETTE, stripe};
use crate::data::PatternKind;
use crate::math::Vec2;

/// The geometry of a pattern. Lattice coordinates: the dot of column `c` and row `r` is centred at
/// `(c, r)`; stripe `i` has its left edge at `x = i`.
#[derive(Clone, Debug, PartialEq)]
pub struct Design {
    /// Distance between dots (or stripes) in the projector image.
    pub spacing_px: f64,
    kind: PatternKind,
    columns: i64,
    rows: i64,
    radius: f64,
    /// Centre of the pattern, lattice coordinates.
    middle: Vec2,
    /// Centre of the projector image, pixels.
    centre_px: Vec2,
    cos: f64,
    sin: f64,
}

impl Design {
    /// The geometry of a pattern that fills the projector image up to its margin.
    pub fn new(params: &PatternParams) -> Self {
        let (sin, cos) = params.rotation_deg.to_radians().sin_cos();
        let (columns, rows) = (params.columns as f64, params.rows as f64);
        let size = Vec2::new(params.width_px as f64, params.height_px as f64);
        let room = size - Vec2::repeat(2.0 * params.margin_fraction * size.min());
        // The rotated pattern must fit.
        let wide = columns * cos + rows * sin.abs();
        let high = columns * sin.abs() + rows * cos;
        let first = match params.kind {
            PatternKind::Dots => Vec2::repeat(-0.5),
            PatternKind::Stripes => Vec2::new(0.0, -0.5),
        };
        Self {
            spacing_px: (room.x / wide).min(room.y / high),
            kind: params.kind,
            columns: params.columns as i64,
            rows: params.rows as i64,
            radius: params.dot_fraction / 2.0,
            middle: first + Vec2::new(columns, rows) / 2.0,
            centre_px: (size - Vec2::repeat(1.0)) / 2.0,
            cos,
            sin,
        }
    }

    /// Centre of the pattern, lattice coordinates.
    pub fn middle(&self) -> Vec2 {
        self.middle
    }

    /// Projector pixel of a point given in lattice coordinates.
    pub fn pixel(&self, lattice: Vec2) -> Vec2 {
        let d = (lattice - self.middle) * self.spacing_px;
        self.centre_px + Vec2::new(self.cos * d.x - self.sin * d.y, self.sin * d.x + self.cos * d.y)
    }

    /// Lattice coordinates of a projector pixel.
    pub fn lattice(&self, x: f64, y: f64) -> Vec2 {
        let d = (Vec2::new(x, y) - self.centre_px) / self.spacing_px;
        self.middle + Vec2::new(self.cos * d.x + self.sin * d.y, self.cos * d.y - self.sin * d.x)
    }

    /// Linear light, 0 to 1, red, green, blue, at a point in lattice coordinates. Edges are
    /// smoothed over `softness` spacings on either side, as by a projector out of focus.
    pub fn light(&self, at: Vec2, softness: f64) -> [f64; 3] {
        match self.kind {
            PatternKind::Dots => {
                let (column, row) = (at.x.round(), at.y.round());
                let inside = column >= 0.0
                    && row >= 0.0
                    && column < self.columns as f64
                    && row < self.rows as f64;
                let from_edge = self.radius - (at - Vec2::new(column, row)).norm();
                [if inside { ramp(from_edge, softness) } else { 0.0 }; 3]
            }
            PatternKind::Stripes => {
                let number = at.x.floor();
                let along = ramp((at.y + 0.5).min(self.rows as f64 - 0.5 - at.y), softness);
                let mut light = [0.0; 3];
                // The smooth edge of a stripe extends into the cell of its neighbour.
                for i in [number - 1.0, number, number + 1.0] {
                    if !(i >= 0.0 && i < self.columns as f64) {
                        continue;
                    }
                    let s = stripe(i as usize);
                    let across = ramp((at.x - i).min(i + s.width - at.x), softness);
                    for k in 0..3 {
                        light[k] += PALETTE[s.color_index][k] * across * along;
                    }
                }
                light
            }
        }
    }
}

/// Smooth step from 0 at `-softness` to 1 at `softness`.
fn ramp(distance: f64, softness: f64) -> f64 {
    if softness <= 0.0 {
        return if distance >= 0.0 { 1.0 } else { 0.0 };
    }
    let t = (0.5 + 0.5 * distance / softness).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
