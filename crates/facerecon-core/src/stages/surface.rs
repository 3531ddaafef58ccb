//! Stage surface.
