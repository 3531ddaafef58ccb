//! Pairs of dots, and the shift of the lattice that pairs them: a component of the left photo is a
//! component of the right one, moved by whole columns and rows.

use super::graph::{Cell, Graph};

/// A left dot and a right dot, by index.
pub(super) type DotPair = (usize, usize);

/// Left component, right component, and `right cell - left cell`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct Shift {
    pub left: usize,
    pub right: usize,
    pub cell: Cell,
}

impl Shift {
    /// The shift that pairs two dots; `None` where one has no label.
    pub(super) fn of(graphs: &[Graph; 2], (left, right): &DotPair) -> Option<Self> {
        let (a, b) = (graphs[0].labels[*left]?, graphs[1].labels[*right]?);
        let cell = [b.cell[0] - a.cell[0], b.cell[1] - a.cell[1]];
        Some(Self { left: a.component, right: b.component, cell })
    }

    /// The pairs of free dots that the shift makes from the left dots `members`.
    pub(super) fn pairs(
        &self,
        graphs: &[Graph; 2],
        members: &[usize],
        free: &[Vec<bool>; 2],
    ) -> Vec<DotPair> {
        members
            .iter()
            .filter(|i| free[0][**i])
            .filter_map(|i| {
                let label = graphs[0].labels[*i].filter(|l| l.component == self.left)?;
                let cell = [label.cell[0] + self.cell[0], label.cell[1] + self.cell[1]];
                let j = graphs[1].dot(self.right, cell)?;
                free[1][j].then_some((*i, j))
            })
            .collect()
    }
}

/// The right dot of every paired left dot.
pub(super) struct Partners(Vec<Option<usize>>);

impl Partners {
    /// From pairs of `len` left dots.
    pub(super) fn new(len: usize, pairs: &[DotPair]) -> Self {
        let mut partners = vec![None; len];
        pairs.iter().for_each(|(i, j)| partners[*i] = Some(*j));
        Self(partners)
    }

    /// The right dot of a left dot.
    pub(super) fn of(&self, left: usize) -> Option<usize> {
        self.0[left]
    }
}
