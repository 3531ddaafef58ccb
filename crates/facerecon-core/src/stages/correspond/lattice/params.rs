//! Parameters of the lattice method.

use crate::settings::settings;

settings! {
    /// Correspondence by the lattice of the dots (method "lattice").
    pub struct LatticeParams {
        /// Largest distance of a dot from the position its lattice neighbours predict, in spacings.
        max_link_error: f64 = 0.3, range 0.05..=0.5;
        /// Greatest row difference of a match after offset and tilt of the rows are removed, in
        /// spacings; never less than 0.4 px.
        row_tolerance: f64 = 0.08, range 0.005..=0.5;
        /// Least ratio of the costs of the second-best and the best shift of the lattice for the
        /// shift to count as known.
        min_confidence: f64 = 1.3, range 1.0..=100.0;
        /// Fewest matches of a connected component; smaller ones are dropped.
        min_component: usize = 12, range 2.0..=1000.0;
        /// Matches further than this many standard deviations (from the median absolute deviation)
        /// from the plane of their neighbours are dropped.
        outlier_mads: f64 = 4.0, range 1.0..=20.0;
        /// Least depth of a subject; needs a calibrated rig.
        nearest_mm: f64 = 150.0, range 1.0..=1e6, unit "mm";
        /// Greatest depth of a subject; needs a calibrated rig.
        farthest_mm: f64 = 6000.0, range 1.0..=1e7, unit "mm";
        /// Matches further behind the subject than this (a wall), or further in front of it, are
        /// dropped; needs a calibrated rig.
        behind_mm: f64 = 120.0, range 1.0..=1e6, unit "mm";
    }
}
