//! facerecon: textured 3D face meshes from two stereo photographs under a projected pattern.
//!
//! The method, in the order of the stages:
//! 1. rectify: warp both photos so that matching points lie on the same row; check the photos,
//! 2. filter, detect: find the projected dots,
//! 3. correspond: match the dots of the left photo with those of the right,
//! 4. cameras: estimate the cameras from the pattern, where there is no calibration,
//! 5. refine: measure the disparity by image matching, at the dots and between them; outline: find where
//!    the plain photos show the subject,
//! 6. triangulate: disparity to points in space,
//! 7. landmarks: find eyes, nose, mouth and chin on the surface and in the photos,
//! 8. register: align the points with the template, a generic head, by the landmarks,
//! 9. deform, smooth: deform the template to the points (or surface: mesh the points themselves),
//! 10. texture: colour the mesh from the photos without the pattern.
//!
//! [`reconstruct`] runs them all. It takes a [`data::Capture`] (read by
//! [`io::capture::read_capture`], or built from arrays), a template ([`template::built_in`]), the
//! [`Params`] and an [`observer::Observer`], for which `()` observes nothing. Each stage is also a
//! function of its own in [`stages`]; [`output::write_result`] writes a result folder.
//!
//! # Example
//! A simulated capture, its reconstruction, and the error against the truth of the simulation
//! (`examples/reconstruct.rs` reads a capture from disk):
//!
//! ```
//! use facerecon_core::synthetic::demo::demo;
//! use facerecon_core::Params;
//!
//! let made = demo(1, &Params::default(), &())?;
//! let face = &made.reconstruction;
//! assert!(face.metric && face.texture.is_some());
//! println!(
//!     "{} matches, {} vertices, median error {:.3} mm",
//!     face.matches.len(),
//!     face.mesh.vertices.len(),
//!     made.error.median_mm
//! );
//! assert!(made.error.median_mm < 0.2);
//! # Ok::<(), facerecon_core::Error>(())
//! ```
//!
//! Frames and units: pixel centres at integers; camera frame x right, y down, z forward; model
//! frame x right, y up, z toward the viewer; millimetres where [`Reconstruction::metric`] is true,
//! else units of the template. Transforms are named `target_from_source`.

pub mod camera;
pub mod data;
pub mod evaluate;
pub mod io;
pub mod math;
pub mod observer;
pub mod output;
mod pipeline;
pub mod render;
pub mod settings;
pub mod spatial;
pub mod stages;
pub mod synthetic;
pub mod template;

pub use pipeline::{
    Error, FaceDistance, FaceLandmark, FaceSize, FaceVerdict, LandmarkStatus, Params, Profile,
    Reason, Reconstruction, VerdictFigures, VerdictLevel, check_capture, reconstruct, single_stage,
};
