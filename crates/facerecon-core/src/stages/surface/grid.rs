//! The dense disparity, sampled on a grid of equilateral triangles.

use super::adjacency::NONE;
use super::patch::{Node, Patch, Unproject};
use crate::data::Gray;
use crate::math::Vec2;

/// Smallest spacing, pixels: the disparity has no detail between pixels.
const MIN_STEP_PX: f64 = 1.0;

/// Triangles between the grid points with a known disparity, `step_px` apart. They are equilateral
/// in the left photo, so that no direction is preferred.
pub(super) fn triangulated(disparity: &Gray, step_px: f64, unproject: Unproject<'_>) -> Patch {
    let step = step_px.max(MIN_STEP_PX);
    let down = step * 0.75f64.sqrt();
    let cells = |length: usize, step: f64| (length.saturating_sub(1) as f64 / step) as usize + 1;
    let (columns, rows) = (cells(disparity.width(), step), cells(disparity.height(), down));
    let mut patch = Patch::default();
    let mut node_at = vec![NONE; columns * rows];
    for row in 0..rows {
        for column in 0..columns {
            let shift = if row % 2 == 1 { 0.5 } else { 0.0 };
            let pixel = Vec2::new((column as f64 + shift) * step, row as f64 * down);
            let value = disparity.bilinear(pixel.x, pixel.y).map(f64::from);
            let node = value.filter(|d| d.is_finite()).and_then(|d| Node::new(pixel, d, unproject));
            if let Some(node) = node {
                node_at[row * columns + column] = patch.nodes.len() as u32;
                patch.nodes.push(node);
            }
        }
    }
    for row in 1..rows {
        for column in 1..columns {
            let at = |c: usize, r: usize| node_at[r * columns + c];
            let (a, b) = (at(column - 1, row - 1), at(column, row - 1));
            let (c, d) = (at(column - 1, row), at(column, row));
            // odd rows are shifted by half a step
            let pair = if row % 2 == 1 { [[a, b, c], [b, d, c]] } else { [[a, b, d], [a, d, c]] };
            for face in pair.into_iter().filter(|f| !f.contains(&NONE)) {
                patch.add(face);
            }
        }
    }
    patch
}
