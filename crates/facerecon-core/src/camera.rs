//! Cameras: pinhole with lens distortion, the stereo rig, rectification. Floor 0.
//!
//! Frames: OpenCV axes (x right, y down, z forward), millimetres; pixel centres at integers.

mod pinhole;
mod rectification;
mod rig;

pub use pinhole::{Distortion, Pinhole};
pub use rectification::{Rectification, RectifiedRig, View};
pub use rig::{RigError, StereoRig};
