//! From a capture to a face: the parameters, the stages in order, and the top error.

mod dense;
mod error;
mod inputs;
mod landmarks;
mod matching;
mod measured;
mod params;
mod photo_check;
mod reconstruct;
mod reconstruction;
mod run;
mod shape;
pub mod single_stage;

pub use error::Error;
pub use params::{Params, Profile};
pub use photo_check::check_capture;
pub use reconstruct::reconstruct;
pub use reconstruction::{FaceSize, Reconstruction};
