//! Stage refine.
