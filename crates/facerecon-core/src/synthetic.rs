//! Captures with known truth: the pattern to project, the virtual rig, the demo.

pub mod demo;
pub mod pattern;
pub mod simulate;
