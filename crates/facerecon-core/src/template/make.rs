//! Makes the stored part of the built-in heads anew.

use super::asset::{HalfHead, LANDMARKS};
use super::layout::{Fineness, Hold, Layout};
use super::mesher::triangulate;
use super::sculpt::Sculpt;
use super::unwrap::unwrap;

/// About 6,000 vertices.
pub(crate) const FINE: Fineness =
    Fineness { scale: 0.885, along: 0.92, all_features: true, candidates: 420 };
/// About 830 vertices.
pub(crate) const COARSE: Fineness =
    Fineness { scale: 2.42, along: 2.2, all_features: false, candidates: 160 };

/// Angle of the midline, past the crown, where the seam begins, in degrees.
const SEAM_DEG: f64 = 108.0;

pub(crate) fn make(sculpt: &Sculpt, fineness: Fineness) -> HalfHead {
    let half = triangulate(sculpt, Layout::new(sculpt, fineness), fineness.scale);
    let points: Vec<_> = half.layout.q.iter().map(|&q| sculpt.point(q)).collect();
    let midline = half.layout.hold.iter().filter(|h| **h == Hold::Midline).count();
    let seam = (0..midline)
        .find(|&i| {
            let q = half.layout.q[i];
            q.x < 0.0 && q.y.atan2(q.x).to_degrees() > SEAM_DEG
        })
        .unwrap_or(midline - 1);
    let uv = unwrap(&half, &points, midline, seam);
    let find = |name: &str| half.layout.landmarks.iter().find(|l| l.0 == name).map_or(0, |l| l.1);
    HalfHead {
        midline,
        landmarks: LANDMARKS.iter().map(|n| find(n)).collect(),
        // The chart is seen from inside.
        faces: half.faces.iter().map(|&[a, b, c]| [a, c, b]).collect(),
        q: half.layout.q,
        uv,
    }
}

/// The bytes that [`HalfHead::decode`] reads.
pub(crate) fn encode(half: &HalfHead) -> Vec<u8> {
    let mut out = Vec::new();
    for n in [half.q.len(), half.midline, half.faces.len()] {
        out.extend((n as u16).to_le_bytes());
    }
    for q in &half.q {
        out.extend((q.x as f32).to_le_bytes());
        out.extend((q.y as f32).to_le_bytes());
    }
    for c in half.uv.iter().flatten() {
        out.extend((*c as f32).to_le_bytes());
    }
    for i in half.faces.iter().flatten() {
        out.extend((*i as u16).to_le_bytes());
    }
    for l in &half.landmarks {
        out.extend((*l as u16).to_le_bytes());
    }
    out
}
