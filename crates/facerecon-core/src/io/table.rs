//! CSV tables.
