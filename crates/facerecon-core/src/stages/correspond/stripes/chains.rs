//! Edges linked from row to row.

use std::collections::BTreeSet;

use super::edges::Edge;

/// Rows above in which the continuation of an edge is sought: one, or two where an edge is missing.
const ROWS_ABOVE: usize = 2;
/// Greatest shift of an edge between these rows, pixels; narrower than any stripe.
const MAX_SHIFT_PX: f64 = 1.8;
/// Greatest sum of the differences of the colour shares along an edge; pure colours differ by 2.
const MAX_COLOR_CHANGE: f64 = 0.35;

/// The edges of all rows, linked down the photo.
pub(super) struct Chains {
    /// Edges of every row, left to right.
    pub rows: Vec<Vec<Edge>>,
    /// Chain number of every edge.
    pub ids: Vec<Vec<usize>>,
}

impl Chains {
    /// Gives each edge the chain number of the nearest edge of its kind in the rows above, or a new
    /// one.
    pub(super) fn link(rows: Vec<Vec<Edge>>) -> Self {
        let mut ids: Vec<Vec<usize>> = Vec::with_capacity(rows.len());
        let mut next = 0;
        for (n, row) in rows.iter().enumerate() {
            let mut used = BTreeSet::new();
            let mut row_ids = Vec::with_capacity(row.len());
            for edge in row {
                let continued = (1..=ROWS_ABOVE)
                    .filter(|up| n >= *up)
                    .find_map(|up| continued(edge, &rows[n - up], &ids[n - up], &used));
                let id = continued.unwrap_or_else(|| {
                    next += 1;
                    next - 1
                });
                used.insert(id);
                row_ids.push(id);
            }
            ids.push(row_ids);
        }
        Self { rows, ids }
    }

    /// Number of edges.
    pub(super) fn count(&self) -> usize {
        self.rows.iter().map(Vec::len).sum()
    }
}

/// The unused chain of a row above that an edge continues.
fn continued(edge: &Edge, above: &[Edge], ids: &[usize], used: &BTreeSet<usize>) -> Option<usize> {
    let same_kind = |other: &Edge| {
        let change: f64 = (0..3).map(|c| (other.color[c] - edge.color[c]).abs()).sum();
        other.rising == edge.rising && change < MAX_COLOR_CHANGE
    };
    above
        .iter()
        .zip(ids)
        .filter(|(other, _)| same_kind(other))
        .map(|(other, id)| ((other.x - edge.x).abs(), *id))
        .filter(|(distance, id)| *distance < MAX_SHIFT_PX && !used.contains(id))
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, id)| id)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn edge(x: f64, rising: bool) -> Edge {
        Edge { x, rising, color: [1.0, 0.0, 0.0], width: 8.0 }
    }

    #[test]
    fn edges_keep_their_chain_over_one_missing_row() {
        let row = |shift: f64| vec![edge(10.0 + shift, true), edge(18.0 + shift, false)];
        let blue = Edge { color: [0.0, 0.0, 1.0], ..edge(12.0, true) };
        let rows = vec![row(0.0), row(1.0), vec![edge(19.5, false)], row(2.0), vec![blue]];
        let chains = Chains::link(rows);
        assert_eq!(chains.ids, [vec![0, 1], vec![0, 1], vec![1], vec![0, 1], vec![2]]);
        assert_eq!(chains.count(), 8);
    }
}
