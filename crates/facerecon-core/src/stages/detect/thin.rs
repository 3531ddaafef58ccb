//! Thinning: one pixel for each dot of a black and white photo (thesis section 2.2.3).

use super::DetectParams;
use crate::data::{Dot, Gray};
use crate::math::Vec2;

/// The dots of a black and white photo.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Thinned {
    /// Sorted by row, then column.
    pub dots: Vec<Dot>,
    /// White at the pixel of each dot, black elsewhere.
    pub image: Gray,
}

/// Grey levels above this are white.
const WHITE: f32 = 127.0;

/// White pixels of one dot.
#[derive(Clone, Copy, Debug, Default)]
struct Group {
    sum: [usize; 2],
    count: usize,
}

impl Group {
    fn add(&mut self, x: usize, y: usize) {
        self.sum[0] += x;
        self.sum[1] += y;
        self.count += 1;
    }
}

/// Thins a black and white photo as in the thesis: in a raster scan, each white pixel found is the
/// upper left corner of a window; the white pixels of the window are replaced by one at their mean.
///
/// With `merge`, connected white pixels (8 neighbours) are one dot, whatever their shape and size and
/// however close the next dot is. Dots with fewer than `min_area_px` pixels or more than `max_area`
/// medians are left out.
pub(super) fn thin(binary: &Gray, params: &DetectParams) -> Thinned {
    let (width, height) = binary.size();
    let groups =
        if params.merge { components(binary) } else { windows(binary, params.window_px.max(1)) };
    let mut image = Gray::filled(width, height, 0.0);
    let (min, max) = if params.merge { limits(&groups, params) } else { (1, usize::MAX) };
    let mut dots = Vec::new();
    for group in groups.iter().filter(|g| g.count >= min && g.count <= max) {
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
    // two groups that round to the same pixel are one dot
    dots.dedup_by(|a, b| a.position == b.position);
    Thinned { dots, image }
}

/// The raster scan of the thesis: each white pixel found takes the window to its right and below.
fn windows(binary: &Gray, window: usize) -> Vec<Group> {
    let (width, height) = binary.size();
    let mut white = binary.map(|v| v > WHITE);
    let mut groups = Vec::new();
    for y in 0..height {
        for x in 0..width {
            if !white.at(x, y) {
                continue;
            }
            let mut group = Group::default();
            for v in y..(y + window).min(height) {
                for u in x..(x + window).min(width) {
                    if white.at(u, v) {
                        white.set(u, v, false);
                        group.add(u, v);
                    }
                }
            }
            groups.push(group);
        }
    }
    groups
}

/// The connected components of the white pixels, in the order of the same scan.
fn components(binary: &Gray) -> Vec<Group> {
    let (width, height) = binary.size();
    let mut white = binary.map(|v| v > WHITE);
    let mut groups = Vec::new();
    let mut open = Vec::new();
    for y in 0..height {
        for x in 0..width {
            if !white.at(x, y) {
                continue;
            }
            let mut group = Group::default();
            white.set(x, y, false);
            open.push((x, y));
            while let Some((x, y)) = open.pop() {
                group.add(x, y);
                for v in y.saturating_sub(1)..(y + 2).min(height) {
                    for u in x.saturating_sub(1)..(x + 2).min(width) {
                        if white.at(u, v) {
                            white.set(u, v, false);
                            open.push((u, v));
                        }
                    }
                }
            }
            groups.push(group);
        }
    }
    groups
}

/// Minimum and maximum number of pixels of a dot.
fn limits(groups: &[Group], params: &DetectParams) -> (usize, usize) {
    let min = params.min_area_px;
    let mut areas: Vec<usize> = groups.iter().map(|g| g.count).filter(|c| *c >= min).collect();
    areas.sort_unstable();
    let median = areas.get(areas.len() / 2).copied().unwrap_or(min);
    (min, (params.max_area * median as f64) as usize)
}
