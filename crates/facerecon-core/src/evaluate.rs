//! How far a mesh is from the truth. Floor 5.

mod compare;

pub use compare::{
    Alignment, BothDirections, CompareError, CompareParams, Comparison, Distances, MeshRegion,
    compare,
};
