//! Parameters of the scan.

use crate::settings::settings;

settings! {
    /// The scan of the thesis from three marked pairs (section 2.3).
    pub struct ScanParams {
        /// Greatest difference of rows between the dots of a match (thesis: 2).
        row_tolerance_px: f64 = 2.0, range 0.0..=50.0, unit "px";
        /// Greatest difference between the distances to the nearest matched dot in both photos, in
        /// spacings of the pattern along x. At 0.5 the next dot of the row would be as likely.
        distance_tolerance: f64 = 0.4, range 0.01..=2.0;
        /// Greatest distance of a seed from the nearest dot, in spacings.
        seed_tolerance: f64 = 0.6, range 0.0..=10.0;
        /// Greatest distance of a dot from the nearest matched dot to be searched, in spacings of
        /// the pattern along x.
        reach: f64 = 2.5, range 1.0..=100.0;
        /// Size of the search window around the head, an ellipse set by the seeds. The thesis does
        /// not say where the head ends, and the pattern may continue on a wall. 1 holds a head with
        /// its hair; 0 searches the whole photo.
        window: f64 = 1.0, range 0.0..=100.0;
        /// Width of the projected picture over its height. With the columns and rows of the pattern
        /// it gives the spacing along x from the measured spacing.
        picture_aspect: f64 = 1.333_333_333_333_333_3, range 0.1..=10.0;
    }
}
