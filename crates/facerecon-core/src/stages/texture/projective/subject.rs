//! Which part of a photo shows the subject, and which the wall behind: the head ends where the
//! photo says, not where the mesh does (ears and the back of the jaw are seldom measured).
//!
//! Measured dots lie on the subject, and what is well outside the mesh does not. From both, paths
//! grow over the picture, dear where colours change; a pixel belongs to whose path reaches it first
//! (geodesic segmentation, Bai and Sapiro 2007).

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::photo::Photo;
use crate::data::{Raster, Rgb};
use crate::math::{Vec2, Vec3};

/// Pictures are looked at in about this width, pixels.
const WIDTH: usize = 256;
/// What is outside the mesh by more than this part of the picture's width is no subject.
const CLEAR: f64 = 0.018;
/// Fewer visible dots than this do not say where the subject is.
const LEAST_DOTS: usize = 20;
/// A dot is seen where its point lies no farther behind the drawn surface, mm.
const BEHIND_MM: f64 = 4.0;
/// Change of colour from one pixel to the next that is noise, grey levels.
const NOISE: i32 = 4;

const UNKNOWN: u8 = 0;
const SUBJECT: u8 = 1;
const WALL: u8 = 2;

/// The subject's part of a photo.
pub(super) struct Subject {
    /// 1 on the subject, 0 off it; coarser than the photo.
    mask: Raster<f32>,
    step: usize,
}

impl Subject {
    /// From points measured on the subject (mesh frame); `None` where too few are seen to tell.
    pub fn new(photo: &Photo<'_>, points: &[Vec3]) -> Option<Self> {
        let (width, height) = photo.image.size();
        let step = width.div_ceil(WIDTH).max(1);
        let (w, h) = (width / step, height / step);
        if w < 3 || h < 3 {
            return None;
        }
        let picture = shrunk(photo.image, step, (w, h));
        let mut seeds = Raster::filled(w, h, UNKNOWN);
        let seen = |point: &Vec3| -> Option<(usize, usize)> {
            let (pixel, depth) = photo.project(point)?;
            let (behind, _) = photo.sight.behind(pixel, depth)?;
            let (x, y) = (pixel.x as usize / step, pixel.y as usize / step);
            (behind.abs() < BEHIND_MM && x < w && y < h).then_some((x, y))
        };
        let dots: Vec<_> = points.iter().filter_map(seen).collect();
        if dots.len() < LEAST_DOTS {
            return None;
        }
        let drawn = Raster::from_fn(w, h, |x, y| {
            photo.shows_head(x * step + step / 2, y * step + step / 2)
        });
        let clear = (CLEAR * w as f64).ceil() as usize;
        let near = dilated(&drawn, clear);
        for (seed, near) in seeds.data_mut().iter_mut().zip(near.data()) {
            if !near {
                *seed = WALL;
            }
        }
        dots.iter().for_each(|&(x, y)| seeds.set(x, y, SUBJECT));
        let labels = grown(&picture, seeds);
        // the last pixel mixes both
        let wall = dilated(&labels.map(|l| l == WALL), 1);
        Some(Self { mask: wall.map(|wall| if wall { 0.0 } else { 1.0 }), step })
    }

    /// How surely a pixel of the photo shows the subject, 0 to 1.
    pub fn at(&self, pixel: Vec2) -> f32 {
        let place =
            |v: f64, n: usize| ((v + 0.5) / self.step as f64 - 0.5).clamp(0.0, (n - 1) as f64);
        let (w, h) = self.mask.size();
        self.mask.bilinear(place(pixel.x, w), place(pixel.y, h)).unwrap_or(1.0)
    }
}

/// Means of blocks of `step` pixels.
fn shrunk(image: &Rgb, step: usize, (w, h): (usize, usize)) -> Raster<[i32; 3]> {
    let count = (step * step) as i32;
    Raster::par_from_fn(w, h, |x, y| {
        let mut sum = [0i32; 3];
        for j in 0..step {
            for p in &image.row(y * step + j)[x * step..(x + 1) * step] {
                (0..3).for_each(|c| sum[c] += i32::from(p[c]));
            }
        }
        sum.map(|s| s / count)
    })
}

/// What lies no more than `reach` rows and columns from a marked pixel.
fn dilated(marked: &Raster<bool>, reach: usize) -> Raster<bool> {
    let (w, h) = marked.size();
    let across = Raster::from_fn(w, h, |x, y| {
        marked.row(y)[x.saturating_sub(reach)..(x + reach + 1).min(w)].contains(&true)
    });
    Raster::from_fn(w, h, |x, y| {
        (y.saturating_sub(reach)..(y + reach + 1).min(h)).any(|row| across.at(x, row))
    })
}

/// The label whose cheapest path reaches a pixel first (Dijkstra 1959, whole numbers; of equals the
/// subject's). Without any wall all is subject.
fn grown(picture: &Raster<[i32; 3]>, seeds: Raster<u8>) -> Raster<u8> {
    let (w, h) = picture.size();
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
        let mut offer = |j: usize| {
            let (a, b) = (picture.data()[i], picture.data()[j]);
            let change = (0..3).map(|c| (a[c] - b[c]).abs()).max().unwrap_or(0);
            let next = here + 1 + 4 * (change - NOISE).max(0) as u32;
            if next < cost[j] {
                cost[j] = next;
                labels.data_mut()[j] = label;
                heap.push(Reverse((next, label, j)));
            }
        };
        if x > 0 {
            offer(i - 1);
        }
        if x + 1 < w {
            offer(i + 1);
        }
        if y > 0 {
            offer(i - w);
        }
        if y + 1 < h {
            offer(i + w);
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
        let picture = Raster::from_fn(60, 40, |x, y| {
            if inside(x, y) { [180 + x as i32 % 3, 140, 120] } else { [20 + x as i32, 22, 25] }
        });
        let seeds = Raster::from_fn(60, 40, |x, y| match (x, y) {
            (16 | 22, 17 | 23) => SUBJECT,
            (0 | 59, _) | (_, 0 | 39) => WALL,
            _ => UNKNOWN,
        });
        let labels = grown(&picture, seeds);
        for y in 0..40 {
            for x in 0..60 {
                let wanted = if inside(x, y) { SUBJECT } else { WALL };
                assert_eq!(labels.at(x, y), wanted, "{x} {y}");
            }
        }
        let all = grown(&picture, Raster::from_fn(60, 40, |x, _| u8::from(x == 30)));
        assert!(all.data().iter().all(|l| *l == SUBJECT));
    }

    #[test]
    fn dilation_grows_by_its_reach() {
        let one = Raster::from_fn(9, 9, |x, y| (x, y) == (4, 4));
        let grown = dilated(&one, 2);
        assert_eq!(grown.data().iter().filter(|v| **v).count(), 25);
    }
}
