//! The ears, by the outline of the subject in the plain photos: the auricle stands out from it
//! between two concave corners, at the upper and at the lower attachment.

use super::LandmarksInput;
use super::ear_outline::{Corner, EarOutline, GRID_DEPTH_MM};
use super::frontal::{DARK, linear_sample};
use super::head_frame::HeadFrame;
use crate::camera::RectifiedRig;
use crate::data::{LandmarkSource, MeasuredLandmark};
use crate::math::Vec3;
use crate::render::linear_table;

/// Attachments of the ears from the middle between the eyes, mm: to the side, up along the line from
/// mouth to eyes, and forward. Means over rendered adult heads; standard deviations 4, 6 and 5.
const UPPER_MM: [f64; 3] = [78.5, 11.0, -77.5];
const LOWER_MM: [f64; 3] = [70.0, -40.5, -79.5];
const EXPECTED_SIGMA_MM: f64 = 5.0;

/// The attachments lie so far in front of the rim of the auricle, mm; means over rendered heads,
/// standard deviations 2.7 and 4.
const UPPER_BEFORE_RIM_MM: f64 = 23.4;
const LOWER_BEFORE_RIM_MM: f64 = 20.6;
/// Weights of the depths by the rim against those by the proportions.
const UPPER_RIM_WEIGHT: f64 = 0.7;
const LOWER_RIM_WEIGHT: f64 = 0.6;
/// A rim farther than this from where the proportions put it is not that of the ear (the cheek hides
/// it from one camera, hair), mm: three standard deviations.
const RIM_TOLERANCE_MM: f64 = 15.0;
/// An attachment farther than this from where the proportions put it belongs to something else, mm:
/// three to four standard deviations.
const TOLERANCE_MM: f64 = 20.0;

/// Position of an attachment relative to the corner of the outline, mm to the side and up. Means
/// over rendered heads; standard deviations 1.2 and 1.0, 2.1 and 1.2, 2.5 and 0.6.
const UPPER_FROM_CORNER_MM: [f64; 2] = [-1.6, -1.9];
const COVERED_FROM_CORNER_MM: [f64; 2] = [-9.4, -4.2];
const LOWER_FROM_CORNER_MM: [f64; 2] = [3.0, 1.0];
/// Standard deviations of the positions, the depth included, mm.
const UPPER_SIGMA_MM: f64 = 2.0;
const COVERED_SIGMA_MM: f64 = 2.6;
const LOWER_SIGMA_MM: f64 = 2.6;
/// Added in quadrature where the outline is not known for certain, mm.
const UNCERTAIN_SIGMA_MM: f64 = 2.0;
/// Usual angle of the camera beside the plane of symmetry, and the angle from there at which the
/// outline begins to show other parts (the jaw or the neck behind the lobe), degrees; and the standard
/// deviation that is added per degree beyond, mm.
const USUAL_ANGLE_DEG: f64 = 4.0;
const FREE_ANGLE_DEG: f64 = 3.0;
const SIGMA_MM_PER_DEG: f64 = 0.8;

/// The auricle stands out from the lower corner by at least this much, mm.
const MIN_AURICLE_MM: f64 = 10.0;
/// Distance between the corners, mm (otobasion superius to inferius: 40 to 62 in children and adults).
const AURICLE_HEIGHT_MM: std::ops::Range<f64> = 34.0..64.0;
/// Logarithm of the brightness by which the upper corner is darker than the ear where there is no hair
/// and where hair covers the attachment.
const HAIR_DARKER: (f64, f64) = (0.4, 1.6);
/// An ear is not darker than the cheek by more than this logarithm of the brightness, nor of another
/// hue by more than this logarithm of red over green: else it is hair.
const EAR_DARKER: f64 = 1.2;
const EAR_HUE: f64 = 0.35;
/// Where the cheek is sampled, mm to the side, up and forward from the middle between the eyes.
const CHEEK_SIDE_MM: [f64; 3] = [45.0, 50.0, 55.0];
const CHEEK_UP_MM: [f64; 3] = [-30.0, -20.0, -10.0];
const CHEEK_FORWARD_MM: f64 = -40.0;

/// The middle between the eyes, and the directions of the upright face; head's frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Upright {
    pub centre: Vec3,
    /// Unit vector from the mouth to the eyes in the plane of symmetry.
    pub up: Vec3,
}

impl Upright {
    /// Camera frame position of a place beside the middle between the eyes, mm: to the side
    /// (`side` is -1 for the left of the picture), up, forward.
    pub fn to_camera(self, frame: &HeadFrame, side: f64, [x, y, z]: [f64; 3]) -> Vec3 {
        let forward = Vec3::x().cross(&self.up);
        frame.to_camera(&(self.centre + side * x * Vec3::x() + y * self.up + z * forward))
    }

    /// Inverse of [`Self::to_camera`]: where a point of the camera frame lies beside the middle between the
    /// eyes, mm: to the side, up, forward.
    pub fn place(self, frame: &HeadFrame, side: f64, point: &Vec3) -> [f64; 3] {
        let d = frame.place(point) - self.centre;
        [side * d.x, d.dot(&self.up), d.dot(&Vec3::x().cross(&self.up))]
    }
}

const SIDES: [(&str, f64); 2] = [("left", -1.0), ("right", 1.0)];

/// Where the attachments of the ears are expected; camera frame.
pub(super) fn expected(upright: Upright, frame: &HeadFrame) -> Vec<MeasuredLandmark> {
    let both = |(name, side): (&str, f64)| {
        [("upper", UPPER_MM), ("lower", LOWER_MM)].map(|(end, at)| {
            landmark(name, end, upright.to_camera(frame, side, at), EXPECTED_SIGMA_MM)
        })
    };
    SIDES.into_iter().flat_map(both).collect()
}

/// Finds the attachments of the ears that the outlines show; camera frame.
pub(super) fn find(
    input: &LandmarksInput<'_>,
    upright: Upright,
    frame: &HeadFrame,
) -> Vec<MeasuredLandmark> {
    let Some(rig) = input.rectification.rig.as_ref() else { return Vec::new() };
    let ears: Vec<(&str, Ear)> = SIDES
        .into_iter()
        .filter_map(|(name, side)| Some((name, Ear::find(input, rig, upright, frame, side)?)))
        .collect();
    // Both ears of a head lie equally deep: what is seen of either counts for both.
    let rims: Vec<f64> = ears.iter().filter_map(|(_, ear)| ear.rim_depth_mm).collect();
    let rim = (!rims.is_empty()).then(|| rims.iter().sum::<f64>() / rims.len() as f64);
    let depth = |expected: f64, before_rim: f64, weight: f64| {
        rim.map_or(expected, |rim| expected + weight * (rim + before_rim - expected))
    };
    let upper_depth = depth(UPPER_MM[2], UPPER_BEFORE_RIM_MM, UPPER_RIM_WEIGHT);
    let lower_depth = depth(LOWER_MM[2], LOWER_BEFORE_RIM_MM, LOWER_RIM_WEIGHT);
    let mut found = Vec::new();
    for (name, ear) in ears {
        let blend = |free: f64, covered: f64| free + ear.covered * (covered - free);
        let upper = [0, 1].map(|i| blend(UPPER_FROM_CORNER_MM[i], COVERED_FROM_CORNER_MM[i]));
        let upper_sigma = blend(UPPER_SIGMA_MM, COVERED_SIGMA_MM);
        let lower_sigma = LOWER_SIGMA_MM.hypot(ear.angle_sigma_mm());
        let ends = [
            ("upper", &ear.upper, upper_depth, upper, upper_sigma, UPPER_MM),
            ("lower", &ear.lower, lower_depth, LOWER_FROM_CORNER_MM, lower_sigma, LOWER_MM),
        ];
        for (end, corner, depth_mm, offset, sigma_mm, expected) in ends {
            let [x, y] = ear.at_depth(corner, depth_mm);
            let at = [x + offset[0], y + offset[1], depth_mm];
            let extra = if corner.certain { 0.0 } else { UNCERTAIN_SIGMA_MM };
            let sigma_mm = sigma_mm.hypot(extra);
            let near = (at[0] - expected[0]).hypot(at[1] - expected[1]) <= TOLERANCE_MM;
            if near && sigma_mm < EXPECTED_SIGMA_MM {
                let position = upright.to_camera(frame, ear.side, at);
                found.push(landmark(name, end, position, sigma_mm));
            }
        }
    }
    found
}

fn landmark(side: &str, end: &str, position: Vec3, sigma_mm: f64) -> MeasuredLandmark {
    let name = format!("ear_{side}_{end}");
    MeasuredLandmark { name, position, sigma_mm, source: LandmarkSource::Found }
}

/// What the outline shows of an ear.
struct Ear {
    /// -1 at the left of the picture, 1 at the right.
    side: f64,
    /// Corners of the outline at the attachments, on the grid's plane.
    upper: Corner,
    lower: Corner,
    /// How far hair covers the upper attachment: 0 not at all, 1 completely.
    covered: f64,
    /// Depth of the rim of the auricle (mm forward of the eyes), where both cameras see it.
    rim_depth_mm: Option<f64>,
    /// The camera that sees the ear best: to the side, up, forward from the middle between the eyes, mm.
    camera: [f64; 3],
}

impl Ear {
    fn find(
        input: &LandmarksInput<'_>,
        rig: &RectifiedRig,
        upright: Upright,
        frame: &HeadFrame,
        side: f64,
    ) -> Option<Self> {
        let cameras = rig.camera_centres().map(|c| upright.place(frame, side, &c));
        // The camera on the side of the ear: the cheek hides the ear from the other one first.
        let near = usize::from(cameras[1][0] > cameras[0][0]);
        let views = [&input.rectification.left, &input.rectification.right];
        let photo_pixel = |camera: usize, at: [f64; 3]| {
            let (left, right) = rig.pixels(&upright.to_camera(frame, side, at))?;
            Some(views[camera].to_photo([left, right][camera]))
        };
        let outline = |camera: usize| {
            let outline = input.outlines[camera]?;
            Some(EarOutline::new(outline, |x, y| photo_pixel(camera, [x, y, GRID_DEPTH_MM])))
        };
        let seen = outline(near)?;
        let lower = seen.lower_corner()?;
        let upper = seen.upper_corner(&lower)?;
        let (side_mm, rows) = seen.auricle(&lower, &upper)?;
        if side_mm - lower.x_mm < MIN_AURICLE_MM
            || !AURICLE_HEIGHT_MM.contains(&(upper.y_mm - lower.y_mm))
        {
            return None;
        }
        let rim_depth_mm = outline(1 - near)
            .and_then(|other| rim_depth(&seen, &other, rows, [cameras[near], cameras[1 - near]]))
            .filter(|z| (z - (UPPER_MM[2] - UPPER_BEFORE_RIM_MM)).abs() < RIM_TOLERANCE_MM);
        let photo = input.plain?[near];
        let linear = linear_table();
        let colour = |places: &[[f64; 3]]| {
            let samples: Vec<[f64; 3]> = places
                .iter()
                .filter_map(|at| linear_sample(photo, &linear, photo_pixel(near, *at)?))
                .collect();
            Shade::mean(&samples)
        };
        let at = |x: f64, ys: [f64; 2]| ys.map(|y| [x, y, GRID_DEPTH_MM]);
        let hollow = upper.hollow_mm;
        let notch: Vec<_> = [2.0, 3.5, 5.0]
            .iter()
            .flat_map(|d| at(hollow[0] - d, [1.0, 3.0].map(|y| hollow[1] + y)))
            .collect();
        let lobe: Vec<_> = [2.0, 4.0, 6.0]
            .iter()
            .flat_map(|d| at(lower.x_mm + d, [6.0, 10.0].map(|y| lower.y_mm + y)))
            .collect();
        let cheek: Vec<_> = CHEEK_SIDE_MM
            .iter()
            .flat_map(|x| CHEEK_UP_MM.map(|y| [*x, y, CHEEK_FORWARD_MM]))
            .collect();
        let (notch, lobe, cheek) = (colour(&notch)?, colour(&lobe)?, colour(&cheek)?);
        if cheek.brightness - lobe.brightness > EAR_DARKER
            || (cheek.redness - lobe.redness).abs() > EAR_HUE
        {
            return None;
        }
        let (free, hair) = HAIR_DARKER;
        let darker = lobe.brightness - notch.brightness;
        let covered = ((darker - free) / (hair - free)).clamp(0.0, 1.0);
        Some(Self { side, upper, lower, covered, rim_depth_mm, camera: cameras[near] })
    }

    /// What an unusual angle of the camera adds to the standard deviation of the lower attachment, mm.
    fn angle_sigma_mm(&self) -> f64 {
        let angle = self.camera[0].atan2(self.camera[2]).to_degrees();
        SIGMA_MM_PER_DEG * ((angle - USUAL_ANGLE_DEG).abs() - FREE_ANGLE_DEG).max(0.0)
    }

    /// To the side and up of a corner of the grid's plane, moved along its ray to a depth, mm.
    fn at_depth(&self, corner: &Corner, depth_mm: f64) -> [f64; 2] {
        let [cx, cy, cz] = self.camera;
        let k = (depth_mm - cz) / (GRID_DEPTH_MM - cz);
        [cx + k * (corner.x_mm - cx), cy + k * (corner.y_mm - cy)]
    }
}

/// Depth at which the outer boundaries of the auricle in both photos coincide, mm.
fn rim_depth(
    near: &EarOutline,
    far: &EarOutline,
    rows: std::ops::Range<usize>,
    cameras: [[f64; 3]; 2],
) -> Option<f64> {
    let (x_mm, difference_mm) = near.boundary_difference(far, rows)?;
    // A boundary at x on the grid's plane lies on the ray of slope (x - camera) / (plane - camera).
    let slope = |camera: [f64; 3]| (x_mm - camera[0]) / (GRID_DEPTH_MM - camera[2]);
    let apart = slope(cameras[0]) - slope(cameras[1]);
    (apart.abs() > f64::EPSILON).then(|| GRID_DEPTH_MM - difference_mm / apart)
}

/// A colour without the strength of its light.
struct Shade {
    /// Logarithm of red over green.
    redness: f64,
    /// Logarithm of the brightness.
    brightness: f64,
}

impl Shade {
    /// The mean over samples of linear light; `None` without any.
    fn mean(samples: &[[f64; 3]]) -> Option<Self> {
        let n = samples.len() as f64;
        let (mut redness, mut brightness) = (0.0, 0.0);
        for [red, green, blue] in samples {
            redness += ((red + DARK) / (green + DARK)).ln() / n;
            brightness += ((red + green + blue) / 3.0 + DARK).ln() / n;
        }
        (!samples.is_empty()).then_some(Self { redness, brightness })
    }
}
