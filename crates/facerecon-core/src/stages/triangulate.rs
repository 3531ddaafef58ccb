//! Stage triangulate.
