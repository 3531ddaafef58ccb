//! Stage surface: a mesh of the measured surface itself, without a generic head.
//!
//! The measurements are triangulated in the rectified left picture, where neighbours are known:
//! the dense disparity on a lattice of equilateral triangles, matched dots by Delaunay. Lifted into
//! space, a triangle stays only where it is a surface: not across a step in depth, where it would be
//! seen at a grazing angle, and not across a gap. Holes stay holes. What is left is made manifold,
//! parts that are not the subject go, and the border is taken off its steps.

mod border;
mod dots;
mod grid;
mod parts;
mod patch;
#[cfg(test)]
mod tests;

use crate::data::{Gray, Match, Mesh};
use crate::math::{Vec2, Vec3};
use crate::observer::{Artifact, Cancelled, Event, Observer};
use crate::settings::{SettingsError, Value};
use crate::spatial::pitch;
use crate::{choices, settings};

use patch::Patch;

choices! {
    /// Whether the mesh is the measured surface itself, and of what it is made.
    pub enum SurfaceMethod {
        /// Not made: the generic head is bent to the points instead.
        None = "none",
        /// Of the dense disparity where the stage refine measured it, else of the matches.
        Auto = "auto",
        /// Of the matches alone (Delaunay triangulation).
        Dots = "dots",
    }
}

settings! {
    /// A mesh of the measured surface itself, without a generic head.
    pub struct SurfaceParams {
        /// Of what it is made; `none` bends the generic head instead.
        method: SurfaceMethod = SurfaceMethod::None;
        /// Distance between neighbouring vertices on the dense disparity, in distances between
        /// dots.
        spacing: f64 = 0.25, range 0.05..=4.0;
        /// Matches farther apart than this are not connected, in distances between dots: a single
        /// missing dot is bridged.
        max_edge: f64 = 2.5, range 1.0..=10.0;
        /// Triangles turned further away from the middle between the cameras are left out: steps
        /// in depth.
        max_tilt_deg: f64 = 80.0, range 10.0..=89.0, unit "degrees";
        /// Strips narrower than this are left out, in distances between dots: hair, threads between
        /// holes, and what hangs on by them.
        min_width: f64 = 1.5, range 0.0..=10.0;
        /// Separate parts with less than this share of the largest one's extent are left out.
        min_part: f64 = 0.1, range 0.0..=1.0;
        /// Rounds of smoothing that take the border off the lattice's steps; the inside does not
        /// move.
        border_steps: usize = 30, range 0.0..=100.0;
    }
}

/// What the surface is made of, in rectified pixels.
#[derive(Clone, Copy)]
pub struct SurfaceInput<'a> {
    /// Disparity `xl - xr` at every pixel of the rectified left picture, NaN in holes; where it
    /// was measured.
    pub disparity: Option<&'a Gray>,
    /// The matches; with a disparity they only tell the distance between dots.
    pub matches: &'a [Match],
    /// Numbers of the matches known to lie on the subject; empty where that is unknown.
    pub on_subject: &'a [usize],
    /// Point in space of a rectified left pixel and its disparity. Its frame must be right-handed.
    pub place: &'a dyn Fn(Vec2, f64) -> Option<Vec3>,
}

/// The measured surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// Triangles counterclockwise as the cameras see them, in the frame of `place`. Its texture
    /// coordinates are the picture of a camera midway between the two.
    pub mesh: Mesh,
    /// Whether it was made of the dense disparity.
    pub dense: bool,
    /// Distance between the pattern's dots in the picture.
    pub pitch_px: f64,
    /// Connected parts.
    pub parts: usize,
    /// Parts that were left out.
    pub parts_left_out: usize,
}

/// A surface that cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SurfaceError {
    /// Not enough to begin with.
    #[error(
        "{got} measured points can be placed in space, but at least {needed} are needed for a surface; check the matches and the calibration"
    )]
    TooFewPoints {
        /// Points found.
        got: usize,
        /// Points needed.
        needed: usize,
    },
    /// No triangle is a surface.
    #[error(
        "of {triangles} triangles between the measured points none is a surface: {tilted} are steps in depth, the rest too long or alone; check the matches, or raise surface.max_edge (now {max_edge}) or surface.max_tilt_deg (now {max_tilt_deg})"
    )]
    NothingLeft {
        /// Triangles before anything was left out.
        triangles: usize,
        /// Of these, turned away too far.
        tilted: usize,
        /// Longest edge allowed, in distances between dots.
        max_edge: f64,
        /// Largest tilt allowed.
        max_tilt_deg: f64,
    },
    /// A match that is not a number.
    #[error("match {index} has a position that is not a finite number")]
    NotFinite {
        /// Its number.
        index: usize,
    },
    /// A match of the subject that is not there.
    #[error("match {index} is said to lie on the subject, but there are {count} (counted from 0)")]
    Index {
        /// Its number.
        index: usize,
        /// How many there are.
        count: usize,
    },
    /// Points too many to triangulate.
    #[error("the matches cannot be triangulated: {0}")]
    Delaunay(String),
    /// A parameter out of its range.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// Cancelled by the observer.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

crate::stage_error!(SurfaceError, "surface");

/// Least number of points that make a surface.
pub const LEAST_POINTS: usize = 4;

/// Triangulates what was measured (`surface.method` `none` counts as `auto` here).
///
/// # Errors
/// [`SurfaceError`] for input that cannot be used, and where no triangle is left.
pub fn surface(
    input: &SurfaceInput<'_>,
    params: &SurfaceParams,
    observer: &dyn Observer,
) -> Result<Surface, SurfaceError> {
    params.check("surface", None)?;
    let matches = input.matches;
    let finite = |m: &Match| m.left.iter().chain(m.right.iter()).all(|v| v.is_finite());
    if let Some(index) = matches.iter().position(|m| !finite(m)) {
        return Err(SurfaceError::NotFinite { index });
    }
    let count = matches.len();
    if let Some(&index) = input.on_subject.iter().find(|&&i| i >= count) {
        return Err(SurfaceError::Index { index, count });
    }
    let pixels: Vec<Vec2> = matches.iter().map(|m| m.left).collect();
    let too_few = |got| SurfaceError::TooFewPoints { got, needed: LEAST_POINTS };
    let pitch_px = pitch(&pixels).filter(|p| *p > 1e-6).ok_or(too_few(count))?;
    stop(observer)?;

    let dense = input.disparity.filter(|_| params.method != SurfaceMethod::Dots);
    let mut patch = match dense {
        Some(disparity) => grid::triangulated(disparity, params.spacing * pitch_px, input.place),
        None => dots::triangulated(matches, pitch_px, input.place)?,
    };
    if patch.nodes.len() < LEAST_POINTS {
        return Err(too_few(patch.nodes.len()));
    }
    stop(observer)?;

    let triangles = patch.faces.len();
    if dense.is_none() {
        patch.drop_long(params.max_edge * pitch_px);
    }
    let tilted = patch.drop_tilted(params.max_tilt_deg, input.place);
    patch.drop_narrow(params.min_width * pitch_px);
    patch.drop_ears();
    patch.part_pinched();
    let subject: Vec<Vec2> = input.on_subject.iter().map(|&i| pixels[i]).collect();
    let kept = parts::keep_subject(&mut patch, &subject, params.min_part, pitch_px);
    if patch.faces.is_empty() {
        let (max_edge, max_tilt_deg) = (params.max_edge, params.max_tilt_deg);
        return Err(SurfaceError::NothingLeft { triangles, tilted, max_edge, max_tilt_deg });
    }
    stop(observer)?;
    if dense.is_some() {
        border::smooth(&mut patch, params.border_steps, input.place);
    }

    let mesh = mesh(&patch);
    observer.event(&Event::Count {
        stage: "surface",
        what: "vertices",
        count: mesh.vertices.len(),
    });
    observer.event(&Event::Count { stage: "surface", what: "parts", count: kept.parts });
    observer.artifact("surface", "mesh", Artifact::Mesh(&mesh));
    Ok(Surface {
        mesh,
        dense: dense.is_some(),
        pitch_px,
        parts: kept.parts,
        parts_left_out: kept.left_out,
    })
}

fn stop(observer: &dyn Observer) -> Result<(), SurfaceError> {
    observer.check()?;
    Ok(())
}

/// Free border of the texture, as a share of its edge.
const MARGIN: f64 = 0.02;

/// The patch in space, its texture laid out as a camera midway between the two sees it. What both
/// cameras see keeps its order along a row there, so no two faces lie on one another.
fn mesh(patch: &Patch) -> Mesh {
    let middles: Vec<Vec2> =
        patch.nodes.iter().map(|n| n.pixel - Vec2::new(0.5 * n.disparity, 0.0)).collect();
    let first = middles.first().copied().unwrap_or_default();
    let (low, high) = middles.iter().fold((first, first), |(l, h), p| (l.inf(p), h.sup(p)));
    let centre = (low + high) / 2.0;
    let scale = (1.0 - 2.0 * MARGIN) / (high - low).max().max(1e-9);
    let uv = |p: &Vec2| {
        let q = (p - centre) * scale;
        [0.5 + q.x, 0.5 - q.y]
    };
    Mesh {
        vertices: patch.nodes.iter().map(|n| n.point).collect(),
        faces: patch.faces.clone(),
        uvs: middles.iter().map(uv).collect(),
        face_uvs: patch.faces.clone(),
        colors: Vec::new(),
    }
}
