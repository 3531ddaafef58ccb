//! Software z-buffer renderer. Floor 2.
