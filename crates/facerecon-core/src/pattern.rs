//! The projector image.
