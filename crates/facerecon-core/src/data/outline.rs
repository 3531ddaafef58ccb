//! The outline of the subject in a photo.

use super::Raster;
use super::distance::{NONE, nearest_marked};
use crate::math::Vec2;

/// Where a photo shows the subject and where the background, as a distance from the line between.
///
/// Parts of the line that could not be found reliably are unknown: they answer `None`.
#[derive(Clone, Debug, PartialEq)]
pub struct Outline {
    /// Distance from the outline, photo pixels: negative on the subject. One value a cell.
    distance_px: Raster<f32>,
    /// Whether the nearest piece of the outline is known.
    known: Raster<bool>,
    /// Pixels of the photo along a cell.
    step: usize,
}

impl Outline {
    /// The outline of a mask whose cells are `step` pixels wide. `certain` tells for each cell on
    /// either side of the line whether the line is known there. The border of the photo is no
    /// outline.
    pub fn from_mask(subject: &Raster<bool>, certain: &Raster<bool>, step: usize) -> Self {
        let to_subject = nearest_marked(subject);
        let to_background = nearest_marked(&subject.map(|s| !s));
        let is_certain =
            |cell: u32| cell != NONE && certain.data().get(cell as usize).is_some_and(|c| *c);
        let (width, height) = subject.size();
        let signed = Raster::from_fn(width, height, |x, y| {
            let (outside, nearest) = to_subject.at(x, y);
            let (inside, other) = to_background.at(x, y);
            if subject.at(x, y) {
                (-(inside - 0.5) * step as f32, is_certain(other))
            } else {
                ((outside - 0.5) * step as f32, is_certain(nearest))
            }
        });
        let (distance_px, known) = signed.unzip();
        Self { distance_px, known, step }
    }

    /// Width and height in cells, and the width of a cell in pixels.
    pub fn grid(&self) -> ((usize, usize), usize) {
        (self.distance_px.size(), self.step)
    }

    /// Whether any part of the outline is known.
    pub fn is_known(&self) -> bool {
        self.known.data().contains(&true)
    }

    /// Position in cells of a pixel of the photo; `None` outside the photo.
    fn cell(&self, pixel: Vec2) -> Option<(f64, f64)> {
        let to_cell = |v: f64, n: usize| {
            let c = (v + 0.5) / self.step as f64 - 0.5;
            (c >= -0.5 && c < n as f64 - 0.5).then(|| c.clamp(0.0, (n - 1) as f64))
        };
        let (width, height) = self.distance_px.size();
        Some((to_cell(pixel.x, width)?, to_cell(pixel.y, height)?))
    }

    /// Signed distance of a pixel of the photo from the outline, pixels, negative on the subject;
    /// `None` outside the photo and where the outline is not known.
    pub fn distance_px(&self, pixel: Vec2) -> Option<f64> {
        let (x, y) = self.cell(pixel)?;
        if !self.known.at(x.round() as usize, y.round() as usize) {
            return None;
        }
        self.distance_px.bilinear(x, y).filter(|d| d.is_finite()).map(f64::from)
    }

    /// Whether a pixel of the photo is more likely on the subject than off it, also where the outline
    /// is not known; `None` outside the photo.
    pub fn is_subject(&self, pixel: Vec2) -> Option<bool> {
        let (x, y) = self.cell(pixel)?;
        self.distance_px.bilinear(x, y).map(|d| d < 0.0)
    }

    /// Unit direction in the photo in which the distance from the outline grows; `None` where
    /// the distance is not known or has no direction.
    pub fn outward(&self, pixel: Vec2) -> Option<Vec2> {
        let (x, y) = self.cell(pixel)?;
        let (x, y) = (x.round() as isize, y.round() as isize);
        if !self.known.at(x as usize, y as usize) {
            return None;
        }
        // two cells to either side: the distance is rough where it changes its sign
        let at = |dx: isize, dy: isize| f64::from(self.distance_px.clamped(x + dx, y + dy));
        let slope = Vec2::new(at(2, 0) - at(-2, 0), at(0, 2) - at(0, -2));
        slope.try_normalize(1e-6)
    }

    /// The subject as a picture, for artifacts: white on it, black off it, grey tones where the
    /// outline is not known.
    pub fn picture(&self) -> Raster<f32> {
        self.distance_px.zip_map(&self.known, |d, known| match (d < 0.0, known) {
            (true, true) => 255.0,
            (true, false) => 160.0,
            (false, true) => 0.0,
            (false, false) => 80.0,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_signed_and_in_pixels_of_the_photo() {
        // the subject is left of cell 10; cells are 2 pixels wide, the line at pixel 19.5
        let subject = Raster::from_fn(30, 20, |x, _| x < 10);
        let certain = Raster::from_fn(30, 20, |_, y| y < 12);
        let outline = Outline::from_mask(&subject, &certain, 2);
        let at = |x: f64, y: f64| outline.distance_px(Vec2::new(x, y));
        assert!((at(29.5, 8.0).unwrap() - 10.0).abs() < 1e-3);
        assert!((at(9.5, 8.0).unwrap() + 10.0).abs() < 1e-3);
        assert_eq!(at(29.5, 35.0), None, "the line is not known there");
        assert_eq!(at(-3.0, 8.0), None);
        assert_eq!(at(61.0, 8.0), None);
        let outward = outline.outward(Vec2::new(24.0, 8.0)).unwrap();
        assert!((outward - Vec2::x()).norm() < 1e-6);
        assert_eq!(outline.picture().at(0, 0), 255.0);
        assert_eq!(outline.picture().at(29, 19), 80.0);
    }
}
