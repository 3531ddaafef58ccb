//! Photographs and pictures: PNG, JPEG, GIF.
