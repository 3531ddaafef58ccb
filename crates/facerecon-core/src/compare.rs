//! Distances between meshes.
