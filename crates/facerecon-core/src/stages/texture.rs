//! Stage texture.
