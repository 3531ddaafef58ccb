//! Closest point on a triangle mesh, by a tree of bounding boxes.

use crate::data::Mesh;
use crate::math::{Vec3, interpolate};

/// A point on a mesh's surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Face it lies on.
    pub face: usize,
    /// Barycentric weights of the face's corners.
    pub barycentric: [f64; 3],
    /// Position.
    pub point: Vec3,
    /// Distance from the query.
    pub distance: f64,
}

#[derive(Clone)]
struct Node {
    low: Vec3,
    high: Vec3,
    /// Inner node: index of the second child (the first is the next node). Leaf: unused.
    second: u32,
    /// Leaf: its range in `order`. Inner node: `count` is 0.
    start: u32,
    count: u32,
}

/// A search tree over the faces of a mesh.
///
/// ```
/// use facerecon_core::{data::Mesh, math::Vec3, spatial::SurfaceIndex};
/// let vertices = vec![Vec3::zeros(), Vec3::x(), Vec3::y()];
/// let mesh = Mesh { vertices, faces: vec![[0, 1, 2]], ..Mesh::default() };
/// let closest = SurfaceIndex::new(&mesh).unwrap().closest(&Vec3::new(0.2, 0.2, 3.0)).unwrap();
/// assert!((closest.distance - 3.0).abs() < 1e-12);
/// ```
pub struct SurfaceIndex {
    nodes: Vec<Node>,
    order: Vec<u32>,
    /// Corners of the faces, in the order of `order`.
    triangles: Vec<[Vec3; 3]>,
}

/// Faces in a leaf at most.
const LEAF: usize = 4;
/// Nodes that wait at most during a search: one for each level, and a tree over 2^32 faces has no
/// more levels than this.
const STACK: usize = 34;

impl SurfaceIndex {
    /// Builds the tree; `None` when the mesh is not valid.
    pub fn new(mesh: &Mesh) -> Option<Self> {
        mesh.validate().ok()?;
        let triangles: Vec<_> = (0..mesh.faces.len()).map(|f| mesh.corners(f)).collect();
        let centres: Vec<Vec3> = triangles.iter().map(|t| (t[0] + t[1] + t[2]) / 3.0).collect();
        let mut order: Vec<u32> = (0..triangles.len() as u32).collect();
        let empty = Node { low: Vec3::zeros(), high: Vec3::zeros(), second: 0, start: 0, count: 0 };
        let mut nodes = vec![empty; node_count(order.len())];
        build(&mut nodes, 0, &mut order, 0, &triangles, &centres);
        let triangles = order.iter().map(|&f| triangles[f as usize]).collect();
        Some(Self { nodes, order, triangles })
    }

    /// The closest point on the surface; `None` when the query is not finite.
    pub fn closest(&self, query: &Vec3) -> Option<SurfacePoint> {
        self.closest_within(query, f64::INFINITY)
    }

    /// The closest point on the surface, no farther than `max_distance`.
    pub fn closest_within(&self, query: &Vec3, max_distance: f64) -> Option<SurfacePoint> {
        if !query.iter().all(|c| c.is_finite()) {
            return None;
        }
        let mut best: Option<SurfacePoint> = None;
        let mut limit = max_distance * max_distance;
        let mut waiting = [(0usize, 0.0f64); STACK];
        let mut count = 1;
        while count > 0 {
            count -= 1;
            let (id, distance) = waiting[count];
            if distance > limit {
                continue;
            }
            let node = &self.nodes[id];
            if node.count > 0 {
                let range = node.start as usize..(node.start + node.count) as usize;
                for (triangle, &face) in
                    self.triangles[range.clone()].iter().zip(&self.order[range])
                {
                    let (point, barycentric) = on_triangle(query, triangle);
                    let d2 = (point - query).norm_squared();
                    let face = face as usize;
                    let better = match &best {
                        None => d2 <= limit,
                        // ties by face number: the result does not depend on the shape of the tree
                        Some(b) => d2 < limit || (d2 == limit && face < b.face),
                    };
                    if better {
                        limit = d2;
                        best = Some(SurfacePoint { face, barycentric, point, distance: d2.sqrt() });
                    }
                }
            } else {
                let children = [id + 1, node.second as usize];
                let [first, second] = children.map(|c| (c, box_distance(&self.nodes[c], query)));
                let (near, far) =
                    if first.1 <= second.1 { (first, second) } else { (second, first) };
                waiting[count] = far;
                waiting[count + 1] = near;
                count += 2;
            }
        }
        best
    }
}

/// Number of nodes of a tree; its shape depends on the number of faces alone.
fn node_count(faces: usize) -> usize {
    if faces <= LEAF {
        return 1;
    }
    1 + node_count(faces / 2) + node_count(faces - faces / 2)
}

/// Subtrees over more faces than this are built in parallel.
const PARALLEL_FACES: usize = 4096;

/// Builds the tree over the faces in `order` into `nodes`. The first of these faces is number
/// `start` of all faces, the first of these nodes number `id` of all nodes.
fn build(
    nodes: &mut [Node],
    id: usize,
    order: &mut [u32],
    start: usize,
    triangles: &[[Vec3; 3]],
    centres: &[Vec3],
) {
    let mut low = Vec3::repeat(f64::INFINITY);
    let mut high = -low;
    for corner in order.iter().flat_map(|&f| &triangles[f as usize]) {
        low = low.inf(corner);
        high = high.sup(corner);
    }
    let count = order.len();
    let middle = count / 2;
    let second = 1 + node_count(middle);
    if count <= LEAF {
        nodes[0] = Node { low, high, second: 0, start: start as u32, count: count as u32 };
        return;
    }
    nodes[0] = Node { low, high, second: (id + second) as u32, start: start as u32, count: 0 };
    let axis = (high - low).imax();
    order.select_nth_unstable_by(middle, |&a, &b| {
        let (x, y) = (centres[a as usize][axis], centres[b as usize][axis]);
        x.total_cmp(&y).then(a.cmp(&b))
    });
    let (lower, upper) = order.split_at_mut(middle);
    let (left, right) = nodes[1..].split_at_mut(second - 1);
    let mut lower = || build(left, id + 1, lower, start, triangles, centres);
    let mut upper = || build(right, id + second, upper, start + middle, triangles, centres);
    if count > PARALLEL_FACES {
        rayon::join(lower, upper);
    } else {
        lower();
        upper();
    }
}

fn box_distance(node: &Node, p: &Vec3) -> f64 {
    let outside = (node.low - p).sup(&(p - node.high)).sup(&Vec3::zeros());
    outside.norm_squared()
}

/// Closest point of a triangle and its barycentric weights (Ericson 2005, section 5.1.5).
fn on_triangle(p: &Vec3, [a, b, c]: &[Vec3; 3]) -> (Vec3, [f64; 3]) {
    let (ab, ac) = (b - a, c - a);
    let weights = barycentric_of_closest(p, a, b, c, &ab, &ac);
    (interpolate([*a, *b, *c], weights), weights)
}

fn barycentric_of_closest(
    p: &Vec3,
    a: &Vec3,
    b: &Vec3,
    c: &Vec3,
    ab: &Vec3,
    ac: &Vec3,
) -> [f64; 3] {
    let ap = p - a;
    let (d1, d2) = (ab.dot(&ap), ac.dot(&ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(&bp), ac.dot(&bp));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 && d1 - d3 > 0.0 {
        let v = d1 / (d1 - d3);
        return [1.0 - v, v, 0.0];
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(&cp), ac.dot(&cp));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 && d2 - d6 > 0.0 {
        let w = d2 / (d2 - d6);
        return [1.0 - w, 0.0, w];
    }
    let va = d3 * d6 - d5 * d4;
    let (e, f) = (d4 - d3, d5 - d6);
    if va <= 0.0 && e >= 0.0 && f >= 0.0 && e + f > 0.0 {
        let w = e / (e + f);
        return [0.0, 1.0 - w, w];
    }
    let sum = va + vb + vc;
    if sum > 0.0 {
        return [va / sum, vb / sum, vc / sum];
    }
    [1.0, 0.0, 0.0] // a triangle without area
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::test_meshes::open_grid;

    fn bumpy() -> Mesh {
        open_grid(20, 20, |x, y| Vec3::new(x, y, (x * 0.9).sin() * 3.0 + (y * 0.6).cos() * 2.0))
    }

    #[test]
    fn agrees_with_an_exhaustive_search() {
        let mesh = bumpy();
        let index = SurfaceIndex::new(&mesh).unwrap();
        for k in 0..200 {
            let t = f64::from(k);
            let q = Vec3::new((t * 1.7).sin(), (t * 0.31).cos(), (t * 2.3).sin()) * 15.0
                + Vec3::new(10.0, 10.0, 0.0);
            let naive = (0..mesh.faces.len())
                .map(|f| (on_triangle(&q, &mesh.corners(f)).0 - q).norm())
                .fold(f64::INFINITY, f64::min);
            let found = index.closest(&q).unwrap();
            assert!((found.distance - naive).abs() < 1e-12);
            let corners = mesh.corners(found.face);
            let again = interpolate(corners, found.barycentric);
            assert!((again - found.point).norm() < 1e-12);
        }
        assert!(index.closest(&Vec3::new(f64::NAN, 0.0, 0.0)).is_none());
        assert!(index.closest_within(&Vec3::new(10.0, 10.0, 90.0), 5.0).is_none());
    }

    #[test]
    fn no_sample_of_a_triangle_is_closer_than_its_closest_point() {
        let triangle = [Vec3::zeros(), Vec3::new(4.0, 0.0, 0.0), Vec3::new(1.0, 3.0, 1.0)];
        for k in 0..60 {
            let t = f64::from(k);
            let q = Vec3::new((t * 0.7).sin() * 6.0, (t * 1.9).cos() * 6.0, (t * 0.3).sin() * 4.0);
            let (point, _) = on_triangle(&q, &triangle);
            for i in 0..=40 {
                for j in 0..=(40 - i) {
                    let (u, v) = (f64::from(i) / 40.0, f64::from(j) / 40.0);
                    let s = triangle[0] * (1.0 - u - v) + triangle[1] * u + triangle[2] * v;
                    assert!((point - q).norm() <= (s - q).norm() + 1e-12);
                }
            }
        }
    }
}
