//! Makes the stored part of the built-in head of `facerecon-core`: lays out vertices on the sculpted
//! head, triangulates them and computes texture coordinates.

mod feature_lines;
mod layout;
mod mesher;
mod unwrap;

use facerecon_core::template::build::{HALF_LANDMARKS, HalfHead, Proportions, Sculpt};
use spade::InsertionError;

pub use layout::Resolution;
use layout::{Layout, VertexKind};

/// About 6,000 vertices.
pub const FINE: Resolution =
    Resolution { scale: 0.885, along: 0.92, all_features: true, candidates: 420 };
/// About 830 vertices.
pub const COARSE: Resolution =
    Resolution { scale: 2.42, along: 2.2, all_features: false, candidates: 160 };

/// The assets: file name and resolution.
pub const ASSETS: [(&str, Resolution); 2] = [("head.bin", FINE), ("head-coarse.bin", COARSE)];

/// Chart angle of the midline, behind the crown, where the texture seam begins, degrees.
const SEAM_DEG: f64 = 108.0;

/// The stored part of the built-in head at a resolution, as bytes. Takes seconds to minutes.
///
/// # Errors
/// [`InsertionError`] if a vertex of the layout has no finite chart position, which means that the
/// proportions of the sculpt are degenerate.
pub fn build(resolution: Resolution) -> Result<Vec<u8>, InsertionError> {
    let sculpt = Sculpt::new(&Proportions::default());
    let layout = Layout::new(&sculpt, resolution);
    let half = mesher::triangulate(&sculpt, layout, resolution.scale)?;
    let points: Vec<_> = half.layout.q.iter().map(|&q| sculpt.point(q)).collect();
    let midline = half.layout.kinds.iter().filter(|k| **k == VertexKind::Midline).count();
    let seam = (0..midline)
        .find(|&i| {
            let q = half.layout.q[i];
            q.x < 0.0 && q.y.atan2(q.x).to_degrees() > SEAM_DEG
        })
        .unwrap_or(midline - 1);
    let uv = unwrap::unwrap(&half, &points, midline, seam);
    let vertex = |name: &str| half.layout.landmarks.iter().find(|l| l.0 == name).map_or(0, |l| l.1);
    let half = HalfHead {
        midline,
        landmarks: HALF_LANDMARKS.iter().map(|n| vertex(n)).collect(),
        // The chart is seen from inside.
        faces: half.faces.iter().map(|&[a, b, c]| [a, c, b]).collect(),
        q: half.layout.q,
        uv,
    };
    Ok(half.encode())
}
