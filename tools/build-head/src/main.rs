//! Writes the stored part of the built-in heads: `cargo run -p facerecon-build-head [FOLDER]`.
//! Without FOLDER it overwrites `crates/facerecon-core/assets`.

use std::error::Error;
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn Error>> {
    let assets = concat!(env!("CARGO_MANIFEST_DIR"), "/../../crates/facerecon-core/assets");
    let folder = std::env::args_os().nth(1).map_or_else(|| PathBuf::from(assets), PathBuf::from);
    for (file, resolution) in facerecon_build_head::ASSETS {
        let bytes = facerecon_build_head::build(resolution)?;
        std::fs::write(folder.join(file), bytes)?;
    }
    Ok(())
}
