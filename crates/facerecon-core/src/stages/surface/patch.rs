//! Triangles between measured points in the left photo.

use super::adjacency::NONE;
use crate::math::{Vec2, Vec3};

/// Faces with less than this double area are degenerate, pixels squared.
const MIN_DOUBLE_AREA_PX2: f64 = 1e-9;

/// Point in space of a rectified left pixel and its disparity.
pub(super) type Unproject<'a> = &'a dyn Fn(Vec2, f64) -> Option<Vec3>;

/// A measured point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Node {
    /// Position in the rectified left photo, pixels.
    pub(super) pixel: Vec2,
    /// Disparity there, pixels.
    pub(super) disparity: f64,
    /// Position in space.
    pub(super) point: Vec3,
}

impl Node {
    /// A node; `None` where its position in space is unknown or not finite.
    pub(super) fn new(pixel: Vec2, disparity: f64, unproject: Unproject<'_>) -> Option<Self> {
        let point = unproject(pixel, disparity).filter(|p| p.iter().all(|c| c.is_finite()))?;
        Some(Self { pixel, disparity, point })
    }
}

/// Nodes and triangles that do not overlap in the left photo, counterclockwise as seen there.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Patch {
    pub(super) nodes: Vec<Node>,
    pub(super) faces: Vec<[u32; 3]>,
}

impl Patch {
    /// The three nodes of a face.
    pub(super) fn corners(&self, face: [u32; 3]) -> [&Node; 3] {
        face.map(|i| &self.nodes[i as usize])
    }

    /// Twice the area of a face in the photo; positive when counterclockwise as seen there.
    pub(super) fn double_area_px2(&self, face: [u32; 3]) -> f64 {
        let [a, b, c] = self.corners(face).map(|n| n.pixel);
        // y points down
        -(b - a).perp(&(c - a))
    }

    /// Adds a face, turned counterclockwise. Faces without area are not added.
    pub(super) fn add(&mut self, face: [u32; 3]) {
        let [a, b, c] = face;
        match self.double_area_px2(face) {
            area if area > MIN_DOUBLE_AREA_PX2 => self.faces.push(face),
            area if area < -MIN_DOUBLE_AREA_PX2 => self.faces.push([a, c, b]),
            _ => {}
        }
    }

    /// Removes nodes without faces; the others keep their order.
    pub(super) fn remove_unused_nodes(&mut self) {
        let mut new_index = vec![NONE; self.nodes.len()];
        self.faces.iter().flatten().for_each(|&n| new_index[n as usize] = 0);
        let mut kept = Vec::new();
        for (node, index) in self.nodes.iter().zip(&mut new_index) {
            if *index != NONE {
                *index = kept.len() as u32;
                kept.push(*node);
            }
        }
        self.nodes = kept;
        self.faces.iter_mut().flatten().for_each(|n| *n = new_index[*n as usize]);
    }
}
