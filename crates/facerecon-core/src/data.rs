//! Data that stages exchange: rasters, dots and matches, clouds, meshes, captures.

mod anthropometry;
mod blocks;
pub(crate) mod blur;
mod capture;
mod cloud;
pub(crate) mod distance;
mod landmarks;
mod matches;
mod mesh;
mod outline;
mod raster;
pub(crate) mod regions;
pub(crate) mod sampling;
#[cfg(test)]
pub(crate) mod test_meshes;
mod topology;
mod validation;

pub use anthropometry::{DISTANCES, DistanceTerm, LANDMARK_TERMS, LandmarkTerm, PictureSide};
pub use capture::{Capture, ExtraPhoto, Pattern, PatternKind, Photo, Seeds};
pub use cloud::{Cloud, CloudFrame};
pub(crate) use landmarks::unknown_landmark;
pub use landmarks::{
    LANDMARKS, LandmarkPairs, LandmarkSource, Landmarks, MARKED_LANDMARK_SIGMA_MM, MeasuredLandmark,
};
pub use matches::{Dot, Match, Pair};
pub use mesh::{Mesh, MeshError};
pub use outline::Outline;
pub use raster::{Gray, Raster, Rgb};
pub use topology::Topology;
pub use validation::{CaptureError, PhotoRole};
