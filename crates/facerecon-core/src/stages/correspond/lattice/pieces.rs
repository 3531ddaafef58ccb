//! Pieces of the lattice that no region matched.
//!
//! A wall behind the subject shows a large piece of regular lattice. If its period could not be
//! decided for hundreds of dots, it cannot be decided for those of them beside the subject either.

use super::components::connected_dots;
use super::graph::Graph;

/// For each dot whether it belongs to a piece of at least `min_size` unmatched dots. Pieces are linked
/// by full cells of four: dots of the subject that labels joined to the wall in single file are not
/// part of it.
pub(super) fn in_unmatched_piece(graph: &Graph, is_matched: &[bool], min_size: usize) -> Vec<bool> {
    let free = |i: usize| !is_matched[i] && graph.labels[i].is_some();
    let starts = (0..graph.labels.len()).filter(|i| free(*i));
    let mut in_piece = vec![false; graph.labels.len()];
    for piece in connected_dots(graph, starts, |a, b| free(a) && free(b)) {
        if piece.len() >= min_size {
            piece.into_iter().for_each(|i| in_piece[i] = true);
        }
    }
    in_piece
}

#[cfg(test)]
mod tests {
    use super::super::graph::Label;
    use super::*;
    use crate::math::Vec2;

    /// A lattice of `columns` by `rows` dots, row by row.
    fn lattice(columns: usize, rows: usize) -> Graph {
        let mut graph = Graph::new(columns * rows);
        let basis = [Vec2::new(8.0, 0.0), Vec2::new(0.0, 8.0)];
        for i in 0..columns * rows {
            let cell = [(i % columns) as i32, (i / columns) as i32];
            graph.set_label(i, Label { component: 0, cell }, basis);
        }
        graph
    }

    #[test]
    fn a_wall_beside_matched_dots_is_a_piece() {
        // columns 0 to 3 of 8 are matched; 4 x 5 dots are not
        let graph = lattice(8, 5);
        let matched: Vec<bool> = (0..40).map(|i| i % 8 < 4).collect();
        let expected: Vec<bool> = matched.iter().map(|m| !m).collect();
        assert_eq!(in_unmatched_piece(&graph, &matched, 20), expected);
        assert_eq!(in_unmatched_piece(&graph, &matched, 21), vec![false; 40]);
    }

    #[test]
    fn single_file_and_unlabelled_dots_are_no_part_of_a_piece() {
        // columns 0 to 3 are free, and of column 4 to 7 only the middle row
        let mut graph = lattice(8, 5);
        let matched: Vec<bool> = (0..40).map(|i| i % 8 > 3 && i / 8 != 2).collect();
        graph.clear_label(0);
        let piece = in_unmatched_piece(&graph, &matched, 12);
        let expected: Vec<bool> = (0..40).map(|i| i % 8 < 4 && i != 0).collect();
        assert_eq!(piece, expected);
    }
}
