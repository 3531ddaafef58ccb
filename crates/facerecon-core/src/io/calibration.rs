//! OpenCV FileStorage calibrations.
