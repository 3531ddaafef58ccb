//! Regions of the frontal picture that differ in colour from the skin about them.

use super::frontal::{pixel, position};
use crate::data::regions::{flood, without_holes};
use crate::data::{Gray, Raster};
use crate::math::{Vec2, median};

/// A rectangle of the frontal picture, mm in the head's frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Window {
    pub x_mm: (f64, f64),
    pub y_mm: (f64, f64),
}

/// A part of the frontal picture.
pub(super) struct Cutout {
    /// First column and row of the frontal picture.
    first: [usize; 2],
    pub size: (usize, usize),
}

impl Cutout {
    pub fn new(window: Window, picture: &Gray) -> Self {
        let low = pixel(window.x_mm.0, window.y_mm.1);
        let high = pixel(window.x_mm.1, window.y_mm.0);
        let clip = |v: f64, limit: usize| (v.round().max(0.0) as usize).min(limit);
        let (width, height) = picture.size();
        let (u0, v0) = (clip(low.x, width), clip(low.y, height));
        let (u1, v1) = (clip(high.x, width), clip(high.y, height));
        Self { first: [u0, v0], size: (u1.saturating_sub(u0), v1.saturating_sub(v0)) }
    }

    /// The part of a picture.
    pub fn of(&self, picture: &Gray) -> Gray {
        let (width, height) = self.size;
        Gray::from_fn(width, height, |u, v| picture.at(u + self.first[0], v + self.first[1]))
    }

    /// Position of a pixel of the part, mm in the head's frame.
    pub fn position(&self, u: f64, v: f64) -> Vec2 {
        position(u + self.first[0] as f64, v + self.first[1] as f64)
    }

    /// The values of a part at positions that satisfy a condition.
    pub fn values(&self, part: &Gray, keep: impl Fn(Vec2) -> bool) -> Vec<f64> {
        let mut values = Vec::new();
        for v in 0..self.size.1 {
            for u in 0..self.size.0 {
                if keep(self.position(u as f64, v as f64)) {
                    values.push(f64::from(part.at(u, v)));
                }
            }
        }
        values
    }

    /// The median of these values.
    pub fn median(&self, part: &Gray, keep: impl Fn(Vec2) -> bool) -> Option<f64> {
        median(&self.values(part, keep))
    }
}

/// A connected set of pixels without holes.
pub(super) struct Region {
    inside: Raster<bool>,
}

/// Pixels beside the extreme column whose mean row is that of the corner.
const CORNER_COLUMNS: usize = 3;

impl Region {
    /// Of the connected sets of pixels with a score above 1, the one with the greatest sum of
    /// weighted scores; `None` where there is none.
    pub fn heaviest(score: &Gray, weight: impl Fn(usize, usize) -> f64) -> Option<Self> {
        let (width, height) = score.size();
        let marked = score.map(|s| s > 1.0);
        let mut label = vec![0u32; width * height];
        let mut best: Option<(f64, u32)> = None;
        let mut count = 0;
        for start in 0..width * height {
            if label[start] != 0 || !marked.data()[start] {
                continue;
            }
            count += 1;
            let mut sum = 0.0;
            flood(&marked, start, &mut |i| {
                let is_new = label[i] == 0;
                if is_new {
                    label[i] = count;
                    sum += weight(i % width, i / width) * f64::from(score.data()[i].min(4.0));
                }
                is_new
            });
            if best.is_none_or(|b| sum > b.0) {
                best = Some((sum, count));
            }
        }
        let chosen = best?.1;
        let inside = Raster::from_fn(width, height, |u, v| label[v * width + u] == chosen);
        Some(Self { inside: without_holes(&inside) })
    }

    /// Whether a pixel belongs to the region.
    pub fn contains(&self, u: usize, v: usize) -> bool {
        self.inside.at(u, v)
    }

    /// Whether a pixel lies within a square of the given half side about a pixel of the region.
    pub fn widened(&self, half_side: usize) -> Self {
        let (width, height) = self.inside.size();
        let along_rows = Raster::from_fn(width, height, |u, v| {
            (u.saturating_sub(half_side)..(u + half_side + 1).min(width))
                .any(|x| self.inside.at(x, v))
        });
        let inside = Raster::from_fn(width, height, |u, v| {
            (v.saturating_sub(half_side)..(v + half_side + 1).min(height))
                .any(|y| along_rows.at(u, y))
        });
        Self { inside }
    }

    /// The pixels.
    pub fn pixels(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let width = self.inside.width().max(1);
        let inside = self.inside.data().iter().enumerate().filter(|(_, inside)| **inside);
        inside.map(move |(i, _)| (i % width, i / width))
    }

    /// The left and right corners: the extreme columns, at the mean row of what is near them.
    pub fn corners(&self) -> Option<[(f64, f64); 2]> {
        let low = self.pixels().map(|p| p.0).min()?;
        let high = self.pixels().map(|p| p.0).max()?;
        let mean_row = |near: &dyn Fn(usize) -> bool| {
            let rows: Vec<f64> = self.pixels().filter(|p| near(p.0)).map(|p| p.1 as f64).collect();
            rows.iter().sum::<f64>() / rows.len().max(1) as f64
        };
        Some([
            (low as f64, mean_row(&|u| u <= low + CORNER_COLUMNS)),
            (high as f64, mean_row(&|u| u + CORNER_COLUMNS >= high)),
        ])
    }

    /// The first and last row of the columns within `half_width` of a column.
    pub fn rows_at(&self, column: f64, half_width: f64) -> Option<(f64, f64)> {
        let rows =
            || self.pixels().filter(|p| (p.0 as f64 - column).abs() <= half_width).map(|p| p.1);
        Some((rows().min()? as f64, rows().max()? as f64))
    }
}
