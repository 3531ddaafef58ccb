//! Stage deform.
