//! Eyes that are covered: dots on something in front of the eye sockets, such as the lenses of
//! glasses, are not on skin.
//!
//! An eye lies behind the line from the brow to the cheek below it, by 1 to 12 mm on faces of known
//! shape; a lens lies about 10 mm in front of it.

use crate::data::Cloud;
use crate::math::{Similarity, Vec2, Vec3, median};
use crate::spatial::{PointIndex, median_spacing};

/// Middle of the eye at the viewer's right, relative to the tip of the nose, and the radius in which
/// its depth is taken, mm.
const EYE_MM: Vec2 = Vec2::new(31.0, 29.0);
const EYE_RADIUS_MM: f64 = 9.0;
/// Heights above the tip of the nose of the cheek and of the forehead above the brow, and the radius
/// in which their depths are taken, mm.
const CHEEK_MM: f64 = -2.0;
const BROW_MM: f64 = 56.0;
const LEVEL_RADIUS_MM: f64 = 6.0;
/// Skin around the eyes lies at most this far in front of the line from brow to cheek, mm.
const BEFORE_LINE_MM: f64 = 4.0;
/// The line is taken at these distances from the middle, mm: beside the nose to the temple.
const FIRST_COLUMN_MM: f64 = 12.0;
const COLUMN_MM: f64 = 5.0;
const COLUMNS: usize = 11;
/// Fewest dots that give a depth.
const MIN_DOTS: usize = 3;
/// Points behind the tip by more than this do not belong to the face, mm.
const DEPTH_MM: f64 = 90.0;
/// What is measured between the dots this near to a dot on a cover is not skin either, distances of
/// dots: the surface runs from one dot to the next.
const NEAR_SPACINGS: f64 = 1.3;

/// Covers of one or both eyes.
#[derive(Clone, Debug)]
pub struct CoveredEyes {
    head_from_camera: Similarity,
    /// Lines from cheek to brow (depths in the head's frame, mm) by column, of the covered eyes at
    /// the viewer's left and right.
    sides: [Option<[[f64; 2]; COLUMNS]>; 2],
    /// The dots on the covers, head's frame, x and y.
    on_cover: Vec<Vec2>,
    near_mm: f64,
}

impl CoveredEyes {
    /// Whether and where the eyes are covered, from the measured dots (camera frame, mm); `None` if
    /// neither is.
    pub fn find(dots: &Cloud, head_from_camera: &Similarity) -> Option<Self> {
        let placed: Vec<Vec3> = dots.points.iter().map(|p| head_from_camera.apply(p)).collect();
        let placed: Vec<Vec3> =
            placed.into_iter().filter(|p| p.z > -DEPTH_MM && p.y.abs() < DEPTH_MM).collect();
        let plane: Vec<Vec2> = placed.iter().map(Vec3::xy).collect();
        let index = PointIndex::<2>::new(&plane)?;
        let near_mm = NEAR_SPACINGS * median_spacing(&plane)?;
        let depth = |x: f64, y: f64, radius: f64| {
            // far apart dots: at least the next ones
            let near = index.within(&[x, y], radius.max(near_mm));
            let depths: Vec<f64> = near.iter().map(|n| placed[n.index].z).collect();
            median(&depths).filter(|_| depths.len() >= MIN_DOTS)
        };
        let side = |sign: f64| {
            let line = |x: f64| {
                let at = |y: f64| depth(sign * x, y, LEVEL_RADIUS_MM);
                Some([at(CHEEK_MM)?, at(BROW_MM)?])
            };
            let eye = depth(sign * EYE_MM.x, EYE_MM.y, EYE_RADIUS_MM)?;
            let at_eye = line(EYE_MM.x)?;
            if eye - on_line(&at_eye, EYE_MM.y) < BEFORE_LINE_MM {
                return None;
            }
            let mut lines = [at_eye; COLUMNS];
            for k in 0..COLUMNS {
                let known = line(FIRST_COLUMN_MM + k as f64 * COLUMN_MM);
                // beyond the measured skin the line of the column before continues
                lines[k] = known.unwrap_or(if k > 0 { lines[k - 1] } else { at_eye });
            }
            Some(lines)
        };
        let mut covers = Self {
            head_from_camera: *head_from_camera,
            sides: [side(-1.0), side(1.0)],
            on_cover: Vec::new(),
            near_mm,
        };
        covers.on_cover =
            placed.iter().filter(|p| covers.is_before_skin(p)).map(Vec3::xy).collect();
        covers.sides.iter().any(Option::is_some).then_some(covers)
    }

    /// Whether the eye at the viewer's left (`side` 0) or right (1) is covered.
    pub fn is_covered(&self, side: usize) -> bool {
        self.sides[side].is_some()
    }

    /// Number of dots on the covers.
    pub fn dots(&self) -> usize {
        self.on_cover.len()
    }

    /// Whether a dot (camera frame) lies on a cover.
    pub fn contains_dot(&self, p: &Vec3) -> bool {
        self.is_before_skin(&self.head_from_camera.apply(p))
    }

    /// Whether a point between dots (camera frame) belongs to a cover: the surface there runs from
    /// the cover to the skin.
    pub fn contains(&self, p: &Vec3) -> bool {
        let p = self.head_from_camera.apply(p);
        let near = |c: &Vec2| (c - p.xy()).norm_squared() < self.near_mm.powi(2);
        p.z > -DEPTH_MM && (self.is_before_skin(&p) || self.on_cover.iter().any(near))
    }

    /// The same for a position of the head's frame.
    fn is_before_skin(&self, p: &Vec3) -> bool {
        let column = ((p.x.abs() - FIRST_COLUMN_MM) / COLUMN_MM).round();
        let lines = self.sides[usize::from(p.x > 0.0)].as_ref();
        let (Some(lines), true) = (lines, (0.0..COLUMNS as f64).contains(&column)) else {
            return false;
        };
        let between = (CHEEK_MM..BROW_MM - LEVEL_RADIUS_MM).contains(&p.y);
        between && p.z > on_line(&lines[column as usize], p.y) + BEFORE_LINE_MM
    }
}

/// Depth of the line from cheek to brow at a height.
fn on_line([cheek, brow]: &[f64; 2], y: f64) -> f64 {
    cheek + (brow - cheek) * (y - CHEEK_MM) / (BROW_MM - CHEEK_MM)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::{Glasses, Person};
    use crate::template::Template;

    /// Dots about 4 mm apart on the front of a head, and on lenses in front of it.
    fn dots(head: &Template) -> [Vec<Vec3>; 2] {
        let mut skin: Vec<Vec3> = Vec::new();
        for v in head.mesh.vertices.iter().filter(|v| v.z > 30.0) {
            if skin.iter().all(|p| (p - v).xy().norm() > 3.5) {
                skin.push(*v);
            }
        }
        let lenses = Glasses::for_head(head).unwrap().lenses;
        let spokes = (0..lenses.faces.len()).step_by(6).map(|f| lenses.corners(f));
        let on_lenses: Vec<Vec3> = spokes
            .flat_map(|[middle, rim, _]| [0.3, 0.6, 0.9].map(|t| middle + (rim - middle) * t))
            .collect();
        [skin, on_lenses]
    }

    fn pose(head: &Template) -> Similarity {
        let tip = head.mesh.vertices[head.landmarks["nose_tip"]];
        Similarity::rigid(crate::math::Mat3::identity(), -tip)
    }

    #[test]
    fn uncovered_eyes_stay() {
        let head = Person::new(1).head;
        let [skin, _] = dots(&head);
        assert!(CoveredEyes::find(&Cloud::from_points(skin), &pose(&head)).is_none());
        assert!(CoveredEyes::find(&Cloud::default(), &pose(&head)).is_none());
    }

    #[test]
    fn dots_on_lenses_are_told_from_skin() {
        let head = Person::new(1).head;
        let [mut skin, on_lenses] = dots(&head);
        // no light comes to the skin behind the lenses
        skin.retain(|s| on_lenses.iter().all(|l| (l - s).xy().norm() > 4.0));
        let all = skin.iter().chain(&on_lenses).copied().collect();
        let covers = CoveredEyes::find(&Cloud::from_points(all), &pose(&head)).unwrap();
        assert!(covers.is_covered(0) && covers.is_covered(1));
        let kept = on_lenses.iter().filter(|p| !covers.contains_dot(p)).count();
        assert!(kept * 4 < on_lenses.len(), "{kept} of {} dots on lenses", on_lenses.len());
        let lost = skin.iter().filter(|p| covers.contains_dot(p)).count();
        assert!(lost * 50 < skin.len(), "{lost} of {} dots on skin are lost", skin.len());
        // what is between the dots of a cover is not skin either
        let mut on_cover = on_lenses.iter().filter(|p| covers.contains_dot(p));
        assert!(on_cover.all(|p| covers.contains(&(p - Vec3::new(0.0, 0.0, 8.0)))));
    }
}
