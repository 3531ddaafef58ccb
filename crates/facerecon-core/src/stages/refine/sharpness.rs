//! Photos of different sharpness: the sharper one is smoothed until both agree.
//!
//! A dot that is sharp in one photo and blurred in the other is fitted with a bias, wherever the
//! brightness around it is uneven. The difference is found by the agreement of both photos itself:
//! it is clearly best where the sharper photo has the blur of the other one.

use rayon::prelude::*;

use super::image::RowSpline;
use super::samples::{self, Sample, local_surface};
use crate::data::Gray;
use crate::math::median;
use crate::spatial::PointIndex;

/// Differences of the blur are tried in steps of this, in pitches: about 1 px in common captures.
const STEP: f64 = 0.11;
/// Greatest difference, in steps: a dot blurred by more is not detected.
const MOST_STEPS: usize = 4;
/// The first step must lower the disagreement to this share: it raises it for equal photos, and
/// lowers it to 0.4 to 0.65 where one is blurred by 0.16 to 0.28 pitches.
const FIRST_SHARE: f64 = 0.8;
/// Windows that are compared; more give the same median.
const WINDOWS: usize = 300;
/// Half width of a window, in pitches: a dot and its neighbours.
const HALF_WIDTH: f64 = 1.0;
/// Radius of the neighbours that give the slopes of the disparity, in pitches.
const SLOPE_RADIUS: f64 = 2.3;
/// The smoothing is cut off at this many standard deviations.
const CUTOFF: f64 = 3.5;

/// A window of the left photo with the plane of its disparity.
struct Window {
    x: usize,
    y: usize,
    /// Disparity at `(x, y)`, its slopes across and down.
    plane: [f64; 3],
}

/// Both photos in equal sharpness, and the standard deviation of the smoothing in pixels: positive
/// for the left photo, negative for the right one, 0 for photos left as they are.
pub(super) fn equal_sharpness(
    left: Gray,
    right: Gray,
    samples: &[Sample],
    pitch: f64,
) -> (Gray, Gray, f64) {
    let windows = windows(samples, pitch, left.size());
    let smoothed = |blur_px: f64| {
        let of = |photo: &Gray, sigma: f64| photo.blurred_to(sigma, CUTOFF);
        (of(&left, blur_px.max(0.0)), of(&right, (-blur_px).max(0.0)))
    };
    let disagreement = |blur_px: f64| {
        let (left, right) = smoothed(blur_px);
        disagreement(&left, &RowSpline::new(&right), &windows, HALF_WIDTH * pitch)
    };
    let as_they_are = disagreement(0.0);
    let mut best = (as_they_are, 0.0);
    for side in [1.0, -1.0] {
        for step in 1..=MOST_STEPS {
            let blur_px = side * step as f64 * STEP * pitch;
            let found = disagreement(blur_px);
            let limit = if step == 1 { FIRST_SHARE * as_they_are } else { best.0 };
            // written so that NaN ends the search
            if !(found < limit) {
                break;
            }
            best = (found, blur_px);
        }
        if best.1 != 0.0 {
            break;
        }
    }
    if best.1 == 0.0 {
        return (left, right, 0.0);
    }
    let half = 0.5 * STEP * pitch;
    let near = [best.1 - half, best.1 + half].map(|blur_px| (disagreement(blur_px), blur_px));
    let best = near.into_iter().fold(best, |a, b| if b.0 < a.0 { b } else { a });
    let (left, right) = smoothed(best.1);
    (left, right, best.1)
}

/// Evenly chosen samples whose neighbours give the slopes of the disparity.
fn windows(samples: &[Sample], pitch: f64, (width, height): (usize, usize)) -> Vec<Window> {
    let Some(index) = samples::index(samples) else { return Vec::new() };
    let border = HALF_WIDTH * pitch + 1.0;
    let inside = |v: f64, size: usize| v > border && v < size as f64 - 1.0 - border;
    let window = |s: &Sample, index: &PointIndex<2>| {
        let (x, y) = (s.x.round(), s.y.round());
        let (plane, _) = local_surface(samples, index, [x, y], SLOPE_RADIUS, pitch, None)?;
        Some(Window { x: x as usize, y: y as usize, plane: plane.into() })
    };
    let step = samples.len().div_ceil(WINDOWS).max(1);
    samples
        .iter()
        .step_by(step)
        .filter(|s| inside(s.x, width) && inside(s.y, height))
        .filter_map(|s| window(s, &index))
        .collect()
}

/// Median over the windows of 1 minus the correlation of both photos; NaN without windows.
fn disagreement(left: &Gray, right: &RowSpline, windows: &[Window], half_width: f64) -> f64 {
    let reach = half_width.round().max(2.0) as isize;
    let of_window = |w: &Window| -> Option<f64> {
        let (mut n, mut sums, mut squares) = (0.0, [0.0; 2], [0.0; 3]);
        for dy in -reach..=reach {
            for dx in -reach..=reach {
                let (x, y) = (w.x as isize + dx, w.y as isize + dy);
                let a = f64::from(left.get(x, y)?);
                let d = w.plane[0] + w.plane[1] * dx as f64 + w.plane[2] * dy as f64;
                let b = f64::from(right.sample(x as f64 - d, y as usize)?.0);
                n += 1.0;
                sums = [sums[0] + a, sums[1] + b];
                squares = [squares[0] + a * a, squares[1] + b * b, squares[2] + a * b];
            }
        }
        let [a, b] = sums;
        let spread = ((squares[0] - a * a / n).max(0.0) * (squares[1] - b * b / n).max(0.0)).sqrt();
        (spread > 0.0).then(|| 1.0 - (squares[2] - a * b / n) / spread)
    };
    let all: Vec<f64> = windows.par_iter().filter_map(of_window).collect();
    median(&all).unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Dots 9 px apart with sharp edges.
    fn dots(shift: f64) -> Gray {
        let off = |v: f64| v - 9.0 * (v / 9.0).round();
        Gray::from_fn(220, 180, |x, y| {
            let r = off(x as f64 + shift).hypot(off(y as f64));
            (50.0 + 120.0 / (1.0 + ((r - 2.3) * 3.0).exp())) as f32
        })
    }

    fn samples() -> Vec<Sample> {
        let at = |k: usize| ((27 + 9 * (k % 18)) as f64, (18 + 9 * (k / 18)) as f64);
        (0..270).map(at).map(|(x, y)| Sample { x, y, disparity: 9.0 }).collect()
    }

    #[test]
    fn the_sharper_photo_gets_the_blur_of_the_other() {
        let sharp = dots(0.0);
        for blur_px in [1.5, 2.0] {
            let soft = sharp.blurred(blur_px);
            let (_, right, found) = equal_sharpness(sharp.clone(), soft.clone(), &samples(), 9.0);
            assert!((found - blur_px).abs() < 0.6, "{found}, expected {blur_px}");
            assert_eq!(right, soft);
            let (left, _, found) = equal_sharpness(soft.clone(), sharp.clone(), &samples(), 9.0);
            assert!((found + blur_px).abs() < 0.6, "{found}, expected {}", -blur_px);
            assert_eq!(left, soft);
        }
    }

    #[test]
    fn photos_of_equal_sharpness_stay_as_they_are() {
        for photo in [dots(0.0), dots(0.0).blurred(1.5)] {
            let (left, right, found) =
                equal_sharpness(photo.clone(), photo.clone(), &samples(), 9.0);
            assert_eq!((left, right, found), (photo.clone(), photo, 0.0));
        }
        let empty = equal_sharpness(dots(0.0), dots(0.0), &[], 9.0);
        assert_eq!(empty.2, 0.0);
    }
}
