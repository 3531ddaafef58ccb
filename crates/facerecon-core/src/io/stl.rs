//! STL.
