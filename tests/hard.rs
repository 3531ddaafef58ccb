//! Captures that are hard to reconstruct end well, or with a verdict that names the matter.
#![allow(clippy::unwrap_used, clippy::panic)] // also the helpers of tests may stop a test

#[path = "support/hard.rs"]
mod hard;

use facerecon_core::evaluate::Distances;
use facerecon_core::render::Frame;
use facerecon_core::spatial::SurfaceIndex;
use facerecon_core::synthetic::pattern::PatternParams;
use facerecon_core::synthetic::simulate::SimulateParams;
use facerecon_core::{Params, Reconstruction, VerdictLevel, reconstruct, template};

/// Number of the person in most cases.
const PERSON: u64 = 21;

/// Small photos, with dots 9 px apart as in the large ones.
fn small() -> SimulateParams {
    SimulateParams {
        width_px: 448,
        height_px: 336,
        focal_px: 1613.0,
        dot_mm: 7.7,
        pattern: PatternParams { columns: 50, rows: 38, ..Default::default() },
        ..Default::default()
    }
}

/// The reconstruction of a case, without texture, and the distances of the true dots of the face
/// that both cameras see from its mesh, mm.
fn reconstructed(case: &str) -> (Reconstruction, Distances) {
    let made = hard::hard(case, PERSON, &small()).unwrap();
    let mut params = Params::default();
    params.texture.size = 256; // not looked at
    let found = reconstruct(&made.capture, &template::built_in(), &params, &()).unwrap();
    let index = SurfaceIndex::new(&found.mesh_in(Frame::Camera)).unwrap();
    let seen = made.truth.dots.iter().filter(|d| d.on_face && d.visible == [true; 2]);
    let all: Vec<f64> = seen.map(|d| index.closest(&d.point).unwrap().distance).collect();
    (found, Distances::of(&all).unwrap())
}

#[test]
fn an_over_exposed_face_is_measured() {
    let (found, error) = reconstructed("over_strong");
    assert!(error.median_mm < 0.2, "{error:?}");
    assert_eq!(found.verdict.level, VerdictLevel::Good, "{}", found.verdict);
}

#[test]
fn of_two_people_the_one_that_fills_the_photos_is_reconstructed() {
    let (_, error) = reconstructed("two_left");
    assert!(error.median_mm < 0.2, "{error:?}");
}

#[test]
fn a_blurred_photo_costs_little_and_is_named() {
    let (found, error) = reconstructed("blur_right");
    assert!(error.median_mm < 0.2 && error.p90_mm < 0.7, "{error:?}");
    let text = found.verdict.to_string();
    assert!(text.contains("right photo is less sharp"), "{text}");
}

#[test]
fn a_full_beard_is_measured() {
    let (found, error) = reconstructed("beard");
    assert!(found.warnings.iter().any(|w| w.contains("beard")), "{:?}", found.warnings);
    assert!(found.measured_landmarks.iter().all(|l| l.name != "chin"));
    assert!(error.median_mm < 0.2 && error.p90_mm < 1.0, "{error:?}");
}

#[test]
fn dots_on_dark_glasses_are_not_skin() {
    let (found, error) = reconstructed("glasses_sun");
    // the lenses stand up to 20 mm in front of the skin
    assert!(error.median_mm < 0.6 && error.p99_mm < 5.0, "{error:?}");
    let text = found.verdict.to_string();
    assert!(text.contains("in front of the eye sockets"), "{text}");
}

#[test]
fn a_head_turned_by_25_degrees_is_reconstructed() {
    let (found, error) = reconstructed("turned_left");
    assert!(error.median_mm < 0.2, "{error:?}");
    assert_ne!(found.verdict.level, VerdictLevel::Doubtful, "{}", found.verdict);
}
