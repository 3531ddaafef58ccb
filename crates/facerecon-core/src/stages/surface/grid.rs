//! The dense disparity as a lattice of triangles.

use super::patch::{NONE, Node, Patch, Place};
use crate::data::Gray;
use crate::math::Vec2;

/// Triangles between the points of a lattice, `step` pixels apart, at which the disparity is
/// known. They are equilateral in the picture: no direction is preferred.
pub(super) fn triangulated(disparity: &Gray, step: f64, place: Place<'_>) -> Patch {
    // finer than the pixels there is nothing to see
    let step = step.max(1.0);
    let down = step * 0.75f64.sqrt();
    let cells = |length: usize, step: f64| (length.saturating_sub(1) as f64 / step) as usize + 1;
    let (columns, rows) = (cells(disparity.width(), step), cells(disparity.height(), down));
    let mut patch = Patch::default();
    let mut names = vec![NONE; columns * rows];
    for row in 0..rows {
        for column in 0..columns {
            let shift = if row % 2 == 1 { 0.5 } else { 0.0 };
            let pixel = Vec2::new((column as f64 + shift) * step, row as f64 * down);
            let value = disparity.bilinear(pixel.x, pixel.y).map(f64::from);
            let node = value.filter(|d| d.is_finite()).and_then(|d| Node::new(pixel, d, place));
            if let Some(node) = node {
                names[row * columns + column] = patch.nodes.len() as u32;
                patch.nodes.push(node);
            }
        }
    }
    for row in 1..rows {
        for column in 1..columns {
            let at = |c: usize, r: usize| names[r * columns + c];
            let (a, b) = (at(column - 1, row - 1), at(column, row - 1));
            let (c, d) = (at(column - 1, row), at(column, row));
            // the row that is shifted has its nodes over the middles of the other's edges
            let pair = if row % 2 == 1 { [[a, b, c], [b, d, c]] } else { [[a, b, d], [a, d, c]] };
            for face in pair.into_iter().filter(|f| !f.contains(&NONE)) {
                patch.add(face);
            }
        }
    }
    patch
}
