//! The region that is scanned, in a photo and on the texture map (thesis section 5.2).

use super::{Boundary, TextureDot, TextureError};
use crate::data::Mesh;
use crate::math::{Vec2, mad};

/// A dot with its place on the texture map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Anchor {
    /// Position in the photo, pixels.
    pub photo: Vec2,
    /// Position on the texture, texels, y down.
    pub texel: Vec2,
}

/// The matched dots that lie inside the photo, with the texel of their vertex; those that do not
/// fit the others' common course are left out, since one wrong dot would be an extreme one.
pub fn anchors(
    mesh: &Mesh,
    dots: &[TextureDot],
    photo_size: (usize, usize),
    texture_size: usize,
) -> Vec<Anchor> {
    let uv = vertex_uvs(mesh);
    let (w, h) = (photo_size.0 as f64 - 0.5, photo_size.1 as f64 - 0.5);
    let mut list: Vec<Anchor> = dots
        .iter()
        .filter(|d| d.pixel.x > -0.5 && d.pixel.y > -0.5 && d.pixel.x < w && d.pixel.y < h)
        .filter_map(|d| {
            let [u, v] = uv[d.vertex]?;
            Some(Anchor { photo: d.pixel, texel: to_texel([u, v], texture_size) })
        })
        .collect();
    for _ in 0..3 {
        let misses = misses(&list);
        let least = 0.01 * texture_size as f64; // how well the cubic course can hold
        let Some(limit) = mad(&misses).map(|m| 5.0 * m.max(least)) else {
            break;
        };
        let before = list.len();
        let mut miss = misses.iter();
        list.retain(|_| miss.next().is_none_or(|m| *m <= limit));
        if list.len() == before {
            break;
        }
    }
    list
}

/// Texel position (pixel centres at integers, y down) of a texture coordinate (v up).
pub fn to_texel([u, v]: [f64; 2], size: usize) -> Vec2 {
    Vec2::new(u, 1.0 - v) * size as f64 - Vec2::repeat(0.5)
}

/// The texture coordinate of each vertex, of its first face; `None` for a vertex without one.
fn vertex_uvs(mesh: &Mesh) -> Vec<Option<[f64; 2]>> {
    let mut uvs = vec![None; mesh.vertices.len()];
    for (face, corners) in mesh.faces.iter().zip(&mesh.face_uvs) {
        for (&vertex, &uv) in face.iter().zip(corners) {
            let [u, v] = mesh.uvs[uv as usize];
            if u.is_finite() && v.is_finite() {
                uvs[vertex as usize].get_or_insert([u, v]);
            }
        }
    }
    uvs
}

/// How far each texel lies from a cubic course of the photo position; a flattened head is a smooth
/// function of where it is seen.
fn misses(list: &[Anchor]) -> Vec<f64> {
    let (low, high) = photo_bounds(list);
    let half = ((high - low) / 2.0).sup(&Vec2::repeat(1e-9));
    let middle = (high + low) / 2.0;
    let terms = |p: &Vec2| -> [f64; 10] {
        let (x, y) = ((p.x - middle.x) / half.x, (p.y - middle.y) / half.y);
        [1.0, x, y, x * x, x * y, y * y, x * x * x, x * x * y, x * y * y, y * y * y]
    };
    let mut normal = nalgebra::SMatrix::<f64, 10, 10>::identity() * 1e-6;
    let mut right = nalgebra::SMatrix::<f64, 10, 2>::zeros();
    for a in list {
        let t = nalgebra::SVector::<f64, 10>::from(terms(&a.photo));
        normal += t * t.transpose();
        right += t * a.texel.transpose();
    }
    let Some(solved) = normal.cholesky().map(|c| c.solve(&right)) else {
        return vec![0.0; list.len()];
    };
    list.iter()
        .map(|a| {
            let t = nalgebra::SVector::<f64, 10>::from(terms(&a.photo));
            (solved.transpose() * t - a.texel).norm()
        })
        .collect()
}

fn photo_bounds(list: &[Anchor]) -> (Vec2, Vec2) {
    let start = (Vec2::repeat(f64::INFINITY), Vec2::repeat(f64::NEG_INFINITY));
    list.iter().fold(start, |(lo, hi), a| (lo.inf(&a.photo), hi.sup(&a.photo)))
}

/// The four extreme dots of a photo.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extremes {
    /// Least x.
    pub left: Anchor,
    /// Greatest x.
    pub right: Anchor,
    /// Least y.
    pub top: Anchor,
    /// Greatest y.
    pub bottom: Anchor,
}

impl Extremes {
    /// Finds them; `None` without dots.
    pub fn new(list: &[Anchor]) -> Option<Self> {
        let by =
            |key: fn(&Anchor) -> f64| list.iter().copied().min_by(|a, b| key(a).total_cmp(&key(b)));
        Some(Self {
            left: by(|a| a.photo.x)?,
            right: by(|a| -a.photo.x)?,
            top: by(|a| a.photo.y)?,
            bottom: by(|a| -a.photo.y)?,
        })
    }
}

/// A polygon whose rows are single spans: left and right edge chains, ordered by y.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    left: Vec<Vec2>,
    right: Vec<Vec2>,
}

impl Region {
    /// The region in the photo.
    pub fn photo(e: &Extremes, kind: Boundary) -> Self {
        Self::new([e.left.photo, e.right.photo, e.top.photo, e.bottom.photo], kind)
    }

    /// The like region on the texture, from the vertices of the same dots.
    ///
    /// # Errors
    /// [`TextureError::Boundary`] when it has no area.
    pub fn texture(e: &Extremes, kind: Boundary) -> Result<Self, TextureError> {
        let (width, height) = (e.right.texel.x - e.left.texel.x, e.bottom.texel.y - e.top.texel.y);
        if !(width >= 2.0 && height >= 2.0) {
            return Err(TextureError::Boundary { width, height });
        }
        Ok(Self::new([e.left.texel, e.right.texel, e.top.texel, e.bottom.texel], kind))
    }

    /// A hexagon has its outer corners at the leftmost and rightmost dot, though never in the upper
    /// or lower fifth; top and bottom edge are half as wide as the box, as in a regular one.
    fn new([l, r, t, b]: [Vec2; 4], kind: Boundary) -> Self {
        let inset = match kind {
            Boundary::Rectangle => 0.0,
            Boundary::Hexagon => (r.x - l.x) / 4.0,
        };
        let margin = 0.2 * (b.y - t.y).abs();
        let (high, low) = (t.y.min(b.y) + margin, b.y.max(t.y) - margin);
        let chain = |outer: Vec2, side: f64| match kind {
            Boundary::Rectangle => vec![Vec2::new(outer.x, t.y), Vec2::new(outer.x, b.y)],
            Boundary::Hexagon => vec![
                Vec2::new(outer.x + side * inset, t.y),
                Vec2::new(outer.x, outer.y.clamp(high, low)),
                Vec2::new(outer.x + side * inset, b.y),
            ],
        };
        Self { left: chain(l, 1.0), right: chain(r, -1.0) }
    }

    /// First and last row.
    pub fn rows(&self) -> (f64, f64) {
        (self.left[0].y, self.left[self.left.len() - 1].y)
    }

    /// The span of a row, clamped to the first and last.
    pub fn span(&self, y: f64) -> (f64, f64) {
        let x = |chain: &[Vec2]| {
            let points: Vec<(f64, f64)> = chain.iter().map(|p| (p.y, p.x)).collect();
            interpolate(&points, y)
        };
        (x(&self.left), x(&self.right))
    }
}

/// Piecewise linear interpolation through knots of ascending first coordinate, constant outside.
pub fn interpolate(knots: &[(f64, f64)], at: f64) -> f64 {
    let after = knots.partition_point(|k| k.0 <= at);
    match (after.checked_sub(1).and_then(|i| knots.get(i)), knots.get(after)) {
        (Some(a), Some(b)) => a.1 + (b.1 - a.1) * (at - a.0) / (b.0 - a.0),
        (Some(k), None) | (None, Some(k)) => k.1,
        (None, None) => at,
    }
}

/// A course from `(from.0, from.1)` to `(to.0, to.1)` through the medians of the samples in equal
/// stretches, strictly rising in both: knots that would fold it are left out.
pub fn course(
    from: (f64, f64),
    to: (f64, f64),
    samples: &[(f64, f64)],
    stretches: usize,
) -> Vec<(f64, f64)> {
    let mut knots = vec![from];
    let width = (to.0 - from.0) / stretches.max(1) as f64;
    let least = 0.15 * width * (to.1 - from.1) / (to.0 - from.0);
    for k in 0..stretches.saturating_sub(1) {
        // stretches end at dots: the knot is the middle of those around the boundary of two
        let centre = from.0 + width * (k + 1) as f64;
        let near: Vec<&(f64, f64)> =
            samples.iter().filter(|s| (s.0 - centre).abs() <= width / 2.0).collect();
        if near.len() < 2 {
            continue;
        }
        let n = near.len() as f64;
        let (a, b) = near.iter().fold((0.0, 0.0), |m, s| (m.0 + s.0 / n, m.1 + s.1 / n));
        let last = knots[knots.len() - 1];
        if a > last.0 && b > last.1 + least && b < to.1 - least && a < to.0 {
            knots.push((a, b));
        }
    }
    knots.push(to);
    knots
}
