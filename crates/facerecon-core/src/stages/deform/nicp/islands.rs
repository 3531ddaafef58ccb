//! Small pieces of data apart from the rest: an ear's edge, a collar, the wall beside a cheek.
//!
//! Nothing around them says that they are right, so they count only where they agree with the head
//! as the large pieces have bent it.

use std::collections::BTreeMap;

use super::matching::{Found, Point, cell_of};
use crate::math::{Vec3, median};

/// Points per cell of the grid whose touching cells make one piece.
const PER_CELL: f64 = 4.0;
/// Pieces with a smaller share of all points are islands.
const SMALL: f64 = 0.1;
/// An island whose points lie farther from the head than this, in the median, is left out, mm.
const STRAY_MM: f64 = 4.0;

/// Marks the points of the small pieces.
pub(super) fn mark(points: &mut [Point]) {
    let cell = cell_of(points, PER_CELL);
    let key = |p: &Vec3| {
        let k = p.map(|c| (c / cell).floor() as i64);
        [k.x, k.y, k.z]
    };
    let mut members: BTreeMap<[i64; 3], Vec<usize>> = BTreeMap::new();
    for (i, p) in points.iter().enumerate() {
        members.entry(key(&p.at)).or_default().push(i);
    }
    let least = (SMALL * points.len() as f64) as usize;
    let mut island = 0;
    // flood from the first cell that is left, until none is
    while let Some((start, first)) = members.pop_first() {
        let mut open = vec![start];
        let mut piece = first;
        while let Some([x, y, z]) = open.pop() {
            for step in 0..27 {
                let near = [x + step % 3 - 1, y + step / 3 % 3 - 1, z + step / 9 - 1];
                if let Some(more) = members.remove(&near) {
                    piece.extend(more);
                    open.push(near);
                }
            }
        }
        if piece.len() < least {
            piece.iter().for_each(|&i| points[i].island = Some(island));
            island += 1;
        }
    }
}

/// Leaves out the islands that stray.
pub(super) fn forget(found: &mut Vec<Found>) {
    let mut misses: BTreeMap<u32, Vec<f64>> = BTreeMap::new();
    for f in found.iter() {
        if let Some(island) = f.island {
            misses.entry(island).or_default().push((f.data - f.foot).norm());
        }
    }
    let strays = |list: &Vec<f64>| median(list).is_none_or(|m| m > STRAY_MM);
    misses.retain(|_, list| strays(list));
    found.retain(|f| f.island.is_none_or(|island| !misses.contains_key(&island)));
}
