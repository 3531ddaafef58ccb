//! Stage filter.
