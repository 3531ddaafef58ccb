//! Stage smooth.
