use super::*;

fn picture(rows: &[&str]) -> Gray {
    Gray::from_fn(rows[0].len(), rows.len(), |x, y| {
        if rows[y].as_bytes()[x] == b'#' { 255.0 } else { 0.0 }
    })
}

fn positions(thinned: &Thinned) -> Vec<(f64, f64)> {
    thinned.dots.iter().map(|d| (d.position.x, d.position.y)).collect()
}

fn loose() -> DetectParams {
    DetectParams { min_area_px: 1, max_area: 1000.0, ..DetectParams::default() }
}

#[test]
fn a_square_dot_becomes_its_middle_pixel() {
    let image = picture(&["......", ".###..", ".###..", ".###..", "......"]);
    let thinned = thin(&image, &loose());
    assert_eq!(positions(&thinned), [(2.0, 2.0)]);
    assert_eq!(thinned.image.data().iter().filter(|v| **v > 0.0).count(), 1);
    assert_eq!(thinned.image.at(2, 2), 255.0);
}

#[test]
fn windows_alone_split_a_round_dot_and_merging_does_not() {
    // the first pixel found is to the right of the dot's left end
    let image = picture(&[".......", "...##..", "..####.", "..####.", "...##..", "......."]);
    let literal = DetectParams { merge: false, ..loose() };
    // window 1 from (3, 1) takes all but column 2, which window 2 from (2, 2) takes
    assert_eq!(positions(&thin(&image, &literal)), [(2.0, 3.0), (4.0, 3.0)]);
    assert_eq!(positions(&thin(&image, &DetectParams { round: false, ..loose() })), [(3.5, 2.5)]);
}

#[test]
fn a_dot_larger_than_the_window_stays_one() {
    let (cx, cy, r) = (20.0, 17.0, 9.3);
    let image =
        Gray::from_fn(
            40,
            36,
            |x, y| {
                if (x as f64 - cx).hypot(y as f64 - cy) <= r { 255.0 } else { 0.0 }
            },
        );
    let params = DetectParams { round: false, ..loose() };
    assert_eq!(positions(&thin(&image, &params)), [(cx, cy)]);
    // the windows of the thesis alone give several dots
    let literal = DetectParams { merge: false, ..loose() };
    assert!(thin(&image, &literal).dots.len() > 4);
}

#[test]
fn dots_a_pixel_apart_stay_two_and_specks_and_reflections_are_dropped() {
    let mut image = Gray::filled(200, 60, 0.0);
    let mut square = |x0: usize, y0: usize, side: usize| {
        for y in y0..y0 + side {
            for x in x0..x0 + side {
                image.set(x, y, 255.0);
            }
        }
    };
    for i in 0..30 {
        square(3 + 4 * i, 5, 3); // one black column between
    }
    square(10, 30, 1); // a speck
    square(60, 30, 20); // a reflection
    let thinned = thin(&image, &DetectParams::default());
    let expected: Vec<_> = (0..30).map(|i| (f64::from(4 + 4 * i), 6.0)).collect();
    assert_eq!(positions(&thinned), expected);
}

#[test]
fn the_spacing_of_a_lattice_with_holes_is_that_of_the_lattice() {
    let dots: Vec<Dot> = (0..20 * 15)
        .filter(|i| i % 7 != 3)
        .map(|i| Dot {
            position: Vec2::new(f64::from(i % 20) * 9.5, f64::from(i / 20) * 9.5),
            sigma_px: 0.0,
            amplitude: 0.0,
            score: 1.0,
        })
        .collect();
    assert!((spacing_px(&dots).unwrap() - 9.5).abs() < 1e-9);
    assert_eq!(spacing_px(&dots[..1]), None);
    assert_eq!(spacing_px(&[dots[0]; 5]), None);
}

#[test]
fn photos_without_a_pattern_are_refused_with_the_count() {
    let params = DetectParams { method: DetectMethod::Thin, ..DetectParams::default() };
    let error = detect(&Gray::filled(50, 40, 0.0), &params, &()).unwrap_err();
    assert_eq!(error, DetectError::TooFewDots { got: 0, needed: 12 });
    let white = detect(&Gray::filled(50, 40, 255.0), &params, &()).unwrap_err();
    assert_eq!(white, DetectError::TooFewDots { got: 1, needed: 12 });
    let empty = detect(&Gray::filled(0, 0, 0.0), &params, &()).unwrap_err();
    assert_eq!(empty, DetectError::Empty { width: 0, height: 0 });
}
