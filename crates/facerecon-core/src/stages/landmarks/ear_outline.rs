//! The outline of the subject beside the face, on a grid in the plane of the ears.

use rayon::prelude::*;

use crate::data::{Outline, Raster};
use crate::math::{Vec2, median};

/// Depth of the grid's plane: so far behind the eyes the ears are attached, mm.
pub(super) const GRID_DEPTH_MM: f64 = -80.0;
/// Size of a cell, mm.
const CELL_MM: f64 = 0.5;
/// The grid reaches from the cheek to beyond the ear, mm to the side of the middle between the eyes.
const SIDE_MM: (f64, f64) = (30.0, 125.0);
/// And from above the ear to the neck, mm above the eyes.
const HEIGHT_MM: (f64, f64) = (-90.0, 70.0);
/// Corners nearer to the midline than this are not those of an ear, mm.
const MIN_SIDE_MM: f64 = 50.0;
/// Radius of the disk in which the share of the subject is taken, mm: well below the size of an ear,
/// well above that of a cell.
const DISK_MM: f64 = 4.0;
/// Where the lower corner is looked for, mm above the eyes.
const LOWER_MM: (f64, f64) = (-70.0, -15.0);
/// Where the upper corner is looked for: above the lower corner, and above the eyes, mm.
const UPPER_ABOVE_LOWER_MM: (f64, f64) = (30.0, 75.0);
const UPPER_MM: (f64, f64) = (-15.0, 50.0);
/// Least share of the subject in the disk at a corner: a straight outline has 0.5. The upper corner
/// is the lowest place with the first share, or where there is none, with the next.
const MIN_LOWER_SHARE: f64 = 0.60;
const UPPER_SHARES: [f64; 3] = [0.70, 0.66, 0.62];
/// The boundary of the auricle is taken between this distance above the lower and this distance below
/// the upper corner, mm.
const AURICLE_MARGIN_MM: (f64, f64) = (12.0, 4.0);
/// Fewest rows of that boundary.
const MIN_ROWS: usize = 20;

/// A concave corner of the outline, on the plane of the grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Corner {
    /// To the side of the middle between the eyes, mm.
    pub x_mm: f64,
    /// Above the eyes, mm.
    pub y_mm: f64,
    /// The most concave place beside it, to the side and up, mm.
    pub hollow_mm: [f64; 2],
    /// Whether the outline is known there.
    pub certain: bool,
}

/// The subject beside one side of the face in one photo.
pub(super) struct EarOutline {
    subject: Raster<bool>,
    certain: Raster<bool>,
}

impl EarOutline {
    /// Resamples an outline. `photo_pixel` gives the pixel of the photo of a place of the plane (mm to
    /// the side, mm up).
    pub fn new(outline: &Outline, photo_pixel: impl Fn(f64, f64) -> Option<Vec2> + Sync) -> Self {
        let cells = |(from, to): (f64, f64)| ((to - from) / CELL_MM) as usize;
        let (width, height) = (cells(SIDE_MM), cells(HEIGHT_MM));
        let (subject, certain) = Raster::par_from_fn(width, height, |u, v| {
            let pixel = photo_pixel(x_mm(u), y_mm(v));
            let on = pixel.and_then(|p| outline.is_subject(p)).unwrap_or(false);
            let certain = pixel.is_some_and(|p| outline.distance_px(p).is_some());
            (on, certain)
        })
        .unzip();
        Self { subject, certain }
    }

    /// The most concave place of the outline below the ear.
    pub fn lower_corner(&self) -> Option<Corner> {
        let places = self.places(LOWER_MM);
        let best = places.iter().max_by(|a, b| a.share.total_cmp(&b.share))?;
        (best.share >= MIN_LOWER_SHARE).then(|| self.corner(best, best))
    }

    /// The lowest concave place of the outline above the ear.
    pub fn upper_corner(&self, lower: &Corner) -> Option<Corner> {
        let from = UPPER_MM.0.max(lower.y_mm + UPPER_ABOVE_LOWER_MM.0);
        let to = UPPER_MM.1.min(lower.y_mm + UPPER_ABOVE_LOWER_MM.1);
        let places = self.places((from, to));
        let lowest = UPPER_SHARES.iter().find_map(|share| {
            let concave = places.iter().filter(|p| p.share > *share);
            // the lowest; of one row the outermost
            concave.max_by_key(|p| (p.v, p.u))
        })?;
        let beside = |p: &&Place| {
            let mm = |a: usize, b: usize| a.abs_diff(b) as f64 * CELL_MM;
            mm(p.u, lowest.u).hypot(mm(p.v, lowest.v)) < DISK_MM
        };
        let hollow = places.iter().filter(beside).max_by(|a, b| a.share.total_cmp(&b.share));
        Some(self.corner(lowest, hollow.unwrap_or(lowest)))
    }

    /// The farthest side of the auricle (mm) and the rows in which its boundary is seen.
    pub fn auricle(&self, lower: &Corner, upper: &Corner) -> Option<(f64, std::ops::Range<usize>)> {
        let rows = row(upper.y_mm - AURICLE_MARGIN_MM.1)..row(lower.y_mm + AURICLE_MARGIN_MM.0);
        let farthest = rows.clone().filter_map(|v| self.boundary(v)).max()?;
        (rows.len() >= MIN_ROWS).then(|| (x_mm(farthest), rows))
    }

    /// Medians of the boundary, and of its difference from that of another photo, mm.
    pub fn boundary_difference(
        &self,
        other: &Self,
        rows: std::ops::Range<usize>,
    ) -> Option<(f64, f64)> {
        let pairs: Vec<(f64, f64)> = rows
            .filter_map(|v| Some((x_mm(self.boundary(v)?), x_mm(other.boundary(v)?))))
            .collect();
        let own: Vec<f64> = pairs.iter().map(|p| p.0).collect();
        let differences: Vec<f64> = pairs.iter().map(|p| p.0 - p.1).collect();
        if pairs.len() < MIN_ROWS {
            return None;
        }
        Some((median(&own)?, median(&differences)?))
    }

    /// First column of a row, from the face outward, that is not the subject; `None` where the row
    /// begins or ends otherwise.
    fn boundary(&self, v: usize) -> Option<usize> {
        let width = self.subject.width();
        (0..width).find(|&u| !self.subject.at(u, v)).filter(|u| *u > 0)
    }

    fn corner(&self, place: &Place, hollow: &Place) -> Corner {
        let certain = self.certain.at(place.u, place.v);
        let hollow_mm = [x_mm(hollow.u), y_mm(hollow.v)];
        Corner { x_mm: x_mm(place.u), y_mm: y_mm(place.v), hollow_mm, certain }
    }

    /// The places of the outline between two heights, with the share of the subject about them.
    fn places(&self, (low_mm, high_mm): (f64, f64)) -> Vec<Place> {
        let (width, height) = self.subject.size();
        let first = ((MIN_SIDE_MM - SIDE_MM.0) / CELL_MM) as usize;
        let rows = row(high_mm)..row(low_mm).min(height);
        let radius = (DISK_MM / CELL_MM) as isize;
        let on = |u: isize, v: isize| self.subject.get(u, v).unwrap_or(false);
        let share = |u: usize, v: usize| {
            let (mut inside, mut all) = (0u32, 0u32);
            for dv in -radius..=radius {
                for du in -radius..=radius {
                    if du * du + dv * dv <= radius * radius {
                        all += 1;
                        inside += u32::from(on(u as isize + du, v as isize + dv));
                    }
                }
            }
            f64::from(inside) / f64::from(all)
        };
        let on_line = |u: usize, v: usize| {
            let (u, v) = (u as isize, v as isize);
            on(u, v) && (-1..=1).any(|dv| (-1..=1).any(|du| !on(u + du, v + dv)))
        };
        rows.into_par_iter()
            .flat_map_iter(|v| {
                (first..width).filter(move |&u| on_line(u, v)).map(move |u| Place {
                    u,
                    v,
                    share: share(u, v),
                })
            })
            .collect()
    }
}

/// A cell on the outline.
struct Place {
    u: usize,
    v: usize,
    /// Share of the subject in the disk about it.
    share: f64,
}

fn x_mm(u: usize) -> f64 {
    SIDE_MM.0 + u as f64 * CELL_MM
}

fn y_mm(v: usize) -> f64 {
    HEIGHT_MM.1 - v as f64 * CELL_MM
}

fn row(y_mm: f64) -> usize {
    ((HEIGHT_MM.1 - y_mm) / CELL_MM).round().max(0.0) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A photo of the plane itself, 4 pixels per millimetre: the face ends 70 mm from the midline, the
    /// ear reaches from there to `rim_mm`, from 40 mm below to 15 mm above the eyes.
    fn photographed(rim_mm: f64) -> EarOutline {
        let subject = Raster::from_fn(400, 660, |u, v| {
            let (x, y) = (28.0 + 0.25 * u as f64, 72.0 - 0.25 * v as f64);
            x < 70.0 || (x < rim_mm && (-40.0..15.0).contains(&y))
        });
        let certain = subject.map(|_| true);
        let outline = Outline::from_mask(&subject, &certain, 1);
        EarOutline::new(&outline, |x, y| Some(Vec2::new((x - 28.0) * 4.0, (72.0 - y) * 4.0)))
    }

    #[test]
    fn the_corners_between_face_and_ear_are_found() {
        let seen = photographed(88.0);
        let lower = seen.lower_corner().unwrap();
        assert!((lower.x_mm - 70.0).abs() < 1.0 && (lower.y_mm + 40.0).abs() < 1.0, "{lower:?}");
        let upper = seen.upper_corner(&lower).unwrap();
        assert!((upper.x_mm - 70.0).abs() < 2.0 && (upper.y_mm - 15.0).abs() < 2.0, "{upper:?}");
        assert!(lower.certain && upper.certain);
        let (rim_mm, _) = seen.auricle(&lower, &upper).unwrap();
        assert!((rim_mm - 88.0).abs() < 1.0, "{rim_mm}");
    }

    #[test]
    fn a_straight_outline_has_no_corners() {
        let hair = photographed(70.0);
        assert_eq!(hair.lower_corner(), None);
    }

    #[test]
    fn boundaries_are_compared_row_by_row() {
        let (near, far) = (photographed(88.0), photographed(85.5));
        let (x_mm, difference_mm) = near.boundary_difference(&far, row(10.0)..row(-30.0)).unwrap();
        assert!((x_mm - 88.0).abs() < 0.6 && (difference_mm - 2.5).abs() < 0.6);
        assert_eq!(near.boundary_difference(&far, row(10.0)..row(5.0)), None, "too few rows");
    }
}
