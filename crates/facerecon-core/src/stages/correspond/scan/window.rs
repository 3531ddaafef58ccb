//! The part of the left photo that is searched.

use crate::math::Vec2;
use crate::stages::correspond::matches::IndexedMatch;

/// Distance from ear to ear over the distance from the mark on the forehead to the midpoint of the
/// ears: about 145 mm over 80 mm.
const BREADTH_OVER_HEIGHT: f64 = 1.8;
/// Half axes of the ellipse over the distance from ear to ear: the jaw reaches 105 mm beside the
/// midpoint of the ears, the hair 165 mm above.
const HALF_AXES: Vec2 = Vec2::new(0.72, 1.15);

/// The part of the left photo that holds the head: an upright ellipse.
pub(super) struct HeadWindow {
    centre: Vec2,
    half_axes: Vec2,
}

impl HeadWindow {
    /// From the seeds of the forehead and both ears; the whole photo when one is missing or `size`
    /// is 0.
    pub(super) fn new(seeds: &[IndexedMatch], left: &[Vec2], size: f64) -> Self {
        let whole_photo = Self { centre: Vec2::zeros(), half_axes: Vec2::repeat(f64::INFINITY) };
        let [head, left_ear, right_ear] = seeds else {
            return whole_photo;
        };
        let (head, a, b) = (left[head.left], left[left_ear.left], left[right_ear.left]);
        let centre = (a + b) / 2.0;
        // A turned head brings the ears closer together; the greater estimate holds.
        let breadth = (a - b).norm().max(BREADTH_OVER_HEIGHT * (head - centre).norm());
        if size > 0.0 && breadth > 0.0 {
            Self { centre, half_axes: HALF_AXES * breadth * size }
        } else {
            whole_photo
        }
    }

    /// Whether a position of the left photo is inside.
    pub(super) fn contains(&self, p: Vec2) -> bool {
        (p - self.centre).component_div(&self.half_axes).norm_squared() <= 1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_window_is_an_ellipse_around_the_ears_or_the_whole_photo() {
        let left = [Vec2::new(100.0, 20.0), Vec2::new(50.0, 100.0), Vec2::new(150.0, 100.0)];
        let seeds = [0, 1, 2].map(|i| IndexedMatch { left: i, right: i, score: 1.0 });
        // the forehead is 80 px above the ears: a breadth of 144 px, more than the ears' 100 px
        let window = HeadWindow::new(&seeds, &left, 1.0);
        for (x, y, inside) in [
            (100.0, 100.0, true),
            (100.0 + 0.72 * 143.9, 100.0, true),
            (100.0 + 0.72 * 144.1, 100.0, false),
            (100.0, 100.0 - 1.15 * 143.9, true),
            (100.0, 100.0 - 1.15 * 144.1, false),
        ] {
            assert_eq!(window.contains(Vec2::new(x, y)), inside, "{x} {y}");
        }
        let far = Vec2::new(1e9, -1e9);
        assert!(HeadWindow::new(&seeds, &left, 0.0).contains(far));
        assert!(HeadWindow::new(&seeds[..2], &left, 1.0).contains(far));
        assert!(!window.contains(Vec2::new(f64::NAN, 0.0)));
    }
}
