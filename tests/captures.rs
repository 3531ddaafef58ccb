//! The profile `facebuilder` on captures with truth that lie outside of this repository: the
//! folders in `FACERECON_CAPTURES` that hold a `truth_dots.csv`. Skipped where that is not set.
#![allow(clippy::unwrap_used, clippy::panic)] // also the helpers of tests may stop a test
#![allow(clippy::print_stdout)] // the figures are worth reading

#[path = "support/truth.rs"]
mod truth;

use std::path::PathBuf;

use facerecon_core::io::capture::read_capture;
use facerecon_core::pipeline::Params;
use facerecon_core::pipeline::reconstruct;
use facerecon_core::render::Frame;
use facerecon_core::{output, template};

#[test]
fn facebuilder_matches_the_face_of_every_capture() {
    let Some(folder) = std::env::var_os("FACERECON_CAPTURES") else {
        println!("skipped: FACERECON_CAPTURES is not set");
        return;
    };
    let mut captures: Vec<PathBuf> = std::fs::read_dir(&folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.join("truth_dots.csv").is_file())
        .collect();
    captures.sort();
    assert!(!captures.is_empty(), "no capture with truth_dots.csv in {}", folder.display());

    let params = Params::profile("facebuilder").unwrap();
    let mut faults = Vec::new();
    for path in captures {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let capture = read_capture(&path).unwrap().capture;
        let found = match reconstruct(&capture, &template::built_in(), &params, &()) {
            Ok(found) => found,
            Err(error) => {
                faults.push(format!("{name}: {error}"));
                continue;
            }
        };
        let dots = truth::face_dots(&path);
        let score = truth::score(&dots, &output::match_rows(&found, Frame::Camera));
        let far = truth::distances(&dots, &found.mesh_in(Frame::Camera)).median_mm;
        let said = format!(
            "{name}: {:.1} % of the face's dots matched, {:.2} % wrong, surface {far:.2} mm",
            100.0 * score.recall,
            100.0 * score.wrong
        );
        println!("{said}");
        if score.recall < 0.6 || score.wrong > 0.02 || far > 3.0 {
            faults.push(said);
        }
    }
    assert!(faults.is_empty(), "needed: 60 %, 2 %, 3 mm\n{}", faults.join("\n"));
}
