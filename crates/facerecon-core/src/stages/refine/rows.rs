//! Rows of the right photo, levelled with the matches.

use super::image::shifted_down;
use super::plane::robust_plane;
use crate::data::{Gray, Match};

/// Smallest scale of the row offsets' residuals, in pitches: about the row error of a detected dot.
const MIN_SCALE: f64 = 0.0022;
/// Row offsets below this, summed over the plane's terms, are left as they are, in pitches.
const NEGLIGIBLE: f64 = 0.0044;
/// Farthest a row is moved, in pitches: rectified rows differ by less, so a larger shift is a wrong
/// fit.
const MAX_SHIFT: f64 = 0.45;

/// The right photo with its rows moved to where the matches show those of the left one: a plane of
/// row offsets is fitted to them. The photo is unchanged when the offsets are negligible.
pub(super) fn levelled(right: &Gray, matches: &[Match], pitch_px: f64) -> Gray {
    let centre = [right.width() as f64 / 2.0, right.height() as f64 / 2.0];
    let size = centre[0].max(centre[1]).max(1.0);
    let points: Vec<[f64; 4]> = matches
        .iter()
        .map(|m| {
            let (u, v) = ((m.right.x - centre[0]) / size, (m.right.y - centre[1]) / size);
            [u, v, m.right.y - m.left.y, 1.0]
        })
        .collect();
    let Some((plane, _)) = robust_plane(&points, MIN_SCALE * pitch_px) else {
        return right.clone();
    };
    if plane.abs().sum() < NEGLIGIBLE * pitch_px {
        return right.clone();
    }
    let limit = MAX_SHIFT * pitch_px;
    shifted_down(right, |x, y| {
        let shift =
            plane[0] + plane[1] * (x - centre[0]) / size + plane[2] * (y - centre[1]) / size;
        shift.clamp(-limit, limit)
    })
}
