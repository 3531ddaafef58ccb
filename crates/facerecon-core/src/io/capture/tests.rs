use std::fs;

use proptest::prelude::*;
use tempfile::TempDir;

use super::*;
use crate::camera::{Distortion, Pinhole, StereoRig};
use crate::data::{
    Capture, ExtraPhoto, LANDMARKS, LandmarkPairs, Pair, Pattern, PatternKind, Photo, Rgb, Seeds,
};
use crate::io::{write_calibration, write_png};
use crate::math::{Similarity, Vec2, Vec3};

fn photo(width: usize, height: usize, shift: u8) -> Photo {
    Photo::from_rgb(Rgb::from_fn(width, height, |x, y| [x as u8, y as u8, shift]))
}

fn pair(x: f64) -> Pair {
    Pair { left: Vec2::new(x, 5.5), right: Vec2::new(x - 3.25, 5.5) }
}

fn capture() -> Capture {
    let mut rig = StereoRig::parallel(150.0, 900.0, Vec2::new(19.5, 14.5), Vec2::new(20.0, 15.0));
    rig.left.distortion = Distortion([0.01, -0.02, 0.001, 0.0, 0.0, 0.0, 0.0, 0.0]);
    rig.image_size = Some((40, 30));
    let rotation = nalgebra::Rotation3::from_euler_angles(0.0, 0.8, 0.1).into_inner();
    Capture {
        left: photo(40, 30, 1),
        right: photo(40, 30, 2),
        plain: Some([photo(40, 30, 3), photo(40, 30, 4)]),
        extra: vec![ExtraPhoto {
            photo: photo(20, 60, 5),
            camera: Pinhole::ideal(700.0, Vec2::new(9.5, 29.5)),
            camera_from_left: Similarity::rigid(rotation, Vec3::new(-918.9, -3.0, 413.8)),
        }],
        pattern: Pattern {
            kind: PatternKind::Dots,
            columns: 85,
            rows: 64,
            rotation: 9.5f64.to_radians(),
        },
        rig: Some(rig),
        seeds: Some(Seeds { head: pair(20.0), left_ear: pair(8.0), right_ear: pair(33.0) }),
        landmarks: LandmarkPairs::from([
            ("nose_tip".into(), pair(19.0)),
            ("chin".into(), pair(18.0)),
        ]),
    }
}

/// A folder with two photos and a capture file.
fn folder(text: &str) -> TempDir {
    let dir = tempfile::tempdir().unwrap();
    for (name, shift) in [("l.png", 1), ("r.png", 2)] {
        write_png(&dir.path().join(name), &photo(40, 30, shift).rgb).unwrap();
    }
    write_png(&dir.path().join("small.png"), &photo(20, 30, 1).rgb).unwrap();
    fs::write(dir.path().join("capture.toml"), text).unwrap();
    dir
}

const IMAGES: &str = "[images]\nleft = \"l.png\"\nright = \"r.png\"\n";
const PATTERN: &str = "[pattern]\ncolumns = 85\nrows = 64\n";

const EARS: &str =
    "left_ear = { left = [1, 1], right = [1, 1] }\nright_ear = { left = [1, 1], right = [1, 1] }\n";

fn refusal(text: &str) -> String {
    read_capture(folder(text).path()).unwrap_err().to_string()
}

#[test]
fn a_written_capture_is_read_back() {
    let dir = tempfile::tempdir().unwrap();
    let capture = capture();
    let path = write_capture(&dir.path().join("c"), &capture).unwrap();
    for place in [path.as_path(), &dir.path().join("c")] {
        let found = read_capture(place).unwrap();
        assert_eq!(found.warnings, Vec::<String>::new());
        assert_eq!(found.sources.len(), 7);
        let pose = |c: &Capture| c.extra[0].camera_from_left;
        assert!((pose(&found.capture).rotation - pose(&capture).rotation).amax() < 1e-15);
        assert!((found.capture.pattern.rotation - capture.pattern.rotation).abs() < 1e-15);
        let mut same = found.capture;
        same.extra[0].camera_from_left = pose(&capture);
        same.pattern.rotation = capture.pattern.rotation;
        assert_eq!(same, capture);
    }
}

#[test]
fn the_new_file_is_valid_and_names_every_landmark() {
    let text = new_capture_toml();
    let (parsed, warnings) = text::parse(&text).unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    assert_eq!(parsed.pattern.unwrap().columns, Some(85));
    assert!(LANDMARKS.iter().all(|f| text.contains(f)));
    let dir = folder(&text);
    assert!(read_capture(dir.path()).unwrap_err().to_string().contains("left_dots.png"));
    // It is still a capture file when every commented key is active.
    let on: String = text
        .lines()
        .map(|l| match l.strip_prefix("# ") {
            Some(rest)
                if rest.starts_with('[')
                    || rest.split_once(" = ").is_some_and(|(key, _)| !key.contains(' ')) =>
            {
                format!("{rest}\n")
            }
            _ => format!("{l}\n"),
        })
        .collect();
    let (parsed, warnings) = text::parse(&on).unwrap();
    assert!(warnings.is_empty() && parsed.seeds.is_some() && !parsed.landmarks.is_empty());
}

#[test]
fn the_command_line_replaces_the_calibration_which_replaces_the_parallel_keys() {
    let text = format!(
        "{IMAGES}{PATTERN}[rig]\ncalibration = \"c.yml\"\nbaseline_mm = 99.0\nfocal_px = 500.0\n"
    );
    let dir = folder(&text);
    let mut rig = capture().rig.unwrap();
    write_calibration(&dir.path().join("c.yml"), &rig).unwrap();
    let found = read_capture(dir.path()).unwrap();
    assert_eq!(found.capture.rig.unwrap().left.fx, 900.0);
    let elsewhere = tempfile::tempdir().unwrap();
    rig.left.fx = 901.0;
    let given = elsewhere.path().join("other.yml");
    write_calibration(&given, &rig).unwrap();
    let files = CaptureFiles { calibration: Some(given), columns: Some(40), ..Default::default() };
    let found = read_capture_with(Some(dir.path()), &files).unwrap().capture;
    assert_eq!((found.rig.unwrap().left.fx, found.pattern.columns), (901.0, 40));
}

#[test]
fn a_parallel_rig_is_built_from_its_keys() {
    let keys = "[rig]\nbaseline_mm = 150\nfocal_px = 900.0\nprincipal_left = [19.5, 14.5]\n";
    let found = read_capture(folder(&format!("{IMAGES}{PATTERN}{keys}")).path()).unwrap();
    let rig = found.capture.rig.unwrap();
    assert_eq!(rig.baseline_mm(), 150.0);
    assert_eq!((rig.right.cx, rig.right.cy), (19.5, 14.5));
    assert!(found.warnings[0].contains("principal_right"), "{:?}", found.warnings);
    let none = read_capture(folder(&format!("{IMAGES}{PATTERN}")).path()).unwrap();
    assert!(none.capture.rig.is_none() && none.capture.plain.is_none());
}

#[test]
fn a_capture_is_read_from_photos_without_a_file() {
    let dir = folder("");
    let path = |name: &str| Some(dir.path().join(name));
    let files = CaptureFiles {
        left: path("l.png"),
        right: path("r.png"),
        columns: Some(85),
        rows: Some(64),
        ..Default::default()
    };
    let found = read_capture_with(None, &files).unwrap();
    assert_eq!(found.capture.pattern.rows, 64);
    let missing = CaptureFiles { rows: None, ..files.clone() };
    let error = read_capture_with(None, &missing).unwrap_err().to_string();
    assert!(error.contains("--rows"), "{error}");
    let stripes =
        CaptureFiles { kind: Some(PatternKind::Stripes), rows: None, columns: None, ..files };
    assert_eq!(read_capture_with(None, &stripes).unwrap().capture.pattern.columns, 0);
    assert!(read_capture_with(None, &CaptureFiles::default()).is_err());
}

#[test]
fn mistakes_are_named() {
    let seeds = |x: f64| {
        format!("{IMAGES}{PATTERN}[seeds]\nhead = {{ left = [{x}, 1], right = [1, 1] }}\n")
    };
    let cases = [
        ("".into(), "left photo"),
        (format!("[images]\nleft = \"l.png\"\n{PATTERN}"), "right photo"),
        (format!("[images]\nleft = \"l.png\"\nright = \"small.png\"\n{PATTERN}"), "20x30"),
        (format!("[images]\nleft = \"l.png\"\nright = \"gone.png\"\n{PATTERN}"), "gone.png"),
        (format!("{IMAGES}left_texture = \"l.png\"\n{PATTERN}"), "right_plain"),
        (
            format!(
                "{IMAGES}left_texture = \"small.png\"\nright_texture = \"small.png\"\n{PATTERN}"
            ),
            "20x30",
        ),
        (IMAGES.into(), "columns = NUMBER"),
        (format!("{IMAGES}[pattern]\ncolumns = 1\nrows = 64"), "1 columns"),
        (format!("{IMAGES}[pattern]\ncolumns = -4\nrows = 64"), "line 5"),
        (format!("{IMAGES}[pattern]\nkind = \"rings\"\ncolumns = 9\nrows = 9"), "rings"),
        (format!("{IMAGES}{PATTERN}rotation_deg = 1000.0"), "1000"),
        (format!("{IMAGES}{PATTERN}[rig]\nbaseline_mm = 0.15\nfocal_px = 900.0"), "metres"),
        (format!("{IMAGES}{PATTERN}[rig]\nbaseline_mm = -150.0\nfocal_px = 900.0"), "above 0"),
        (format!("{IMAGES}{PATTERN}[rig]\nbaseline_mm = 150.0"), "focal_px"),
        (format!("{IMAGES}{PATTERN}[rig]\ncalibration = \"none.yml\""), "none.yml"),
        (seeds(1.0), "left_ear is missing"),
        (
            format!("{}{EARS}", seeds(40.0)),
            "seeds.head: (40, 1) is outside the left photo of 40x30",
        ),
        (
            format!("{IMAGES}{PATTERN}[landmarks]\nnose_tp = {{ left = [1, 1], right = [1, 1] }}"),
            "did you mean nose_tip",
        ),
        (
            format!("{IMAGES}{PATTERN}[landmarks]\nelbow = {{ left = [1, 1], right = [1, 1] }}"),
            "forehead",
        ),
        ("images = 3".into(), "line 1"),
        ("[images\nleft = 3".into(), "line 1"),
        (
            format!(
                "{IMAGES}[[images.extra]]\nimage = \"l.png\"\nK = [[1,0,0],[0,1,0],[0,0,1]]\nR = [[2,0,0],[0,1,0],[0,0,1]]\nT = [0,0,0]\n{PATTERN}"
            ),
            "rotation",
        ),
        (format!("{IMAGES}[[images.extra]]\nimage = \"l.png\"\n{PATTERN}"), "K"),
    ];
    for (text, part) in cases {
        let error = refusal(&text);
        assert!(error.contains(part), "{part}: {error}");
    }
    let dir = tempfile::tempdir().unwrap();
    let error = read_capture(dir.path()).unwrap_err().to_string();
    assert!(error.contains("capture.toml") && error.contains("facerecon new"), "{error}");
}

#[test]
fn earlier_keys_of_the_plain_pair_are_read_without_a_warning() {
    let text = format!("{IMAGES}left_texture = \"r.png\"\nright_texture = \"l.png\"\n{PATTERN}");
    let found = read_capture(folder(&text).path()).unwrap();
    assert_eq!(found.warnings, Vec::<String>::new());
    let [left, right] = found.capture.plain.unwrap();
    assert_eq!((left, right), (found.capture.right, found.capture.left));
    let text = format!("{IMAGES}left_texture = \"r.png\"\nleft_plain = \"r.png\"\n{PATTERN}");
    assert!(refusal(&text).contains("left_plain"));
}

#[test]
fn unknown_keys_are_named_with_the_nearest() {
    let text = format!("note = 1\n{IMAGES}{PATTERN}colums = 3\n");
    let found = read_capture(folder(&text).path()).unwrap();
    assert_eq!(found.warnings.len(), 2);
    assert!(found.warnings[1].contains("did you mean columns"), "{:?}", found.warnings);
}

#[test]
fn paths_outside_the_folder_are_refused() {
    let outer = folder("");
    let inner = outer.path().join("capture");
    fs::create_dir(&inner).unwrap();
    fs::copy(outer.path().join("r.png"), inner.join("r.png")).unwrap();
    let outside = outer.path().join("l.png").display().to_string();
    for left in ["../l.png", &outside, "../gone.png", "/gone.png"] {
        let text = format!("[images]\nleft = {left:?}\nright = \"r.png\"\n{PATTERN}");
        fs::write(inner.join("capture.toml"), text).unwrap();
        let error = read_capture(&inner).unwrap_err();
        assert!(matches!(error, IoError::Outside { .. }), "{left}: {error}");
    }
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(outer.path().join("l.png"), inner.join("link.png")).unwrap();
        let text = format!("[images]\nleft = \"link.png\"\nright = \"r.png\"\n{PATTERN}");
        fs::write(inner.join("capture.toml"), text).unwrap();
        assert!(matches!(read_capture(&inner).unwrap_err(), IoError::Outside { .. }));
    }
    // A path that leaves and re-enters the folder is accepted, and any path of the command line.
    let text = format!("[images]\nleft = \"../capture/r.png\"\nright = \"r.png\"\n{PATTERN}");
    fs::write(inner.join("capture.toml"), text).unwrap();
    assert!(read_capture(&inner).is_ok());
    let given = CaptureFiles { left: Some(outer.path().join("l.png")), ..Default::default() };
    assert!(read_capture_with(Some(&inner), &given).is_ok());
}

/// The captures of `FACERECON_CAPTURES`, where that is set.
#[test]
fn real_captures_are_read() {
    let Ok(folder) = std::env::var("FACERECON_CAPTURES") else { return };
    let mut count = 0;
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.join("capture.toml").is_file() {
            let found = read_capture(&path).unwrap();
            assert_eq!(found.warnings, Vec::<String>::new(), "{}", path.display());
            count += 1;
        }
    }
    assert!(count > 0, "no capture in FACERECON_CAPTURES");
}

proptest! {
    #[test]
    fn no_text_panics(text in "[a-z_\\[\\]={},.\"0-9 \n-]{0,200}", at in 0usize..2000) {
        let _ = text::parse(&text);
        let mut whole = new_capture_toml();
        let at = at.min(whole.len());
        if whole.is_char_boundary(at) {
            whole.insert_str(at, &text);
            let _ = text::parse(&whole);
        }
    }
}
