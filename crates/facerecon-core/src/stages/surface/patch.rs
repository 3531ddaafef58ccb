//! Triangles between measured points, and which of them are a surface.

use crate::math::{Vec2, Vec3};

/// A measured point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Node {
    /// Place in the rectified left picture.
    pub(super) pixel: Vec2,
    /// Disparity there, pixels.
    pub(super) disparity: f64,
    /// Place in space.
    pub(super) point: Vec3,
}

impl Node {
    /// A node, where its place in space is known.
    pub(super) fn new(pixel: Vec2, disparity: f64, place: Place<'_>) -> Option<Self> {
        let point = place(pixel, disparity).filter(|p| p.iter().all(|c| c.is_finite()))?;
        Some(Self { pixel, disparity, point })
    }
}

/// Point in space of a rectified left pixel and its disparity.
pub(super) type Place<'a> = &'a dyn Fn(Vec2, f64) -> Option<Vec3>;

/// Nodes and triangles that overlap nowhere in the picture, counterclockwise as one sees it.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Patch {
    pub(super) nodes: Vec<Node>,
    pub(super) faces: Vec<[u32; 3]>,
}

/// No face, no node.
pub(super) const NONE: u32 = u32::MAX;
/// Triangles at the border with a smaller angle than this in the picture are left out, degrees.
const SLIVER_DEG: f64 = 10.0;
/// Most rings of faces that [`Patch::drop_narrow`] looks through.
const MAX_RINGS: usize = 1000;

impl Patch {
    /// The three nodes of a face.
    pub(super) fn corners(&self, face: [u32; 3]) -> [&Node; 3] {
        face.map(|i| &self.nodes[i as usize])
    }

    /// Twice the area of a face in the picture; positive when counterclockwise as one sees it.
    pub(super) fn double_area_px(&self, face: [u32; 3]) -> f64 {
        let [a, b, c] = self.corners(face).map(|n| n.pixel);
        // y runs down
        -(b - a).perp(&(c - a))
    }

    /// Adds a face, turned counterclockwise; one without area is left out.
    pub(super) fn add(&mut self, face: [u32; 3]) {
        let [a, b, c] = face;
        match self.double_area_px(face) {
            area if area > 1e-9 => self.faces.push(face),
            area if area < -1e-9 => self.faces.push([a, c, b]),
            _ => {}
        }
    }

    /// Leaves out faces with an edge longer than this in the picture.
    pub(super) fn drop_long(&mut self, limit_px: f64) {
        let nodes = &self.nodes;
        let at = |i: u32| nodes[i as usize].pixel;
        self.faces.retain(|&[a, b, c]| {
            [(a, b), (b, c), (c, a)].iter().all(|&(i, j)| (at(i) - at(j)).norm() <= limit_px)
        });
    }

    /// Leaves out faces seen at a flatter angle from midway between the cameras, or from behind;
    /// gives their number.
    pub(super) fn drop_tilted(&mut self, max_tilt_deg: f64, place: Place<'_>) -> usize {
        let least_cosine = max_tilt_deg.to_radians().cos();
        let before = self.faces.len();
        let nodes = &self.nodes;
        self.faces.retain(|face| {
            let [a, b, c] = face.map(|i| &nodes[i as usize]);
            let normal = (b.point - a.point).cross(&(c.point - a.point));
            let pixel = (a.pixel + b.pixel + c.pixel) / 3.0;
            let disparity = (a.disparity + b.disparity + c.disparity) / 3.0;
            let facing = toward(pixel, disparity, place)
                .map_or(0.0, |t| normal.dot(&t) / (normal.norm() * t.norm()).max(1e-300));
            facing >= least_cosine
        });
        before - self.faces.len()
    }

    /// Leaves out what a disc of this diameter does not reach without leaving the patch, counted in
    /// rings of faces (a morphological opening).
    pub(super) fn drop_narrow(&mut self, width_px: f64) {
        let lengths = self
            .faces
            .iter()
            .map(|&[a, b, _]| (self.nodes[a as usize].pixel - self.nodes[b as usize].pixel).norm());
        let edge_px = lengths.sum::<f64>() / self.faces.len().max(1) as f64;
        // more rings than this leave nothing of any patch
        let rings = ((0.5 * width_px / edge_px).round() as usize).min(MAX_RINGS);
        if rings == 0 || self.faces.is_empty() {
            return;
        }
        let mut outside = vec![false; self.nodes.len()];
        for (face, beside) in self.faces.iter().zip(neighbours(&self.faces)) {
            for k in (0..3).filter(|&k| beside[k] == NONE) {
                outside[face[k] as usize] = true;
                outside[face[(k + 1) % 3] as usize] = true;
            }
        }
        (1..rings).for_each(|_| self.spread(&mut outside));
        let mut inside: Vec<bool> = outside.iter().map(|o| !o).collect();
        (0..rings).for_each(|_| self.spread(&mut inside));
        self.faces.retain(|face| face.iter().all(|&n| inside[n as usize]));
    }

    /// Marks the nodes that share a face with a marked one.
    fn spread(&self, marked: &mut [bool]) {
        let before = marked.to_vec();
        for face in &self.faces {
            if face.iter().any(|&n| before[n as usize]) {
                face.iter().for_each(|&n| marked[n as usize] = true);
            }
        }
    }

    /// Leaves out, from the border inward, faces that hang on by one edge only or are slivers.
    pub(super) fn drop_ears(&mut self) {
        let neighbours = neighbours(&self.faces);
        let mut alive = vec![true; self.faces.len()];
        let mut waiting: Vec<u32> = (0..self.faces.len() as u32).rev().collect();
        while let Some(face) = waiting.pop() {
            let f = face as usize;
            let beside = neighbours[f].iter().filter(|&&n| n != NONE && alive[n as usize]);
            let held = beside.clone().count();
            if !alive[f] || held == 3 || (held == 2 && !self.is_sliver(self.faces[f])) {
                continue;
            }
            waiting.extend(beside);
            alive[f] = false;
        }
        let mut alive = alive.into_iter();
        self.faces.retain(|_| alive.next() == Some(true));
    }

    fn is_sliver(&self, face: [u32; 3]) -> bool {
        let p = self.corners(face).map(|n| n.pixel);
        let least = (0..3)
            .map(|k| (p[(k + 1) % 3] - p[k]).angle(&(p[(k + 2) % 3] - p[k])))
            .fold(f64::INFINITY, f64::min);
        least < SLIVER_DEG.to_radians()
    }

    /// Gives each fan of faces its own node where several meet in one node only, and takes nodes
    /// without faces out: the patch is manifold afterwards.
    pub(super) fn part_pinched(&mut self) {
        let neighbours = neighbours(&self.faces);
        let mut fans = vec![[NONE; 3]; self.faces.len()];
        let mut nodes = Vec::with_capacity(self.nodes.len());
        for start in 0..self.faces.len() {
            for corner in 0..3 {
                if fans[start][corner] != NONE {
                    continue;
                }
                let node = self.faces[start][corner];
                let name = nodes.len() as u32;
                nodes.push(self.nodes[node as usize]);
                let mut waiting = vec![start];
                while let Some(face) = waiting.pop() {
                    let Some(k) = self.faces[face].iter().position(|&n| n == node) else {
                        continue;
                    };
                    if fans[face][k] != NONE {
                        continue;
                    }
                    fans[face][k] = name;
                    // across the two edges that meet in this corner
                    for edge in [k, (k + 2) % 3] {
                        let next = neighbours[face][edge];
                        if next != NONE {
                            waiting.push(next as usize);
                        }
                    }
                }
            }
        }
        self.nodes = nodes;
        self.faces = fans;
    }

    /// Takes nodes without faces out; the others keep their order.
    pub(super) fn drop_bare_nodes(&mut self) {
        let mut names = vec![NONE; self.nodes.len()];
        self.faces.iter().flatten().for_each(|&n| names[n as usize] = 0);
        let mut kept = Vec::new();
        for (node, name) in self.nodes.iter().zip(&mut names) {
            if *name != NONE {
                *name = kept.len() as u32;
                kept.push(*node);
            }
        }
        self.nodes = kept;
        self.faces.iter_mut().flatten().for_each(|n| *n = names[*n as usize]);
    }
}

/// Direction from a point toward the middle between the cameras: where it goes when its disparity
/// grows and its place midway between both pictures stays.
fn toward(pixel: Vec2, disparity: f64, place: Place<'_>) -> Option<Vec3> {
    const STEP_PX: f64 = 0.5;
    let near = place(pixel + Vec2::new(0.25 * STEP_PX, 0.0), disparity + 0.5 * STEP_PX)?;
    let far = place(pixel - Vec2::new(0.25 * STEP_PX, 0.0), disparity - 0.5 * STEP_PX)?;
    Some(near - far)
}

/// For each face its neighbours across the edges 0-1, 1-2, 2-0; [`NONE`] on the border.
pub(super) fn neighbours(faces: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut edges: Vec<(u32, u32, u32, u8)> = Vec::with_capacity(3 * faces.len());
    for (number, face) in faces.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (face[k], face[(k + 1) % 3]);
            edges.push((a.min(b), a.max(b), number as u32, k as u8));
        }
    }
    edges.sort_unstable();
    let mut out = vec![[NONE; 3]; faces.len()];
    for pair in edges.windows(2) {
        let ((a, b, f, i), (c, d, g, j)) = (pair[0], pair[1]);
        if (a, b) == (c, d) {
            out[f as usize][i as usize] = g;
            out[g as usize][j as usize] = f;
        }
    }
    out
}
