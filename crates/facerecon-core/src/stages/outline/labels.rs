//! Which cells show the subject.

use super::Cells;
use super::background::Background;
use super::cell_images::distance_to;
use crate::data::regions::{flood, without_holes};
use crate::data::{Gray, Raster};

const EVIDENCE_BLUR: f64 = 1.2;
/// Mean squared deviation from the background, in variances, from which a cell is more likely
/// subject: the background exceeds it in about one cell of 400.
const MIN_DEVIATION: f32 = 6.0;
/// Share of the contrast between the nearest dots and the background at which the line lies. A half
/// would be the middle of a blurred edge; less, since hair at the line is thinner than at the dots.
const CONTRAST_SHARE: f32 = 0.4;
/// The contrast of the dots is a mean over this many dot spacings.
const CONTRAST_SPACINGS: f64 = 2.0;
/// Weight with which distant dots count where none is near.
const FAR_WEIGHT: f32 = 1e-6;
/// Bounds of a cell's evidence, natural logarithms of a likelihood ratio: no cell outvotes more than
/// a few neighbours.
const EVIDENCE_RANGE: (f32, f32) = (-3.0, 3.0);
/// Cells farther than this from every dot are far, dot spacings: dots reach closer than this to the
/// outline of nearly all that is subject.
const FAR_SPACINGS: f32 = 4.0;

/// The distance of every cell from the nearest dot.
pub(super) struct DotDistance {
    distance: Gray,
    spacing: f32,
}

impl DotDistance {
    pub fn new(cells: &Cells) -> Self {
        let (width, height) = cells.colours.size();
        let mut marked = Raster::filled(width, height, false);
        cells.dots.iter().for_each(|&(x, y)| marked.set(x, y, true));
        Self { distance: distance_to(&marked), spacing: cells.spacing as f32 }
    }

    /// The cells far from all dots.
    pub fn far(&self) -> Raster<bool> {
        let limit = FAR_SPACINGS * self.spacing;
        self.distance.map(|d| d > limit)
    }
}

/// The subject and the evidence for it.
pub(super) struct Labels {
    pub subject: Raster<bool>,
    /// Evidence of each cell by itself: above 0 for the background, below for the subject.
    pub evidence: Gray,
}

/// Labels the cells: evidence, smoothed, then the component with the most dots, without holes.
pub(super) fn subject_cells(cells: &Cells, background: &Background) -> Labels {
    let deviation = squared_deviation(cells, background);
    let threshold = thresholds(cells, &deviation);
    let evidence = deviation
        .zip_map(&threshold, |d, t| (0.5 * (t - d)).clamp(EVIDENCE_RANGE.0, EVIDENCE_RANGE.1));
    let differs = evidence.blurred(EVIDENCE_BLUR).map(|e| e < 0.0);
    let subject = without_holes(&component_of(&differs, &cells.dots));
    Labels { subject, evidence }
}

fn squared_deviation(cells: &Cells, background: &Background) -> Gray {
    cells.colours.zip_map(&background.colours, |colour, expected| {
        let one = |c: usize| ((colour[c] - expected[c]) / background.sigma[c]).powi(2);
        (one(0) + one(1) + one(2)) / 3.0
    })
}

/// The deviation at which the line between subject and background lies: a share of the contrast of
/// the dots around (a blurred edge, a halo of the lens), at least the noise's.
fn thresholds(cells: &Cells, deviation: &Gray) -> Gray {
    let (width, height) = deviation.size();
    let mut weight = Gray::filled(width, height, 0.0);
    let mut inverse = weight.clone();
    for &(x, y) in &cells.dots {
        // the harmonic mean is close to the smallest contrast: dark hair counts beside light skin
        weight.set(x, y, 1.0);
        inverse.set(x, y, 1.0 / deviation.at(x, y).max(MIN_DEVIATION).sqrt());
    }
    let sigma = CONTRAST_SPACINGS * cells.spacing;
    let (weight, inverse) = (weight.blurred(sigma), inverse.blurred(sigma));
    weight.zip_map(&inverse, |w, i| {
        let contrast = if w > FAR_WEIGHT { w / i.max(f32::MIN_POSITIVE) } else { 0.0 };
        (CONTRAST_SHARE * contrast).powi(2).max(MIN_DEVIATION)
    })
}

/// The connected marked cells that hold the most dots.
fn component_of(marked: &Raster<bool>, dots: &[(usize, usize)]) -> Raster<bool> {
    let (width, height) = marked.size();
    let mut number = vec![0u32; width * height];
    let mut best = (0usize, 0u32);
    let mut count = 0;
    let mut hits = Vec::new();
    for &(x, y) in dots {
        let start = y * width + x;
        if marked.data()[start] && number[start] == 0 {
            count += 1;
            hits.push(0usize);
            flood(marked, start, &mut |i| {
                let is_new = number[i] == 0;
                number[i] = count;
                is_new
            });
        }
        if let Some(hit) = (number[start] as usize).checked_sub(1).and_then(|n| hits.get_mut(n)) {
            *hit += 1;
            if *hit > best.0 {
                best = (*hit, number[start]);
            }
        }
    }
    Raster::from_fn(width, height, |x, y| best.0 > 0 && number[y * width + x] == best.1)
}
