//! The part of a photo that shows the subject rather than the wall behind: it ends where the photo
//! shows it, not where the mesh does, since ears and the back of the jaw are seldom measured.
//!
//! Measured dots lie on the subject, and pixels well outside the mesh do not. From both, paths grow
//! over the image at a cost that rises with the change of colour; a pixel takes the label whose path
//! reaches it first (geodesic segmentation, Bai and Sapiro 2007).

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::posed_camera::PosedCamera;
use super::visibility::Visibility;
use crate::data::{Raster, Rgb};
use crate::math::{Vec2, Vec3};

/// The photo is reduced to about this width, pixels: enough for an outline, and fast.
const WIDTH_PX: usize = 256;
/// Pixels farther from the mesh than this fraction of the image width are no subject.
const MARGIN: f64 = 0.018;
/// Fewer visible dots than this do not say where the subject is.
const LEAST_DOTS: usize = 20;
/// A dot is visible where its point is within this distance of the visible surface, mm.
const VISIBLE_MM: f64 = 4.0;
/// Change of colour from one pixel to the next that is noise, grey levels.
const NOISE: i32 = 4;
/// Cost of a step between equal colours, and of a grey level of change above the noise: an edge of
/// ten grey levels counts as much as a detour of 24 pixels.
const STEP_COST: u32 = 1;
const CHANGE_COST: i32 = 4;

// Labels; of equal costs the smaller label wins.
const UNKNOWN: u8 = 0;
const SUBJECT: u8 = 1;
const WALL: u8 = 2;

/// The subject's part of a photo.
pub(super) struct SubjectMask {
    /// 1 on the subject, 0 off it; coarser than the photo.
    mask: Raster<f32>,
    /// Pixels of the photo along a pixel of the mask.
    step: usize,
}

impl SubjectMask {
    /// From points measured on the subject (mesh frame); `None` where too few are visible.
    pub fn new(
        image: &Rgb,
        camera: &PosedCamera,
        visibility: &Visibility,
        points: &[Vec3],
    ) -> Option<Self> {
        let (width, height) = image.size();
        let step = width.div_ceil(WIDTH_PX).max(1);
        let (w, h) = (width / step, height / step);
        if w < 3 || h < 3 {
            return None;
        }
        let visible = |point: &Vec3| -> Option<(usize, usize)> {
            let (pixel, depth) = camera.project(point)?;
            let (behind, _) = visibility.behind(pixel, depth)?;
            let (x, y) = (pixel.x as usize / step, pixel.y as usize / step);
            (behind.abs() < VISIBLE_MM && x < w && y < h).then_some((x, y))
        };
        let dots: Vec<_> = points.iter().filter_map(visible).collect();
        if dots.len() < LEAST_DOTS {
            return None;
        }
        let mesh = Raster::from_fn(w, h, |x, y| {
            visibility.shows_mesh(x * step + step / 2, y * step + step / 2)
        });
        let near_mesh = dilated(&mesh, (MARGIN * w as f64).ceil() as usize);
        let mut seeds = near_mesh.map(|near| if near { UNKNOWN } else { WALL });
        dots.iter().for_each(|&(x, y)| seeds.set(x, y, SUBJECT));
        let count = (step * step) as u32;
        let small = image.block_sums(step).map(|sum| sum.map(|s| (s / count) as i32));
        let labels = grown(&small, seeds);
        // the last pixel mixes both colours
        let wall = dilated(&labels.map(|l| l == WALL), 1);
        Some(Self { mask: wall.map(|wall| if wall { 0.0 } else { 1.0 }), step })
    }

    /// Degree to which a pixel of the photo shows the subject, 0 to 1.
    pub fn at(&self, pixel: Vec2) -> f32 {
        let to_mask =
            |v: f64, n: usize| ((v + 0.5) / self.step as f64 - 0.5).clamp(0.0, (n - 1) as f64);
        let (w, h) = self.mask.size();
        self.mask.bilinear(to_mask(pixel.x, w), to_mask(pixel.y, h)).unwrap_or(1.0)
    }
}

/// Pixels no more than `reach` rows and columns from a marked one.
fn dilated(marked: &Raster<bool>, reach: usize) -> Raster<bool> {
    let (w, h) = marked.size();
    let across = Raster::from_fn(w, h, |x, y| {
        marked.row(y)[x.saturating_sub(reach)..(x + reach + 1).min(w)].contains(&true)
    });
    Raster::from_fn(w, h, |x, y| {
        (y.saturating_sub(reach)..(y + reach + 1).min(h)).any(|row| across.at(x, row))
    })
}

/// For each pixel the label whose path reaches it at the lowest cost (Dijkstra 1959; whole numbers,
/// so that the result is exact).
fn grown(image: &Raster<[i32; 3]>, seeds: Raster<u8>) -> Raster<u8> {
    let (w, h) = image.size();
    let mut labels = seeds;
    let mut cost = vec![u32::MAX; w * h];
    let mut heap = BinaryHeap::new();
    for (i, label) in labels.data().iter().enumerate() {
        if *label != UNKNOWN {
            cost[i] = 0;
            heap.push(Reverse((0u32, *label, i)));
        }
    }
    while let Some(Reverse((here, label, i))) = heap.pop() {
        if here > cost[i] || labels.data()[i] != label {
            continue;
        }
        let (x, y) = (i % w, i / w);
        let mut relax = |j: usize| {
            let (a, b) = (image.data()[i], image.data()[j]);
            let change = (0..3).map(|c| (a[c] - b[c]).abs()).max().unwrap_or(0);
            let next = here + STEP_COST + (CHANGE_COST * (change - NOISE).max(0)) as u32;
            if next < cost[j] {
                cost[j] = next;
                labels.data_mut()[j] = label;
                heap.push(Reverse((next, label, j)));
            }
        };
        if x > 0 {
            relax(i - 1);
        }
        if x + 1 < w {
            relax(i + 1);
        }
        if y > 0 {
            relax(i - w);
        }
        if y + 1 < h {
            relax(i + w);
        }
    }
    labels
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_meet_at_the_edge_of_colour() {
        // a light disc of radius 12 on a dark ramp
        let inside = |x: usize, y: usize| x.abs_diff(20).pow(2) + y.abs_diff(20).pow(2) <= 144;
        let image = Raster::from_fn(60, 40, |x, y| {
            if inside(x, y) { [180 + x as i32 % 3, 140, 120] } else { [20 + x as i32, 22, 25] }
        });
        let seeds = Raster::from_fn(60, 40, |x, y| match (x, y) {
            (16 | 22, 17 | 23) => SUBJECT,
            (0 | 59, _) | (_, 0 | 39) => WALL,
            _ => UNKNOWN,
        });
        let labels = grown(&image, seeds);
        for y in 0..40 {
            for x in 0..60 {
                let expected = if inside(x, y) { SUBJECT } else { WALL };
                assert_eq!(labels.at(x, y), expected, "{x} {y}");
            }
        }
        let all = grown(&image, Raster::from_fn(60, 40, |x, _| u8::from(x == 30)));
        assert!(all.data().iter().all(|l| *l == SUBJECT));
    }

    #[test]
    fn dilation_grows_by_its_reach() {
        let one = Raster::from_fn(9, 9, |x, y| (x, y) == (4, 4));
        let grown = dilated(&one, 2);
        assert_eq!(grown.data().iter().filter(|v| **v).count(), 25);
    }
}
