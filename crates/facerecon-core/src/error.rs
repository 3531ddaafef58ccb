//! The top error.
