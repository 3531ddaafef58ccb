//! Writes simulated captures that are hard to reconstruct, each a folder with its truth:
//! `cargo run --release -p facerecon-core --example hard_captures -- FOLDER [SEED [CASE ...]]`

#[path = "../../../tests/support/hard.rs"]
mod hard;

use std::path::PathBuf;

use facerecon_core::synthetic::simulate::{SimulateParams, npy, write_simulated};

/// Names of all cases.
const CASES: [&str; 20] = [
    "scatter",
    "scatter_strong",
    "beard",
    "beard_dark",
    "wide_left",
    "wide_right",
    "two_right",
    "two_left",
    "two_beside",
    "two_small",
    "glasses_clear",
    "glasses_dark",
    "glasses_dots",
    "glasses_sun",
    "turned_right",
    "turned_left",
    "blur_right",
    "blur_right_strong",
    "over",
    "over_strong",
];

#[allow(clippy::print_stdout)] // an example shows its result
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let folder = PathBuf::from(arguments.next().ok_or("expected a folder to write to")?);
    let seed: u64 = arguments.next().map_or(Ok(1), |text| text.parse())?;
    let asked: Vec<String> = arguments.collect();
    for case in CASES.iter().filter(|c| asked.is_empty() || asked.iter().any(|a| a == *c)) {
        let made = hard::hard(case, seed, &SimulateParams::default())?;
        let place = folder.join(case);
        write_simulated(&place, &made)?;
        // 1 where the left photo shows the face
        let face = made.truth.face.map(|inside| f32::from(u8::from(inside)));
        std::fs::write(place.join("truth_face.npy"), npy(&face))?;
        println!("{}", place.display());
    }
    Ok(())
}
