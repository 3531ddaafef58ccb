//! Stage rectify.
