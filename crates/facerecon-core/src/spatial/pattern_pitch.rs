//! The pitch of the projected pattern, from the points found in a photo.

use std::collections::BTreeSet;

use super::PointIndex;
use crate::math::{Vec2, median, percentile};

/// Points lie along stripes when the gaps along the rows are this many times the distance to the
/// nearest point. In a dot lattice, turned by any angle, both are about the same.
const STRIPE_RATIO: f64 = 1.6;
/// Fraction of the gaps between stripe edges that are not wider than the pitch: stripes have
/// several widths, and few gaps span a missing edge.
const STRIPE_PITCH_QUANTILE: f64 = 0.9;
/// Points searched for the nearest one that is not at the same position.
const NEIGHBOURS: usize = 8;
/// Points closer than this are at the same position, pixels.
const SAME_POSITION_PX: f64 = 1e-9;

/// Distance between neighbouring dots, or between stripes when points lie along stripes: the
/// median distance to the nearest point, or, where the gaps along the rows are far wider, their
/// 90th percentile. `None` for fewer than three points.
pub fn estimate_pitch(points: &[Vec2]) -> Option<f64> {
    let index = (points.len() >= 3).then(|| PointIndex::<2>::new(points)).flatten()?;
    let nearest_distance = |p: &Vec2| {
        let near = index.nearest_n(&[p.x, p.y], NEIGHBOURS);
        near.iter().map(|n| n.distance).find(|d| *d > SAME_POSITION_PX)
    };
    let nearest = median(&points.iter().filter_map(nearest_distance).collect::<Vec<_>>())?;
    let gaps = gaps_along_rows(points, nearest);
    let stripes = median(&gaps).is_some_and(|gap| gap > STRIPE_RATIO * nearest);
    if stripes { percentile(&gaps, STRIPE_PITCH_QUANTILE) } else { Some(nearest) }
}

/// Distances in x from each point to the next in the same row; rows are `height` high.
fn gaps_along_rows(points: &[Vec2], height: f64) -> Vec<f64> {
    let mut by_row: Vec<(i64, f64)> =
        points.iter().map(|p| ((p.y / height).floor() as i64, p.x)).collect();
    by_row.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let pairs = by_row.windows(2).filter(|pair| pair[0].0 == pair[1].0);
    pairs.map(|pair| pair[1].1 - pair[0].1).collect()
}

/// Indices of the first point in each cell of half a pitch: all points of a dot lattice, a part of
/// those along stripes.
pub fn thin_to_pitch(points: &[Vec2], pitch: f64) -> Vec<usize> {
    let cell = |v: f64| (v / (0.5 * pitch)).floor() as i64;
    let mut occupied = BTreeSet::new();
    (0..points.len()).filter(|&i| occupied.insert((cell(points[i].x), cell(points[i].y)))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pitch_of_lattices_and_of_stripes() {
        let position = |i: i32, j: i32, turn: f64| {
            let (x, y) = (9.0 * f64::from(i), 9.0 * f64::from(j));
            Vec2::new(x * turn.cos() - y * turn.sin(), x * turn.sin() + y * turn.cos())
        };
        for turn in [0.0, 0.02, 0.3, 0.785, 1.5] {
            let dots: Vec<Vec2> = (0..400).map(|k| position(k % 20, k / 20, turn)).collect();
            assert!((estimate_pitch(&dots).unwrap() - 9.0).abs() < 1e-9, "turned by {turn}");
        }
        // edges of stripes 8 and 14 px wide, a point every third row
        let edges: Vec<Vec2> = (0..12)
            .flat_map(|k| (0..60).map(move |j| (k, j)))
            .map(|(k, j)| {
                Vec2::new(22.0 * f64::from(k / 2) + 8.0 * f64::from(k % 2), 3.0 * f64::from(j))
            })
            .collect();
        assert!(
            (8.0..=14.0).contains(&estimate_pitch(&edges).unwrap()),
            "{:?}",
            estimate_pitch(&edges)
        );
        assert!(estimate_pitch(&edges[..2]).is_none());
        assert!(thin_to_pitch(&edges, 14.0).len() < edges.len() / 2);
    }

    #[test]
    fn points_at_one_position_have_no_pitch() {
        assert_eq!(estimate_pitch(&[Vec2::new(1.0, 2.0); 20]), None);
    }
}
