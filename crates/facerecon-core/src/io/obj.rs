//! Wavefront OBJ with MTL and texture.
