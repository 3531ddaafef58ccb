//! The lattice of one photo: dots with integer column and row labels.

use std::collections::HashMap;

use crate::math::Vec2;

/// Column and row of a dot in its component.
pub(super) type Cell = [i32; 2];

/// Label of a dot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Label {
    pub component: usize,
    pub cell: Cell,
}

/// Steps to the right, left, lower and upper neighbour: axis and sign.
pub(super) const STEPS: [(usize, i32); 4] = [(0, 1), (0, -1), (1, 1), (1, -1)];

/// The labelled dots of one photo.
pub(super) struct Graph {
    /// By dot; `None` for dots in no component.
    pub labels: Vec<Option<Label>>,
    /// Local lattice basis `(u, v)` by dot, pixels; zero without a label.
    pub basis: Vec<[Vec2; 2]>,
    /// Dots by label. Never iterated, so its order does not matter.
    dots: HashMap<(usize, Cell), usize>,
}

impl Graph {
    /// A graph of `len` dots without labels.
    pub(super) fn new(len: usize) -> Self {
        Self { labels: vec![None; len], basis: vec![[Vec2::zeros(); 2]; len], dots: HashMap::new() }
    }

    /// Labels a dot.
    pub(super) fn set_label(&mut self, dot: usize, label: Label, basis: [Vec2; 2]) {
        self.labels[dot] = Some(label);
        self.dots.insert((label.component, label.cell), dot);
        self.basis[dot] = basis;
    }

    /// Removes the label of a dot.
    pub(super) fn clear_label(&mut self, dot: usize) {
        if let Some(label) = self.labels[dot].take() {
            self.dots.remove(&(label.component, label.cell));
        }
    }

    /// The dot with a label.
    pub(super) fn dot(&self, component: usize, cell: Cell) -> Option<usize> {
        self.dots.get(&(component, cell)).copied()
    }

    /// The labelled neighbours of a dot: right, left, below, above.
    pub(super) fn neighbours(&self, dot: usize) -> impl Iterator<Item = usize> + '_ {
        STEPS.iter().filter_map(move |(axis, sign)| self.neighbour(dot, *axis, *sign))
    }

    /// The labelled dot one step along an axis (0: columns, 1: rows).
    pub(super) fn neighbour(&self, dot: usize, axis: usize, sign: i32) -> Option<usize> {
        let Label { component, mut cell } = self.labels[dot]?;
        cell[axis] += sign;
        self.dot(component, cell)
    }
}
