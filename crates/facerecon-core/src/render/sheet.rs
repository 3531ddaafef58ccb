//! Several views side by side in one picture.

use super::error::{LARGEST_SIDE, RenderError};
use super::font::{draw_text, text_width};
use super::picture::{Mode, Scene, Studio, room};
use super::view::View;
use crate::data::Rgb;

/// Draws several views side by side at one scale, each cell of `cell` = (width, height) pixels and
/// labelled with the view's name.
///
/// # Errors
/// [`RenderError`] as for a single picture, and without any view.
pub fn contact_sheet(
    scene: &Scene<'_>,
    views: &[View],
    mode: Mode,
    cell: (usize, usize),
) -> Result<Rgb, RenderError> {
    if views.is_empty() {
        return Err(RenderError::NoViews);
    }
    let studio = Studio::new(scene, mode)?;
    // one scale for all, so that the heads have one size
    let room = room(mode, cell);
    let focal = views.iter().map(|v| studio.focal_px(*v, room)).fold(f64::INFINITY, f64::min);
    let mut cells = Vec::with_capacity(views.len());
    for view in views {
        let mut image = studio.picture(*view, Some(focal), cell)?;
        let zoom = (cell.0 / 320).clamp(1, 4);
        let label = view.to_string();
        let x = cell.0.saturating_sub(text_width(&label) * zoom) / 2;
        draw_text(&mut image, x, 4 * zoom, &label, zoom, [90, 92, 96]);
        cells.push(image);
    }
    tile(&cells, views.len())
}

/// Arranges pictures in a grid of `columns` columns on white; cells have the size of the largest.
///
/// # Errors
/// [`RenderError::NoViews`] without pictures, [`RenderError::Size`] when the sheet becomes too large.
pub fn tile(cells: &[Rgb], columns: usize) -> Result<Rgb, RenderError> {
    let columns = columns.clamp(1, cells.len().max(1));
    let cell_width = cells.iter().map(Rgb::width).max().ok_or(RenderError::NoViews)?;
    let cell_height = cells.iter().map(Rgb::height).max().ok_or(RenderError::NoViews)?;
    let (width, height) = (cell_width * columns, cell_height * cells.len().div_ceil(columns));
    if width > 4 * LARGEST_SIDE || height > 4 * LARGEST_SIDE {
        return Err(RenderError::Size { width, height });
    }
    let mut sheet = Rgb::filled(width, height, [255; 3]);
    for (i, image) in cells.iter().enumerate() {
        let (left, top) = (i % columns * cell_width, i / columns * cell_height);
        for y in 0..image.height() {
            let start = (top + y) * width + left;
            sheet.data_mut()[start..start + image.width()].copy_from_slice(image.row(y));
        }
    }
    Ok(sheet)
}
