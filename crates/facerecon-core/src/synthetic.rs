//! Captures with known truth: made-up persons, the pattern to project, the virtual rig, the demo.
//!

pub mod demo;
pub mod pattern;
mod person;
mod random;
pub mod simulate;

pub use person::{Glasses, Person};
