//! Templates that are masks: a face without the rest of the head.

use crate::data::{Mesh, Topology};

/// Height of a head with its neck relative to its width: that of the built-in head.
const HEIGHT_PER_WIDTH: f64 = 1.6;

/// For each vertex whether it is on the border of a mask: points closest to it belong to a part of
/// the head that the mask does not have. None is on a whole head, which is deeper than wide.
pub(super) fn border_of_mask(mesh: &Mesh) -> Vec<bool> {
    match mesh.bounds() {
        Some((low, high)) if high.z - low.z < high.x - low.x => Topology::new(mesh).border,
        _ => vec![false; mesh.vertices.len()],
    }
}

/// For each vertex whether points closest to it tell nothing about the pose of the head: it is on the
/// border of a mask or below the chin, where that is known.
pub(super) fn outside_head(mesh: &Mesh, chin_y: Option<f64>) -> Vec<bool> {
    let below = |v: usize| chin_y.is_some_and(|y| mesh.vertices[v].y < y);
    border_of_mask(mesh).into_iter().enumerate().map(|(v, border)| border || below(v)).collect()
}

/// Height of the head that a mesh shows, whole or in part: a mask is less high than its head, but as
/// wide.
pub(super) fn head_height(mesh: &Mesh) -> f64 {
    mesh.bounds()
        .map_or(0.0, |(low, high)| (high.y - low.y).max(HEIGHT_PER_WIDTH * (high.x - low.x)))
}

/// Height of a mesh.
pub(super) fn height(mesh: &Mesh) -> f64 {
    mesh.bounds().map_or(0.0, |(low, high)| high.y - low.y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::template::head;

    #[test]
    fn only_a_mask_has_a_border() {
        let flat = Mesh {
            vertices: vec![Vec3::zeros(), Vec3::x() * 100.0, Vec3::y() * 50.0],
            faces: vec![[0, 1, 2]],
            ..Mesh::default()
        };
        assert_eq!(border_of_mask(&flat), [true; 3]);
        assert_eq!((height(&flat), head_height(&flat)), (50.0, 160.0));
        // the neck of the built-in head is open, but the head is whole
        assert!(!border_of_mask(&head().mesh).contains(&true));
    }

    #[test]
    fn the_neck_is_outside_the_head() {
        let head = head();
        let (chin_y, mesh) = (head.chin_y(), &head.mesh);
        assert!(!outside_head(mesh, None).contains(&true));
        let outside = outside_head(mesh, chin_y);
        for (p, outside) in mesh.vertices.iter().zip(outside) {
            assert_eq!(outside, p.y < chin_y.unwrap(), "{p}");
        }
    }
}
