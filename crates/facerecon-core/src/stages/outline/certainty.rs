//! Where the line between subject and background is known.

use super::cell_images::distance_to;
use super::labels::{DotDistance, Labels};
use crate::data::{Gray, Raster};

/// Width of the bands on both sides of the line that are judged, dot spacings, and at least, cells.
const BAND_SPACINGS: f64 = 1.0;
const MIN_BAND: f64 = 4.0;
/// Cells so close to the line mix both colours, cells.
const MIXED: f32 = 1.5;
/// Least share of a band's cells that agree with their side. Hair has gaps in which the wall's
/// colour appears; a wall as plain as its model assumes has next to none.
const MIN_SUBJECT: f32 = 0.7;
const MIN_BACKGROUND: f32 = 0.85;

/// The cells on both sides of the line at which it is known: the bands agree with their labels, and
/// dots are near enough to make the inner side subject.
pub(super) fn certain_cells(labels: &Labels, dots: &DotDistance, spacing: f64) -> Raster<bool> {
    let band = (BAND_SPACINGS * spacing).max(MIN_BAND);
    let to_subject = distance_to(&labels.subject);
    let to_background = distance_to(&labels.subject.map(|s| !s));
    let in_band = |d: f32| d > MIXED && f64::from(d) <= MIXED as f64 + band;
    // a band's share of agreeing cells around each cell
    let share = |distance: &Gray, agrees: &dyn Fn(f32) -> bool| {
        let weight = distance.map(|d| if in_band(d) { 1.0 } else { 0.0f32 });
        let good = weight.zip_map(&labels.evidence, |w, e| if agrees(e) { w } else { 0.0 });
        good.blurred(band).zip_map(&weight.blurred(band), |g, w| g / w.max(1e-6))
    };
    let subject = share(&to_background, &|e| e < 0.0);
    let background = share(&to_subject, &|e| e > 0.0);
    let far = dots.far();
    let (width, height) = labels.subject.size();
    Raster::from_fn(width, height, |x, y| {
        subject.at(x, y) >= MIN_SUBJECT && background.at(x, y) >= MIN_BACKGROUND && !far.at(x, y)
    })
}
