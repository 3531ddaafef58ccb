//! Labels the dots of one photo with columns and rows.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::graph::{Graph, Label, STEPS};
use crate::math::Vec2;
use crate::spatial::PointIndex;

/// Nearest neighbours among which the lattice directions of a seed are sought.
const SEED_NEIGHBOURS: usize = 8;
/// Greatest `|a + b| / |a|` of two opposite neighbours `a` and `b` of a seed.
const MAX_UNEVENNESS: f64 = 0.3;
/// Least sine of the angle between both lattice directions of a seed (37 degrees).
const MIN_SINE: f64 = 0.6;
/// Costs are compared as integers, in this fraction of a spacing.
const COST_STEPS: f64 = 1e6;
/// A single prediction must be this much closer than the link error allowed: beyond a silhouette
/// there are chance neighbours.
const SINGLE_PREDICTION: f64 = 0.5;
/// The worst of several predictions may be off by this multiple of the link error allowed.
const WORST_PREDICTION: f64 = 1.5;
/// Share of the new link in the basis along it, against the basis of the neighbour: follows the
/// surface, and averages the noise of the positions.
const NEW_LINK_WEIGHT: f64 = 0.5;
/// Weight of a neighbour's basis across the link, which the link itself does not measure.
const ACROSS_WEIGHT: f64 = 0.25;

/// How the dots are labelled.
pub(super) struct LabelOptions {
    /// Direction of the lattice's rows, radians, clockwise in the image.
    pub rotation: f64,
    /// Largest distance of a dot from its predicted position, in spacings.
    pub max_link_error: f64,
    /// Components of fewer dots lose their labels.
    pub min_component: usize,
}

/// A link that may be followed: cost (`COST_STEPS`), then indices of dot, step and neighbour to break
/// ties.
type Link = Reverse<(u64, usize, usize, usize)>;

struct Labeller<'a> {
    points: &'a [Vec2],
    index: PointIndex<2>,
    options: &'a LabelOptions,
    graph: Graph,
    links: BinaryHeap<Link>,
}

/// Labels the dots by best-first flood fill from the most regular places. Each dot predicts its
/// neighbours from its local basis; a dot is accepted only where the predictions of all labelled
/// dots around it agree, which closes every 4-cycle. Holes are never bridged.
pub(super) fn label_dots(points: &[Vec2], options: &LabelOptions) -> Graph {
    let graph = Graph::new(points.len());
    let Some(index) = PointIndex::<2>::new(points) else {
        return graph;
    };
    let mut labeller = Labeller { points, index, options, graph, links: BinaryHeap::new() };
    let mut seeds: Vec<(u64, usize, [Vec2; 2])> = (0..points.len())
        .filter_map(|i| labeller.seed(i).map(|(cost, basis)| (integer(cost), i, basis)))
        .collect();
    seeds.sort_unstable_by_key(|s| (s.0, s.1));
    let mut component = 0;
    for (_, dot, basis) in seeds {
        if labeller.graph.labels[dot].is_none() {
            let members = labeller.fill(dot, basis, component);
            if members.len() < options.min_component {
                members.into_iter().for_each(|m| labeller.graph.clear_label(m));
            } else {
                component += 1;
            }
        }
    }
    labeller.graph
}

fn integer(cost: f64) -> u64 {
    (cost * COST_STEPS) as u64
}

impl Labeller<'_> {
    /// The basis at a dot between two pairs of opposite neighbours, and how uneven they are.
    fn seed(&self, dot: usize) -> Option<(f64, [Vec2; 2])> {
        let p = self.points[dot];
        let near: Vec<Vec2> = self
            .index
            .nearest_n(&[p.x, p.y], SEED_NEIGHBOURS + 1)
            .iter()
            .filter(|n| n.index != dot && n.distance > 0.0)
            .map(|n| self.points[n.index] - p)
            .collect();
        let opposite = |a: &Vec2| {
            let unevenness = |b: &Vec2| (a + b).norm() / a.norm();
            let best = near.iter().min_by(|b, c| unevenness(b).total_cmp(&unevenness(c)))?;
            (unevenness(best) < MAX_UNEVENNESS).then(|| ((a - best) / 2.0, unevenness(best)))
        };
        let (first, first_cost) = opposite(near.first()?)?;
        let across = |v: &&Vec2| first.perp(v).abs() > MIN_SINE * first.norm() * v.norm();
        let (second, second_cost) = near.iter().filter(across).find_map(opposite)?;
        Some((first_cost + second_cost, self.orient(first, second)))
    }

    /// Orders and signs two lattice directions: `u` along the rows, `v` a quarter turn clockwise.
    fn orient(&self, a: Vec2, b: Vec2) -> [Vec2; 2] {
        let along = Vec2::new(self.options.rotation.cos(), self.options.rotation.sin());
        let cosine = |v: &Vec2| along.dot(v).abs() / v.norm();
        let (u, v) = if cosine(&a) >= cosine(&b) { (a, b) } else { (b, a) };
        let u = if along.dot(&u) < 0.0 { -u } else { u };
        let v = if u.perp(&v) < 0.0 { -v } else { v };
        [u, v]
    }

    /// Fills one component from a seed; returns its members.
    fn fill(&mut self, seed: usize, basis: [Vec2; 2], component: usize) -> Vec<usize> {
        self.links.clear();
        let mut members = vec![seed];
        self.label(seed, Label { component, cell: [0, 0] }, basis);
        while let Some(Reverse((_, from, step, to))) = self.links.pop() {
            let Some(Label { mut cell, .. }) = self.graph.labels[from] else {
                continue;
            };
            let (axis, sign) = STEPS[step];
            cell[axis] += sign;
            if self.graph.dot(component, cell).is_some() || self.graph.labels[to].is_some() {
                continue;
            }
            let label = Label { component, cell };
            let prediction = Prediction::new(self.points, &self.graph, to, label);
            if let Some(basis) = prediction.basis(self.options.max_link_error) {
                members.push(to);
                self.label(to, label, basis);
            }
        }
        members
    }

    /// Labels a dot and adds its links to unlabelled dots.
    fn label(&mut self, dot: usize, label: Label, basis: [Vec2; 2]) {
        self.graph.set_label(dot, label, basis);
        for (step, (axis, sign)) in STEPS.iter().enumerate() {
            if self.graph.neighbour(dot, *axis, *sign).is_some() {
                continue;
            }
            let arm = basis[*axis];
            let at = self.points[dot] + arm * f64::from(*sign);
            let Some(nearest) = self.index.nearest(&[at.x, at.y]) else {
                continue;
            };
            let error = nearest.distance / arm.norm();
            if error < self.options.max_link_error && self.graph.labels[nearest.index].is_none() {
                self.links.push(Reverse((integer(error), dot, step, nearest.index)));
            }
        }
    }
}

/// How well the labelled dots around a cell predict the position of a dot in it.
struct Prediction {
    /// Errors of the best and the worst prediction, in spacings.
    least: f64,
    greatest: f64,
    count: usize,
    /// Weighted sums of the neighbours' bases, and their weights.
    sums: [Vec2; 2],
    weights: [f64; 2],
}

impl Prediction {
    fn new(points: &[Vec2], graph: &Graph, dot: usize, label: Label) -> Self {
        let mut prediction = Self {
            least: f64::INFINITY,
            greatest: 0.0,
            count: 0,
            sums: [Vec2::zeros(); 2],
            weights: [0.0; 2],
        };
        let at = |column: i32, row: i32| {
            graph.dot(label.component, [label.cell[0] + column, label.cell[1] + row])
        };
        prediction.add_neighbours(points, graph, dot, at);
        prediction.add_cycles(points, dot, at);
        prediction
    }

    /// Predictions from the bases of the four neighbours.
    fn add_neighbours(
        &mut self,
        points: &[Vec2],
        graph: &Graph,
        dot: usize,
        at: impl Fn(i32, i32) -> Option<usize>,
    ) {
        let p = points[dot];
        for (axis, sign) in STEPS {
            let (column, row) = if axis == 0 { (-sign, 0) } else { (0, -sign) };
            let Some(n) = at(column, row) else {
                continue;
            };
            let arm = graph.basis[n][axis];
            let error = (points[n] + arm * f64::from(sign) - p).norm() / arm.norm();
            self.least = self.least.min(error);
            self.greatest = self.greatest.max(error);
            self.count += 1;
            let link = (p - points[n]) * f64::from(sign);
            self.sums[axis] += NEW_LINK_WEIGHT * (link + arm);
            self.weights[axis] += 1.0;
            let other = 1 - axis;
            self.sums[other] += ACROSS_WEIGHT * graph.basis[n][other];
            self.weights[other] += ACROSS_WEIGHT;
        }
    }

    /// Predictions from the 4-cycles at the corners of the cell: the fourth corner of a
    /// parallelogram.
    fn add_cycles(&mut self, points: &[Vec2], dot: usize, at: impl Fn(i32, i32) -> Option<usize>) {
        for (column, row) in [(1, 1), (1, -1), (-1, 1), (-1, -1)] {
            if let (Some(a), Some(b), Some(d)) = (at(column, 0), at(0, row), at(column, row)) {
                let expected = points[a] + points[b] - points[d];
                let side = (points[a] - points[d]).norm();
                self.greatest = self.greatest.max((expected - points[dot]).norm() / side.max(1e-9));
                self.count += 1;
            }
        }
    }

    /// The basis of the dot, where the predictions agree that it belongs to the cell.
    fn basis(&self, max_link_error: f64) -> Option<[Vec2; 2]> {
        let factor = if self.count > 1 { 1.0 } else { SINGLE_PREDICTION };
        let agreed = self.count > 0
            && self.least < factor * max_link_error
            && self.greatest < WORST_PREDICTION * max_link_error;
        agreed.then(|| [self.sums[0] / self.weights[0], self.sums[1] / self.weights[1]])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn options(rotation: f64) -> LabelOptions {
        LabelOptions { rotation, max_link_error: 0.3, min_component: 6 }
    }

    /// A rotated lattice that bends, with holes, and the cell of every dot.
    fn bent(rotation: f64) -> (Vec<Vec2>, Vec<[i32; 2]>) {
        let (sin, cos) = rotation.sin_cos();
        let cells = (-10..=10).flat_map(|row| (-12..=12).map(move |column| [column, row]));
        let is_hole = |[column, row]: &[i32; 2]| (3 * column + 5 * row).rem_euclid(17) == 0;
        let cells: Vec<[i32; 2]> = cells.filter(|cell| !is_hole(cell)).collect();
        let point = |[column, row]: &[i32; 2]| {
            let (u, v) = (10.0 * f64::from(*column), 10.0 * f64::from(*row));
            let bend = 0.002 * (u * u + v * v);
            Vec2::new(cos * u - sin * v + bend, sin * u + cos * v)
        };
        (cells.iter().map(point).collect(), cells)
    }

    #[test]
    fn labels_are_the_cells_of_the_lattice_up_to_one_shift() {
        for rotation in [0.0, 0.3, -0.2] {
            let (points, cells) = bent(rotation);
            let graph = label_dots(&points, &options(rotation));
            let shifts: Vec<[i32; 2]> = (0..points.len())
                .filter_map(|i| graph.labels[i].map(|l| (l.cell, cells[i])))
                .map(|(label, cell)| [label[0] - cell[0], label[1] - cell[1]])
                .collect();
            assert_eq!(shifts.len(), points.len(), "{rotation}");
            assert!(shifts.iter().all(|s| *s == shifts[0]), "{rotation}");
            for (i, label) in graph.labels.iter().flatten().enumerate() {
                assert_eq!(graph.dot(label.component, label.cell), Some(i));
            }
        }
    }

    #[test]
    fn components_that_are_too_small_lose_their_labels() {
        let (points, _) = bent(0.0);
        let graph = label_dots(&points, &LabelOptions { min_component: 10_000, ..options(0.0) });
        assert!(graph.labels.iter().all(Option::is_none));
        assert_eq!(graph.dot(0, [0, 0]), None);
        assert!(label_dots(&[], &options(0.0)).labels.is_empty());
    }
}
