//! The face as a whole: what was found, checked against the proportions of faces and completed.

use super::ears::Upright;
use super::eyes::{self, Eye};
use super::frontal::{FrontalPicture, PIXEL_MM, pixel};
use super::head_frame::HeadFrame;
use super::mouth::{self, Mouth};
use super::nose::{self, Nose, Profile};
use crate::data::{LandmarkSource, MeasuredLandmark};
use crate::math::{Vec2, Vec3, median};

/// Distances between the outer and the inner corners of the eyes, mm (children to large adults;
/// Farkas 1994 gives 74 to 100 and 25 to 39 with two standard deviations).
const OUTER_CORNERS_MM: std::ops::Range<f64> = 66.0..112.0;
const INNER_CORNERS_MM: std::ops::Range<f64> = 20.0..48.0;
/// Greatest difference in height of both eyes, mm, and of their distances from the midline.
const UNEVEN_EYES_MM: f64 = 9.0;
/// Distance from the line of the eyes to that of the mouth, mm.
const EYES_TO_MOUTH_MM: std::ops::Range<f64> = 44.0..98.0;
/// Width of a nose, mm.
const NOSE_WIDTH_MM: std::ops::Range<f64> = 20.0..56.0;
/// The profile reaches so far above and below the tip, mm.
const PROFILE_MM: f64 = 112.0;

/// Heights along the line from mouth to eyes, mm. Means over rendered adult heads.
/// Saddle above the line of the eyes; standard deviation 1.0.
const SADDLE_ABOVE_EYES_MM: f64 = 4.8;
/// Forehead above the line of the eyes; 1.7.
const FOREHEAD_ABOVE_EYES_MM: f64 = 46.4;
/// Chin below the lower lip; 2.4.
const CHIN_BELOW_LIP_MM: f64 = 25.3;
/// Chin below the position where the profile recedes by this slope, below the lip by at least this
/// distance; 2.0.
const CHIN_SLOPE: f64 = 0.7;
const CHIN_BELOW_SLOPE_MM: f64 = 1.5;
const CHIN_SEARCH_MM: f64 = 12.0;
/// A position farther than this from the expected one is not that of the chin (beard, collar), mm.
const CHIN_TOLERANCE_MM: f64 = 9.0;
/// Forehead above the saddle where no eyes are found, mm; standard deviation 1.1.
const FOREHEAD_ABOVE_SADDLE_MM: f64 = 41.3;

/// Standard deviations of the positions, mm.
const EYE_SIGMA_MM: f64 = 1.0;
const MOUTH_SIGMA_MM: f64 = 1.0;
const NOSE_SIGMA_MM: f64 = 1.2;
const ALA_SIGMA_MM: f64 = 1.6;
const SADDLE_SIGMA_MM: f64 = 1.3;
const SADDLE_BY_SHAPE_SIGMA_MM: f64 = 2.5;
const CHIN_SIGMA_MM: f64 = 2.0;
const FOREHEAD_SIGMA_MM: f64 = 2.5;
/// Added in quadrature where the depth is interpolated across a hole, mm.
const UNMEASURED_SIGMA_MM: f64 = 0.7;

/// The corners of an eye lie so far behind the surface interpolated from lid to lid, mm; standard
/// deviation 0.6. Means over rendered heads, outer and inner corner.
const OUTER_BEHIND_MM: f64 = 1.6;
const INNER_BEHIND_MM: f64 = 1.1;
/// The ala lies this far outside the steepest position of the wing, which is smoothed, mm; standard
/// deviation 0.7. Mean over rendered heads.
const ALA_BEYOND_MM: f64 = 0.5;
/// A position on a steep wing hardly determines the depth. The alae lie this far in front of the
/// weighted mean of the cheek, a distance outside them, and of the base of the nose on the midline, a
/// distance below them; mm, standard deviation 1.0. Means over rendered heads.
const ALA_BEFORE_MM: f64 = 5.1;
const CHEEK_WEIGHT: f64 = 0.7;
const CHEEK_OUTSIDE_MM: f64 = 4.0;
const BASE_BELOW_ALAE_MM: f64 = 8.0;
/// And in front of the smoothed surface at the edge of the wing, mm; standard deviation 1.8. It counts
/// alone where not both cheeks are measured, else by the inverse of the variances.
const ALA_BEFORE_WING_MM: f64 = 1.5;
const BY_CHEEK_WEIGHT: f64 = 0.7;
/// The surface is smoothed across the lips: their corners lie so far behind it, the border of the
/// lower lip so far in front, mm; standard deviations 0.4 and 1.0. Means over rendered heads.
const MOUTH_CORNERS_BEHIND_MM: f64 = 0.5;
const LOWER_LIP_BEFORE_MM: f64 = 0.9;

/// A landmark in the frontal picture.
struct Placed {
    name: &'static str,
    /// Position in the head's frame, mm.
    at: Vec2,
    /// Height above the resampled surface, mm.
    raised_mm: f64,
    /// Standard deviation of the position, mm.
    sigma_mm: f64,
}

/// A landmark on the resampled surface.
fn placed(name: &'static str, at: Vec2, sigma_mm: f64) -> Placed {
    Placed { name, at, raised_mm: 0.0, sigma_mm }
}

/// A chin darker than both cheeks by this is under a beard: difference of the logarithms of
/// brightness. Bare and shaved chins lie between 0.5 below and 0.4 above, dark beards 2 below.
const BEARD_DARKER: f64 = 1.0;
/// Middle of a cheek, relative to the tip of the nose, and half the side of the squares in which
/// brightness is taken, mm.
const CHEEK_MM: (f64, f64) = (33.0, -6.0);
const TONE_MM: f64 = 6.0;

/// The landmarks found in one frontal picture.
pub(super) struct Face {
    placed: Vec<Placed>,
    /// The upright face, where eyes and mouth were found.
    pub upright: Option<Upright>,
    /// Whether a beard hides the chin, whose landmark is then left out.
    pub bearded: bool,
    /// Number of parts (two eyes, mouth, nose) that were found and agree.
    pub parts: u32,
}

impl Face {
    /// Whether every part was found.
    pub fn is_complete(&self) -> bool {
        self.parts == 4
    }

    /// The landmarks on the measured surface, camera frame.
    pub fn lifted(&self, picture: &FrontalPicture, frame: &HeadFrame) -> Vec<MeasuredLandmark> {
        let lift = |&Placed { name, at, raised_mm, sigma_mm }: &Placed| {
            let height = picture.height_at(at.x, at.y) + raised_mm;
            let on_surface = Vec3::new(at.x, at.y, height);
            let hole = !picture.measured_at(at.x, at.y);
            let extra = if hole { UNMEASURED_SIGMA_MM } else { 0.0 };
            MeasuredLandmark {
                name: name.to_owned(),
                position: frame.to_camera(&on_surface),
                sigma_mm: sigma_mm.hypot(extra),
                source: LandmarkSource::Found,
            }
        };
        self.placed.iter().map(lift).collect()
    }
}

/// Finds the parts of the face and keeps those whose proportions are those of a face.
pub(super) fn find(picture: &FrontalPicture) -> Face {
    let profile = Profile::new(picture, PROFILE_MM);
    let nose = nose::find(picture, &profile).filter(plausible_nose);
    let colors = picture.colors.as_ref();
    let eyes = colors.and_then(|c| Some([eyes::find(c, -1.0)?, eyes::find(c, 1.0)?]));
    let eyes = eyes.filter(plausible_eyes);
    let mouth = colors.and_then(mouth::find);
    let (eyes, mouth) = agreeing(eyes, mouth);
    let mut list = Vec::new();
    let mut parts = 0;
    if let Some(nose) = &nose {
        parts += 1;
        place_nose(nose, picture, &mut list);
    }
    if let Some([left, right]) = &eyes {
        parts += 2;
        list.push(corner("eye_left_outer", left.outer, OUTER_BEHIND_MM));
        list.push(corner("eye_left_inner", left.inner, INNER_BEHIND_MM));
        list.push(corner("eye_right_inner", right.inner, INNER_BEHIND_MM));
        list.push(corner("eye_right_outer", right.outer, OUTER_BEHIND_MM));
    }
    if let Some(mouth) = &mouth {
        parts += 1;
        for (name, at, raised_mm) in [
            ("mouth_left", mouth.left, -MOUTH_CORNERS_BEHIND_MM),
            ("mouth_right", mouth.right, -MOUTH_CORNERS_BEHIND_MM),
            ("mouth_up", mouth.up, 0.0),
            ("mouth_down", mouth.down, LOWER_LIP_BEFORE_MM),
        ] {
            list.push(Placed { name, at, raised_mm, sigma_mm: MOUTH_SIGMA_MM });
        }
    }
    let upright = upright(picture, eyes.as_ref(), mouth.as_ref());
    place_midline(picture, &profile, nose.as_ref(), upright, mouth.as_ref(), &mut list);
    let bearded = list.iter().any(|p| p.name == "chin" && is_bearded(picture, p.at));
    list.retain(|p| p.name != "chin" || !bearded);
    Face { placed: list, upright, bearded, parts }
}

/// Whether the chin is much darker than both cheeks.
fn is_bearded(picture: &FrontalPicture, chin: Vec2) -> bool {
    let Some(colors) = &picture.colors else { return false };
    let steps = (TONE_MM / PIXEL_MM) as isize;
    let tone = |at: Vec2| {
        let middle = pixel(at.x, at.y);
        let (u, v) = (middle.x.round() as isize, middle.y.round() as isize);
        let square = (-steps..=steps).flat_map(|j| (-steps..=steps).map(move |i| (i, j)));
        let all: Vec<f64> = square
            .filter_map(|(i, j)| colors.brightness.get(u + i, v + j))
            .map(f64::from)
            .collect();
        median(&all)
    };
    let cheeks = [-1.0, 1.0].map(|side| tone(Vec2::new(side * CHEEK_MM.0, CHEEK_MM.1)));
    let above = tone(chin + Vec2::new(0.0, TONE_MM));
    match (above, cheeks) {
        (Some(chin), [Some(left), Some(right)]) => chin < left.min(right) - BEARD_DARKER,
        _ => false,
    }
}

fn plausible_nose(nose: &Nose) -> bool {
    match (nose.ala_left, nose.ala_right) {
        (Some(left), Some(right)) => NOSE_WIDTH_MM.contains(&(right.x - left.x)),
        _ => true,
    }
}

fn plausible_eyes([left, right]: &[Eye; 2]) -> bool {
    OUTER_CORNERS_MM.contains(&(right.outer.x - left.outer.x))
        && INNER_CORNERS_MM.contains(&(right.inner.x - left.inner.x))
        && (right.inner.y - left.inner.y).abs() < UNEVEN_EYES_MM
        && (right.outer.y - left.outer.y).abs() < UNEVEN_EYES_MM
        && (right.inner.x + left.inner.x).abs() < UNEVEN_EYES_MM
}

/// Eyes and mouth where their distance is that of a face; else neither.
fn agreeing(eyes: Option<[Eye; 2]>, mouth: Option<Mouth>) -> (Option<[Eye; 2]>, Option<Mouth>) {
    if let (Some([left, right]), Some(mouth)) = (&eyes, &mouth) {
        let eye_line = 0.25 * (left.inner.y + left.outer.y + right.inner.y + right.outer.y);
        let mouth_line = 0.5 * (mouth.left.y + mouth.right.y);
        if !EYES_TO_MOUTH_MM.contains(&(eye_line - mouth_line)) {
            return (None, None);
        }
    }
    (eyes, mouth)
}

/// The corner of an eye.
fn corner(name: &'static str, at: Vec2, behind_mm: f64) -> Placed {
    Placed { name, at, raised_mm: -behind_mm, sigma_mm: EYE_SIGMA_MM }
}

fn place_nose(nose: &Nose, picture: &FrontalPicture, list: &mut Vec<Placed>) {
    list.push(placed("nose_tip", nose.tip, NOSE_SIGMA_MM));
    let beyond = |p: Vec2, mm: f64| Vec2::new(p.x + mm.copysign(p.x), p.y);
    let alae = [("ala_left", nose.ala_left), ("ala_right", nose.ala_right)];
    let found: Vec<(&'static str, Vec2)> = alae
        .into_iter()
        .filter_map(|(name, at)| Some((name, beyond(at?, ALA_BEYOND_MM))))
        .collect();
    // the depth of both wings is the same
    let depths: Vec<f64> = found
        .iter()
        .filter_map(|(_, at)| ala_depth(picture, *at, beyond(*at, CHEEK_OUTSIDE_MM)))
        .collect();
    let on_wing: f64 = found.iter().map(|(_, at)| picture.height_at(at.x, at.y)).sum();
    let by_wing = on_wing / found.len().max(1) as f64 + ALA_BEFORE_WING_MM;
    let depth = if depths.len() < 2 {
        by_wing
    } else {
        let by_cheek = depths.iter().sum::<f64>() / depths.len() as f64;
        by_wing + BY_CHEEK_WEIGHT * (by_cheek - by_wing)
    };
    list.extend(found.iter().map(|&(name, at)| Placed {
        name,
        at,
        raised_mm: depth - picture.height_at(at.x, at.y),
        sigma_mm: ALA_SIGMA_MM,
    }));
}

/// The depth of an ala by the cheek beside it and the base of the nose, where both are measured.
fn ala_depth(picture: &FrontalPicture, ala: Vec2, cheek: Vec2) -> Option<f64> {
    let measured = |x: f64, y: f64| picture.measured_at(x, y).then(|| picture.height_at(x, y));
    let base = measured(0.0, ala.y - BASE_BELOW_ALAE_MM)?;
    let cheek = measured(cheek.x, cheek.y)?;
    Some(CHEEK_WEIGHT * cheek + (1.0 - CHEEK_WEIGHT) * base + ALA_BEFORE_MM)
}

/// The middle between the eyes, and the direction upward from the mouth to it in the plane of
/// symmetry.
fn upright(
    picture: &FrontalPicture,
    eyes: Option<&[Eye; 2]>,
    mouth: Option<&Mouth>,
) -> Option<Upright> {
    let lifted = |p: Vec2| Vec3::new(p.x, p.y, picture.height_at(p.x, p.y));
    let ([left, right], mouth) = (eyes?, mouth?);
    let eyes = [left.inner, left.outer, right.inner, right.outer].map(lifted);
    let centre = eyes.iter().sum::<Vec3>() / 4.0;
    let mouth = (lifted(mouth.left) + lifted(mouth.right)) / 2.0;
    let up = Vec3::new(0.0, centre.y - mouth.y, centre.z - mouth.z).normalize();
    Some(Upright { centre, up })
}

/// Saddle, forehead and chin: by their heights relative to eyes and mouth, and by the profile. The
/// level of the face is that of `upright`, or of the head's frame.
fn place_midline(
    picture: &FrontalPicture,
    profile: &Profile,
    nose: Option<&Nose>,
    upright: Option<Upright>,
    mouth: Option<&Mouth>,
    list: &mut Vec<Placed>,
) {
    let lifted = |p: Vec2| Vec3::new(p.x, p.y, picture.height_at(p.x, p.y));
    let up = upright.map_or(Vec3::y(), |u| u.up);
    let midline =
        |x: f64, from: Vec3, distance_mm: f64| on_surface_at(picture, x, from, up, distance_mm);
    if let Some(Upright { centre, .. }) = upright {
        let x = 0.5 * centre.x;
        list.push(placed("nose_saddle", midline(x, centre, SADDLE_ABOVE_EYES_MM), SADDLE_SIGMA_MM));
        list.push(placed(
            "forehead",
            midline(x, centre, FOREHEAD_ABOVE_EYES_MM),
            FOREHEAD_SIGMA_MM,
        ));
    } else if let Some(nose) = nose {
        let saddle = nose.saddle;
        list.push(placed("nose_saddle", saddle, SADDLE_BY_SHAPE_SIGMA_MM));
        let forehead = midline(0.0, lifted(saddle), FOREHEAD_ABOVE_SADDLE_MM);
        list.push(placed("forehead", forehead, SADDLE_BY_SHAPE_SIGMA_MM.hypot(FOREHEAD_SIGMA_MM)));
    }
    if let Some(mouth) = mouth {
        let expected = midline(0.5 * mouth.down.x, lifted(mouth.down), -CHIN_BELOW_LIP_MM);
        let tilt = up.z / up.y;
        let y = profile
            .receding_below(mouth.down.y - CHIN_SEARCH_MM, tilt, CHIN_SLOPE)
            .map(|y| y - CHIN_BELOW_SLOPE_MM)
            .filter(|y| (y - expected.y).abs() < CHIN_TOLERANCE_MM)
            .map_or(expected.y, |y| 0.5 * (expected.y + y));
        list.push(placed("chin", Vec2::new(expected.x, y), CHIN_SIGMA_MM));
    }
}

/// The position on the surface in a column at a distance from a point along a direction.
fn on_surface_at(picture: &FrontalPicture, x: f64, from: Vec3, up: Vec3, distance_mm: f64) -> Vec2 {
    let mut y = from.y + distance_mm;
    // the slope of the surface against `up` is small: a few steps suffice
    for _ in 0..8 {
        let p = Vec3::new(x, y, picture.height_at(x, y));
        y += distance_mm - (p - from).dot(&up);
    }
    Vec2::new(x, y)
}
