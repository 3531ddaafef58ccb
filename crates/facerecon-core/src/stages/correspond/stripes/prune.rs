//! Drops matches that differ from those of their stripe, and the background.

use std::collections::BTreeMap;

use crate::camera::RectifiedRig;
use crate::data::Match;
use crate::math::median;

/// Rows above and below whose matches of the same stripe a match is compared with.
const COMPARED_ROWS: i32 = 4;
/// Fewest matches to compare with.
const MIN_COMPARED: usize = 2;
/// Greatest difference of disparity from their median, pixels.
const MAX_DIFFERENCE_PX: f64 = 1.25;
/// Least share of the matches in the cluster of the subject, percent.
const SUBJECT_PERCENT: usize = 15;

/// Drops matches whose disparity differs from the median of the neighbouring rows of their stripe.
pub(super) fn drop_outliers(matches: &mut Vec<Match>) {
    let mut by_stripe: BTreeMap<i32, Vec<(i32, f64)>> = BTreeMap::new();
    for m in matches.iter() {
        if let Some([stripe, row]) = m.lattice {
            by_stripe.entry(stripe).or_default().push((row, m.disparity()));
        }
    }
    matches.retain(|m| {
        let Some([stripe, row]) = m.lattice else {
            return false;
        };
        let around: Vec<f64> = by_stripe
            .get(&stripe)
            .into_iter()
            .flatten()
            .filter(|(r, _)| (r - row).abs() <= COMPARED_ROWS && *r != row)
            .map(|(_, d)| *d)
            .collect();
        around.len() >= MIN_COMPARED
            && median(&around).is_some_and(|d| (m.disparity() - d).abs() < MAX_DIFFERENCE_PX)
    });
}

/// Drops what is not the subject and returns the number of matches dropped. Disparities form
/// clusters separated by empty gaps; the subject is the nearest cluster with at least 15 % of the
/// matches.
pub(super) fn drop_background(
    matches: &mut Vec<Match>,
    width: usize,
    rig: Option<&RectifiedRig>,
    gap: f64,
) -> usize {
    let mut disparities: Vec<f64> = matches.iter().map(Match::disparity).collect();
    disparities.sort_by(|a, b| b.total_cmp(a));
    let count = disparities.len();
    let is_gap = |near: f64, far: f64| match rig {
        Some(rig) => match (rig.depth_mm(near), rig.depth_mm(far)) {
            (Some(a), Some(b)) => b - a > gap * a,
            _ => true,
        },
        None => near - far > gap * width as f64,
    };
    let (mut start, mut subject) = (0, 0..count);
    for end in 1..=count {
        if end == count || is_gap(disparities[end - 1], disparities[end]) {
            if 100 * (end - start) >= SUBJECT_PERCENT * count {
                subject = start..end;
                break;
            }
            start = end;
        }
    }
    let (Some(high), Some(low)) = (
        disparities.get(subject.start).copied(),
        disparities.get(subject.end.saturating_sub(1)).copied(),
    ) else {
        return 0;
    };
    matches.retain(|m| (low..=high).contains(&m.disparity()));
    count - matches.len()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec2;

    fn at(disparity: f64, stripe: i32, row: i32) -> Match {
        Match {
            left: Vec2::new(disparity, f64::from(row)),
            right: Vec2::new(0.0, f64::from(row)),
            lattice: Some([stripe, row]),
            sigma_px: 0.0,
            score: 1.0,
        }
    }

    #[test]
    fn a_row_off_its_stripe_and_a_lone_row_are_dropped() {
        let mut matches: Vec<Match> = (0..10).map(|row| at(30.0, 0, row)).collect();
        matches[4] = at(31.3, 0, 4);
        matches.push(at(30.0, 1, 0));
        drop_outliers(&mut matches);
        assert_eq!(matches.len(), 9);
        assert!(matches.iter().all(|m| m.disparity() == 30.0));
    }

    #[test]
    fn the_nearest_cluster_that_is_large_enough_is_kept() {
        let cluster = |disparity: f64, count: i32| (0..count).map(move |i| at(disparity, i, 0));
        // a few false matches in front, the subject, and a larger wall behind
        let all: Vec<Match> =
            cluster(60.0, 5).chain(cluster(30.0, 40)).chain(cluster(5.0, 80)).collect();
        let mut matches = all.clone();
        assert_eq!(drop_background(&mut matches, 400, None, 0.03), 85);
        assert!(matches.iter().all(|m| m.disparity() == 30.0) && matches.len() == 40);
        let mut matches = all;
        assert_eq!(drop_background(&mut matches, 4000, None, 0.03), 0, "no gap is that wide");
        assert_eq!(drop_background(&mut Vec::new(), 400, None, 0.03), 0);
    }
}
