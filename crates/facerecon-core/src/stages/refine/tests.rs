//! Synthetic pairs of known disparity.

use std::cell::Cell;

use super::image::shifted_down;
use super::*;
use crate::math::{Vec2, median, percentile};

const SIZE: (usize, usize) = (200, 160);

/// Gaussian dots on a dark background, as the left camera sees them.
fn pattern(x: f64, y: f64, pitch: f64) -> f64 {
    let off = |v: f64| v - (v / pitch).round() * pitch;
    let r2 = off(x).powi(2) + off(y).powi(2);
    45.0 + 140.0 * (-r2 / (2.0 * (0.19 * pitch).powi(2))).exp()
}

/// Deterministic noise, about normal with standard deviation 1.
fn noise(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed | 1;
    move || {
        (0..12)
            .map(|_| {
                state ^= state << 13;
                state ^= state >> 7;
                state ^= state << 17;
                (state >> 11) as f64 / (1u64 << 53) as f64
            })
            .sum::<f64>()
            - 6.0
    }
}

struct Pair {
    left: Gray,
    right: Gray,
    matches: Vec<Match>,
}

/// A pair with `disparity(x, y)` at left pixels, camera noise, different exposures, and matches with
/// errors of up to 0.3 px, every 31st missing.
fn pair(pitch: f64, amplitude: f64, disparity: impl Fn(f64, f64) -> f64) -> Pair {
    let (w, h) = SIZE;
    let mut random = noise(7);
    let left = Gray::from_fn(w, h, |x, y| {
        (pattern(x as f64, y as f64, pitch) + amplitude * random()) as f32
    });
    let right = Gray::from_fn(w, h, |xr, y| {
        let mut x = xr as f64 + disparity(xr as f64, y as f64);
        (0..60).for_each(|_| x = xr as f64 + disparity(x, y as f64));
        (0.9 * pattern(x, y as f64, pitch) + 5.0 + amplitude * random()) as f32
    });
    let mut matches = Vec::new();
    let across = (w as f64 / pitch) as usize;
    let down = (h as f64 / pitch) as usize;
    for (i, j) in (0..across * down).map(|k| (k % across, k / across)) {
        let (x, y) = ((i + 1) as f64 * pitch, (j + 1) as f64 * pitch);
        let d = disparity(x, y) + 0.1 * random().clamp(-3.0, 3.0);
        if x - d > 2.0 && x < w as f64 - 3.0 && y < h as f64 - 3.0 && (i + 7 * j) % 31 != 5 {
            matches.push(Match {
                left: Vec2::new(x, y),
                right: Vec2::new(x - d, y),
                lattice: None,
                sigma_px: 0.0,
                score: 1.0,
            });
        }
    }
    Pair { left, right, matches }
}

fn run(p: &Pair, params: &RefineParams) -> Result<Refined, RefineError> {
    refine(&p.left, &p.right, None, &p.matches, params, &())
}

/// Median and 99th percentile of the error, and the share of the central pixels that was measured.
fn errors(r: &Refined, truth: impl Fn(f64, f64) -> f64) -> (f64, f64, f64) {
    let mut e = Vec::new();
    let mut all = 0;
    for y in 20..SIZE.1 - 20 {
        for x in 50..SIZE.0 - 20 {
            all += 1;
            let d = f64::from(r.disparity.at(x, y));
            if d.is_finite() {
                e.push((d - truth(x as f64, y as f64)).abs());
            }
        }
    }
    let q = |q| percentile(&e, q).unwrap();
    (q(0.5), q(0.99), e.len() as f64 / all as f64)
}

#[test]
fn a_ramp_and_a_bowl_are_measured_to_hundredths_of_a_pixel() {
    let ramp = |x: f64, y: f64| 14.0 + 0.04 * x - 0.03 * y;
    let bowl = |x: f64, y: f64| 20.0 - ((x - 110.0).powi(2) + (y - 80.0).powi(2)) / 900.0;
    for (pitch, limit) in [(9.0, 0.012), (7.0, 0.012), (19.0, 0.02)] {
        let (median, worst, share) =
            errors(&run(&pair(pitch, 1.0, ramp), &RefineParams::default()).unwrap(), ramp);
        assert!(
            median < limit && worst < 4.0 * limit && share > 0.99,
            "{pitch}: {median} {worst} {share}"
        );
        let (median, worst, share) =
            errors(&run(&pair(pitch, 1.0, bowl), &RefineParams::default()).unwrap(), bowl);
        assert!(median < limit && worst < 0.1 && share > 0.99, "{pitch}: {median} {worst} {share}");
    }
}

#[test]
fn matches_are_refined_and_wrong_ones_removed() {
    let truth = |x: f64, y: f64| 15.0 + 2.0 * (0.05 * x).sin() + 0.01 * y;
    let mut p = pair(9.0, 2.0, truth);
    let wrong = p.matches.len() / 2;
    p.matches[wrong].right.x -= 9.0;
    let r = run(&p, &RefineParams::default()).unwrap();
    assert!((r.pitch_px - 9.0).abs() < 1e-9);
    assert_eq!(r.dropped, 1);
    let e: Vec<f64> = r
        .matches
        .iter()
        .filter(|m| m.left.x > 40.0)
        .map(|m| (m.disparity() - truth(m.left.x, m.left.y)).abs())
        .collect();
    assert!(median(&e).unwrap() < 0.02, "{:?}", median(&e));
    assert!(r.matches.iter().all(|m| (0.001..=0.6).contains(&m.sigma_px)));
}

#[test]
fn regions_without_pattern_stay_holes() {
    let truth = |x: f64, _: f64| 12.0 + 0.02 * x;
    let mut p = pair(9.0, 1.0, truth);
    // a dark region (hair) in the middle of both photos
    for y in 60..100 {
        for x in 90..140 {
            p.left.set(x, y, 10.0);
            p.right.set(x - 14, y, 10.0);
        }
    }
    let r = run(&p, &RefineParams::default()).unwrap();
    assert!(r.disparity.at(115, 80).is_nan());
    assert!(r.disparity.at(60, 40).is_finite() && r.sigma_px.at(60, 40) > 0.0);
    assert!(r.disparity.at(115, 80).is_nan() == r.sigma_px.at(115, 80).is_nan());
}

#[test]
fn row_offsets_are_corrected_from_the_matches() {
    let truth = |x: f64, y: f64| 14.0 + 0.02 * x - 0.01 * y;
    let mut p = pair(9.0, 1.0, truth);
    p.right = shifted_down(&p.right, |_, _| -0.3);
    p.matches.iter_mut().for_each(|m| m.right.y += 0.3);
    let (median, worst, _) = errors(&run(&p, &RefineParams::default()).unwrap(), truth);
    assert!(median < 0.012 && worst < 0.05, "{median} {worst}");
}

#[test]
fn the_result_does_not_depend_on_the_number_of_threads() {
    let p = pair(9.0, 2.0, |x, y| 14.0 + 0.02 * x + 0.5 * (0.1 * y).sin());
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let r = pool.install(|| run(&p, &RefineParams::default())).unwrap();
        let bits = |g: &Gray| g.data().iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        (bits(&r.disparity), bits(&r.sigma_px), r.matches)
    };
    assert!(with(1) == with(3));
}

#[test]
fn bad_input_is_refused_with_a_message() {
    let p = pair(9.0, 1.0, |_, _| 10.0);
    let params = RefineParams::default();
    let small = Gray::filled(10, 10, 0.0);
    let e = refine(&p.left, &small, None, &p.matches, &params, &()).unwrap_err();
    assert!(e.to_string().contains("200x160") && e.to_string().contains("10x10"), "{e}");
    let e = refine(&p.left, &p.right, None, &p.matches[..5], &params, &()).unwrap_err();
    assert_eq!(e, RefineError::TooFewMatches { got: 5, needed: MIN_MATCHES });
    let e = run(&p, &RefineParams { knot: 0.0, ..params.clone() }).unwrap_err();
    assert!(matches!(e, RefineError::Settings(_)), "{e}");
    let blank = Gray::filled(200, 160, 80.0);
    let e = refine(&blank, &blank, None, &p.matches, &params, &()).unwrap_err();
    assert!(matches!(e, RefineError::NothingMeasured { .. }), "{e}");
    // empty photos, and values that are not numbers
    let none = Gray::filled(0, 0, 0.0);
    assert!(refine(&none, &none, None, &p.matches, &params, &()).is_err());
    let mut odd = p.matches.clone();
    odd.iter_mut().for_each(|m| m.left.x = f64::NAN);
    assert!(refine(&p.left, &p.right, None, &odd, &params, &()).is_err());
    let nan = Gray::filled(200, 160, f32::NAN);
    assert!(refine(&nan, &p.right, None, &p.matches, &params, &()).is_err());
    // photos of a few columns, with a column of matches
    for width in 3..8 {
        let narrow = Gray::from_fn(width, 300, |_, y| 100.0 + 50.0 * (y as f32).sin());
        let column: Vec<Match> = (0..30)
            .map(|k| Vec2::new(width as f64 - 1.0, 10.0 * f64::from(k)))
            .map(|left| Match { left, right: left - Vec2::new(1.0, 0.0), ..p.matches[0] })
            .collect();
        let _ = refine(&narrow, &narrow, None, &column, &params, &());
    }
}

#[test]
fn an_observer_can_cancel_the_descent() {
    let p = pair(9.0, 1.0, |_, _| 10.0);
    struct Stops(Cell<u32>);
    impl Observer for Stops {
        fn cancelled(&self) -> bool {
            self.0.set(self.0.get() + 1);
            self.0.get() > 2
        }
    }
    let stops = Stops(Cell::new(0));
    let e =
        refine(&p.left, &p.right, None, &p.matches, &RefineParams::default(), &stops).unwrap_err();
    assert_eq!(e, RefineError::Cancelled(Cancelled));
}

#[test]
fn the_largest_sigma_scales_with_the_pitch() {
    let sigma_px = |pitch| limits(&RefineParams::default(), pitch, 8.0).sigma_px;
    assert!((sigma_px(18.0) - 2.0 * sigma_px(9.0)).abs() < 1e-12);
    assert!((sigma_px(9.0) - 0.6).abs() < 0.01, "{}", sigma_px(9.0));
}
