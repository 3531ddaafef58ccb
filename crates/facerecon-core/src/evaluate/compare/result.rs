//! Statistics of distances, and the result of a comparison.

use serde::Serialize;

use crate::math::{Similarity, percentile};

/// Statistics of distances, mm.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Distances {
    /// Median.
    pub median_mm: f64,
    /// Mean.
    pub mean_mm: f64,
    /// Root mean square.
    pub rms_mm: f64,
    /// 90th percentile.
    pub p90_mm: f64,
    /// 99th percentile.
    pub p99_mm: f64,
    /// Maximum.
    pub max_mm: f64,
    /// Fraction of the points within 1 mm.
    pub within_1mm: f64,
    /// Points measured.
    pub points: usize,
}

impl Distances {
    /// Statistics of a list; `None` if it is empty.
    ///
    /// ```
    /// let d = facerecon_core::evaluate::Distances::of(&[0.5, 1.5, 0.25]).unwrap();
    /// assert_eq!((d.median_mm, d.max_mm, d.points), (0.5, 1.5, 3));
    /// ```
    pub fn of(distances: &[f64]) -> Option<Self> {
        let n = distances.len() as f64;
        let at = |q| percentile(distances, q);
        Some(Self {
            median_mm: at(0.5)?,
            mean_mm: distances.iter().sum::<f64>() / n,
            rms_mm: (distances.iter().map(|d| d * d).sum::<f64>() / n).sqrt(),
            p90_mm: at(0.9)?,
            p99_mm: at(0.99)?,
            max_mm: at(1.0)?,
            within_1mm: distances.iter().filter(|d| **d <= 1.0).count() as f64 / n,
            points: distances.len(),
        })
    }
}

/// Distances in both directions.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BothDirections {
    /// From points of the first surface to the second.
    pub first_to_second: Distances,
    /// From points of the second surface to the first.
    pub second_to_first: Distances,
}

/// The result of a comparison.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// In the frames of the meshes as given.
    pub before: BothDirections,
    /// After the alignment; absent without alignment.
    pub after: Option<BothDirections>,
    /// The alignment: frame of the second mesh from that of the first.
    #[serde(serialize_with = "rows")]
    pub second_from_first: Similarity,
    /// Scale factor of the alignment (1 unless the scale may change).
    pub scale: f64,
    /// Rotation angle of the alignment, degrees.
    pub rotation_deg: f64,
    /// Iterations of the alignment.
    pub iterations: usize,
    /// Distance of each vertex of the first mesh from the second, after the alignment, mm; for heat
    /// maps. NaN above `reach_mm`.
    #[serde(skip)]
    pub vertex_distances: Vec<f64>,
}

fn rows<S: serde::Serializer>(value: &Similarity, serializer: S) -> Result<S::Ok, S::Error> {
    value.to_rows().serialize(serializer)
}
