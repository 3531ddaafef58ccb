//! Writes simulated captures that are hard to reconstruct, each a folder with its truth:
//! `cargo run --release -p facerecon-core --example hard_captures -- FOLDER [SEED [CASE ...]]`

#[path = "../../../tests/support/hard.rs"]
mod hard;

use std::path::PathBuf;

use facerecon_core::synthetic::simulate::{SimulateParams, npy, write_simulated};

#[allow(clippy::print_stdout)] // an example shows its result
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let folder = PathBuf::from(arguments.next().ok_or("expected a folder to write to")?);
    let seed: u64 = arguments.next().map_or(Ok(1), |text| text.parse())?;
    let asked: Vec<String> = arguments.collect();
    for case in hard::CASES.iter().filter(|c| asked.is_empty() || asked.iter().any(|a| a == *c)) {
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
