//! How far a mesh is from the truth.

mod compare;

pub use compare::{
    Alignment, BothDirections, CompareError, CompareParams, Comparison, Distances, MeshRegion,
    compare,
};
