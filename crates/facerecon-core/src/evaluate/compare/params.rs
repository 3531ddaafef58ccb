//! Parameters and errors of a comparison.

use crate::data::MeshError;
use crate::observer::Cancelled;
use crate::settings::SettingsError;
use crate::settings::{choices, settings};

choices! {
    /// The transform that aligns the first mesh with the second.
    pub enum Alignment {
        /// None: both meshes are in one frame.
        None = "none",
        /// Rotation and translation.
        Rigid = "rigid",
        /// Rotation, translation and scale.
        Similarity = "similarity",
    }
}

settings! {
    /// Comparison of two meshes.
    pub struct CompareParams {
        /// The transform that aligns the first mesh with the second.
        alignment: Alignment = Alignment::Rigid;
        /// Points on each surface, evenly distributed over its area.
        samples: usize = 20000, range 100.0..=2000000.0;
        /// Fraction of the points that the alignment uses, those with the smallest residuals: the rest
        /// may have no counterpart (a face compared with a whole head).
        keep: f64 = 0.9, range 0.1..=1.0;
        /// Most iterations of the alignment.
        iterations: usize = 80, range 1.0..=1000.0;
        /// Larger distances are left out, as of regions that only one mesh has (with an alignment:
        /// after it).
        reach_mm: Option<f64> = None, range 0.0..=1e6, unit "mm";
    }
}

/// Why two meshes cannot be compared.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CompareError {
    /// An invalid mesh.
    #[error("the {which} mesh is invalid: {cause}")]
    Mesh {
        /// `first` or `second`.
        which: &'static str,
        /// The reason.
        cause: MeshError,
    },
    /// A region without faces, or a mask of the wrong length.
    #[error(
        "the region of the {which} mesh contains no face (its mask has {got} entries, the mesh has {expected} vertices); a face is in the region if all its vertices are"
    )]
    Region {
        /// `first` or `second`.
        which: &'static str,
        /// Entries of the mask.
        got: usize,
        /// Vertices of the mesh.
        expected: usize,
    },
    /// No distance below `reach_mm`.
    #[error(
        "no point of one mesh is within {reach_mm} mm of the other (the diagonal of the first is {first_mm:.1} mm, of the second {second_mm:.1} mm); give both meshes in one frame and unit, or increase reach_mm"
    )]
    Apart {
        /// The largest distance that counts.
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

crate::stages::stage_error!(CompareError, "compare");
