use super::*;
use crate::data::{Pattern, Photo, Rgb};

/// A photo of Gaussian dots on a face-like disc, `lower` pixels further down.
fn dotted(lower: f64, height: f64, sigma: f64, disc: f64) -> Photo {
    let gray = Gray::from_fn(768, 576, |x, y| {
        let (x, y) = (x as f64, y as f64 - lower);
        let r = (x - 380.0).hypot((y - 290.0) * 0.8);
        if r > disc {
            return 6.0;
        }
        let (u, v) = (x - 10.0 * (x / 10.0).round(), y - 10.0 * (y / 10.0).round());
        (50.0 + height * (-(u * u + v * v) / (2.0 * sigma * sigma)).exp()) as f32
    });
    let rgb = Rgb::from_fn(768, 576, |x, y| [gray.at(x, y) as u8; 3]);
    Photo { rgb, gray }
}

fn lit(level: f32) -> Photo {
    Photo { rgb: Rgb::filled(768, 576, [level as u8; 3]), gray: Gray::filled(768, 576, level) }
}

fn capture(left: Photo, right: Photo) -> Capture {
    Capture {
        left,
        right,
        plain: Some([lit(120.0), lit(120.0)]),
        extra: Vec::new(),
        pattern: Pattern { kind: PatternKind::Dots, columns: 85, rows: 64, rotation: 0.0 },
        rig: None,
        seeds: None,
        landmarks: Default::default(),
    }
}

fn broken(capture: &Capture) -> Vec<&'static str> {
    let report = check(capture, &CheckParams::default());
    let warned: Vec<_> =
        report.findings.iter().filter(|f| f.verdict == Verdict::Warning).map(|f| f.rule).collect();
    assert_eq!(report.is_good(), warned.is_empty());
    assert_eq!(report.warnings().len(), warned.len());
    warned
}

fn good() -> Photo {
    dotted(0.0, 130.0, 2.0, 200.0)
}

#[test]
fn a_good_capture_breaks_no_rule() {
    assert_eq!(broken(&capture(good(), good())), Vec::<&str>::new());
}

#[test]
fn each_fault_breaks_its_own_rule() {
    let dim = Photo { gray: good().gray.map(|v| v * 0.6), ..good() };
    assert_eq!(broken(&capture(good(), dim)), ["luminance"]);
    assert_eq!(broken(&capture(good(), dotted(3.0, 130.0, 2.0, 200.0))), ["rows"]);
    let faint = || dotted(0.0, 20.0, 2.0, 200.0);
    assert_eq!(broken(&capture(faint(), faint())), ["contrast"]);
    let soft = || dotted(0.0, 130.0, 3.6, 200.0);
    assert!(broken(&capture(soft(), soft())).contains(&"sharpness"));
    // half of the head is outside the right photo
    let aside = |by: isize| {
        let gray = good().gray;
        let gray =
            Gray::from_fn(768, 576, |x, y| gray.get(x as isize + by, y as isize).unwrap_or(6.0));
        Photo { gray, ..good() }
    };
    assert!(broken(&capture(good(), aside(330))).contains(&"subject"));
    let glare = || dotted(0.0, 260.0, 2.0, 200.0);
    assert_eq!(broken(&capture(glare(), glare())), ["shine"]);
    let mut dark = capture(good(), good());
    dark.plain = Some([lit(12.0), lit(12.0)]);
    assert_eq!(broken(&dark), ["plain"]);
    dark.plain = None;
    assert_eq!(broken(&dark), ["plain"]);
    assert!(broken(&capture(good(), lit(50.0))).contains(&"dots"));
}

#[test]
fn small_photos_are_told_with_their_size() {
    let small = || Photo { rgb: Rgb::filled(64, 48, [9; 3]), gray: Gray::filled(64, 48, 9.0) };
    let report = check(&capture(small(), small()), &CheckParams::default());
    let finding = &report.findings[0];
    assert_eq!((finding.rule, finding.verdict), ("resolution", Verdict::Warning));
    assert!(finding.message.contains("64x48") && finding.message.contains("768x576"));
    // nothing at all is no panic
    let none = || Photo { rgb: Rgb::filled(0, 0, [0; 3]), gray: Gray::filled(0, 0, 0.0) };
    assert!(!check(&capture(none(), none()), &CheckParams::default()).is_good());
}

#[test]
fn the_row_offset_comes_back_to_a_tenth_of_a_pixel() {
    let left: Vec<Vec2> = (0..900)
        .map(|i| {
            Vec2::new(f64::from(i % 30) * 9.0, f64::from(i / 30) * 9.0 + f64::from(i % 30) * 0.07)
        })
        .collect();
    for lower in [-3.0, -0.4, 0.0, 0.3, 1.7, 4.0] {
        let right: Vec<Vec2> = left.iter().map(|p| p + Vec2::new(-200.0, lower)).collect();
        let found = rows::offset(&left, &right, 9.0).unwrap();
        assert!((found - lower).abs() < 0.1, "{lower}: {found}");
    }
    // no rows, no answer
    let scattered: Vec<Vec2> =
        (0..900).map(|i| Vec2::new(f64::from(i), f64::from(i * 7919 % 10_000) / 40.0)).collect();
    assert_eq!(rows::offset(&scattered, &scattered[..400], 9.0), None);
}
