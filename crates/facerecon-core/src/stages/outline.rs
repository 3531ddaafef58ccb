//! Stage outline: where a photo shows the subject, hair included, and where the background.
//!
//! Measured dots lie on the subject, what is far from all of them is mostly background. A smooth
//! model of the background's colour is fitted to the latter; what differs from it by more than its
//! noise, and by more than a share of the contrast of the nearest dots, is subject. The line is
//! known where the photo tells both sides apart; elsewhere (hair before a wall of its colour, a
//! cluttered background) nothing is said.

mod background;
mod cell_images;
mod certainty;
mod labels;

#[cfg(test)]
mod tests;

use crate::data::{Outline, Raster, Rgb};
use crate::math::Vec2;
use crate::observer::{Artifact, Cancelled, Event, Observer};
use crate::settings::{SettingsError, Value};
use crate::spatial::median_spacing;

use background::Background;
use labels::{DotDistance, subject_cells};

crate::settings::settings! {
    /// Finding the subject's outline in the plain photos.
    pub struct OutlineParams {
        /// Whether the outline is looked for; without it nothing bounds the head.
        find: bool = true;
        /// Photos are reduced until both sides are at most so long; the outline is found to about
        /// half a pixel of the reduced photo.
        size_px: usize = 1200, range 64.0..=100000.0, unit "px";
        /// Rounds of background model and labels.
        rounds: usize = 2, range 1.0..=10.0;
    }
}

/// An outline that cannot be looked for.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum OutlineError {
    /// A parameter outside its range.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// Cancelled by the observer.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

crate::stages::stage_error!(OutlineError, "outline");

/// Fewer dots than this do not say where the subject is.
const MIN_DOTS: usize = 50;
/// Least side of the reduced photo, cells.
const MIN_SIDE: usize = 32;
/// Least share of the photo that must be far from all dots: less is no sample of the background.
const MIN_BACKGROUND: f64 = 0.05;
/// Least share of the dots that must come to lie on the subject; with fewer the background has the
/// subject's colours.
const MIN_DOTS_INSIDE: f64 = 0.9;
/// Greatest share of the cells far from the dots that may differ from the background's model: with
/// more there is no one background.
const MAX_CLUTTER: f64 = 0.35;

/// A plain photo and the dots measured on the subject in it.
#[derive(Clone, Copy, Debug)]
pub struct OutlineInput<'a> {
    /// The photo without the pattern.
    pub image: &'a Rgb,
    /// Positions of measured dots on the subject, photo pixels; a few wrong ones do no harm.
    pub dots: &'a [Vec2],
}

/// Finds the subject's outline in one plain photo; `None` where the photo does not show it.
///
/// # Errors
/// [`OutlineError`] for parameters out of range and when the observer cancels.
///
/// ```
/// use facerecon_core::data::Rgb;
/// use facerecon_core::math::Vec2;
/// use facerecon_core::stages::outline::{OutlineInput, OutlineParams, outline};
///
/// // a light disc of radius 60 on a dark wall, with dots 8 pixels apart
/// let from_middle = |x: f64, y: f64| (x - 150.0).hypot(y - 120.0);
/// let image = Rgb::from_fn(300, 240, |x, y| {
///     if from_middle(x as f64, y as f64) < 60.0 { [180, 150, 130] } else { [40, 42, 45] }
/// });
/// let grid = (0..30 * 40).map(|i| Vec2::new(f64::from(i % 40) * 8.0, f64::from(i / 40) * 8.0));
/// let dots: Vec<Vec2> = grid.filter(|p| from_middle(p.x, p.y) < 55.0).collect();
/// let input = OutlineInput { image: &image, dots: &dots };
/// let found = outline(&input, &OutlineParams::default(), &())?.unwrap();
/// let distance_px = found.distance_px(Vec2::new(240.0, 120.0)).unwrap();
/// assert!((distance_px - 30.0).abs() < 1.5);
/// # Ok::<(), facerecon_core::stages::outline::OutlineError>(())
/// ```
pub fn outline(
    input: &OutlineInput<'_>,
    params: &OutlineParams,
    observer: &dyn Observer,
) -> Result<Option<Outline>, OutlineError> {
    params.check("outline", None)?;
    observer.check()?;
    if !params.find {
        return Ok(None);
    }
    let Some(cells) = Cells::new(input, params) else { return Ok(None) };
    let dots = DotDistance::new(&cells);
    let far = dots.far();
    let share = |marked: &Raster<bool>| {
        let count = marked.data().iter().filter(|m| **m).count();
        count as f64 / marked.data().len().max(1) as f64
    };
    if share(&far) < MIN_BACKGROUND {
        return Ok(None);
    }
    let Some(mut background) = Background::smooth(&cells.colours, &far) else { return Ok(None) };
    let mut labels = subject_cells(&cells, &background);
    for _ in 1..params.rounds {
        observer.check()?;
        background = background.following(&cells, &labels.subject);
        labels = subject_cells(&cells, &background);
    }
    let inside = cells.dots.iter().filter(|&&(x, y)| labels.subject.at(x, y)).count();
    let clutter = labels.evidence.zip_map(&far, |e, far| far && e < 0.0);
    let clutter = clutter.zip_map(&labels.subject, |c, subject| c && !subject);
    if (inside as f64) < MIN_DOTS_INSIDE * cells.dots.len() as f64
        || share(&clutter) > MAX_CLUTTER * share(&far)
    {
        return Ok(None);
    }
    let certain = certainty::certain_cells(&labels, &dots, cells.spacing);
    let found = Outline::from_mask(&labels.subject, &certain, cells.step);
    observer.artifact("outline", "subject", Artifact::Gray(&found.picture()));
    let count = certain.data().iter().filter(|c| **c).count();
    observer.event(&Event::Count { stage: "outline", what: "cells of known outline", count });
    Ok(found.is_known().then_some(found))
}

/// The photo and the dots on a grid of cells.
struct Cells {
    /// Pixels along a cell.
    step: usize,
    /// Mean colours, slightly smoothed.
    colours: Raster<[f32; 3]>,
    /// The cells of the dots inside the photo.
    dots: Vec<(usize, usize)>,
    /// Typical distance between neighbouring dots, cells.
    spacing: f64,
}

impl Cells {
    fn new(input: &OutlineInput<'_>, params: &OutlineParams) -> Option<Self> {
        let (width, height) = input.image.size();
        let step = width.max(height).div_ceil(params.size_px).max(1);
        let (w, h) = (width / step, height / step);
        if w < MIN_SIDE || h < MIN_SIDE {
            return None;
        }
        if input.dots.len() < MIN_DOTS {
            return None;
        }
        let spacing = median_spacing(input.dots).filter(|s| *s > 0.0)? / step as f64;
        let to_cell = |p: &Vec2| {
            let (x, y) = ((p.x + 0.5) / step as f64, (p.y + 0.5) / step as f64);
            (x >= 0.0 && y >= 0.0 && x < w as f64 && y < h as f64)
                .then_some((x as usize, y as usize))
        };
        let dots: Vec<_> = input.dots.iter().filter_map(to_cell).collect();
        let count = (step * step) as f32;
        let colours = input.image.block_sums(step).map(|sum| sum.map(|s| s as f32 / count));
        let colours = cell_images::smoothed(&colours);
        (dots.len() >= MIN_DOTS).then_some(Self { step, colours, dots, spacing })
    }
}
