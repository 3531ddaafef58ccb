//! How far apart the points of a picture's pattern lie.

use std::collections::BTreeSet;

use super::PointIndex;
use crate::math::{Vec2, median, percentile};

/// Gaps along the rows this many times the usual distance to the nearest point tell stripes.
const STRIPES: f64 = 1.6;

/// Distance between neighbouring dots, or between stripes when points lie along stripes: the usual
/// distance to the nearest point, or, where the gaps along the rows are far wider, nine tenths of
/// these (stripes are of many widths). `None` for fewer than three points.
pub fn pitch(points: &[Vec2]) -> Option<f64> {
    let index = (points.len() >= 3).then(|| PointIndex::<2>::new(points)).flatten()?;
    let apart = |p: &Vec2| {
        let near = index.nearest_n(&[p.x, p.y], 8);
        near.iter().map(|n| n.distance).find(|d| *d > 1e-9)
    };
    let nearest = median(&points.iter().filter_map(apart).collect::<Vec<_>>())?;
    let gaps = gaps_along_rows(points, nearest);
    let stripes = median(&gaps).is_some_and(|gap| gap > STRIPES * nearest);
    if stripes { percentile(&gaps, 0.9) } else { Some(nearest) }
}

/// Distances in x from each point to the next in the same row, rows being `height` high.
fn gaps_along_rows(points: &[Vec2], height: f64) -> Vec<f64> {
    let mut placed: Vec<(i64, f64)> =
        points.iter().map(|p| ((p.y / height).floor() as i64, p.x)).collect();
    placed.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let pairs = placed.windows(2).filter(|pair| pair[0].0 == pair[1].0);
    pairs.map(|pair| pair[1].1 - pair[0].1).collect()
}

/// Numbers of points no denser than the pitch needs: the first one of every cell of half a pitch
/// (all of a dot lattice, a part of those along stripes).
pub fn thinned(points: &[Vec2], pitch: f64) -> Vec<usize> {
    let cell = |v: f64| (v / (0.5 * pitch)).floor() as i64;
    let mut taken = BTreeSet::new();
    (0..points.len()).filter(|&i| taken.insert((cell(points[i].x), cell(points[i].y)))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pitch_of_lattices_and_of_stripes() {
        let place = |i: i32, j: i32, turn: f64| {
            let (x, y) = (9.0 * f64::from(i), 9.0 * f64::from(j));
            Vec2::new(x * turn.cos() - y * turn.sin(), x * turn.sin() + y * turn.cos())
        };
        for turn in [0.0, 0.02, 0.3, 0.785, 1.5] {
            let dots: Vec<Vec2> = (0..400).map(|k| place(k % 20, k / 20, turn)).collect();
            assert!((pitch(&dots).unwrap() - 9.0).abs() < 1e-9, "turned by {turn}");
        }
        // edges of stripes 8 and 14 px wide, a point every third row
        let edges: Vec<Vec2> = (0..12)
            .flat_map(|k| (0..60).map(move |j| (k, j)))
            .map(|(k, j)| {
                Vec2::new(22.0 * f64::from(k / 2) + 8.0 * f64::from(k % 2), 3.0 * f64::from(j))
            })
            .collect();
        assert!((8.0..=14.0).contains(&pitch(&edges).unwrap()), "{:?}", pitch(&edges));
        assert!(pitch(&edges[..2]).is_none());
        assert!(thinned(&edges, 14.0).len() < edges.len() / 2);
    }

    #[test]
    fn points_at_one_place_have_no_pitch() {
        assert_eq!(pitch(&[Vec2::new(1.0, 2.0); 20]), None);
    }
}
