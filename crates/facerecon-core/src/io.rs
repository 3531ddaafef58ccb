//! Files: one format a file. Floor 2.

pub mod atomic;
pub mod calibration;
pub mod capture;
pub mod glb;
pub mod image;
pub mod obj;
pub mod ply;
pub mod stl;
pub mod table;
pub mod vrml;
