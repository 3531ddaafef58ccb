//! Binary glTF.
