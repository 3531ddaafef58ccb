//! Matches of the head's silhouette with the subject's outline in the photos.
//!
//! A vertex on the silhouette of the head belongs on the outline of the subject, from inside and
//! from outside, and no vertex belongs beyond it. Either is a plane through the outline along the
//! line of sight, to which the vertex is matched.

use rayon::prelude::*;

use super::super::OutlineView;
use super::surface_match::{SurfaceMatch, face_area};
use crate::data::{Mesh, Outline, Raster, Topology};
use crate::math::{Vec2, Vec3};

/// Weight relative to data that cover the area of the vertex: only a narrow strip of the head is on
/// the outline, with nothing measured behind it.
const WEIGHT: f64 = 2.0;
/// Weight of a vertex that stands out without being on the silhouette: its neighbours on the
/// silhouette hold it too.
const BEYOND_WEIGHT: f64 = 0.5;
/// A vertex within this of the line counts as on it, pixels.
const ON_LINE_PX: f64 = 0.5;
/// Vertices between front and back so close to the silhouette of the head are on it, cells; beyond
/// lie the contours of nose, lips and lids.
const SILHOUETTE_CELLS: f64 = 2.5;
/// Least cosine in the photo between the directions of the head's silhouette and of the outline:
/// the neck does not follow the shoulders.
const MIN_COSINE: f64 = 0.7;
/// Rounds and smoothing rounds of the last correction.
const BOUND_ROUNDS: usize = 3;
const SMOOTHING_ROUNDS: usize = 6;

/// A vertex with its offset to the outline in one photo.
struct Offset {
    vertex: usize,
    /// From the vertex to the outline, across the line of sight.
    offset: Vec3,
    /// Unit direction out of the subject, across the line of sight.
    outward: Vec3,
    /// Whether the vertex is on the head's silhouette.
    on_silhouette: bool,
    /// Whether it stands out beyond the outline.
    is_beyond: bool,
}

/// The outlines that bound the head.
pub(super) struct OutlineMatcher<'a> {
    views: &'a [OutlineView<'a>],
    border_rings: usize,
}

impl<'a> OutlineMatcher<'a> {
    /// Vertices within `border_rings` of the template's open border are not matched.
    pub fn new(views: &'a [OutlineView<'a>], border_rings: usize) -> Self {
        Self { views, border_rings }
    }

    /// Whether any outline is known.
    pub fn is_empty(&self) -> bool {
        self.views.is_empty()
    }

    /// Matches of vertices no farther than `reach_mm` from the outline. `area_mm2` is the area that
    /// a match of weight 1 stands for.
    pub fn find(&self, mesh: &Mesh, reach_mm: f64, area_mm2: f64) -> Vec<SurfaceMatch> {
        if self.is_empty() {
            return Vec::new();
        }
        let free = self.free_vertices(mesh);
        let mut areas = vec![0.0; mesh.vertices.len()];
        for face in &mesh.faces {
            face.iter().for_each(|&v| areas[v as usize] += face_area(mesh, face) / 3.0);
        }
        let to_match = |o: Offset| {
            let share = if o.on_silhouette { WEIGHT } else { BEYOND_WEIGHT };
            SurfaceMatch {
                data: mesh.vertices[o.vertex] + o.offset,
                corners: [o.vertex; 3],
                barycentric: [1.0, 0.0, 0.0],
                closest_point: mesh.vertices[o.vertex],
                normal: o.outward,
                weight: share * areas[o.vertex] / area_mm2.max(1e-6),
                cell: 0,
                small_component: None,
            }
        };
        let offsets = self.views.iter().flat_map(|view| offsets(mesh, view, &free, true));
        offsets.filter(|o| o.offset.norm() <= reach_mm).map(to_match).collect()
    }

    /// Moves the vertices that still stand out to the outline; neighbours follow smoothly.
    pub fn bound(&self, mesh: &mut Mesh, reach_mm: f64) {
        if self.is_empty() {
            return;
        }
        let free = self.free_vertices(mesh);
        let topology = Topology::new(mesh);
        for _ in 0..BOUND_ROUNDS {
            for view in self.views {
                let mut moved = vec![Vec3::zeros(); mesh.vertices.len()];
                let mut is_held = vec![false; mesh.vertices.len()];
                for o in offsets(mesh, view, &free, false) {
                    if o.is_beyond && o.offset.norm() <= reach_mm {
                        moved[o.vertex] = o.offset;
                        is_held[o.vertex] = true;
                    }
                }
                if !is_held.contains(&true) {
                    continue;
                }
                for _ in 0..SMOOTHING_ROUNDS {
                    let last = moved.clone();
                    for (v, near) in topology.neighbours.iter().enumerate() {
                        if !is_held[v] && free[v] {
                            let sum: Vec3 = near.iter().map(|&n| last[n as usize]).sum();
                            moved[v] = sum / near.len().max(1) as f64;
                        }
                    }
                }
                mesh.vertices.iter_mut().zip(&moved).for_each(|(v, d)| *v += d);
            }
        }
    }

    fn free_vertices(&self, mesh: &Mesh) -> Vec<bool> {
        let rings = Topology::new(mesh).rings_from_border();
        rings.iter().map(|r| *r as usize >= self.border_rings).collect()
    }
}

/// The offsets to the outline in one photo, in the order of the vertices: those of the silhouette
/// (where wanted) and those of vertices beyond the outline.
fn offsets(mesh: &Mesh, view: &OutlineView<'_>, free: &[bool], silhouette: bool) -> Vec<Offset> {
    let placed: Vec<Vec3> =
        mesh.vertices.par_iter().map(|v| view.camera_from_mesh.apply(v)).collect();
    let pixels: Vec<Option<Vec2>> = placed.par_iter().map(|p| view.camera.project(p)).collect();
    let normals = mesh.vertex_normals();
    let own = silhouette.then(|| head_outline(mesh, &pixels, view.outline));
    let turning = if silhouette { turning_vertices(mesh, &placed) } else { Vec::new() };
    let (_, step) = view.outline.grid();
    let one = |v: usize| -> Option<Offset> {
        let pixel = pixels[v].filter(|_| free[v])?;
        let distance = view.outline.distance_px(pixel)?;
        let is_beyond = distance > ON_LINE_PX;
        let on_silhouette = turning.get(v).is_some_and(|t| *t)
            && own
                .as_ref()
                .and_then(|o| o.distance_px(pixel))
                .is_some_and(|d| d > -SILHOUETTE_CELLS * step as f64);
        if !is_beyond && !on_silhouette {
            return None;
        }
        let direction = view.outline.outward(pixel)?;
        let across = |d: Vec2| {
            let width = placed[v].z / view.camera.fx;
            let in_camera = Vec3::new(d.x, d.y, 0.0) * width;
            // perpendicular to the line of sight
            let ray = placed[v].try_normalize(1e-9)?;
            let in_camera = in_camera - ray * ray.dot(&in_camera);
            let turned = view.camera_from_mesh.rotation.transpose() * in_camera;
            Some(turned / view.camera_from_mesh.scale)
        };
        let outward = across(direction)?.try_normalize(1e-12)?;
        let follows = normals[v].dot(&outward) > MIN_COSINE;
        if !is_beyond && !follows {
            return None;
        }
        Some(Offset {
            vertex: v,
            offset: across(direction * -distance)?,
            outward,
            on_silhouette: on_silhouette && follows,
            is_beyond,
        })
    };
    (0..mesh.vertices.len()).into_par_iter().filter_map(one).collect()
}

/// Vertices with faces toward the camera and faces away from it.
fn turning_vertices(mesh: &Mesh, placed: &[Vec3]) -> Vec<bool> {
    let mut sides = vec![[false; 2]; mesh.vertices.len()];
    for face in &mesh.faces {
        let [a, b, c] = face.map(|v| placed[v as usize]);
        let is_front = (b - a).cross(&(c - a)).dot(&a) < 0.0;
        face.iter().for_each(|&v| sides[v as usize][usize::from(is_front)] = true);
    }
    sides.iter().map(|s| s[0] && s[1]).collect()
}

/// The outline of the head itself on the grid of the subject's.
fn head_outline(mesh: &Mesh, pixels: &[Option<Vec2>], like: &Outline) -> Outline {
    let ((width, height), step) = like.grid();
    let mut mask = Raster::filled(width, height, false);
    let cell = |p: Vec2| (p + Vec2::repeat(0.5)) / step as f64 - Vec2::repeat(0.5);
    for face in &mesh.faces {
        let corners = face.map(|v| pixels[v as usize].map(cell));
        if let [Some(a), Some(b), Some(c)] = corners {
            fill(&mut mask, [a, b, c]);
        }
    }
    Outline::from_mask(&mask, &Raster::filled(width, height, true), step)
}

/// Marks the cells whose centres lie in a triangle, row by row.
fn fill(mask: &mut Raster<bool>, corners: [Vec2; 3]) {
    let (width, height) = mask.size();
    let low = corners.iter().map(|p| p.y).fold(f64::INFINITY, f64::min).ceil().max(0.0);
    let high = corners.iter().map(|p| p.y).fold(f64::NEG_INFINITY, f64::max).floor();
    let mut y = low;
    while y <= high.min(height as f64 - 1.0) {
        let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            if (a.y - y) * (b.y - y) <= 0.0 {
                let t = if a.y == b.y { 0.0 } else { (y - a.y) / (b.y - a.y) };
                let x = a.x + t * (b.x - a.x);
                (left, right) = (left.min(x), right.max(x));
                if a.y == b.y {
                    (left, right) = (left.min(b.x), right.max(b.x));
                }
            }
        }
        let (first, last) = (left.ceil().max(0.0), right.floor().min(width as f64 - 1.0));
        if first <= last {
            (first as usize..=last as usize).for_each(|x| mask.set(x, y as usize, true));
        }
        y += 1.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Pinhole;
    use crate::math::Similarity;

    /// A sphere of radius 60 mm about the origin.
    fn sphere() -> Mesh {
        let (rows, columns) = (40u32, 60u32);
        let mut mesh = Mesh::default();
        for i in 0..=rows {
            for j in 0..columns {
                let a = std::f64::consts::PI * f64::from(i) / f64::from(rows);
                let b = std::f64::consts::TAU * f64::from(j) / f64::from(columns);
                mesh.vertices.push(Vec3::new(a.sin() * b.cos(), a.cos(), a.sin() * b.sin()) * 60.0);
            }
        }
        for i in 0..rows {
            for j in 0..columns {
                let at = |i: u32, j: u32| i * columns + j % columns;
                mesh.faces.push([at(i, j), at(i, j + 1), at(i + 1, j)]);
                mesh.faces.push([at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)]);
            }
        }
        mesh
    }

    /// The outline of a ball of some radius, mm, seen from 1 m.
    fn ball(radius_mm: f64) -> (Outline, Pinhole, Similarity) {
        let camera = Pinhole::ideal(1000.0, Vec2::new(150.0, 120.0));
        let pose = Similarity::rigid(crate::math::Mat3::identity(), Vec3::z() * 1000.0);
        let subject = Raster::from_fn(300, 240, |x, y| {
            (x as f64 - 150.0).hypot(y as f64 - 120.0) < radius_mm
        });
        let outline = Outline::from_mask(&subject, &subject.map(|_| true), 1);
        (outline, camera, pose)
    }

    #[test]
    fn the_silhouette_is_matched_from_inside_and_from_outside() {
        for radius_mm in [50.0, 70.0] {
            let (outline, camera, camera_from_mesh) = ball(radius_mm);
            let views = [OutlineView { camera, camera_from_mesh, outline: &outline }];
            let found = OutlineMatcher::new(&views, 3).find(&sphere(), 30.0, 1.0);
            assert!(found.len() > 60, "{radius_mm}: {}", found.len());
            for m in found.iter().filter(|m| m.closest_point.xy().norm() > 59.0) {
                let radius = m.data.xy().norm();
                assert!((radius - radius_mm).abs() < 1.5, "{radius_mm}: {radius}");
            }
            // the silhouette is 10 mm from the outline: out of a reach of 5 mm
            let near = OutlineMatcher::new(&views, 3).find(&sphere(), 5.0, 1.0);
            assert!(near.iter().all(|m| m.closest_point.xy().norm() < 59.0));
        }
    }

    #[test]
    fn nothing_stands_out_after_bounding_and_nothing_else_moves() {
        let (outline, camera, camera_from_mesh) = ball(55.0);
        let views = [OutlineView { camera, camera_from_mesh, outline: &outline }];
        let mut mesh = sphere();
        OutlineMatcher::new(&views, 3).bound(&mut mesh, 30.0);
        // the poles are an open border, which stays free
        let bounded = mesh.vertices.iter().filter(|v| v.y.abs() < 50.0);
        let widest = bounded.map(|v| v.xy().norm()).fold(0.0, f64::max);
        assert!(widest < 56.5, "{widest}");
        let mut inside = sphere();
        let (outline, ..) = ball(80.0);
        let views = [OutlineView { outline: &outline, ..views[0] }];
        OutlineMatcher::new(&views, 3).bound(&mut inside, 30.0);
        assert_eq!(inside, sphere());
    }
}
