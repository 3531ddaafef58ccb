//! Matches: by dot index while they are searched, by position in the result.

use crate::data::Match;

/// Result of the stage.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Correspondence {
    /// In raster order of the left positions; each dot is in at most one match.
    pub matches: Vec<Match>,
}

/// A match by the indices of its dots.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct IndexedMatch {
    pub left: usize,
    pub right: usize,
    /// Confidence, 0 to 1.
    pub score: f64,
}

/// Sorts matches by row, then by column of the left positions.
pub(super) fn sort_in_raster_order(matches: &mut [Match]) {
    matches.sort_by(|a, b| a.left.y.total_cmp(&b.left.y).then(a.left.x.total_cmp(&b.left.x)));
}
