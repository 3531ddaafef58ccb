//! A capture folder and its capture.toml.
