//! Thinning: one pixel for each dot of a black and white photo (thesis section 2.2.3).

use super::DetectParams;
use crate::data::{Dot, Gray};
use crate::math::Vec2;

/// The dots of a black and white photo.
#[derive(Clone, Debug, PartialEq)]
pub struct Thinned {
    /// In raster order.
    pub dots: Vec<Dot>,
    /// White at each dot's pixel, black elsewhere.
    pub image: Gray,
}

/// White pixels gathered into one group.
#[derive(Clone, Copy, Debug, Default)]
struct Group {
    sum: [usize; 2],
    count: usize,
}

impl Group {
    fn add(&mut self, other: &Group) {
        self.sum[0] += other.sum[0];
        self.sum[1] += other.sum[1];
        self.count += other.count;
    }
}

/// Thins a black and white photo (white is above 127) as the thesis does: the photo is scanned from
/// the upper left corner; a white pixel found is the upper left corner of a window; the white pixels
/// in it are averaged to one, the others become black.
///
/// With `merge`, windows whose white pixels touch (also over a corner) are then one dot, so that a
/// dot is one however it lies against the windows and however large it is; dots of less than
/// `min_area_px` pixels or of more than `max_area` medians are left out.
pub fn thin(binary: &Gray, params: &DetectParams) -> Thinned {
    let (width, height) = binary.size();
    let (labels, windows) = scan(binary, params.window_px.max(1));
    let groups = if params.merge { merge(&labels, (width, height), &windows) } else { windows };
    let mut image = Gray::filled(width, height, 0.0);
    let (least, most) = if params.merge { limits(&groups, params) } else { (1, usize::MAX) };
    let mut dots = Vec::new();
    for group in groups.iter().filter(|g| g.count >= least && g.count <= most) {
        let mean = Vec2::new(group.sum[0] as f64, group.sum[1] as f64) / group.count as f64;
        let pixel = mean.map(f64::round);
        image.set(pixel.x as usize, pixel.y as usize, 255.0);
        let position = if params.round { pixel } else { mean };
        dots.push(Dot { position, sigma_px: 0.0, amplitude: 0.0, score: 1.0 });
    }
    dots.sort_by(|a, b| {
        let (a, b) = (a.position, b.position);
        a.y.total_cmp(&b.y).then(a.x.total_cmp(&b.x))
    });
    // two groups may round to one pixel: it is one dot
    dots.dedup_by(|a, b| a.position == b.position);
    Thinned { dots, image }
}

/// The thesis's raster scan: the number of its window plus 1 for every white pixel, and the windows.
fn scan(binary: &Gray, window: usize) -> (Vec<u32>, Vec<Group>) {
    let (width, height) = binary.size();
    let mut labels = vec![0_u32; width * height];
    let mut windows = Vec::new();
    for y in 0..height {
        for x in 0..width {
            if binary.at(x, y) <= 127.0 || labels[y * width + x] != 0 {
                continue;
            }
            let mut group = Group::default();
            let label = windows.len() as u32 + 1;
            for v in y..(y + window).min(height) {
                for u in x..(x + window).min(width) {
                    let taken = &mut labels[v * width + u];
                    if binary.at(u, v) > 127.0 && *taken == 0 {
                        *taken = label;
                        group.add(&Group { sum: [u, v], count: 1 });
                    }
                }
            }
            windows.push(group);
        }
    }
    (labels, windows)
}

/// Joins windows whose white pixels touch.
fn merge(labels: &[u32], (width, height): (usize, usize), windows: &[Group]) -> Vec<Group> {
    let mut parents: Vec<usize> = (0..windows.len()).collect();
    let mut touch = |a: u32, b: u32| {
        if a != 0 && b != 0 && a != b {
            let (a, b) = (root(&mut parents, a as usize - 1), root(&mut parents, b as usize - 1));
            parents[a.max(b)] = a.min(b);
        }
    };
    for y in 0..height {
        for x in 0..width {
            let here = labels[y * width + x];
            if x + 1 < width {
                touch(here, labels[y * width + x + 1]);
            }
            if y + 1 < height {
                let below = &labels[(y + 1) * width..(y + 2) * width];
                for u in x.saturating_sub(1)..(x + 2).min(width) {
                    touch(here, below[u]);
                }
            }
        }
    }
    let mut groups = vec![Group::default(); windows.len()];
    for (i, window) in windows.iter().enumerate() {
        groups[root(&mut parents, i)].add(window);
    }
    groups.retain(|g| g.count > 0);
    groups
}

fn root(parents: &mut [usize], mut i: usize) -> usize {
    while parents[i] != i {
        parents[i] = parents[parents[i]];
        i = parents[i];
    }
    i
}

/// Least and greatest number of pixels of a dot.
fn limits(groups: &[Group], params: &DetectParams) -> (usize, usize) {
    let least = params.min_area_px;
    let mut areas: Vec<usize> = groups.iter().map(|g| g.count).filter(|c| *c >= least).collect();
    areas.sort_unstable();
    let median = areas.get(areas.len() / 2).copied().unwrap_or(least);
    (least, (params.max_area * median as f64) as usize)
}
