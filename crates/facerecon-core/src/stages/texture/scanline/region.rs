//! The region that is copied, in a photo and on the texture map (thesis section 5.2).

use super::super::error::TextureError;
use super::super::params::Boundary;
use super::anchors::Anchor;
use super::mapping::Mapping;
use crate::math::Vec2;

/// Top and bottom edge of the hexagon are shorter by this fraction of the width at either end.
const HEXAGON_INSET: f64 = 0.25;
/// The hexagon's outer corners keep this fraction of the height from top and bottom.
const CORNER_MARGIN: f64 = 0.2;
/// Least width and height of the region, texels.
const LEAST_SIDE: f64 = 2.0;

/// The four extreme dots of a photo.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Extremes {
    /// Least x.
    pub left: Anchor,
    /// Greatest x.
    pub right: Anchor,
    /// Least y.
    pub top: Anchor,
    /// Greatest y.
    pub bottom: Anchor,
}

impl Extremes {
    /// Finds them; `None` without dots.
    pub fn new(list: &[Anchor]) -> Option<Self> {
        let by =
            |key: fn(&Anchor) -> f64| list.iter().copied().min_by(|a, b| key(a).total_cmp(&key(b)));
        Some(Self {
            left: by(|a| a.photo.x)?,
            right: by(|a| -a.photo.x)?,
            top: by(|a| a.photo.y)?,
            bottom: by(|a| -a.photo.y)?,
        })
    }
}

/// A polygon each row of which is one span: left and right edge, from top to bottom.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Region {
    left: Vec<Vec2>,
    right: Vec<Vec2>,
}

impl Region {
    /// The region in the photo.
    pub fn photo(e: &Extremes, kind: Boundary) -> Self {
        Self::new([e.left.photo, e.right.photo, e.top.photo, e.bottom.photo], kind)
    }

    /// The corresponding region on the texture, from the vertices of the same dots.
    ///
    /// # Errors
    /// [`TextureError::Boundary`] when it has no area.
    pub fn texture(e: &Extremes, kind: Boundary) -> Result<Self, TextureError> {
        let (width, height) = (e.right.texel.x - e.left.texel.x, e.bottom.texel.y - e.top.texel.y);
        if !(width >= LEAST_SIDE && height >= LEAST_SIDE) {
            return Err(TextureError::Boundary { width, height });
        }
        Ok(Self::new([e.left.texel, e.right.texel, e.top.texel, e.bottom.texel], kind))
    }

    /// A hexagon has its outer corners at the leftmost and rightmost dot, but not in the upper or
    /// lower fifth; top and bottom edge are half as wide as the box, as in a regular hexagon.
    fn new([l, r, t, b]: [Vec2; 4], kind: Boundary) -> Self {
        let inset = match kind {
            Boundary::Rectangle => 0.0,
            Boundary::Hexagon => (r.x - l.x) * HEXAGON_INSET,
        };
        let margin = CORNER_MARGIN * (b.y - t.y).abs();
        let (high, low) = (t.y.min(b.y) + margin, b.y.max(t.y) - margin);
        let edge = |outer: Vec2, side: f64| match kind {
            Boundary::Rectangle => vec![Vec2::new(outer.x, t.y), Vec2::new(outer.x, b.y)],
            Boundary::Hexagon => vec![
                Vec2::new(outer.x + side * inset, t.y),
                Vec2::new(outer.x, outer.y.clamp(high, low)),
                Vec2::new(outer.x + side * inset, b.y),
            ],
        };
        Self { left: edge(l, 1.0), right: edge(r, -1.0) }
    }

    /// First and last row.
    pub fn rows(&self) -> (f64, f64) {
        (self.left[0].y, self.left[self.left.len() - 1].y)
    }

    /// First and last column of a row; rows outside take that of the first or last row.
    pub fn span(&self, y: f64) -> (f64, f64) {
        let x = |edge: &[Vec2]| Mapping::through(edge.iter().map(|p| (p.y, p.x)).collect()).at(y);
        (x(&self.left), x(&self.right))
    }
}
