use std::cell::RefCell;

use super::*;
use crate::camera::{Rectification, View};
use crate::data::{Capture, Dot, Gray, Pattern, Photo, Rgb};
use crate::math::{Mat3, Vec2};
use crate::observer::Event;

/// Distance of the dots that [`dotted`] draws, pixels.
const SPACING: f64 = 10.0;

/// A photo of Gaussian dots on a face-like disc, `lower` pixels further down.
fn dotted(lower: f64, height: f64, sigma: f64, disc: f64) -> Photo {
    let gray = Gray::from_fn(768, 576, |x, y| {
        let (x, y) = (x as f64, y as f64 - lower);
        let r = (x - 380.0).hypot((y - 290.0) * 0.8);
        if r > disc {
            return 6.0;
        }
        let near = |v: f64| v - SPACING * (v / SPACING).round();
        let (u, v) = (near(x), near(y));
        (50.0 + height * (-(u * u + v * v) / (2.0 * sigma * sigma)).exp()) as f32
    });
    let rgb = Rgb::from_fn(768, 576, |x, y| [gray.at(x, y) as u8; 3]);
    Photo { rgb, gray }
}

/// The dots of a photo that [`dotted`] drew: local maxima of the grey levels.
fn dots_of(image: &Gray) -> Vec<Dot> {
    let mut dots = Vec::new();
    for y in 2..image.height().saturating_sub(2) {
        for x in 2..image.width().saturating_sub(2) {
            let value = image.at(x, y);
            let mut around = (0..25).filter(|k| *k != 12);
            if value > 20.0 && around.all(|k| image.at(x + k % 5 - 2, y + k / 5 - 2) < value) {
                let position = Vec2::new(x as f64, y as f64);
                dots.push(Dot { position, sigma_px: 0.0, amplitude: 0.0, score: 1.0 });
            }
        }
    }
    dots
}

fn lit(level: f32) -> Photo {
    Photo { rgb: Rgb::filled(768, 576, [level as u8; 3]), gray: Gray::filled(768, 576, level) }
}

/// The right photo is taken 3 pixels aside, so that it is not the same picture as the left one.
fn capture(left: Photo, right: Photo) -> Capture {
    let (width, height) = right.size();
    let aside = |x: usize, y: usize| right.gray.clamped(x as isize + 3, y as isize);
    let right = Photo { gray: Gray::from_fn(width, height, aside), ..right };
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

/// Collects warnings.
#[derive(Default)]
struct Warnings(RefCell<Vec<String>>);

impl Observer for Warnings {
    fn event(&self, event: &Event<'_>) {
        if let Event::Warning { stage: "check", message } = event {
            self.0.borrow_mut().push((*message).to_owned());
        }
    }
}

fn report_with(capture: &Capture, views: &Rectification, observer: &dyn Observer) -> CheckReport {
    let found = [&capture.left.gray, &capture.right.gray].map(dots_of);
    let dots = [0, 1].map(|i| {
        let dots = found[i].as_slice();
        (dots.len() >= 12).then_some(PhotoDots { dots, spacing_px: SPACING })
    });
    let input = CheckInput { capture, dots, views: Ok(views), rows_corrected: false };
    check(&input, &CheckParams::default(), observer).unwrap()
}

fn report(capture: &Capture) -> CheckReport {
    report_with(capture, &Rectification::identity(capture.left.size()), &())
}

fn broken(capture: &Capture) -> Vec<&'static str> {
    let heard = Warnings::default();
    let views = Rectification::identity(capture.left.size());
    let report = report_with(capture, &views, &heard);
    let warned: Vec<_> = report.findings.iter().filter(|f| f.is_broken()).map(|f| f.rule).collect();
    assert_eq!(report.is_good(), warned.is_empty());
    assert_eq!(report.warnings().len(), warned.len());
    assert_eq!(*heard.0.borrow(), report.warnings());
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
    assert_eq!(broken(&capture(glare(), glare())), ["saturation"]);
    let mut dark = capture(good(), good());
    dark.plain = Some([lit(12.0), lit(12.0)]);
    assert_eq!(broken(&dark), ["plain"]);
    dark.plain = None;
    assert_eq!(broken(&dark), ["plain"]);
    assert!(broken(&capture(good(), lit(50.0))).contains(&"dots"));
}

#[test]
fn rows_are_checked_as_rectification_has_corrected_them() {
    let tilted = capture(good(), dotted(3.0, 130.0, 2.0, 200.0));
    let up = Mat3::new(1.0, 0.0, 0.0, 0.0, 1.0, -3.0, 0.0, 0.0, 1.0);
    let level = Rectification::identity((768, 576));
    let corrected = Rectification { right: View::plane(up).unwrap(), ..level };
    assert!(!report_with(&tilted, &level, &()).is_good());
    let report = report_with(&tilted, &corrected, &());
    assert!(report.is_good(), "{:?}", report.warnings());
    // a rig that cannot be used is a finding, not an error
    let dots = dots_of(&good().gray);
    let dots = [Some(PhotoDots { dots: &dots, spacing_px: SPACING }); 2];
    let views = Err("the cameras are swapped".to_owned());
    let input = CheckInput { capture: &tilted, dots, views, rows_corrected: false };
    let report = check(&input, &CheckParams::default(), &()).unwrap();
    let rows = report.findings.iter().find(|f| f.rule == "rows").unwrap();
    assert_eq!(
        (rows.verdict, rows.message.as_str()),
        (Verdict::Warning, "the cameras are swapped")
    );
}

#[test]
fn the_size_of_small_photos_is_reported() {
    let small = || Photo { rgb: Rgb::filled(64, 48, [9; 3]), gray: Gray::filled(64, 48, 9.0) };
    let found = report(&capture(small(), small()));
    let finding = &found.findings[0];
    assert_eq!((finding.rule, finding.verdict), ("resolution", Verdict::Warning));
    assert!(finding.message.contains("64x48") && finding.message.contains("768x576"));
    // photos without pixels do not panic
    let none = || Photo { rgb: Rgb::filled(0, 0, [0; 3]), gray: Gray::filled(0, 0, 0.0) };
    assert!(!report(&capture(none(), none())).is_good());
}

#[test]
fn parameters_and_cancelling_are_obeyed() {
    struct Stop;
    impl Observer for Stop {
        fn cancelled(&self) -> bool {
            true
        }
    }
    let capture = capture(good(), good());
    let views = Rectification::identity((768, 576));
    let input = CheckInput {
        capture: &capture,
        dots: [None, None],
        views: Ok(&views),
        rows_corrected: false,
    };
    let params = CheckParams { min_dot_ratio: 7.0, ..CheckParams::default() };
    let error = check(&input, &params, &()).unwrap_err();
    assert!(
        matches!(&error, CheckError::Settings(e) if e.to_string().contains("check.min_dot_ratio"))
    );
    let error = check(&input, &CheckParams::default(), &Stop).unwrap_err();
    assert_eq!(error, CheckError::Cancelled(Cancelled));
}

#[test]
fn the_row_offset_is_measured_to_a_tenth_of_a_pixel() {
    let left: Vec<Vec2> = (0..900)
        .map(|i| {
            Vec2::new(f64::from(i % 30) * 9.0, f64::from(i / 30) * 9.0 + f64::from(i % 30) * 0.07)
        })
        .collect();
    for lower in [-3.0, -0.4, 0.0, 0.3, 1.7, 4.0] {
        let right: Vec<Vec2> = left.iter().map(|p| p + Vec2::new(-200.0, lower)).collect();
        let found = row_offset::offset(&left, &right, 9.0).unwrap();
        assert!((found - lower).abs() < 0.1, "{lower}: {found}");
    }
    // without rows there is no offset
    let scattered: Vec<Vec2> =
        (0..900).map(|i| Vec2::new(f64::from(i), f64::from(i * 7919 % 10_000) / 40.0)).collect();
    assert_eq!(row_offset::offset(&scattered, &scattered[..400], 9.0), None);
}

/// A subject without the pattern: a disc with bright and dark parts, `aside` pixels further right.
fn plain(aside: f64) -> Photo {
    let gray = Gray::from_fn(768, 576, |x, y| {
        let (x, y) = (x as f64 - aside, y as f64);
        let r = (x - 380.0).hypot((y - 290.0) * 0.8);
        let marks = (x / 37.0).sin() * (y / 29.0).cos();
        if r > 200.0 { 6.0 } else { (120.0 + 60.0 * marks) as f32 }
    });
    Photo { rgb: Rgb::filled(768, 576, [0; 3]), gray }
}

/// The photo with the pattern of the same subject.
fn patterned(aside: f64) -> Photo {
    let (dots, subject) = (dotted(0.0, 130.0, 2.0, 200.0).gray, plain(aside).gray);
    let gray = Gray::from_fn(768, 576, |x, y| {
        let dot = dots.clamped(x as isize - aside as isize, y as isize);
        dot * (0.3 + subject.at(x, y) / 255.0)
    });
    Photo { gray, ..plain(aside) }
}

/// The message of the fault of a capture of the photos; `None` without one.
fn fault(dotted: [Photo; 2], plain: [Photo; 2]) -> Option<String> {
    let [left, right] = dotted;
    let mut given = capture(left, right.clone());
    given.right = right;
    given.plain = Some(plain);
    report(&given).faults().into_iter().next()
}

#[test]
fn photos_that_do_not_belong_together_are_faults() {
    let (dots, bare) = (|| [patterned(0.0), patterned(-40.0)], || [plain(0.0), plain(-40.0)]);
    assert_eq!(fault(dots(), bare()), None);
    let contains = |text: Option<String>, part: &str| {
        assert!(text.as_ref().is_some_and(|t| t.contains(part)), "{part}: {text:?}");
    };
    let [left, right] = bare();
    contains(fault(dots(), [right, left]), "interchanged");
    contains(fault(dots(), [plain(-90.0), plain(-140.0)]), "of each camera");
    contains(fault(dots(), [plain(0.0), plain(-140.0)]), "of the right camera");
    contains(fault(dots(), dots()), "pattern's contrast");
    contains(fault([patterned(0.0), patterned(0.0)], bare()), "with the pattern are the same");
    contains(fault(dots(), [plain(0.0), plain(0.0)]), "without the pattern are the same");
}
