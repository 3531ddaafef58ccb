//! The stored part of the built-in heads is what the tool makes.
#![allow(clippy::unwrap_used)] // helpers of tests may stop a test

use facerecon_build_head::{ASSETS, build};
use std::path::Path;

fn assert_stored(index: usize) {
    let (file, resolution) = ASSETS[index];
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../crates/facerecon-core/assets");
    let stored = std::fs::read(assets.join(file)).unwrap();
    let made = build(resolution).unwrap();
    let differing = stored.iter().zip(&made).filter(|(a, b)| a != b).count();
    assert!(
        stored == made,
        "{file}: {} bytes stored, {} made, {differing} differ; \
         `cargo run -p facerecon-build-head` writes it again",
        stored.len(),
        made.len(),
    );
}

#[test]
fn the_fine_head_is_what_the_tool_makes() {
    assert_stored(0);
}

#[test]
fn the_coarse_head_is_what_the_tool_makes() {
    assert_stored(1);
}
