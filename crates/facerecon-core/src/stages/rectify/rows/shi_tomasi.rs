//! Corners of one picture (Shi and Tomasi 1994).

use crate::data::Gray;

/// Side of the cells that give one corner each at most, pixels.
const CELL_PX: usize = 5;
/// Half the side of the window that the gradients are summed over, pixels.
const WINDOW_RADIUS: usize = 2;
/// Minimum of the smaller eigenvalue of the summed gradients, grey levels squared. Set by hand.
const MIN_STRENGTH: f32 = 20.0;

/// The strongest corners of a picture at least `margin` pixels from its border, at most `count`,
/// strongest first.
pub(super) fn corners(image: &Gray, margin: usize, count: usize) -> Vec<(usize, usize)> {
    let (width, height) = image.size();
    let mut found: Vec<(f32, usize, usize)> = Vec::new();
    for cell_y in (margin..height.saturating_sub(margin)).step_by(CELL_PX) {
        for cell_x in (margin..width.saturating_sub(margin)).step_by(CELL_PX) {
            let ys = cell_y..(cell_y + CELL_PX).min(height - margin);
            let best = ys
                .flat_map(|y| (cell_x..(cell_x + CELL_PX).min(width - margin)).map(move |x| (x, y)))
                .map(|(x, y)| (strength(image, x, y), x, y))
                .max_by(|a, b| a.0.total_cmp(&b.0));
            found.extend(best.filter(|b| b.0 > MIN_STRENGTH));
        }
    }
    found.sort_by(|a, b| b.0.total_cmp(&a.0).then((a.2, a.1).cmp(&(b.2, b.1))));
    found.truncate(count);
    found.into_iter().map(|f| (f.1, f.2)).collect()
}

/// The smaller eigenvalue of the gradients' outer products summed over the window.
fn strength(image: &Gray, x: usize, y: usize) -> f32 {
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for v in y - WINDOW_RADIUS..=y + WINDOW_RADIUS {
        for u in x - WINDOW_RADIUS..=x + WINDOW_RADIUS {
            let gx = image.at(u + 1, v) - image.at(u - 1, v);
            let gy = image.at(u, v + 1) - image.at(u, v - 1);
            (xx, xy, yy) = (xx + gx * gx, xy + gx * gy, yy + gy * gy);
        }
    }
    0.5 * (xx + yy) - (0.25 * (xx - yy).powi(2) + xy * xy).sqrt()
}
