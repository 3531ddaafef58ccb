//! Files: one module per format.
//!
//! Readers accept any bytes and end in bounded time and memory with a result or an [`IoError`], which
//! says what was found and what to do. Writers write each file atomically.

pub mod atomic;
pub mod calibration;
pub mod capture;
mod error;
pub(crate) mod glb;
pub mod image;
mod loaded_mesh;
mod mesh;
pub mod obj;
pub mod ply;
mod source;
mod stl;
pub mod table;
mod unit;
mod vrml;

pub use calibration::{Calibration, read_calibration, write_calibration};
pub use capture::{
    CaptureFiles, LoadedCapture, new_capture_toml, read_capture, read_capture_with, write_capture,
};
pub use error::{Fault, IoError};
pub use image::{encode_jpeg, encode_png, read_photo, read_rgb, write_png};
pub use loaded_mesh::LoadedMesh;
pub use mesh::{MeshFormat, read_mesh, write_mesh};
pub use source::read_text;
pub use table::{MatchRow, read_matches, read_points, write_matches};
pub use unit::LengthUnit;
