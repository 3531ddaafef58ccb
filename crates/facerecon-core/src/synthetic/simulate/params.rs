//! Parameters of the virtual rig.

use crate::settings::settings;
use crate::synthetic::pattern::PatternParams;

settings! {
    /// The virtual rig.
    pub struct SimulateParams {
        /// Width of the photos.
        width_px: usize = 768, range 64.0..=8192.0, unit "px";
        /// Height of the photos.
        height_px: usize = 576, range 64.0..=8192.0, unit "px";
        /// Distance from the midpoint between the cameras to the frontmost point of the subject.
        distance_mm: f64 = 1300.0, range 200.0..=5000.0, unit "mm";
        /// Distance between the cameras.
        baseline_mm: f64 = 150.0, range 10.0..=1000.0, unit "mm";
        /// Focal length of the left camera.
        focal_px: f64 = 2766.0, range 100.0..=50000.0, unit "px";
        /// Focal length of the right camera, relative to that of the left camera.
        focal_ratio: f64 = 1.0, range 0.5..=2.0;
        /// Rotation of each camera toward the subject; 0 is a parallel rig.
        toe_in_deg: f64 = 0.0, range 0.0..=30.0, unit "deg";
        /// Shift of the sensors: at 1 the subject is in the middle of both photos of a parallel rig, at
        /// 0 the principal points are in the middle of the photos.
        sensor_shift: f64 = 0.0, range 0.0..=1.0;
        /// First radial distortion coefficient of both lenses.
        distortion_k1: f64 = 0.0, range -0.5..=0.5;
        /// Second radial distortion coefficient of both lenses.
        distortion_k2: f64 = 0.0, range -1.0..=1.0;
        /// Calibration error: the right photo is lower by this than the calibration states.
        row_offset_px: f64 = 0.0, range -50.0..=50.0, unit "px";
        /// Calibration error: the right photo is rotated by this relative to the calibration.
        row_roll_deg: f64 = 0.0, range -5.0..=5.0, unit "deg";
        /// Rotation of the head to its left (to the right in the photos).
        yaw_deg: f64 = 0.0, range -90.0..=90.0, unit "deg";
        /// Rotation of the head upward.
        pitch_deg: f64 = 0.0, range -60.0..=60.0, unit "deg";
        /// Rotation of the head in the image plane, clockwise in the photos.
        roll_deg: f64 = 0.0, range -60.0..=60.0, unit "deg";
        /// Shift of the head to the right in the photos.
        shift_x_mm: f64 = 0.0, range -500.0..=500.0, unit "mm";
        /// Shift of the head downward.
        shift_y_mm: f64 = 0.0, range -500.0..=500.0, unit "mm";
        /// Translation of the head between the dotted pair and the plain pair.
        plain_motion_mm: f64 = 0.0, range 0.0..=50.0, unit "mm";
        /// Rotation of the head between the dotted pair and the plain pair.
        plain_motion_deg: f64 = 0.0, range 0.0..=20.0, unit "deg";
        /// Height of the projector above the cameras.
        projector_above_mm: f64 = 130.0, range -1000.0..=1000.0, unit "mm";
        /// Distance between dots (or stripes) on the subject.
        dot_mm: f64 = 4.5, range 0.5..=50.0, unit "mm";
        /// Blur of the edges of the dots, in distances between dots.
        dot_softness: f64 = 0.04, range 0.0..=0.5;
        /// Intensity of the projector.
        projector_light: f64 = 1.0, range 0.0..=10.0;
        /// Intensity of ambient light in the dotted pair.
        ambient_light: f64 = 0.07, range 0.0..=10.0;
        /// Intensity of a large light at the upper left in the dotted pair.
        soft_light: f64 = 0.06, range 0.0..=10.0;
        /// Intensity of ambient light in the plain pair.
        ambient_plain: f64 = 0.30, range 0.0..=10.0;
        /// Intensity of the large light in the plain pair.
        soft_plain: f64 = 0.45, range 0.0..=10.0;
        /// Intensity of specular reflection of the skin.
        gloss: f64 = 0.02, range 0.0..=1.0;
        /// Whether there is a wall behind the subject.
        wall: bool = true;
        /// Distance of the wall behind the frontmost point of the subject.
        wall_mm: f64 = 700.0, range 50.0..=5000.0, unit "mm";
        /// Exposure of the dotted pair: 95th percentile of the brightness of the subject (of its
        /// brightest colour channel), as a fraction of white; the same for both cameras.
        exposure: f64 = 0.72, range 0.01..=4.0;
        /// Exposure of the plain pair: brightness of white paper that faces the large light, as a
        /// fraction of white; near 1 the photos show the albedo of the skin.
        exposure_plain: f64 = 1.25, range 0.01..=4.0;
        /// Sensitivity of the right camera, relative to the left camera.
        gain_right: f64 = 1.0, range 0.1..=10.0;
        /// Standard deviation of the lens blur.
        blur_px: f64 = 0.5, range 0.0..=20.0, unit "px";
        /// Electrons at white; photon noise is their square root. 0 turns all noise off.
        full_well_e: f64 = 9000.0, range 0.0..=1e6, unit "electrons";
        /// Standard deviation of the read noise.
        read_noise_e: f64 = 3.0, range 0.0..=1000.0, unit "electrons";
        /// Seed of the noise and of the motion of the head.
        seed: u64 = 1, range 0.0..=9e15;
        /// The projected pattern; the resolution of its image has no effect.
        pattern: PatternParams = PatternParams::default();
    }
}
