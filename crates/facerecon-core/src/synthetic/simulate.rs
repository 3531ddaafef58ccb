//! The virtual rig: photographs of a mesh under the projected pattern, with the truth beside them.
//! Floor 4.
//!
//! Light is computed in linear units by a z-buffer of both cameras and one of the projector
//! (shadows), nine samples a pixel; then come lens blur, photon and read noise, and 8 bit sRGB
//! coding (IEC 61966-2-1) at the same exposure for both cameras.

mod files;
mod geometry;
mod lamps;
mod noise;
mod photo;
mod truth;

#[cfg(test)]
mod tests;

pub use files::{dots_csv, npy, write_simulated};
pub use truth::{DotTruth, Truth};

use crate::camera::RigError;
use crate::data::{Capture, LandmarkPairs, Landmarks, Mesh, Photo, Rgb};
use crate::math::{Similarity, Vec3};
use crate::observer::{Artifact, Cancelled, Event, Observer};
use crate::render::RenderError;
use crate::settings;
use crate::settings::{SettingsError, Value};
use crate::synthetic::pattern::{PatternError, PatternParams};

use geometry::Rig;
use lamps::Lamps;
use photo::{Exposure, develop, expose};

settings! {
    /// The virtual rig.
    pub struct SimulateParams {
        /// Width of the photos.
        width_px: usize = 768, range 64.0..=8192.0, unit "px";
        /// Height of the photos.
        height_px: usize = 576, range 64.0..=8192.0, unit "px";
        /// Distance from the middle between the cameras to the foremost point of the subject.
        distance_mm: f64 = 1300.0, range 200.0..=5000.0, unit "mm";
        /// Distance between the cameras.
        baseline_mm: f64 = 150.0, range 10.0..=1000.0, unit "mm";
        /// Focal length of the left camera.
        focal_px: f64 = 2766.0, range 100.0..=50000.0, unit "px";
        /// Focal length of the right camera as a fraction of the left one's.
        focal_ratio: f64 = 1.0, range 0.5..=2.0;
        /// Turn of each camera toward the subject; 0 is a parallel rig.
        toe_in_deg: f64 = 0.0, range 0.0..=30.0, unit "deg";
        /// Shift of the sensors toward each other's side: at 1 the subject is in the middle of both
        /// photos of a parallel rig, at 0 the principal points are in the middle of the photos.
        sensor_shift: f64 = 0.0, range 0.0..=1.0;
        /// First radial distortion of both lenses.
        distortion_k1: f64 = 0.0, range -0.5..=0.5;
        /// Second radial distortion of both lenses.
        distortion_k2: f64 = 0.0, range -1.0..=1.0;
        /// Fault: the right photo lies lower by this much than the calibration says.
        row_offset_px: f64 = 0.0, range -50.0..=50.0, unit "px";
        /// Fault: the right photo is turned by this much against the calibration.
        row_roll_deg: f64 = 0.0, range -5.0..=5.0, unit "deg";
        /// Turn of the head to its left (the right of the picture).
        yaw_deg: f64 = 0.0, range -90.0..=90.0, unit "deg";
        /// Nod of the head, upward.
        pitch_deg: f64 = 0.0, range -60.0..=60.0, unit "deg";
        /// Tilt of the head, clockwise in the picture.
        roll_deg: f64 = 0.0, range -60.0..=60.0, unit "deg";
        /// Shift of the head to the right of the picture.
        shift_x_mm: f64 = 0.0, range -500.0..=500.0, unit "mm";
        /// Shift of the head downward.
        shift_y_mm: f64 = 0.0, range -500.0..=500.0, unit "mm";
        /// Motion of the head between the pair with the pattern and the pair without.
        plain_motion_mm: f64 = 0.0, range 0.0..=50.0, unit "mm";
        /// Turn of the head between the pair with the pattern and the pair without.
        plain_motion_deg: f64 = 0.0, range 0.0..=20.0, unit "deg";
        /// Height of the projector above the cameras.
        projector_above_mm: f64 = 130.0, range -1000.0..=1000.0, unit "mm";
        /// Distance from dot to dot (or stripe to stripe) on the subject.
        dot_mm: f64 = 4.5, range 0.5..=50.0, unit "mm";
        /// Softness of the dots' edges, in distances from dot to dot.
        dot_softness: f64 = 0.04, range 0.0..=0.5;
        /// Light of the projector.
        projector_light: f64 = 1.0, range 0.0..=10.0;
        /// Light from everywhere, with the pattern.
        ambient_light: f64 = 0.07, range 0.0..=10.0;
        /// Light of a large lamp at the upper left, with the pattern.
        soft_light: f64 = 0.06, range 0.0..=10.0;
        /// Light from everywhere, without the pattern.
        ambient_plain: f64 = 0.30, range 0.0..=10.0;
        /// Light of the large lamp, without the pattern.
        soft_plain: f64 = 0.45, range 0.0..=10.0;
        /// Shine of the skin: strength of the mirrored light.
        gloss: f64 = 0.02, range 0.0..=1.0;
        /// Whether there is a wall behind the subject.
        wall: bool = true;
        /// Distance of the wall behind the foremost point of the subject.
        wall_mm: f64 = 700.0, range 50.0..=5000.0, unit "mm";
        /// Exposure with the pattern: brightness (of the brightest colour) that a twentieth of the
        /// subject exceeds, as a fraction of white; both cameras are exposed alike.
        exposure: f64 = 0.72, range 0.01..=4.0;
        /// Exposure without the pattern: brightness of white paper that faces the lamp, as a fraction
        /// of white; near 1 skin of any colour comes out at its own tone.
        exposure_plain: f64 = 1.25, range 0.01..=4.0;
        /// Sensitivity of the right camera against the left one.
        gain_right: f64 = 1.0, range 0.1..=10.0;
        /// Standard deviation of the lens blur.
        blur_px: f64 = 0.5, range 0.0..=20.0, unit "px";
        /// Electrons at full white: photon noise is their square root; 0 switches all noise off.
        full_well_e: f64 = 9000.0, range 0.0..=1e6, unit "electrons";
        /// Read noise.
        read_noise_e: f64 = 3.0, range 0.0..=1000.0, unit "electrons";
        /// Seed of the noise and of the head's motion.
        seed: u64 = 1, range 0.0..=9e15;
        /// The projected pattern; its image's resolution plays no part.
        pattern: PatternParams = PatternParams::default();
    }
}

/// What stands before the cameras.
#[derive(Clone, Copy, Debug)]
pub struct Subject<'a> {
    /// The mesh, model frame (x right, y up, z toward the viewer), millimetres.
    pub mesh: &'a Mesh,
    /// Its albedo as a texture, sRGB; else the vertex colours count, else the colour of skin.
    pub texture: Option<&'a Rgb>,
    /// Vertices of the 18 features: the capture then carries the thesis's three marked pairs, and
    /// the truth all features.
    pub landmarks: Option<&'a Landmarks>,
    /// Whether each vertex belongs to the face, for the dots' `on_face`; else all of the subject.
    pub face: Option<&'a [bool]>,
}

/// A capture and the truth behind it.
#[derive(Clone, Debug, PartialEq)]
pub struct Simulated {
    /// The photographs and what is told to the reconstruction. No features are marked in it.
    pub capture: Capture,
    /// What only the simulator knows.
    pub truth: Truth,
}

/// A capture that cannot be simulated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SimulateError {
    /// A parameter out of range.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// A subject that cannot be drawn.
    #[error("simulating the subject: {0}")]
    Render(#[from] RenderError),
    /// A pattern out of range.
    #[error(transparent)]
    Pattern(#[from] PatternError),
    /// Cameras that cannot stand so.
    #[error("the virtual rig cannot be: {0}")]
    Rig(#[from] RigError),
    /// A list that does not fit to the mesh.
    #[error("the subject's {what} has {got} entries, but the mesh has {expected} vertices")]
    Subject {
        /// Which list.
        what: &'static str,
        /// Its entries.
        got: usize,
        /// The vertices.
        expected: usize,
    },
    /// Nothing of the subject in a photo.
    #[error(
        "the {camera} camera sees nothing of the subject (foremost point at {distance_mm:.0} mm); move the subject, shorten the focal length or turn the cameras in"
    )]
    Unseen {
        /// `left` or `right`.
        camera: &'static str,
        /// Distance of the subject.
        distance_mm: f64,
    },
    /// Cancelled by the observer.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

crate::stage_error!(SimulateError, "simulate");

/// Photographs the subject with and without the projected pattern.
///
/// # Errors
/// [`SimulateError`] for parameters out of range, an invalid mesh, an impossible rig, a subject
/// outside the photos, or when the observer asks to stop.
pub fn simulate(
    subject: &Subject<'_>,
    params: &SimulateParams,
    observer: &dyn Observer,
) -> Result<Simulated, SimulateError> {
    params.check("simulate", None)?;
    check_subject(subject)?;
    let rig = Rig::new(params);
    rig.told.validate((params.width_px, params.height_px))?;
    let camera_from_model = rig.camera_from_model(subject.mesh, params);
    let plain_from_dots = rig.plain_from_dots(&camera_from_model, subject.mesh, params);

    let still = Lamps::new(subject, &camera_from_model, &rig, params)?;
    let moved = plain_from_dots
        .map(|motion| Lamps::new(subject, &motion.compose(&camera_from_model), &rig, params));
    let moved = moved.transpose()?;
    let sides = [
        ("left", rig.told.left, Similarity::identity()),
        ("right", rig.true_right(), rig.true_right_from_left),
    ];
    // linear pictures, [left, right] of [pattern, plain]
    let mut light = Vec::with_capacity(2);
    for (camera, pinhole, camera_from_left) in sides {
        let mut pair = expose(&still, &pinhole, &camera_from_left, params, observer)?;
        if let Some(moved) = &moved {
            pair.plain = expose(moved, &pinhole, &camera_from_left, params, observer)?.plain;
        }
        if !pair.subject.contains(&true) {
            let distance_mm = params.distance_mm;
            return Err(SimulateError::Unseen { camera, distance_mm });
        }
        light.push(pair);
    }
    let exposure = [
        Exposure::automatic(&light[0].pattern, &light[0].subject, params),
        Exposure::of_paper(params),
    ];
    let photo = |side: usize, plain: usize| -> Result<Photo, SimulateError> {
        observer.check()?;
        let linear = if plain == 1 { &light[side].plain } else { &light[side].pattern };
        let gain = if side == 1 { params.gain_right } else { 1.0 };
        let developed = develop(linear, &exposure[plain].times(gain), side * 2 + plain, params);
        Ok(Photo::from_rgb(developed))
    };
    let (left, right) = (photo(0, 0)?, photo(1, 0)?);
    let plain = [photo(0, 1)?, photo(1, 1)?];

    let truth = truth::gather(subject, &still, &rig, plain_from_dots, params)?;
    observer.event(&Event::Count {
        stage: "simulate",
        what: "dots on the subject seen by both cameras",
        count: truth.dots.iter().filter(|d| d.lit && d.visible == [true, true]).count(),
    });
    observer.artifact("simulate", "truth_mesh", Artifact::Mesh(&truth.mesh));
    let capture = Capture {
        left,
        right,
        plain: Some(plain),
        extra: Vec::new(),
        pattern: params.pattern.pattern(),
        rig: Some(rig.told),
        seeds: truth.seeds(),
        landmarks: LandmarkPairs::new(),
    };
    Ok(Simulated { capture, truth })
}

fn check_subject(subject: &Subject<'_>) -> Result<(), SimulateError> {
    subject.mesh.validate().map_err(RenderError::from)?;
    let expected = subject.mesh.vertices.len();
    if let Some(face) = subject.face.filter(|f| f.len() != expected) {
        return Err(SimulateError::Subject { what: "face mask", got: face.len(), expected });
    }
    let beyond = subject.landmarks.and_then(|l| l.values().find(|i| **i >= expected));
    match beyond {
        Some(&got) => Err(SimulateError::Subject { what: "landmark list", got, expected }),
        None => Ok(()),
    }
}

/// Middle of a mesh's bounding box.
fn middle(mesh: &Mesh) -> Vec3 {
    mesh.bounds().map_or_else(Vec3::zeros, |(low, high)| (low + high) / 2.0)
}
