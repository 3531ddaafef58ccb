//! Stage surface: a mesh of the measured surface itself, without a generic head.
//!
//! The measurements are triangulated in the rectified left photo, where the neighbours are known:
//! the dense disparity on a grid of equilateral triangles, matched dots by Delaunay triangulation.
//! Triangles across a depth discontinuity (seen at a grazing angle), across a gap, and in narrow
//! strips are removed. Holes stay holes. The rest is made manifold, components that do not belong
//! to the subject are removed, and the border is smoothed.

mod adjacency;
mod border;
mod components;
mod dots;
mod filters;
mod grid;
mod manifold;
mod patch;
#[cfg(test)]
mod tests;

use crate::data::{Gray, Match, Mesh};
use crate::math::{Vec2, Vec3};
use crate::observer::{Artifact, Cancelled, Event, Observer};
use crate::settings::{SettingsError, Value};
use crate::settings::{choices, settings};
use crate::spatial::estimate_pitch;

use patch::Patch;

choices! {
    /// Whether the mesh is the measured surface itself, and what it is made from.
    pub enum SurfaceMethod {
        /// Not made; the generic head is deformed to the points instead.
        None = "none",
        /// From the dense disparity where the stage refine measured it, otherwise from the matches.
        Auto = "auto",
        /// From the matches only (Delaunay triangulation).
        Dots = "dots",
    }
}

settings! {
    /// A mesh of the measured surface itself, without a generic head.
    pub struct SurfaceParams {
        /// What the mesh is made from; `none` deforms the generic head instead.
        method: SurfaceMethod = SurfaceMethod::None;
        /// Distance between neighbouring vertices on the dense disparity, in distances between
        /// dots.
        spacing: f64 = 0.25, range 0.05..=4.0;
        /// Longest edge between matches, in distances between dots; the default bridges one missing
        /// dot.
        max_edge: f64 = 2.5, range 1.0..=10.0;
        /// Triangles tilted further away from the direction midway between the cameras are removed:
        /// depth discontinuities.
        max_tilt_deg: f64 = 80.0, range 10.0..=89.0, unit "degrees";
        /// Strips narrower than this, in distances between dots, are removed with everything that
        /// only they connect: hair, bridges between holes.
        min_width: f64 = 1.5, range 0.0..=10.0;
        /// Connected components with less than this share of the largest one's extent are removed.
        min_component_share: f64 = 0.1, range 0.0..=1.0, alias "min_part";
        /// Steps of smoothing that take the grid's steps off the border; vertices inside do not
        /// move.
        border_steps: usize = 30, range 0.0..=100.0;
    }
}

/// Measurements in rectified pixels and their positions in space.
#[derive(Clone, Copy)]
pub struct SurfaceInput<'a> {
    /// Disparity `xl - xr` at every pixel of the rectified left photo, pixels, NaN in holes; `None`
    /// where it was not measured.
    pub disparity: Option<&'a Gray>,
    /// The matches. With a disparity they only set the distance between dots.
    pub matches: &'a [Match],
    /// Indices of the matches known to lie on the subject; empty when that is unknown.
    pub on_subject: &'a [usize],
    /// Point in space of a rectified left pixel and its disparity, in any right-handed frame.
    pub unproject: &'a dyn Fn(Vec2, f64) -> Option<Vec3>,
}

/// The measured surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// Triangles counterclockwise as the cameras see them, in the frame of
    /// [`SurfaceInput::unproject`]. The texture coordinates are the view of a camera midway between
    /// the two.
    pub mesh: Mesh,
    /// Whether it was made from the dense disparity.
    pub dense: bool,
    /// Distance between neighbouring dots in the rectified left photo, pixels.
    pub pitch_px: f64,
    /// Number of connected components.
    pub components: usize,
    /// Number of connected components that were removed.
    pub components_removed: usize,
}

/// Why a surface could not be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SurfaceError {
    /// Too few points.
    #[error(
        "{got} measured points have a position in space (at least {needed} expected); check the matches and the calibration"
    )]
    TooFewPoints {
        /// Points found.
        got: usize,
        /// Points needed.
        needed: usize,
    },
    /// Every triangle was removed.
    #[error(
        "none of {triangles} triangles between the measured points is a surface: {tilted} are depth discontinuities, the others are too long or isolated; check the matches, or raise surface.max_edge (now {max_edge}) or surface.max_tilt_deg (now {max_tilt_deg})"
    )]
    NothingLeft {
        /// Triangles before any was removed.
        triangles: usize,
        /// Those removed because of their tilt.
        tilted: usize,
        /// Longest edge allowed, in distances between dots.
        max_edge: f64,
        /// Largest tilt allowed.
        max_tilt_deg: f64,
    },
    /// A match has a coordinate that is not a number.
    #[error("match {index} has a position that is not a finite number")]
    NotFinite {
        /// Index of the match.
        index: usize,
    },
    /// A match on the subject does not exist.
    #[error(
        "match {index} is listed as lying on the subject, but there are {count} matches (indices start at 0)"
    )]
    Index {
        /// Index found.
        index: usize,
        /// Number of matches.
        count: usize,
    },
    /// The triangulation failed.
    #[error("the matches cannot be triangulated: {0}; check their positions")]
    Delaunay(String),
    /// A parameter is out of its range.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// The observer cancelled the run.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

crate::stages::stage_error!(SurfaceError, "surface");

/// Smallest number of points: two triangles.
const MIN_POINTS: usize = 4;

/// Smallest distance between dots, pixels; below it the matches coincide.
const MIN_PITCH_PX: f64 = 1e-6;

/// Free border of the texture, as a share of its edge.
const TEXTURE_MARGIN: f64 = 0.02;

/// Triangulates the measurements. The method `none` counts as `auto` here.
///
/// # Errors
/// [`SurfaceError`] for parameters out of range, matches that are not finite, too few points,
/// when no triangle is left, or when cancelled.
///
/// ```
/// use facerecon_core::data::{Gray, Match};
/// use facerecon_core::math::{Vec2, Vec3};
/// use facerecon_core::stages::surface::{SurfaceInput, SurfaceParams, surface};
///
/// // a plane at a disparity of 20 px with dots 8 px apart; millimetres stand for pixels
/// let disparity = Gray::filled(80, 60, 20.0);
/// let matches: Vec<Match> = (0..70)
///     .map(|k| Vec2::new(f64::from(4 + 8 * (k % 10)), f64::from(4 + 8 * (k / 10))))
///     .map(|left| Match {
///         left,
///         right: left - Vec2::new(20.0, 0.0),
///         lattice: None,
///         sigma_px: 0.0,
///         score: 1.0,
///     })
///     .collect();
/// let input = SurfaceInput {
///     disparity: Some(&disparity),
///     matches: &matches,
///     on_subject: &[],
///     unproject: &|pixel, disparity| Some(Vec3::new(pixel.x, pixel.y, -disparity)),
/// };
///
/// let surface = surface(&input, &SurfaceParams::default(), &())?;
/// assert_eq!((surface.components, surface.pitch_px), (1, 8.0));
/// assert!(surface.mesh.vertices.iter().all(|v| (v.z + 20.0).abs() < 1e-4));
/// # Ok::<(), facerecon_core::stages::surface::SurfaceError>(())
/// ```
pub fn surface(
    input: &SurfaceInput<'_>,
    params: &SurfaceParams,
    observer: &dyn Observer,
) -> Result<Surface, SurfaceError> {
    params.check("surface", None)?;
    validate(input)?;
    let pixels: Vec<Vec2> = input.matches.iter().map(|m| m.left).collect();
    let pitch_px = estimate_pitch(&pixels)
        .filter(|p| *p > MIN_PITCH_PX)
        .ok_or_else(|| too_few(input.matches.len()))?;
    observer.check()?;

    let disparity = input.disparity.filter(|_| params.method != SurfaceMethod::Dots);
    let dense = disparity.is_some();
    let mut patch = match disparity {
        Some(disparity) => {
            grid::triangulated(disparity, params.spacing * pitch_px, input.unproject)
        }
        None => dots::triangulated(input.matches, pitch_px, input.unproject)?,
    };
    if patch.nodes.len() < MIN_POINTS {
        return Err(too_few(patch.nodes.len()));
    }
    observer.check()?;

    let triangles = patch.faces.len();
    if !dense {
        filters::remove_long(&mut patch, params.max_edge * pitch_px);
    }
    let tilted = filters::remove_tilted(&mut patch, params.max_tilt_deg, input.unproject);
    filters::remove_narrow(&mut patch, params.min_width * pitch_px);
    filters::remove_ears(&mut patch);
    manifold::split_shared_nodes(&mut patch);
    let subject: Vec<Vec2> = input.on_subject.iter().map(|&i| pixels[i]).collect();
    let components =
        components::keep_subject(&mut patch, &subject, params.min_component_share, pitch_px);
    if patch.faces.is_empty() {
        let (max_edge, max_tilt_deg) = (params.max_edge, params.max_tilt_deg);
        return Err(SurfaceError::NothingLeft { triangles, tilted, max_edge, max_tilt_deg });
    }
    observer.check()?;
    if dense {
        border::smooth(&mut patch, params.border_steps, input.unproject);
    }

    let mesh = mesh(&patch);
    let count = |what, count| observer.event(&Event::Count { stage: "surface", what, count });
    count("vertices", mesh.vertices.len());
    count("components", components.kept);
    observer.artifact("surface", "mesh", Artifact::Mesh(&mesh));
    Ok(Surface {
        mesh,
        dense,
        pitch_px,
        components: components.kept,
        components_removed: components.removed,
    })
}

/// Checks that the matches are finite and that those on the subject exist.
fn validate(input: &SurfaceInput<'_>) -> Result<(), SurfaceError> {
    let finite = |m: &Match| m.left.iter().chain(m.right.iter()).all(|v| v.is_finite());
    if let Some(index) = input.matches.iter().position(|m| !finite(m)) {
        return Err(SurfaceError::NotFinite { index });
    }
    let count = input.matches.len();
    match input.on_subject.iter().find(|&&i| i >= count) {
        Some(&index) => Err(SurfaceError::Index { index, count }),
        None => Ok(()),
    }
}

fn too_few(got: usize) -> SurfaceError {
    SurfaceError::TooFewPoints { got, needed: MIN_POINTS }
}

/// The patch in space. Its texture layout is the view of a camera midway between the two: points
/// that both cameras see keep their order along a row there, so no two faces overlap.
fn mesh(patch: &Patch) -> Mesh {
    let midway: Vec<Vec2> =
        patch.nodes.iter().map(|n| n.pixel - Vec2::new(0.5 * n.disparity, 0.0)).collect();
    let first = midway.first().copied().unwrap_or_default();
    let (low, high) = midway.iter().fold((first, first), |(l, h), p| (l.inf(p), h.sup(p)));
    let centre = (low + high) / 2.0;
    // all points in one place have no extent
    let scale = (1.0 - 2.0 * TEXTURE_MARGIN) / (high - low).max().max(1e-9);
    let uv = |p: &Vec2| {
        let q = (p - centre) * scale;
        [0.5 + q.x, 0.5 - q.y]
    };
    Mesh {
        vertices: patch.nodes.iter().map(|n| n.point).collect(),
        faces: patch.faces.clone(),
        uvs: midway.iter().map(uv).collect(),
        face_uvs: patch.faces.clone(),
        ..Mesh::default()
    }
}
