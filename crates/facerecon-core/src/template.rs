//! The built-in head and presets for known templates. Floor 2.
