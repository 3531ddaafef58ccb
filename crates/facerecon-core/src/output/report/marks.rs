//! Marks on photographs: dots found, matches coloured by disparity; the texture's coverage.

use crate::data::{Gray, Mesh, Raster, Rgb};
use crate::math::{Vec2, Vec3, percentile};
use crate::stages::texture::{FILLED, SEEN_EXTRA, SEEN_LEFT, SEEN_RIGHT};

/// A grey image as colour.
pub fn colored(gray: &Gray) -> Rgb {
    gray.to_u8().map(|v| [v, v, v])
}

/// Draws a small open cross at each position (pixels); what lies outside is left out.
pub fn crosses(image: &mut Rgb, positions: impl IntoIterator<Item = (Vec2, [u8; 3])>) {
    const ARM: isize = 3;
    for (p, color) in positions {
        if !(p.x.is_finite() && p.y.is_finite()) {
            continue;
        }
        let (x, y) = (p.x.round() as isize, p.y.round() as isize);
        for step in 1..=ARM {
            for (dx, dy) in [(step, 0), (-step, 0), (0, step), (0, -step)] {
                let (u, v) = (x.saturating_add(dx), y.saturating_add(dy));
                if image.get(u, v).is_some() {
                    image.set(u as usize, v as usize, color);
                }
            }
        }
    }
}

/// Marks each position (pixels) with a single point; what lies outside is left out.
pub fn points(image: &mut Rgb, positions: impl IntoIterator<Item = Vec2>, color: [u8; 3]) {
    for p in positions.into_iter().filter(|p| p.x.is_finite() && p.y.is_finite()) {
        let (x, y) = (p.x.round() as isize, p.y.round() as isize);
        if image.get(x, y).is_some() {
            image.set(x as usize, y as usize, color);
        }
    }
}

/// A dark picture made lighter for the eye: its brightest hundredth becomes nearly white, and dark
/// tones gain most.
pub fn brightened(image: &Rgb) -> Rgb {
    let values = image.data().iter().map(|p| f64::from(p[0].max(p[1]).max(p[2])));
    let top = percentile(&values.collect::<Vec<_>>(), 0.99).unwrap_or(255.0).clamp(16.0, 235.0);
    let table: [u8; 256] =
        std::array::from_fn(|v| (235.0 * (v as f64 / top).min(1.08).powf(0.7)).round() as u8);
    image.map(|p| p.map(|v| table[usize::from(v)]))
}

/// Single bright pixels made three wide, so that they survive being scaled down.
pub fn widened(image: &Rgb) -> Rgb {
    Rgb::from_fn(image.width(), image.height(), |x, y| {
        let mut most = [0; 3];
        for (dx, dy) in [(0, 0), (-1, 0), (1, 0), (0, -1), (0, 1)] {
            if let Some(p) = image.get(x as isize + dx, y as isize + dy) {
                most = std::array::from_fn(|c| p[c].max(most[c]));
            }
        }
        most
    })
}

/// A mesh in one light colour with a small blue octahedron at each point (mm, the mesh's frame).
pub(super) fn with_point_markers(mesh: &Mesh, points: &[Vec3]) -> Mesh {
    const SURFACE: [u8; 3] = [226, 216, 206];
    const MARKER: [u8; 3] = [38, 110, 190];
    const RADIUS_MM: f64 = 1.1;
    let mut all = Mesh { vertices: mesh.vertices.clone(), ..Mesh::default() };
    all.faces.clone_from(&mesh.faces);
    all.colors = vec![SURFACE; mesh.vertices.len()];
    for p in points.iter().filter(|p| p.iter().all(|v| v.is_finite())) {
        let first = all.vertices.len() as u32;
        let axes = [Vec3::x(), Vec3::y(), -Vec3::x(), -Vec3::y(), Vec3::z(), -Vec3::z()];
        all.vertices.extend(axes.map(|a| p + a * RADIUS_MM));
        all.colors.extend([MARKER; 6]);
        for k in 0..4 {
            let next = (k + 1) % 4;
            all.faces.push([first + k, first + next, first + 4]);
            all.faces.push([first + next, first + k, first + 5]);
        }
    }
    all
}

/// The coverage of a texture as colours: red where the left photo saw it, green the right one
/// (yellow both), blue a further one; dark grey where it was filled.
pub fn coverage(seen: &Raster<u8>) -> Rgb {
    seen.map(|bits| {
        if bits & FILLED != 0 {
            return [48, 48, 48];
        }
        let level = |photo: u8| if bits & photo != 0 { 220 } else { 40 };
        [level(SEEN_LEFT), level(SEEN_RIGHT), level(SEEN_EXTRA)]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_stay_on_the_picture() {
        let mut image = Rgb::filled(8, 8, [0, 0, 0]);
        let red = [255, 0, 0];
        let far = Vec2::new(1e30, -1e30);
        crosses(
            &mut image,
            [(Vec2::new(0.0, 0.0), red), (far, red), (Vec2::repeat(f64::NAN), red)],
        );
        assert_eq!(image.at(2, 0), red);
        assert_eq!(image.data().iter().filter(|p| **p == red).count(), 6);
    }

    #[test]
    fn coverage_tells_the_photos_apart() {
        let seen = Raster::from_vec(3, 1, vec![SEEN_LEFT | SEEN_RIGHT, SEEN_EXTRA, FILLED]);
        let colors = coverage(&seen.unwrap());
        assert_eq!(colors.data(), [[220, 220, 40], [40, 40, 220], [48, 48, 48]]);
    }
}
