//! Stanford PLY.
