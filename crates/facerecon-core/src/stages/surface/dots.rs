//! Matched dots, connected by Delaunay triangulation in the picture.

use spade::{DelaunayTriangulation, HasPosition, Point2, Triangulation};

use super::SurfaceError;
use super::patch::{Node, Patch, Place};
use crate::data::Match;
use crate::spatial::thinned;

/// A node's place in the picture and its number.
struct Spot(Point2<f64>, u32);

impl HasPosition for Spot {
    type Scalar = f64;
    fn position(&self) -> Point2<f64> {
        self.0
    }
}

/// Triangles between the matches whose place in space is known. Along stripes only as many
/// matches are taken as the distance between the stripes asks for.
pub(super) fn triangulated(
    matches: &[Match],
    pitch_px: f64,
    place: Place<'_>,
) -> Result<Patch, SurfaceError> {
    let pixels: Vec<_> = matches.iter().map(|m| m.left).collect();
    let nodes = thinned(&pixels, pitch_px)
        .into_iter()
        .filter_map(|i| Node::new(matches[i].left, matches[i].disparity(), place))
        .collect();
    let mut patch = Patch { nodes, faces: Vec::new() };
    let spots = patch.nodes.iter().zip(0..).map(|(n, name)| {
        // spade refuses numbers below its least normal one
        let [x, y] = [n.pixel.x, n.pixel.y].map(|v| if v.abs() < 1e-30 { 0.0 } else { v });
        Spot(Point2::new(x, y), name)
    });
    let net = DelaunayTriangulation::<Spot>::bulk_load_stable(spots.collect())
        .map_err(|fault| SurfaceError::Delaunay(fault.to_string()))?;
    let mut faces: Vec<[u32; 3]> =
        net.inner_faces().map(|face| face.vertices().map(|v| v.data().1)).collect();
    // whatever order the triangulation keeps them in
    faces.sort_unstable();
    faces.into_iter().for_each(|face| patch.add(face));
    Ok(patch)
}
