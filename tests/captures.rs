//! Profile `facebuilder` on captures with ground truth outside this repository: the folders inside
//! `FACERECON_CAPTURES` that hold a `truth_dots.csv`. Run with
//! `FACERECON_CAPTURES=FOLDER cargo test -p facerecon-cli --test captures -- --ignored`.
#![allow(clippy::unwrap_used, clippy::panic)] // also the helpers of tests may stop a test
#![allow(clippy::print_stdout)] // the figures are worth reading

#[path = "support/truth.rs"]
mod truth;

use std::path::PathBuf;

use facerecon_core::Params;
use facerecon_core::io::capture::read_capture;
use facerecon_core::reconstruct;
use facerecon_core::render::Frame;
use facerecon_core::{output, template};

/// Bounds for every capture, loose enough for all four kinds of docs/accuracy.md: part of the dots
/// of the face that is matched, part of the matches that is wrong, median distance from the face.
const MIN_RECALL: f64 = 0.6;
const MAX_WRONG: f64 = 0.02;
const MAX_MEDIAN_MM: f64 = 3.0;

#[test]
#[ignore = "needs captures with ground truth: set FACERECON_CAPTURES to their folder"]
fn facebuilder_matches_the_face_of_every_capture() {
    let folder = std::env::var_os("FACERECON_CAPTURES")
        .unwrap_or_else(|| panic!("set FACERECON_CAPTURES to a folder of captures"));
    let mut captures: Vec<PathBuf> = std::fs::read_dir(&folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.join("truth_dots.csv").is_file())
        .collect();
    captures.sort();
    assert!(!captures.is_empty(), "no capture with truth_dots.csv in {}", folder.display());

    let params = Params::profile("facebuilder").unwrap();
    let mut failures = Vec::new();
    for path in captures {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let capture = read_capture(&path).unwrap().capture;
        let found = match reconstruct(&capture, &template::built_in(), &params, &()) {
            Ok(found) => found,
            Err(error) => {
                failures.push(format!("{name}: {error}"));
                continue;
            }
        };
        let dots = truth::face_dots(&path);
        let score = truth::score(&dots, &output::match_rows(&found, Frame::Camera));
        let median_mm = truth::distances(&dots, &found.mesh_in(Frame::Camera)).median_mm;
        let figures = format!(
            "{name}: {:.1} % of the face's dots matched, {:.2} % wrong, surface {median_mm:.2} mm",
            100.0 * score.recall,
            100.0 * score.wrong
        );
        println!("{figures}");
        if score.recall < MIN_RECALL || score.wrong > MAX_WRONG || median_mm > MAX_MEDIAN_MM {
            failures.push(figures);
        }
    }
    let bounds = format!("{MIN_RECALL} matched, {MAX_WRONG} wrong, {MAX_MEDIAN_MM} mm");
    assert!(failures.is_empty(), "bounds: {bounds}\n{}", failures.join("\n"));
}
