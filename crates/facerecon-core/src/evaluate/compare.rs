//! Distances between two meshes, before and after the best alignment.

mod align;
mod params;
mod result;
mod samples;

#[cfg(test)]
mod tests;

pub use params::{Alignment, CompareError, CompareParams};
pub use result::{BothDirections, Comparison, Distances};

use rayon::prelude::*;

use crate::data::{Mesh, MeshError};
use crate::math::{Similarity, Vec3};
use crate::observer::Observer;
use crate::settings::Value;
use crate::spatial::SurfaceIndex;
use samples::{Sample, sample_surface};

/// A mesh to compare, or a region of it.
#[derive(Clone, Copy, Debug)]
pub struct MeshRegion<'a> {
    /// The mesh, mm.
    pub mesh: &'a Mesh,
    /// Whether each vertex is in the region; a face is when all its vertices are. Distances are
    /// measured from points of the region to the whole other mesh. `None` for the whole mesh.
    pub mask: Option<&'a [bool]>,
}

impl<'a> MeshRegion<'a> {
    /// The whole mesh.
    pub fn whole(mesh: &'a Mesh) -> Self {
        Self { mesh, mask: None }
    }

    fn samples(&self, which: &'static str, count: usize) -> Result<Vec<Sample>, CompareError> {
        self.mesh.validate().map_err(|cause| CompareError::Mesh { which, cause })?;
        let expected = self.mesh.vertices.len();
        let got = self.mask.map_or(expected, <[bool]>::len);
        let samples = match self.mask {
            Some(mask) if mask.len() != expected => Vec::new(),
            mask => sample_surface(self.mesh, mask, count),
        };
        if samples.is_empty() {
            return Err(CompareError::Region { which, got, expected });
        }
        Ok(samples)
    }

    fn index(&self, which: &'static str) -> Result<SurfaceIndex, CompareError> {
        let (vertices, faces) = (self.mesh.vertices.len(), self.mesh.faces.len());
        let cause = MeshError::Empty { vertices, faces };
        SurfaceIndex::new(self.mesh).ok_or(CompareError::Mesh { which, cause })
    }
}

/// Compares two meshes: distances of evenly distributed points of each surface from the other one,
/// before and after aligning the first with the second.
///
/// ```
/// use facerecon_core::evaluate::{CompareParams, MeshRegion, compare};
/// use facerecon_core::math::Vec3;
/// use facerecon_core::template::head_coarse;
///
/// let first = head_coarse().mesh;
/// let mut second = first.clone();
/// second.vertices.iter_mut().for_each(|v| *v += Vec3::new(0.0, 0.0, 2.0));
/// let params = CompareParams { samples: 500, ..Default::default() };
/// let comparison =
///     compare(&MeshRegion::whole(&first), &MeshRegion::whole(&second), &params, &())?;
/// assert!(comparison.before.first_to_second.max_mm > 1.0);
/// assert!(comparison.after.is_some_and(|d| d.first_to_second.max_mm < 0.01));
/// # Ok::<(), facerecon_core::evaluate::CompareError>(())
/// ```
///
/// # Errors
/// [`CompareError`] for invalid meshes, empty regions, and meshes with no distance below
/// [`CompareParams::reach_mm`]; when the observer cancels.
pub fn compare(
    first: &MeshRegion<'_>,
    second: &MeshRegion<'_>,
    params: &CompareParams,
    observer: &dyn Observer,
) -> Result<Comparison, CompareError> {
    params.check("compare", None)?;
    let surfaces = Surfaces {
        samples: [
            first.samples("first", params.samples)?,
            second.samples("second", params.samples)?,
        ],
        indices: [first.index("first")?, second.index("second")?],
        diagonals_mm: [diagonal(first.mesh), diagonal(second.mesh)],
    };
    let [from_first, _] = &surfaces.samples;
    let [_, second_index] = &surfaces.indices;
    let reach = params.reach_mm.unwrap_or(f64::INFINITY);
    let unmoved = Similarity::identity();
    let aligned = params.alignment != Alignment::None;
    let (second_from_first, iterations) = if aligned {
        align::align(from_first, second.mesh, second_index, params, observer)?
    } else {
        (unmoved, 0)
    };
    // Before an alignment the meshes may be far apart: every distance counts.
    let before_reach = if aligned { f64::INFINITY } else { reach };
    let before = surfaces.measure(&unmoved, before_reach, observer)?;
    let after = match aligned {
        true => Some(surfaces.measure(&second_from_first, reach, observer)?),
        false => None,
    };
    let vertex_distances = first
        .mesh
        .vertices
        .par_iter()
        .map(|v| {
            let closest = second_index.closest_within(&second_from_first.apply(v), reach);
            closest.map_or(f64::NAN, |c| c.distance)
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

/// Both surfaces, `[first, second]`, prepared for measurement.
struct Surfaces {
    samples: [Vec<Sample>; 2],
    indices: [SurfaceIndex; 2],
    diagonals_mm: [f64; 2],
}

impl Surfaces {
    /// Distances in both directions, in the unit of the second mesh.
    fn measure(
        &self,
        second_from_first: &Similarity,
        reach: f64,
        observer: &dyn Observer,
    ) -> Result<BothDirections, CompareError> {
        let [from_first, from_second] = &self.samples;
        let [first_index, second_index] = &self.indices;
        let first_from_second = second_from_first.inverse();
        let forward = distances(from_first, second_from_first, second_index, reach, observer)?;
        // Measured in the frame of the first mesh.
        let scale = second_from_first.scale;
        let backward =
            distances(from_second, &first_from_second, first_index, reach / scale, observer)?;
        let backward: Vec<f64> = backward.iter().map(|d| d * scale).collect();
        match (Distances::of(&forward), Distances::of(&backward)) {
            (Some(first_to_second), Some(second_to_first)) => {
                Ok(BothDirections { first_to_second, second_to_first })
            }
            _ => {
                let [first_mm, second_mm] = self.diagonals_mm;
                Err(CompareError::Apart { reach_mm: reach, first_mm, second_mm })
            }
        }
    }
}

/// Diagonal of the bounding box.
fn diagonal(mesh: &Mesh) -> f64 {
    mesh.bounds().map_or(0.0, |(low, high)| (high - low).norm())
}

/// Distances of the samples from a surface, without those above `reach`.
fn distances(
    samples: &[Sample],
    target_from_samples: &Similarity,
    index: &SurfaceIndex,
    reach: f64,
    observer: &dyn Observer,
) -> Result<Vec<f64>, CompareError> {
    /// Samples between two checks for cancellation.
    const CHUNK: usize = 10_000;
    let mut measured: Vec<f64> = Vec::with_capacity(samples.len());
    for chunk in samples.chunks(CHUNK) {
        observer.check()?;
        let distances: Vec<Option<f64>> = chunk
            .par_iter()
            .map(|s| {
                let point: Vec3 = target_from_samples.apply(&s.point);
                index.closest_within(&point, reach).map(|c| c.distance)
            })
            .collect();
        measured.extend(distances.into_iter().flatten());
    }
    Ok(measured)
}
