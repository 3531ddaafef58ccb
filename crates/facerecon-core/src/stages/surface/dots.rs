//! Matched dots, connected by Delaunay triangulation in the left photo.

use spade::{DelaunayTriangulation, HasPosition, Point2, Triangulation};

use super::SurfaceError;
use super::patch::{Node, Patch, Unproject};
use crate::data::Match;
use crate::spatial::thin_to_pitch;

/// Coordinates below this count as 0, pixels: spade refuses smaller ones than about 1e-43.
const MIN_COORDINATE_PX: f64 = 1e-30;

/// Position of a node in the photo, and its number.
struct NumberedPoint(Point2<f64>, u32);

impl HasPosition for NumberedPoint {
    type Scalar = f64;
    fn position(&self) -> Point2<f64> {
        self.0
    }
}

/// Triangles between the matches whose position in space is known. Along stripes the matches are
/// thinned to the distance between the stripes.
pub(super) fn triangulated(
    matches: &[Match],
    pitch_px: f64,
    unproject: Unproject<'_>,
) -> Result<Patch, SurfaceError> {
    let pixels: Vec<_> = matches.iter().map(|m| m.left).collect();
    let nodes = thin_to_pitch(&pixels, pitch_px)
        .into_iter()
        .filter_map(|i| Node::new(matches[i].left, matches[i].disparity(), unproject))
        .collect();
    let mut patch = Patch { nodes, faces: Vec::new() };
    let points = patch.nodes.iter().zip(0..).map(|(n, number)| {
        let [x, y] =
            [n.pixel.x, n.pixel.y].map(|v| if v.abs() < MIN_COORDINATE_PX { 0.0 } else { v });
        NumberedPoint(Point2::new(x, y), number)
    });
    let triangulation = DelaunayTriangulation::<NumberedPoint>::bulk_load_stable(points.collect())
        .map_err(|error| SurfaceError::Delaunay(error.to_string()))?;
    let mut faces: Vec<[u32; 3]> =
        triangulation.inner_faces().map(|face| face.vertices().map(|v| v.data().1)).collect();
    // independent of the order inside the triangulation
    faces.sort_unstable();
    faces.into_iter().for_each(|face| patch.add(face));
    Ok(patch)
}
