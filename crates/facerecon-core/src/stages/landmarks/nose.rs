//! The nose by its shape: profile on the midline and the slope of its wings.

use super::frontal::{FrontalPicture, PIXEL_MM};
use crate::data::Gray;
use crate::math::Vec2;

/// The profile is the mean over this distance to either side of the midline, mm.
const MIDLINE_MM: f64 = 1.5;
/// Smoothing before curvature is measured, mm: dots do not resolve less.
const CURVATURE_SMOOTH_MM: f64 = 3.0;
/// Smoothing before the slope of the wings is measured, mm.
const SLOPE_SMOOTH_MM: f64 = 1.0;
/// Where the base of the nose (subnasale) is looked for, below the foremost point, mm.
const BASE_MM: (f64, f64) = (-26.0, -6.0);
/// Where the sharpest bend of the tip is looked for, mm.
const BEND_MM: (f64, f64) = (-12.0, 12.0);
/// Heights of the tip (pronasale): above the foremost point of the levelled face, above the
/// sharpest bend, above the base, mm. Means over rendered heads; standard deviations 1.0, 1.1, 1.2.
const TIP_ABOVE_FOREMOST_MM: f64 = 1.4;
const TIP_ABOVE_BEND_MM: f64 = 5.8;
const TIP_ABOVE_BASE_MM: f64 = 15.3;
/// Height of the alae above the base, mm; standard deviation 1.1.
const ALAE_ABOVE_BASE_MM: f64 = 9.6;
/// Distances of the alae from the midline, mm.
const ALA_MM: (f64, f64) = (8.0, 28.0);
/// Least slope of the wing of a nose.
const MIN_WING_SLOPE: f64 = 0.7;
/// A place is steep where its slope is at least this share of the greatest of the wing.
const EDGE_SHARE: f64 = 0.7;
/// Rows above and below over which the height is averaged, mm.
const WING_ROWS_MM: f64 = 1.5;
/// Where the saddle (sellion) is looked for by shape, above the tip, mm; and its height above the
/// deepest point of the chord from tip to glabella, standard deviation 2.0.
const SADDLE_MM: (f64, f64) = (20.0, 52.0);
const GLABELLA_ABOVE_MM: f64 = 25.0;
const SADDLE_ABOVE_DEEPEST_MM: f64 = 3.4;

/// The landmarks of a nose, head's frame, mm.
pub(super) struct Nose {
    pub tip: Vec2,
    pub ala_left: Option<Vec2>,
    pub ala_right: Option<Vec2>,
    /// The saddle as the profile shows it.
    pub saddle: Vec2,
}

/// The profile on the midline.
pub(super) struct Profile {
    /// Height of the face's surface by step of [`PIXEL_MM`] downward from `top_mm`, mm.
    heights: Vec<f64>,
    /// The same, smoothed.
    smooth: Vec<f64>,
    /// Second derivative of the smoothed heights, 1/mm.
    bends: Vec<f64>,
    top_mm: f64,
}

impl Profile {
    pub fn new(picture: &FrontalPicture, reach_mm: f64) -> Self {
        let steps = (2.0 * reach_mm / PIXEL_MM) as usize + 1;
        let columns = (MIDLINE_MM / PIXEL_MM) as i32;
        let mean = |y: f64| {
            (-columns..=columns).map(|k| picture.height_at(f64::from(k) * PIXEL_MM, y)).sum::<f64>()
                / f64::from(2 * columns + 1)
        };
        let heights: Vec<f64> = (0..steps).map(|i| mean(reach_mm - i as f64 * PIXEL_MM)).collect();
        let row = Gray::from_fn(steps, 1, |i, _| heights[i] as f32);
        let blurred = row.blurred(CURVATURE_SMOOTH_MM / PIXEL_MM);
        let at = |i: usize, d: isize| f64::from(blurred.clamped(i as isize + d, 0));
        let bends = (0..steps)
            .map(|i| (at(i, -1) - 2.0 * at(i, 0) + at(i, 1)) / PIXEL_MM.powi(2))
            .collect();
        let smooth = (0..steps).map(|i| at(i, 0)).collect();
        Self { heights, smooth, bends, top_mm: reach_mm }
    }

    fn y_mm(&self, index: usize) -> f64 {
        self.top_mm - index as f64 * PIXEL_MM
    }

    /// The position within a range at which a quantity of `(y, height, second derivative)` is
    /// greatest, mm.
    fn greatest(&self, range_mm: (f64, f64), of: impl Fn(f64, f64, f64) -> f64) -> Option<f64> {
        let mut best: Option<(f64, f64)> = None;
        for i in 0..self.heights.len() {
            let y = self.y_mm(i);
            if y < range_mm.0 || y > range_mm.1 {
                continue;
            }
            let value = of(y, self.heights[i], self.bends[i]);
            if best.is_none_or(|b| value > b.0) {
                best = Some((value, y));
            }
        }
        best.map(|b| b.1)
    }

    /// The sharpest convex bend within a range, mm.
    fn convex_bend(&self, range_mm: (f64, f64)) -> Option<f64> {
        self.greatest(range_mm, |_, _, bend| -bend)
    }

    /// The first position below `from_mm`, downward, at which the profile recedes by more than
    /// `slope` mm per mm relative to a line of slope `tilt`; mm.
    pub fn receding_below(&self, from_mm: f64, tilt: f64, slope: f64) -> Option<f64> {
        let first = ((self.top_mm - from_mm) / PIXEL_MM).ceil().max(1.0) as usize;
        (first..self.smooth.len().saturating_sub(1))
            .find(|&i| {
                let fall = (self.smooth[i - 1] - self.smooth[i + 1]) / (2.0 * PIXEL_MM);
                fall - tilt > slope
            })
            .map(|i| self.y_mm(i))
    }

    /// The sharpest concave bend within a range, mm.
    fn concave_bend(&self, range_mm: (f64, f64)) -> Option<f64> {
        self.greatest(range_mm, |_, _, bend| bend)
    }

    fn height_at(&self, y_mm: f64) -> f64 {
        let index = ((self.top_mm - y_mm) / PIXEL_MM).round().max(0.0) as usize;
        self.heights.get(index).or(self.heights.last()).copied().unwrap_or(0.0)
    }

    /// The deepest point below the chord from the tip to the glabella, mm.
    fn saddle(&self) -> Option<f64> {
        let deepest = self.greatest(SADDLE_MM, |_, height, _| -height)?;
        let end = deepest + GLABELLA_ABOVE_MM;
        let (tip, glabella) = (self.height_at(0.0), self.height_at(end));
        let below = |y: f64, height: f64| tip + (glabella - tip) * y / end - height;
        self.greatest(SADDLE_MM, |y, height, _| below(y, height))
    }
}

/// Finds the nose, whose foremost point is the origin.
pub(super) fn find(picture: &FrontalPicture, profile: &Profile) -> Option<Nose> {
    let base = profile.concave_bend(BASE_MM)?;
    let bend = profile.convex_bend(BEND_MM)?;
    let tip = (TIP_ABOVE_FOREMOST_MM + bend + TIP_ABOVE_BEND_MM + base + TIP_ABOVE_BASE_MM) / 3.0;
    let alae = base + ALAE_ABOVE_BASE_MM;
    Some(Nose {
        tip: Vec2::new(0.0, tip),
        ala_left: wing(picture, alae, -1.0),
        ala_right: wing(picture, alae, 1.0),
        saddle: Vec2::new(0.0, profile.saddle()? + SADDLE_ABOVE_DEEPEST_MM),
    })
}

/// The edge of a wing of the nose in a row: the outermost steep place. Nearer to the midline the tip
/// may be as steep.
fn wing(picture: &FrontalPicture, y_mm: f64, side: f64) -> Option<Vec2> {
    let rows = (WING_ROWS_MM / PIXEL_MM) as i32;
    let steps = (ALA_MM.1 / PIXEL_MM) as usize + 12;
    let mean = |i: usize| {
        let at =
            |k: i32| picture.height_at(side * i as f64 * PIXEL_MM, y_mm + f64::from(k) * PIXEL_MM);
        (-rows..=rows).map(at).sum::<f64>() / f64::from(2 * rows + 1)
    };
    let row = Gray::from_fn(steps, 1, |i, _| mean(i) as f32).blurred(SLOPE_SMOOTH_MM / PIXEL_MM);
    let slope = |i: usize| f64::from(row.at(i - 1, 0) - row.at(i + 1, 0)) / (2.0 * PIXEL_MM);
    let range = (ALA_MM.0 / PIXEL_MM) as usize..(ALA_MM.1 / PIXEL_MM) as usize;
    let greatest = range.clone().map(slope).max_by(f64::total_cmp)?;
    let least = MIN_WING_SLOPE.max(EDGE_SHARE * greatest);
    let is_peak =
        |i: &usize| slope(*i) >= least && slope(*i) >= slope(*i - 1) && slope(*i) >= slope(*i + 1);
    let edge = range.rev().find(is_peak)?;
    Some(Vec2::new(side * edge as f64 * PIXEL_MM, y_mm))
}
