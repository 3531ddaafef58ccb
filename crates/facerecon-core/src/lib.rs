//! facerecon: textured 3D face meshes from two stereo photographs under a projected pattern.
//!
//! The method, in the order of the stages:
//! 1. rectify: turn both photos so that rows are level,
//! 2. filter, detect: find the projected dots,
//! 3. correspond: say which dot of the left photo is which of the right,
//! 4. refine: measure disparity by image matching, at the dots and between them,
//! 5. triangulate: disparity to points in space,
//! 6. register: bring the points to the generic head,
//! 7. deform, smooth: bend the generic head to the points,
//! 8. texture: colour it from the photos without the pattern.

pub mod camera;
pub mod data;
pub mod evaluate;
pub mod io;
pub mod math;
pub mod observer;
pub mod output;
pub mod pipeline;
pub mod render;
pub mod settings;
pub mod spatial;
pub mod stages;
pub mod synthetic;
pub mod template;
