//! The opening of an eye: the region beside the nose that is less red or darker than skin.

use super::color_regions::{Cutout, Region, Window};
use super::frontal::{Colors, PIXEL_MM};
use crate::data::Gray;
use crate::math::{Vec2, median};

/// Where an eye is looked for, relative to the tip of the nose, mm; x for the eye at the right.
const WINDOW_X_MM: (f64, f64) = (10.0, 56.0);
const WINDOW_Y_MM: (f64, f64) = (10.0, 48.0);
/// Expected centre and the spread about it, mm.
const CENTRE_MM: (f64, f64) = (31.0, 29.0);
const SPREAD_MM: (f64, f64) = (12.0, 9.0);
/// Difference of redness, and of the logarithm of brightness, with which the first region is found.
const FIRST_REDNESS: f64 = 0.1;
const DARKNESS: f64 = 0.8;
/// Rounds in which skin and sclera of this eye are measured.
const ROUNDS: usize = 2;
/// Skin of this eye: between these distances from the region, mm, and not in the brow.
const SKIN_RING_MM: (f64, f64) = (2.0, 6.0);
const BROW_MM: f64 = 8.0;
/// Half width of an iris, mm: beside it there is sclera.
const IRIS_MM: f64 = 6.5;
/// Fewest pixels that measure the sclera.
const MIN_SCLERA: usize = 20;
/// The lid's border lies where this share of the difference between skin and sclera is reached; and
/// the least difference.
const BORDER_SHARE: f64 = 0.45;
const MIN_REDNESS: f64 = 0.06;
/// Half size of the area about the centre in which darkness counts, mm: brows are farther.
const DARK_AREA_MM: (f64, f64) = (16.0, 7.0);
/// Smoothing of the score, pixels.
const SCORE_SMOOTH_PX: f64 = 1.0;
/// Sizes of the opening, mm.
const LENGTH_MM: std::ops::Range<f64> = 16.0..42.0;
const OPENING_MM: std::ops::Range<f64> = 2.5..20.0;
/// The outer corner lies this far beyond the region and below it, mm; the inner one too: the lids
/// meet in an acute angle, and the caruncle, which has the colour of skin, belongs to the eye.
/// Means over rendered heads.
const OUTER_BEYOND_MM: f64 = 0.9;
const OUTER_BELOW_MM: f64 = 0.35;
const INNER_BEYOND_MM: f64 = 1.8;
const INNER_BELOW_MM: f64 = 1.6;

/// The corners of an eye, head's frame, mm.
pub(super) struct Eye {
    pub inner: Vec2,
    pub outer: Vec2,
}

/// Finds the eye at the left (`side` -1) or right (1) of the picture; `None` where nothing has its
/// colour, size and place.
pub(super) fn find(colors: &Colors, side: f64) -> Option<Eye> {
    let x_mm = if side > 0.0 { WINDOW_X_MM } else { (-WINDOW_X_MM.1, -WINDOW_X_MM.0) };
    let cutout = Cutout::new(Window { x_mm, y_mm: WINDOW_Y_MM }, &colors.redness);
    let (redness, brightness) = (cutout.of(&colors.redness), cutout.of(&colors.brightness));
    let weight = |u: usize, v: usize| {
        let p = cutout.position(u as f64, v as f64);
        let (x, y) = ((p.x - side * CENTRE_MM.0) / SPREAD_MM.0, (p.y - CENTRE_MM.1) / SPREAD_MM.1);
        (-x * x - y * y).exp()
    };
    let (skin, light) = (cutout.median(&redness, |_| true)?, cutout.median(&brightness, |_| true)?);
    let mut score = Gray::from_fn(cutout.size.0, cutout.size.1, |u, v| {
        let less_red = (skin - f64::from(redness.at(u, v))) / FIRST_REDNESS;
        less_red.max((light - f64::from(brightness.at(u, v))) / DARKNESS) as f32
    });
    for _ in 0..ROUNDS {
        let region = Region::heaviest(&score, weight)?;
        score = score_of_opening(&region, &cutout, &redness, &brightness, skin)?;
    }
    let region = Region::heaviest(&score, weight)?;
    let [left, right] = region.corners()?;
    let (left, right) = (cutout.position(left.0, left.1), cutout.position(right.0, right.1));
    let (first, last) =
        (region.pixels().map(|p| p.1).min()? as f64, region.pixels().map(|p| p.1).max()? as f64);
    let plausible = LENGTH_MM.contains(&(right.x - left.x))
        && OPENING_MM.contains(&((last - first) * PIXEL_MM));
    let (inner, outer) = if side > 0.0 { (left, right) } else { (right, left) };
    let moved = |p: Vec2, beyond: f64, below: f64| p + Vec2::new(beyond, -below);
    plausible.then(|| Eye {
        inner: moved(inner, -side * INNER_BEYOND_MM, INNER_BELOW_MM),
        outer: moved(outer, side * OUTER_BEYOND_MM, OUTER_BELOW_MM),
    })
}

/// Score above 1 inside the opening, by skin and sclera of this eye.
fn score_of_opening(
    region: &Region,
    cutout: &Cutout,
    redness: &Gray,
    brightness: &Gray,
    skin_before: f64,
) -> Option<Gray> {
    let (mut sum, mut total) = (Vec2::zeros(), 0.0);
    for (u, v) in region.pixels() {
        let weight = (skin_before - f64::from(redness.at(u, v))).max(1e-3);
        sum += weight * cutout.position(u as f64, v as f64);
        total += weight;
    }
    let centre = sum / total;
    let half = |mm: f64| (mm / PIXEL_MM) as usize;
    let (near, far) = (region.widened(half(SKIN_RING_MM.0)), region.widened(half(SKIN_RING_MM.1)));
    let mut ring = [Vec::new(), Vec::new()];
    for (u, v) in far.pixels().filter(|p| !near.contains(p.0, p.1)) {
        if cutout.position(u as f64, v as f64).y < centre.y + BROW_MM {
            ring[0].push(f64::from(redness.at(u, v)));
            ring[1].push(f64::from(brightness.at(u, v)));
        }
    }
    let (skin, light) = (median(&ring[0])?, median(&ring[1])?);
    let sclera: Vec<f64> = region
        .pixels()
        .filter(|p| (cutout.position(p.0 as f64, p.1 as f64).x - centre.x).abs() > IRIS_MM)
        .map(|p| skin - f64::from(redness.at(p.0, p.1)))
        .collect();
    let difference = match median(&sclera) {
        Some(difference) if sclera.len() > MIN_SCLERA => difference,
        _ => 2.0 * FIRST_REDNESS,
    };
    let border = (BORDER_SHARE * difference).max(MIN_REDNESS);
    let score = Gray::from_fn(cutout.size.0, cutout.size.1, |u, v| {
        let offset = cutout.position(u as f64, v as f64) - centre;
        let about = (offset.x / DARK_AREA_MM.0).powi(2) + (offset.y / DARK_AREA_MM.1).powi(2) < 1.0;
        let dark = (light - f64::from(brightness.at(u, v))) / DARKNESS;
        let less_red = (skin - f64::from(redness.at(u, v))) / border;
        less_red.max(if about { dark } else { 0.0 }) as f32
    });
    Some(score.blurred(SCORE_SMOOTH_PX))
}
