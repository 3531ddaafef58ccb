//! From a capture to a face: the parameters, the stages in order, and the top error.

mod covered;
mod dense;
mod error;
mod inputs;
mod landmarks;
mod matching;
mod measured;
mod numbers;
mod outline;
mod params;
mod photo_check;
mod reconstruct;
mod reconstruction;
mod run;
mod shape;
pub mod single_stage;
mod trial;
mod uncertainty;
mod verdict;

pub use error::Error;
pub use numbers::{FaceDistance, FaceLandmark, FaceSize, LandmarkStatus};
pub use params::{Params, Profile};
pub use reconstruct::reconstruct;
pub use reconstruction::Reconstruction;
pub use trial::check_capture;
pub use verdict::{FaceVerdict, Reason, VerdictFigures, VerdictLevel};
