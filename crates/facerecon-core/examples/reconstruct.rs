//! Reads a capture folder, reconstructs the face and writes the result folder:
//! `cargo run --release -p facerecon-core --example reconstruct -- CAPTURE RESULT`

use std::path::PathBuf;

use facerecon_core::io::capture::read_capture;
use facerecon_core::output::{Recorder, write_result};
use facerecon_core::render::Frame;
use facerecon_core::{Params, reconstruct, template};

#[allow(clippy::print_stdout)] // an example shows its result
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args_os().skip(1).map(PathBuf::from);
    let (Some(capture), Some(result)) = (arguments.next(), arguments.next()) else {
        return Err("expected two arguments: CAPTURE RESULT".into());
    };
    let loaded = read_capture(&capture)?;
    let params = Params::profile("precise")?;
    // keeps the pictures of the stages for the report
    let recorder = Recorder::default();
    let face = reconstruct(&loaded.capture, &template::built_in(), &params, &recorder)?;
    write_result(&result, &loaded.capture, &face, &recorder.take(), Frame::Model, false)?;

    println!("{} matches, {} vertices", face.matches.len(), face.mesh.vertices.len());
    for distance in face.face_distances().iter().filter(|d| d.is_measured) {
        let (mm, sigma) = (distance.value_mm, distance.sigma_mm);
        println!("{}: {mm:.1} mm, standard deviation {sigma:.1} mm", distance.term.term);
    }
    println!("{}", face.verdict);
    for warning in loaded.warnings.iter().chain(&face.warnings) {
        println!("warning: {warning}");
    }
    Ok(())
}
