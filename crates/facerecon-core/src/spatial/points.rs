//! Nearest neighbours among points. Only this file uses the crate `kiddo`.

use std::num::NonZero;

use kiddo::{ImmutableKdTree, SquaredEuclidean};

use crate::math::{Vec2, Vec3, median};

/// A point of the index, with its distance from the query (not squared).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Neighbour {
    /// Index of the point.
    pub index: usize,
    /// Distance in the unit of the points.
    pub distance: f64,
}

/// A k-d tree over points in `D` dimensions.
pub struct PointIndex<const D: usize> {
    tree: ImmutableKdTree<f64, D>,
    len: usize,
}

impl PointIndex<3> {
    /// An index over points in space; `None` when there are none or a coordinate is not finite.
    pub fn new(points: &[Vec3]) -> Option<Self> {
        Self::from_arrays(&points.iter().map(|p| [p.x, p.y, p.z]).collect::<Vec<_>>())
    }
}

impl PointIndex<2> {
    /// An index over points in the plane; `None` when there are none or a coordinate is not finite.
    pub fn new(points: &[Vec2]) -> Option<Self> {
        Self::from_arrays(&points.iter().map(|p| [p.x, p.y]).collect::<Vec<_>>())
    }
}

/// Median distance from a point to the nearest other one; `None` with fewer than two points or a
/// coordinate that is not finite.
pub fn median_spacing(points: &[Vec2]) -> Option<f64> {
    let index = PointIndex::<2>::new(points)?;
    let nearest: Vec<f64> =
        points.iter().filter_map(|p| index.distance_to_next(&[p.x, p.y])).collect();
    median(&nearest)
}

impl<const D: usize> PointIndex<D> {
    /// Distance from one of the points to the nearest other one; `None` with fewer than two.
    pub fn distance_to_next(&self, point: &[f64; D]) -> Option<f64> {
        self.nearest_n(point, 2).get(1).map(|n| n.distance)
    }

    fn from_arrays(points: &[[f64; D]]) -> Option<Self> {
        if points.is_empty() || !points.iter().flatten().all(|c| c.is_finite()) {
            return None;
        }
        let tree = ImmutableKdTree::new_from_slice(points).ok()?;
        Some(Self { tree, len: points.len() })
    }

    /// The nearest point; `None` when the query is not finite.
    pub fn nearest(&self, query: &[f64; D]) -> Option<Neighbour> {
        if !query.iter().all(|c| c.is_finite()) {
            return None;
        }
        let found = self.tree.query(query).nearest_one::<SquaredEuclidean<f64>>().execute();
        Some(Neighbour { index: found.item as usize, distance: found.distance.sqrt() })
    }

    /// The `count` nearest points, nearest first; equal distances by index.
    pub fn nearest_n(&self, query: &[f64; D], count: usize) -> Vec<Neighbour> {
        let Some(count) = NonZero::new(count.min(self.len)) else {
            return Vec::new();
        };
        if !query.iter().all(|c| c.is_finite()) {
            return Vec::new();
        }
        let found = self.tree.query(query).nearest_n::<SquaredEuclidean<f64>>(count).execute();
        sorted(found.iter().map(|n| (n.item as usize, n.distance)))
    }

    /// All points within a radius (inclusive), nearest first; equal distances by index.
    pub fn within(&self, query: &[f64; D], radius: f64) -> Vec<Neighbour> {
        if !query.iter().all(|c| c.is_finite()) || radius.is_nan() || radius < 0.0 {
            return Vec::new();
        }
        let found =
            self.tree.query(query).within::<SquaredEuclidean<f64>>(radius * radius).execute();
        sorted(found.iter().map(|n| (n.item as usize, n.distance)))
    }
}

fn sorted(found: impl Iterator<Item = (usize, f64)>) -> Vec<Neighbour> {
    let mut list: Vec<_> =
        found.map(|(index, d2)| Neighbour { index, distance: d2.sqrt() }).collect();
    list.sort_by(|a, b| a.distance.total_cmp(&b.distance).then(a.index.cmp(&b.index)));
    list
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points() -> Vec<Vec3> {
        (0..500)
            .map(|i| {
                let t = f64::from(i);
                Vec3::new((t * 12.9898).sin(), (t * 78.233).sin(), (t * 37.719).sin()) * 50.0
            })
            .collect()
    }

    #[test]
    fn agrees_with_an_exhaustive_search() {
        let points = points();
        let index = PointIndex::<3>::new(&points).unwrap();
        for k in 0..50 {
            let q = Vec3::new(f64::from(k) - 25.0, f64::from(k * k % 60) - 30.0, 5.0);
            let mut naive: Vec<_> =
                points.iter().enumerate().map(|(i, p)| ((p - q).norm(), i)).collect();
            naive.sort_by(|a, b| a.0.total_cmp(&b.0));
            let q = [q.x, q.y, q.z];
            assert_eq!(index.nearest(&q).unwrap().index, naive[0].1);
            let seven: Vec<_> = index.nearest_n(&q, 7).iter().map(|n| n.index).collect();
            assert_eq!(seven, naive[..7].iter().map(|n| n.1).collect::<Vec<_>>());
            let near = index.within(&q, 20.0);
            assert_eq!(near.len(), naive.iter().filter(|n| n.0 <= 20.0).count());
        }
    }

    #[test]
    fn identical_points_and_numbers_that_are_not_finite_are_handled() {
        let same = vec![Vec2::new(1.0, 2.0); 200];
        let index = PointIndex::<2>::new(&same).unwrap();
        assert_eq!(index.nearest_n(&[0.0, 0.0], 300).len(), 200);
        assert!(index.nearest(&[f64::NAN, 0.0]).is_none());
        assert!(PointIndex::<2>::new(&[]).is_none());
        assert!(PointIndex::<2>::new(&[Vec2::new(f64::NAN, 0.0)]).is_none());
    }
}
