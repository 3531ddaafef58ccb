//! All parameters in one struct; profiles; TOML.
