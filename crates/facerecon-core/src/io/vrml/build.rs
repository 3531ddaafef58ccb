//! The face sets of a scene as one mesh.

use std::collections::BTreeMap;

use nalgebra::Matrix4;

use super::nodes::NodeId;
use crate::data::Mesh;
use crate::io::error::Fault;
use crate::io::loaded_mesh::LoadedMesh;
use crate::math::Vec3;

/// Most vertices of the whole scene: a small file can repeat a large part with USE. A full scan has
/// about a million.
const MAX_VERTICES: usize = 5_000_000;
/// Most corners of faces of the whole scene, for the same reason: four per vertex.
const MAX_CORNERS: usize = 20_000_000;
/// Most nodes visited, for the same reason: five times the nodes that a file may have.
const MAX_VISITS: usize = 1_000_000;

/// An indexed face set, ready to be added.
pub(super) struct FaceSet<'a> {
    /// The node of the points, and the points.
    pub coordinates: (NodeId, &'a [f64]),
    /// Corners, -1 after each face.
    pub index: &'a [f64],
    /// Texture coordinates and their index, -1 after each face; if empty, `index` is used.
    pub uv: Option<(&'a [f64], &'a [f64])>,
    /// Colours of the points, 0 to 1, and their index; if empty, `index` is used.
    pub colors: Option<(&'a [f64], &'a [f64])>,
    /// Whether faces are counter-clockwise seen from outside.
    pub ccw: bool,
    /// The texture's file name.
    pub image: Option<&'a str>,
}

#[derive(Default)]
pub(super) struct Builder {
    mesh: Mesh,
    /// For each triangle its texture coordinates.
    uv_of_face: Vec<Option<[u32; 3]>>,
    /// For each vertex its colour.
    colored: Vec<Option<[u8; 3]>>,
    /// First vertex of the points already added, by node and transform.
    placed: BTreeMap<(NodeId, Vec<u64>), usize>,
    /// Textures, with the number of triangles that use each.
    images: Vec<(String, usize)>,
    warnings: Vec<String>,
    visits: usize,
    corners: usize,
    degenerate: usize,
}

impl Builder {
    /// Counts a visit to a node.
    pub(super) fn visit(&mut self) -> Result<(), Fault> {
        self.visits += 1;
        if self.visits > MAX_VISITS {
            return Err(Fault::new(format!(
                "the scene repeats its nodes more than {MAX_VISITS} times"
            )));
        }
        Ok(())
    }

    /// Adds a warning, once, about something that is not read.
    pub(super) fn ignored(&mut self, what: &str) {
        let warning = format!("{what} is ignored");
        if !self.warnings.contains(&warning) {
            self.warnings.push(warning);
        }
    }

    /// Adds a face set, its points transformed by `world_from_node`.
    pub(super) fn add(
        &mut self,
        set: &FaceSet<'_>,
        world_from_node: &Matrix4<f64>,
    ) -> Result<(), Fault> {
        let points = set.coordinates.1;
        let count = points.len() / 3;
        self.corners += set.index.len();
        let uv_count = set.uv.map_or(0, |(points, _)| points.len() / 2);
        let vertices = self.mesh.vertices.len() + count;
        let uvs = self.mesh.uvs.len() + uv_count;
        if vertices.max(uvs) > MAX_VERTICES || self.corners > MAX_CORNERS {
            return Err(Fault::new(format!(
                "the scene has more than {MAX_VERTICES} vertices or {MAX_CORNERS} corners of faces; simplify it"
            )));
        }
        let base = self.points(set.coordinates.0, points, world_from_node);
        let uv_base = self.mesh.uvs.len();
        if let Some((points, _)) = set.uv {
            self.mesh.uvs.extend(points.chunks_exact(2).map(|p| [p[0], p[1]]));
        }
        let uv_index = set.uv.map(|(_, index)| if index.is_empty() { set.index } else { index });
        // A mirroring transform or clockwise faces turn the triangles inside out.
        let flip = set.ccw != (world_from_node.fixed_view::<3, 3>(0, 0).determinant() >= 0.0);
        let mut start = 0;
        let mut triangles = 0;
        for end in (0..set.index.len()).filter(|&i| set.index[i] < 0.0).chain([set.index.len()]) {
            let corners = resolve(set.index.get(start..end), count, base, "point")?;
            let uvs = match uv_index.map(|index| index.get(start..end)) {
                Some(Some(index)) => {
                    Some(resolve(Some(index), uv_count, uv_base, "texture coordinate")?)
                }
                _ => None,
            };
            self.color(set, start, &corners, base);
            triangles += self.fan(&corners, uvs.as_deref(), flip);
            start = end + 1;
        }
        if let (Some(image), Some(_)) = (set.image, set.uv) {
            match self.images.iter_mut().find(|(name, _)| name == image) {
                Some((_, faces)) => *faces += triangles,
                None => self.images.push((image.to_owned(), triangles)),
            }
        }
        Ok(())
    }

    /// The first vertex of a node's points under a transform; adds them where they are new.
    fn points(&mut self, node: NodeId, points: &[f64], world_from_node: &Matrix4<f64>) -> usize {
        let key = (node, world_from_node.iter().map(|v| v.to_bits()).collect());
        if let Some(base) = self.placed.get(&key) {
            return *base;
        }
        let base = self.mesh.vertices.len();
        let moved = points.chunks_exact(3).map(|p| {
            world_from_node.transform_point(&nalgebra::Point3::new(p[0], p[1], p[2])).coords
        });
        self.mesh.vertices.extend(moved);
        self.colored.resize(self.mesh.vertices.len(), None);
        self.placed.insert(key, base);
        base
    }

    /// Colours the vertices of a face whose index begins at `start`.
    fn color(&mut self, set: &FaceSet<'_>, start: usize, corners: &[u32], base: usize) {
        let Some((colors, index)) = set.colors else { return };
        for (k, &corner) in corners.iter().enumerate() {
            let number = match index.get(start + k) {
                Some(number) => *number,
                None => corner as f64 - base as f64,
            };
            if number >= 0.0
                && let Some(&[r, g, b]) =
                    colors.get(3 * number as usize..).and_then(|c| c.first_chunk())
            {
                let byte = |c: f64| (c.clamp(0.0, 1.0) * 255.0).round() as u8;
                self.colored[corner as usize] = Some([byte(r), byte(g), byte(b)]);
            }
        }
    }

    /// Adds a polygon as a triangle fan; returns the number of triangles.
    fn fan(&mut self, corners: &[u32], uvs: Option<&[u32]>, flip: bool) -> usize {
        let mut whole = 0;
        for k in 1..corners.len().saturating_sub(1) {
            let order = if flip { [0, k + 1, k] } else { [0, k, k + 1] };
            let triangle = order.map(|i| corners[i]);
            let [a, b, c] = triangle;
            if a == b || b == c || c == a {
                continue;
            }
            whole += 1;
            self.mesh.faces.push(triangle);
            self.uv_of_face
                .push(uvs.filter(|u| u.len() == corners.len()).map(|u| order.map(|i| u[i])));
        }
        self.degenerate += usize::from(!corners.is_empty() && whole + 2 != corners.len());
        whole
    }

    /// The mesh and its textures, ordered by number of triangles, largest first.
    pub(super) fn finish(mut self) -> (LoadedMesh, Vec<(String, usize)>) {
        let without_uv = self.uv_of_face.iter().filter(|uv| uv.is_none()).count();
        if without_uv == self.uv_of_face.len() {
            self.mesh.uvs.clear();
        } else {
            let fallback = self.mesh.uvs.len() as u32;
            if without_uv > 0 {
                self.mesh.uvs.push([0.0, 0.0]);
                self.warnings.push(format!("{without_uv} triangles have no texture coordinates"));
            }
            self.mesh.face_uvs =
                self.uv_of_face.iter().map(|uv| uv.unwrap_or([fallback; 3])).collect();
        }
        self.mesh.colors = self.colored.into_iter().collect::<Option<_>>().unwrap_or_default();
        if self.degenerate > 0 {
            self.warnings.push(format!(
                "{} faces have repeated corners; triangles without area are not read",
                self.degenerate
            ));
        }
        // Stable: among equals the first in the file.
        self.images.sort_by_key(|(_, faces)| std::cmp::Reverse(*faces));
        let loaded =
            LoadedMesh { mesh: self.mesh, warnings: self.warnings, ..LoadedMesh::default() };
        (loaded, self.images)
    }
}

/// Indices of one face as indices of the mesh.
fn resolve(
    index: Option<&[f64]>,
    count: usize,
    base: usize,
    what: &str,
) -> Result<Vec<u32>, Fault> {
    let one = |&i: &f64| match i {
        i if i >= 0.0 && i < count as f64 && i.fract() == 0.0 => Ok((base + i as usize) as u32),
        i => Err(Fault::new(format!(
            "a face names {what} {i}, but there are {count} (counted from 0)"
        ))),
    };
    index.unwrap_or_default().iter().map(one).collect()
}

/// A rotation `x y z angle` (radians); the identity where the axis is zero.
pub(super) fn rotation([x, y, z, angle]: [f64; 4]) -> Matrix4<f64> {
    match nalgebra::Unit::try_new(Vec3::new(x, y, z), 1e-12) {
        Some(axis) => Matrix4::from_axis_angle(&axis, angle),
        None => Matrix4::identity(),
    }
}

/// The matrix `T C R SR S -SR -C` of both versions' Transform node.
pub(super) fn transform(
    translation: [f64; 3],
    turn: [f64; 4],
    scale: [f64; 3],
    scale_orientation: [f64; 4],
    center: [f64; 3],
) -> Matrix4<f64> {
    let shift = |v: [f64; 3]| Matrix4::new_translation(&Vec3::from(v));
    let [x, y, z, angle] = scale_orientation;
    shift(translation)
        * shift(center)
        * rotation(turn)
        * rotation(scale_orientation)
        * Matrix4::new_nonuniform_scaling(&Vec3::from(scale))
        * rotation([x, y, z, -angle])
        * shift(center.map(|c| -c))
}
