//! Files: one format a file. Floor 2.
//!
//! Readers take any bytes and end in bounded time and memory with a right result or an [`IoError`]
//! that says what was found and what to do. Writers write each file whole or not at all.

pub mod atomic;
pub mod calibration;
pub mod capture;
mod error;
pub mod glb;
pub mod image;
pub mod mesh;
pub mod obj;
pub mod ply;
mod source;
pub mod stl;
pub mod table;
mod unit;
pub mod vrml;

pub use calibration::{Calibration, read_calibration, write_calibration};
pub(crate) use capture::unknown_landmark;
pub use capture::{
    CaptureFiles, LoadedCapture, new_capture_toml, read_capture, read_capture_with, write_capture,
};
pub use error::{Fault, IoError};
pub use image::{encode_jpeg, encode_png, read_photo, read_rgb, write_png};
pub use mesh::{LoadedMesh, MeshFormat, read_mesh, write_mesh};
pub(crate) use source::nearest_name;
pub use source::read_text;
pub use table::{MatchRow, read_matches, read_points, write_matches};
pub use unit::LengthUnit;
