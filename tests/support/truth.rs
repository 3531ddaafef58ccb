//! The ground truth beside a simulated or rendered capture, and the comparison of a result with it.

use std::fs;
use std::path::Path;

use facerecon_core::data::Mesh;
use facerecon_core::evaluate::Distances;
use facerecon_core::io::table::MatchRow;
use facerecon_core::math::{Vec2, Vec3};
use facerecon_core::spatial::SurfaceIndex;

/// Greatest distance of a match from a true dot in the left photo, well below the spacing of the dots.
const SAME_DOT_PX: f64 = 2.0;
/// Greatest distance of its right position from the true one, for a correct match.
const CORRECT_PX: f64 = 2.5;

/// A dot of the pattern on the face, lit and seen by both cameras.
pub struct TrueDot {
    /// Left camera frame, mm.
    pub point: Vec3,
    pub left: Vec2,
    pub right: Vec2,
}

/// Part of the true dots that was matched, and matched correctly.
pub struct Score {
    /// Part of the dots that was matched correctly.
    pub recall: f64,
    /// Part of the matched dots whose match is wrong.
    pub wrong: f64,
}

/// Reads the face dots of `truth_dots.csv`.
pub fn face_dots(folder: &Path) -> Vec<TrueDot> {
    let text = fs::read_to_string(folder.join("truth_dots.csv")).unwrap();
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    let column = |name: &str| header.iter().position(|h| *h == name).unwrap();
    let flags = ["vis_l", "vis_r", "lit", "on_face"].map(column);
    let numbers = ["X", "Y", "Z", "xl", "yl", "xr", "yr"].map(column);
    lines
        .map(|line| line.split(',').collect::<Vec<_>>())
        .filter(|cells| flags.iter().all(|k| cells[*k] == "1"))
        .map(|cells| {
            let [x, y, z, xl, yl, xr, yr] = numbers.map(|k| cells[k].parse::<f64>().unwrap());
            let point = Vec3::new(x, y, z);
            TrueDot { point, left: Vec2::new(xl, yl), right: Vec2::new(xr, yr) }
        })
        .collect()
}

/// Counts correct and wrong matches at the true dots.
pub fn score(dots: &[TrueDot], matches: &[MatchRow]) -> Score {
    let (mut right, mut wrong) = (0, 0);
    for dot in dots {
        let nearest = matches
            .iter()
            .map(|m| ((m.left - dot.left).norm(), m))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        match nearest {
            Some((apart, m)) if apart < SAME_DOT_PX => {
                if (m.right - dot.right).norm() < CORRECT_PX { right += 1 } else { wrong += 1 }
            }
            _ => {}
        }
    }
    let part = |count: i32, of: f64| f64::from(count) / of.max(1.0);
    Score { recall: part(right, dots.len() as f64), wrong: part(wrong, f64::from(right + wrong)) }
}

/// Distances of the true dots from a mesh of the left camera frame, mm.
pub fn distances(dots: &[TrueDot], mesh: &Mesh) -> Distances {
    let index = SurfaceIndex::new(mesh).unwrap();
    let all: Vec<f64> = dots.iter().map(|d| index.closest(&d.point).unwrap().distance).collect();
    Distances::of(&all).unwrap()
}
