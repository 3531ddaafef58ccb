//! The mouth: the region about the midline that is redder than the skin about it.

use super::color_regions::{Cutout, Region, Window};
use super::frontal::{Colors, PIXEL_MM};
use crate::data::Gray;
use crate::math::{Vec2, percentile};

/// Where the mouth is looked for, relative to the tip of the nose, mm.
const WINDOW: Window = Window { x_mm: (-42.0, 42.0), y_mm: (-72.0, -14.0) };
/// Skin beside, above and below every mouth, mm.
const SKIN_BESIDE_MM: f64 = 30.0;
const SKIN_ABOVE_MM: f64 = -20.0;
const SKIN_BELOW_MM: f64 = -64.0;
/// Expected centre below the tip and the spread of both directions, mm.
const CENTRE_MM: f64 = -40.0;
const SPREAD_MM: (f64, f64) = (14.0, 10.0);
/// Half size of the area in which the redness of lips is measured, mm, and the quantile.
const LIPS_MM: (f64, f64) = (16.0, 12.0);
const LIPS_QUANTILE: f64 = 0.8;
/// Least difference of the log ratio red over green of lips and skin: below it, noise and light
/// decide.
const MIN_REDNESS: f64 = 0.06;
/// The vermilion border lies where this share of the difference is reached.
const BORDER_SHARE: f64 = 0.5;
/// Sizes of mouths, mm: width and height with lips, and how far off the midline they may lie.
const WIDTH_MM: std::ops::Range<f64> = 30.0..75.0;
const HEIGHT_MM: std::ops::Range<f64> = 6.0..50.0;
const MAX_OFFSET_MM: f64 = 9.0;
/// Half width of the columns that give the upper and lower border at the middle, mm.
const MIDDLE_MM: f64 = 1.5;
/// The corner of the mouth lies this far beyond the end of the red region and below it, mm: the
/// vermilion narrows to less than the resolution. Mean over rendered heads.
const CORNER_BEYOND_MM: f64 = 0.8;
const CORNER_BELOW_MM: f64 = 0.3;

/// The four landmarks of a mouth, head's frame, mm.
pub(super) struct Mouth {
    pub left: Vec2,
    pub right: Vec2,
    pub up: Vec2,
    pub down: Vec2,
}

/// Finds the mouth by the colour of its lips; `None` where nothing has its colour, size and place.
pub(super) fn find(colors: &Colors) -> Option<Mouth> {
    let cutout = Cutout::new(WINDOW, &colors.redness);
    let redness = cutout.of(&colors.redness);
    let is_skin =
        |p: Vec2| p.x.abs() > SKIN_BESIDE_MM || p.y > SKIN_ABOVE_MM || p.y < SKIN_BELOW_MM;
    let skin = cutout.median(&redness, is_skin)?;
    let central = |p: Vec2| p.x.abs() < LIPS_MM.0 && (p.y - CENTRE_MM).abs() < LIPS_MM.1;
    let lips = percentile(&cutout.values(&redness, central), LIPS_QUANTILE)?;
    let contrast = lips - skin;
    if !(contrast >= MIN_REDNESS) {
        return None;
    }
    let score: Gray = redness.map(|r| ((f64::from(r) - skin) / (BORDER_SHARE * contrast)) as f32);
    let region = Region::heaviest(&score, |u, v| {
        let p = cutout.position(u as f64, v as f64);
        let (x, y) = (p.x / SPREAD_MM.0, (p.y - CENTRE_MM) / SPREAD_MM.1);
        (-x * x - y * y).exp()
    })?;
    let [left, right] = region.corners()?;
    let middle = 0.5 * (left.0 + right.0);
    let (top, bottom) = region.rows_at(middle, MIDDLE_MM / PIXEL_MM)?;
    let mut left = cutout.position(left.0, left.1);
    let mut right = cutout.position(right.0, right.1);
    // the borders of the pixels, not their centres
    let up = cutout.position(middle, top - 0.5);
    let down = cutout.position(middle, bottom + 0.5);
    let plausible = WIDTH_MM.contains(&(right.x - left.x))
        && HEIGHT_MM.contains(&(up.y - down.y))
        && up.x.abs() <= MAX_OFFSET_MM;
    left += Vec2::new(-CORNER_BEYOND_MM, -CORNER_BELOW_MM);
    right += Vec2::new(CORNER_BEYOND_MM, -CORNER_BELOW_MM);
    plausible.then_some(Mouth { left, right, up, down })
}
