//! Cameras: pinhole with lens distortion, the stereo rig, rectification.
//!
//! Frames: OpenCV axes (x right, y down, z forward), millimetres; pixel centres at integers.

mod pinhole;
mod rectification;
mod resection;
mod rig;
mod rotation;

pub use pinhole::{Distortion, Pinhole};
pub use rectification::{Rectification, RectifiedRig, View};
pub use resection::{Projection, resect};
pub use rig::{RigError, StereoRig};
pub use rotation::RotationFault;
pub(crate) use rotation::rotation_fault;
