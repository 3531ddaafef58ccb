//! The lattice of one photo: every dot gets an integer column and row.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};

use crate::math::Vec2;
use crate::spatial::PointIndex;

/// Place of a dot in its component, `[column, row]`.
pub(super) type Cell = [i32; 2];

/// A dot's label.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Label {
    pub component: usize,
    pub cell: Cell,
}

/// The labelled dots of one photo.
pub(super) struct Graph {
    /// By dot; `None` for dots in no component.
    pub labels: Vec<Option<Label>>,
    /// Dots by label; only ever looked up, never walked through.
    places: HashMap<(usize, Cell), usize>,
    /// Local lattice basis `(u, v)` by dot, pixels; zero without a label.
    pub basis: Vec<[Vec2; 2]>,
}

impl Graph {
    /// The dot with a label.
    pub(super) fn dot(&self, component: usize, cell: Cell) -> Option<usize> {
        self.places.get(&(component, cell)).copied()
    }

    /// The labelled dots next to a dot in the lattice: right, left, below, above.
    pub(super) fn neighbours(&self, dot: usize) -> impl Iterator<Item = usize> + '_ {
        STEPS.iter().filter_map(move |(axis, sign)| self.beside(dot, *axis, *sign))
    }

    /// The labelled dot one step along an axis (0: right, 1: below).
    pub(super) fn beside(&self, dot: usize, axis: usize, sign: i32) -> Option<usize> {
        let Label { component, mut cell } = self.labels[dot]?;
        cell[axis] += sign;
        self.dot(component, cell)
    }
}

/// Right, left, below, above: axis and sign.
pub(super) const STEPS: [(usize, i32); 4] = [(0, 1), (0, -1), (1, 1), (1, -1)];

/// How the lattice is grown.
pub(super) struct Growth {
    /// Direction of the lattice's rows, radians, clockwise as seen.
    pub rotation: f64,
    /// Largest distance of a dot from its predicted place, in spacings.
    pub max_link_error: f64,
    /// Components of fewer dots lose their labels.
    pub min_component: usize,
}

/// A link waiting to be followed: cost (millionths of a spacing), then indices to break ties.
type Link = Reverse<(u64, usize, usize, usize)>;

struct Grower<'a> {
    points: &'a [Vec2],
    index: PointIndex<2>,
    growth: &'a Growth,
    graph: Graph,
    heap: BinaryHeap<Link>,
}

/// Labels the dots by best-first flood fill from the most regular places: each dot predicts its
/// neighbours from the local basis, and a dot is taken only where all labelled dots around it
/// agree, which closes every 4-cycle. Holes are never bridged.
pub(super) fn grow(points: &[Vec2], growth: &Growth) -> Graph {
    let graph = Graph {
        labels: vec![None; points.len()],
        places: HashMap::new(),
        basis: vec![[Vec2::zeros(); 2]; points.len()],
    };
    let Some(index) = PointIndex::<2>::new(points) else {
        return graph;
    };
    let mut grower = Grower { points, index, growth, graph, heap: BinaryHeap::new() };
    let mut seeds: Vec<(u64, usize, [Vec2; 2])> = (0..points.len())
        .filter_map(|i| grower.seed(i).map(|(cost, basis)| ((cost * 1e6) as u64, i, basis)))
        .collect();
    seeds.sort_unstable_by_key(|s| (s.0, s.1));
    let mut component = 0;
    for (_, dot, basis) in seeds {
        if grower.graph.labels[dot].is_none() {
            let members = grower.fill(dot, basis, component);
            if members.len() < growth.min_component {
                for m in members {
                    if let Some(label) = grower.graph.labels[m].take() {
                        grower.graph.places.remove(&(label.component, label.cell));
                    }
                }
            } else {
                component += 1;
            }
        }
    }
    grower.graph
}

impl Grower<'_> {
    /// The basis at a dot between two pairs of opposite neighbours, and how uneven they are.
    fn seed(&self, dot: usize) -> Option<(f64, [Vec2; 2])> {
        let p = self.points[dot];
        let near: Vec<Vec2> = self
            .index
            .nearest_n(&[p.x, p.y], 9)
            .iter()
            .filter(|n| n.index != dot && n.distance > 0.0)
            .map(|n| self.points[n.index] - p)
            .collect();
        let opposite = |a: &Vec2| {
            let uneven = |b: &Vec2| (a + b).norm() / a.norm();
            let best = near.iter().min_by(|b, c| uneven(b).total_cmp(&uneven(c)))?;
            (uneven(best) < 0.3).then(|| ((a - best) / 2.0, uneven(best)))
        };
        let (first, cost_first) = opposite(near.first()?)?;
        let across = |v: &&Vec2| first.perp(v).abs() > 0.6 * first.norm() * v.norm();
        let (second, cost_second) = near.iter().filter(across).find_map(opposite)?;
        Some((cost_first + cost_second, self.orient(first, second)))
    }

    /// Orders and signs two lattice directions: `u` along the rows, `v` a quarter turn clockwise.
    fn orient(&self, a: Vec2, b: Vec2) -> [Vec2; 2] {
        let along = Vec2::new(self.growth.rotation.cos(), self.growth.rotation.sin());
        let lean = |v: &Vec2| along.dot(v).abs() / v.norm();
        let (u, v) = if lean(&a) >= lean(&b) { (a, b) } else { (b, a) };
        let u = if along.dot(&u) < 0.0 { -u } else { u };
        let v = if u.perp(&v) < 0.0 { -v } else { v };
        [u, v]
    }

    /// Fills one component from a seed; returns its members.
    fn fill(&mut self, seed: usize, basis: [Vec2; 2], component: usize) -> Vec<usize> {
        self.heap.clear();
        let mut members = vec![seed];
        self.label(seed, Label { component, cell: [0, 0] }, basis);
        while let Some(Reverse((_, from, step, to))) = self.heap.pop() {
            let Some(Label { mut cell, .. }) = self.graph.labels[from] else {
                continue;
            };
            let (axis, sign) = STEPS[step];
            cell[axis] += sign;
            let taken = self.graph.places.contains_key(&(component, cell));
            if taken || self.graph.labels[to].is_some() {
                continue;
            }
            if let Some(basis) = self.agreed(to, Label { component, cell }) {
                members.push(to);
                self.label(to, Label { component, cell }, basis);
            }
        }
        members
    }

    fn label(&mut self, dot: usize, label: Label, basis: [Vec2; 2]) {
        self.graph.labels[dot] = Some(label);
        self.graph.places.insert((label.component, label.cell), dot);
        self.graph.basis[dot] = basis;
        for (step, (axis, sign)) in STEPS.iter().enumerate() {
            let mut cell = label.cell;
            cell[*axis] += sign;
            if self.graph.places.contains_key(&(label.component, cell)) {
                continue;
            }
            let arm = basis[*axis];
            let at = self.points[dot] + arm * f64::from(*sign);
            let Some(found) = self.index.nearest(&[at.x, at.y]) else {
                continue;
            };
            let error = found.distance / arm.norm();
            if error < self.growth.max_link_error && self.graph.labels[found.index].is_none() {
                self.heap.push(Reverse(((error * 1e6) as u64, dot, step, found.index)));
            }
        }
    }

    /// Whether all labelled dots around a place agree that `dot` belongs there; gives its basis.
    fn agreed(&self, dot: usize, label: Label) -> Option<[Vec2; 2]> {
        let p = self.points[dot];
        let at = |dc: i32, dr: i32| {
            self.graph.dot(label.component, [label.cell[0] + dc, label.cell[1] + dr])
        };
        let (mut least, mut greatest, mut voters) = (f64::INFINITY, 0.0_f64, 0);
        let mut sums = [Vec2::zeros(); 2];
        let mut counts = [0.0; 2];
        for (axis, sign) in STEPS {
            let (dc, dr) = if axis == 0 { (-sign, 0) } else { (0, -sign) };
            let Some(n) = at(dc, dr) else {
                continue;
            };
            let arm = self.graph.basis[n][axis];
            let error = (self.points[n] + arm * f64::from(sign) - p).norm() / arm.norm();
            least = least.min(error);
            greatest = greatest.max(error);
            voters += 1;
            // The new basis follows the surface: half the link just made, half what was known.
            let made = (p - self.points[n]) * f64::from(sign);
            sums[axis] += 0.5 * (made + arm);
            counts[axis] += 1.0;
            let other = 1 - axis;
            sums[other] += 0.25 * self.graph.basis[n][other];
            counts[other] += 0.25;
        }
        // The 4-cycles at the corners.
        for (dc, dr) in [(1, 1), (1, -1), (-1, 1), (-1, -1)] {
            if let (Some(a), Some(b), Some(d)) = (at(dc, 0), at(0, dr), at(dc, dr)) {
                let expected = self.points[a] + self.points[b] - self.points[d];
                let side = (self.points[a] - self.points[d]).norm();
                greatest = greatest.max((expected - p).norm() / side.max(1e-9));
                voters += 1;
            }
        }
        // One voter alone must be sure: silhouettes offer chance neighbours.
        let limit = self.growth.max_link_error;
        let sure = if voters > 1 { limit } else { 0.5 * limit };
        let agreed = voters > 0 && least < sure && greatest < 1.5 * limit;
        agreed.then(|| [sums[0] / counts[0], sums[1] / counts[1]])
    }
}
