//! Distances between meshes, as they lie and after the best alignment. Floor 4.

mod align;
mod samples;

#[cfg(test)]
mod tests;

pub use samples::{Sample, sample_surface};

use rayon::prelude::*;
use serde::Serialize;

use crate::data::{Mesh, MeshError};
use crate::math::{Similarity, Vec3, percentile};
use crate::observer::{Cancelled, Observer};
use crate::settings::{SettingsError, Value};
use crate::spatial::SurfaceIndex;
use crate::{choices, settings};

choices! {
    /// What may be changed to bring the first mesh to the second.
    pub enum Alignment {
        /// Nothing: both lie in one frame.
        None = "none",
        /// Turn and shift.
        Rigid = "rigid",
        /// Turn, shift and size.
        Similarity = "similarity",
    }
}

settings! {
    /// Comparison of two meshes.
    pub struct CompareParams {
        /// What may be changed to bring the first mesh to the second.
        alignment: Alignment = Alignment::Rigid;
        /// Points taken on each surface, spread evenly over its area.
        samples: usize = 20000, range 100.0..=2000000.0;
        /// Part of the points that takes part in the alignment, nearest first: the rest may have no
        /// counterpart (a face against a whole head).
        keep: f64 = 0.9, range 0.1..=1.0;
        /// Most iterations of the alignment.
        iterations: usize = 80, range 1.0..=1000.0;
        /// Distances above this are left out, as parts that only one mesh has (with an alignment:
        /// after it).
        reach_mm: Option<f64> = None, range 0.0..=1e6, unit "mm";
    }
}

/// Meshes that cannot be compared.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CompareError {
    /// A mesh that is not one.
    #[error("the {which} mesh cannot be compared: {cause}")]
    Mesh {
        /// `first` or `second`.
        which: &'static str,
        /// What is wrong with it.
        cause: MeshError,
    },
    /// A region without any face, or a mask of the wrong length.
    #[error(
        "the region of the {which} mesh leaves no face to compare (its mask has {got} entries for {expected} vertices)"
    )]
    Region {
        /// `first` or `second`.
        which: &'static str,
        /// Entries of the mask.
        got: usize,
        /// Vertices of the mesh.
        expected: usize,
    },
    /// No point within reach.
    #[error(
        "no point of one mesh lies within {reach_mm} mm of the other; are both in the same frame and unit? (the first spans {first_mm:.1} mm, the second {second_mm:.1} mm)"
    )]
    Apart {
        /// The reach asked for.
        reach_mm: f64,
        /// Diagonal of the first mesh.
        first_mm: f64,
        /// Diagonal of the second mesh.
        second_mm: f64,
    },
    /// A parameter out of range.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// Cancelled by the observer.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

crate::stage_error!(CompareError, "compare");

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
    /// Greatest.
    pub max_mm: f64,
    /// Part of the points within 1 mm.
    pub within_1mm: f64,
    /// Points measured.
    pub points: usize,
}

impl Distances {
    /// Statistics of a list; `None` when it is empty.
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
pub struct Both {
    /// From points of the first surface to the second.
    pub first_to_second: Distances,
    /// From points of the second surface to the first.
    pub second_to_first: Distances,
}

/// What a comparison found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// As the meshes lie.
    pub before: Both,
    /// After the alignment; absent when none was asked for.
    pub after: Option<Both>,
    /// The alignment: second frame from first frame.
    #[serde(serialize_with = "rows")]
    pub second_from_first: Similarity,
    /// Size of the first mesh as a fraction of the second's (1 unless size may change).
    pub scale: f64,
    /// Turn of the alignment, degrees.
    pub rotation_deg: f64,
    /// Steps the alignment took.
    pub iterations: usize,
    /// Distance of each vertex of the first mesh from the second, after the alignment, mm; for heat
    /// maps. NaN beyond the reach.
    #[serde(skip)]
    pub vertex_distances: Vec<f64>,
}

fn rows<S: serde::Serializer>(value: &Similarity, serializer: S) -> Result<S::Ok, S::Error> {
    value.to_rows().serialize(serializer)
}

/// One side of a comparison: a mesh and, where only a part of it counts, a mask of its vertices.
#[derive(Clone, Copy, Debug)]
pub struct Side<'a> {
    /// The mesh, mm.
    pub mesh: &'a Mesh,
    /// Vertices that count; a face counts when all its corners do. Distances are measured from
    /// points of the region to the whole other mesh.
    pub region: Option<&'a [bool]>,
}

impl<'a> Side<'a> {
    /// The whole mesh.
    pub fn whole(mesh: &'a Mesh) -> Self {
        Self { mesh, region: None }
    }

    fn samples(&self, which: &'static str, count: usize) -> Result<Vec<Sample>, CompareError> {
        self.mesh.validate().map_err(|cause| CompareError::Mesh { which, cause })?;
        let expected = self.mesh.vertices.len();
        let got = self.region.map_or(expected, <[bool]>::len);
        let samples = match self.region {
            Some(mask) if mask.len() != expected => Vec::new(),
            region => sample_surface(self.mesh, region, count),
        };
        if samples.is_empty() {
            return Err(CompareError::Region { which, got, expected });
        }
        Ok(samples)
    }
}

/// Compares two meshes: distances of evenly spread points of each surface from the other one,
/// before and after bringing the first to the second.
///
/// # Errors
/// [`CompareError`] for invalid meshes, empty regions, and meshes that are nowhere near each other;
/// when the observer cancels.
pub fn compare(
    first: &Side<'_>,
    second: &Side<'_>,
    params: &CompareParams,
    observer: &dyn Observer,
) -> Result<Comparison, CompareError> {
    params.check("compare", None)?;
    let from_first = first.samples("first", params.samples)?;
    let from_second = second.samples("second", params.samples)?;
    let index = |mesh: &Mesh, which| {
        let empty = MeshError::Empty { vertices: mesh.vertices.len(), faces: mesh.faces.len() };
        SurfaceIndex::new(mesh).ok_or(CompareError::Mesh { which, cause: empty })
    };
    let first_index = index(first.mesh, "first")?;
    let second_index = index(second.mesh, "second")?;
    let reach = params.reach_mm.unwrap_or(f64::INFINITY);

    let measure = |second_from_first: &Similarity, reach: f64| -> Result<Both, CompareError> {
        let back = second_from_first.inverse();
        let forth = distances(&from_first, second_from_first, &second_index, reach, observer)?;
        // measured in the first mesh's frame, told in the second's unit
        let scale = second_from_first.scale;
        let home = distances(&from_second, &back, &first_index, reach / scale, observer)?;
        let home: Vec<f64> = home.iter().map(|d| d * scale).collect();
        match (Distances::of(&forth), Distances::of(&home)) {
            (Some(first_to_second), Some(second_to_first)) => {
                Ok(Both { first_to_second, second_to_first })
            }
            _ => Err(CompareError::Apart {
                reach_mm: reach,
                first_mm: diagonal(first.mesh),
                second_mm: diagonal(second.mesh),
            }),
        }
    };
    let (second_from_first, iterations) = match params.alignment {
        Alignment::None => (Similarity::identity(), 0),
        _ => align::align(&from_first, second.mesh, &second_index, params, observer)?,
    };
    // without a reach there is always a nearest point; meshes may start far apart
    let before = match params.alignment {
        Alignment::None => measure(&Similarity::identity(), reach)?,
        _ => measure(&Similarity::identity(), f64::INFINITY)?,
    };
    let after = match params.alignment {
        Alignment::None => None,
        _ => Some(measure(&second_from_first, reach)?),
    };
    let vertex_distances = first
        .mesh
        .vertices
        .par_iter()
        .map(|v| {
            let found = second_index.closest_within(&second_from_first.apply(v), reach);
            found.map_or(f64::NAN, |f| f.distance)
        })
        .collect();
    Ok(Comparison {
        before,
        after,
        second_from_first,
        scale: second_from_first.scale,
        rotation_deg: second_from_first.angle().to_degrees(),
        iterations,
        vertex_distances,
    })
}

fn diagonal(mesh: &Mesh) -> f64 {
    mesh.bounds().map_or(0.0, |(low, high)| (high - low).norm())
}

fn distances(
    samples: &[Sample],
    target_from_samples: &Similarity,
    index: &SurfaceIndex,
    reach: f64,
    observer: &dyn Observer,
) -> Result<Vec<f64>, CompareError> {
    // so many between two looks whether to stop
    const PORTION: usize = 10_000;
    let mut found: Vec<f64> = Vec::with_capacity(samples.len());
    for portion in samples.chunks(PORTION) {
        observer.check()?;
        let some: Vec<Option<f64>> = portion
            .par_iter()
            .map(|s| {
                let point: Vec3 = target_from_samples.apply(&s.point);
                index.closest_within(&point, reach).map(|f| f.distance)
            })
            .collect();
        found.extend(some.into_iter().flatten());
    }
    Ok(found)
}
