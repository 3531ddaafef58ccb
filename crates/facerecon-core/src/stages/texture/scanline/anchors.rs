//! Matched dots in a photo and on the texture map.

use super::super::input::TextureDot;
use crate::data::Mesh;
use crate::math::{Vec2, mad};

/// Dots farther than this many robust standard deviations from the common cubic are outliers.
const MAX_DEVIATIONS: f64 = 5.0;
/// Least standard deviation assumed, as a fraction of the texture size: a cubic does not describe
/// the unfolding of a head more closely.
const LEAST_DEVIATION: f64 = 0.01;
/// Rounds of fitting and dropping.
const ROUNDS: usize = 3;
/// Damping of the fit, so that few dots do not make it singular.
const DAMPING: f64 = 1e-6;

/// A dot with its position on the texture map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Anchor {
    /// Position in the photo, pixels.
    pub photo: Vec2,
    /// Position on the texture, texels, y down.
    pub texel: Vec2,
}

/// The matched dots inside the photo, with the texel of their vertex. Outliers from a common cubic
/// mapping are dropped, since a single one would become an extreme dot.
pub(super) fn anchors(
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
    for _ in 0..ROUNDS {
        let residuals = residuals(&list);
        let least = LEAST_DEVIATION * texture_size as f64;
        let Some(limit) = mad(&residuals).map(|m| MAX_DEVIATIONS * m.max(least)) else {
            break;
        };
        let before = list.len();
        let mut residual = residuals.iter();
        list.retain(|_| residual.next().is_none_or(|r| *r <= limit));
        if list.len() == before {
            break;
        }
    }
    list
}

/// Texel position (pixel centres at integers, y down) of a texture coordinate (v up).
fn to_texel([u, v]: [f64; 2], size: usize) -> Vec2 {
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

/// Distance of each texel from the common cubic function of the photo position, texels: the
/// unfolded head is a smooth function of where it is seen.
fn residuals(list: &[Anchor]) -> Vec<f64> {
    let (low, high) = photo_bounds(list);
    let half = ((high - low) / 2.0).sup(&Vec2::repeat(1e-9));
    let middle = (high + low) / 2.0;
    let terms = |p: &Vec2| -> [f64; 10] {
        let (x, y) = ((p.x - middle.x) / half.x, (p.y - middle.y) / half.y);
        [1.0, x, y, x * x, x * y, y * y, x * x * x, x * x * y, x * y * y, y * y * y]
    };
    let mut normal = nalgebra::SMatrix::<f64, 10, 10>::identity() * DAMPING;
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
