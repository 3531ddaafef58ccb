//! Checks of a capture, whatever it was made from: a file, arrays or a simulation.

use std::fmt;
use std::ops::RangeInclusive;

use super::capture::{Capture, ExtraPhoto, Pattern, PatternKind, Photo};
use super::landmarks::{LANDMARKS, unknown_landmark};
use super::matches::Pair;
use crate::camera::{RigError, rotation_fault};

/// Most columns or rows of a pattern; projectors have fewer pixels than that.
const MAX_PATTERN: usize = 10_000;
/// Fewest columns and rows of a lattice of dots: its spacing must be defined.
const MIN_DOTS: usize = 2;
/// Largest rotation of the lattice, degrees: one full turn either way.
const MAX_ROTATION_DEG: f64 = 360.0;

/// One photo of a capture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PhotoRole {
    /// The left dotted photo.
    Left,
    /// The right dotted photo.
    Right,
    /// The left plain photo.
    LeftPlain,
    /// The right plain photo.
    RightPlain,
    /// An extra photo, counted from 1.
    Extra(usize),
}

impl fmt::Display for PhotoRole {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Left => f.write_str("left"),
            Self::Right => f.write_str("right"),
            Self::LeftPlain => f.write_str("left plain"),
            Self::RightPlain => f.write_str("right plain"),
            Self::Extra(number) => write!(f, "extra {number}"),
        }
    }
}

/// A capture that cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CaptureError {
    /// A photo without pixels.
    #[error("the {photo} photo is {}x{} pixels; it is empty", size.0, size.1)]
    EmptyPhoto {
        /// The photo.
        photo: PhotoRole,
        /// Its width and height.
        size: (usize, usize),
    },
    /// A photo of another size than the left one.
    #[error(
        "the {photo} photo is {}x{} pixels, but the left photo is {}x{}; both pairs must have the same size",
        got.0, got.1, expected.0, expected.1
    )]
    PhotoSize {
        /// The photo.
        photo: PhotoRole,
        /// Its width and height.
        got: (usize, usize),
        /// Width and height of the left photo.
        expected: (usize, usize),
    },
    /// A photo whose colour and grey images differ in size.
    #[error(
        "the {photo} photo has a grey image of {}x{} pixels, but a colour image of {}x{}",
        gray.0, gray.1, rgb.0, rgb.1
    )]
    GraySize {
        /// The photo.
        photo: PhotoRole,
        /// Width and height of the grey image.
        gray: (usize, usize),
        /// Width and height of the colour image.
        rgb: (usize, usize),
    },
    /// A pattern with too few or too many dots.
    #[error("the pattern has {got} {what}; {} to {} are expected", expected.start(), expected.end())]
    PatternCount {
        /// `columns` or `rows`.
        what: &'static str,
        /// Number found.
        got: usize,
        /// Numbers that are possible.
        expected: RangeInclusive<usize>,
    },
    /// A rotation of the pattern beyond a full turn, or not a number.
    #[error(
        "the pattern's rotation is {got_deg:.1} degrees; -{MAX_ROTATION_DEG} to {MAX_ROTATION_DEG} are expected"
    )]
    PatternRotation {
        /// Rotation found, degrees.
        got_deg: f64,
    },
    /// A mark outside its photo.
    #[error(
        "{mark}: ({x}, {y}) is outside the {side} photo of {width}x{height} pixels; mark it again"
    )]
    Outside {
        /// The mark, for example `seeds.head` or `landmarks.chin`.
        mark: String,
        /// `left` or `right`.
        side: &'static str,
        /// Column found, pixels.
        x: f64,
        /// Row found, pixels.
        y: f64,
        /// Width of the photo, pixels.
        width: usize,
        /// Height of the photo, pixels.
        height: usize,
    },
    /// A landmark name that is none of the 18.
    #[error("landmarks: {}", unknown_landmark(name))]
    Landmark {
        /// Name found.
        name: String,
    },
    /// An extra photo whose camera cannot exist.
    #[error("the camera of extra photo {number}: {fault}")]
    ExtraCamera {
        /// Number of the photo, counted from 1.
        number: usize,
        /// What was found and what is expected.
        fault: String,
    },
    /// A rig that cannot be used for the photos.
    #[error(transparent)]
    Rig(#[from] RigError),
}

impl Capture {
    /// Checks that all photos of the pairs have the same size, that the pattern's numbers are
    /// possible, that the seeds and landmarks are inside their photos, and that the rig and the
    /// cameras of the extra photos can exist.
    ///
    /// # Errors
    /// [`CaptureError`] for the first fault, with what was found and expected.
    ///
    /// ```
    /// use facerecon_core::data::{Capture, Pattern, PatternKind, Photo, Rgb};
    ///
    /// let photo = Photo::from_rgb(Rgb::filled(64, 48, [0; 3]));
    /// let mut capture = Capture {
    ///     left: photo.clone(),
    ///     right: photo,
    ///     plain: None,
    ///     extra: Vec::new(),
    ///     pattern: Pattern { kind: PatternKind::Dots, columns: 85, rows: 64, rotation: 0.0 },
    ///     rig: None,
    ///     seeds: None,
    ///     landmarks: Default::default(),
    /// };
    /// assert!(capture.validate().is_ok());
    /// capture.right = Photo::from_rgb(Rgb::filled(60, 48, [0; 3]));
    /// assert!(capture.validate().unwrap_err().to_string().contains("60x48"));
    /// ```
    pub fn validate(&self) -> Result<(), CaptureError> {
        self.check_photos()?;
        check_pattern(&self.pattern)?;
        if let Some(rig) = &self.rig {
            rig.validate(self.left.size())?;
        }
        self.check_marks()?;
        for (i, extra) in self.extra.iter().enumerate() {
            check_extra(i + 1, extra)?;
        }
        Ok(())
    }

    fn check_photos(&self) -> Result<(), CaptureError> {
        let pair = [(PhotoRole::Left, &self.left), (PhotoRole::Right, &self.right)];
        let plain = self.plain.iter().flatten();
        let plain = [PhotoRole::LeftPlain, PhotoRole::RightPlain].into_iter().zip(plain);
        let expected = self.left.size();
        for (role, photo) in pair.into_iter().chain(plain) {
            check_photo(role, photo)?;
            if photo.size() != expected {
                let got = photo.size();
                return Err(CaptureError::PhotoSize { photo: role, got, expected });
            }
        }
        Ok(())
    }

    fn check_marks(&self) -> Result<(), CaptureError> {
        let size = self.left.size();
        if let Some(seeds) = &self.seeds {
            check_mark("seeds.head", &seeds.head, size)?;
            check_mark("seeds.left_ear", &seeds.left_ear, size)?;
            check_mark("seeds.right_ear", &seeds.right_ear, size)?;
        }
        for (name, pair) in &self.landmarks {
            if !LANDMARKS.contains(&name.as_str()) {
                return Err(CaptureError::Landmark { name: name.clone() });
            }
            check_mark(&format!("landmarks.{name}"), pair, size)?;
        }
        Ok(())
    }
}

fn check_photo(role: PhotoRole, photo: &Photo) -> Result<(), CaptureError> {
    let (rgb, gray) = (photo.rgb.size(), photo.gray.size());
    if rgb.0 == 0 || rgb.1 == 0 {
        return Err(CaptureError::EmptyPhoto { photo: role, size: rgb });
    }
    if gray != rgb {
        return Err(CaptureError::GraySize { photo: role, gray, rgb });
    }
    Ok(())
}

fn check_pattern(pattern: &Pattern) -> Result<(), CaptureError> {
    // Stripes are identified by width and colour; their number may be unknown.
    let least = if pattern.kind == PatternKind::Dots { MIN_DOTS } else { 0 };
    let expected = least..=MAX_PATTERN;
    for (what, got) in [("columns", pattern.columns), ("rows", pattern.rows)] {
        if !expected.contains(&got) {
            return Err(CaptureError::PatternCount { what, got, expected });
        }
    }
    // The tolerance covers the conversion of 360 degrees to radians and back.
    let got_deg = pattern.rotation.to_degrees();
    if !(got_deg.abs() <= MAX_ROTATION_DEG + 1e-9) {
        return Err(CaptureError::PatternRotation { got_deg });
    }
    Ok(())
}

/// Pixel centres are at integers, so that the photo reaches half a pixel beyond the outer centres.
fn check_mark(
    mark: &str,
    pair: &Pair,
    (width, height): (usize, usize),
) -> Result<(), CaptureError> {
    for (side, p) in [("left", pair.left), ("right", pair.right)] {
        let inside = (-0.5..=width as f64 - 0.5).contains(&p.x)
            && (-0.5..=height as f64 - 0.5).contains(&p.y);
        if !inside {
            let (mark, x, y) = (mark.to_owned(), p.x, p.y);
            return Err(CaptureError::Outside { mark, side, x, y, width, height });
        }
    }
    Ok(())
}

fn check_extra(number: usize, extra: &ExtraPhoto) -> Result<(), CaptureError> {
    check_photo(PhotoRole::Extra(number), &extra.photo)?;
    let fail = |fault: String| Err(CaptureError::ExtraCamera { number, fault });
    if !extra.camera.is_plausible() {
        return fail(format!(
            "its focal lengths are {} and {}; they must be above 0, and all numbers of K and D finite",
            extra.camera.fx, extra.camera.fy
        ));
    }
    if let Some(fault) = rotation_fault(&extra.camera_from_left.rotation) {
        return fail(format!("R is not a rotation: {fault}"));
    }
    let t = extra.camera_from_left.translation;
    if !t.iter().all(|v| v.is_finite()) {
        return fail(format!("T is ({}, {}, {}); it must be finite", t.x, t.y, t.z));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{Pinhole, StereoRig};
    use crate::data::{Gray, Rgb, Seeds};
    use crate::math::{Mat3, Similarity, Vec2, Vec3};

    fn photo(width: usize, height: usize) -> Photo {
        Photo::from_rgb(Rgb::filled(width, height, [9; 3]))
    }

    fn pair(x: f64, y: f64) -> Pair {
        Pair { left: Vec2::new(x, y), right: Vec2::new(x - 1.0, y) }
    }

    fn capture() -> Capture {
        Capture {
            left: photo(40, 30),
            right: photo(40, 30),
            plain: Some([photo(40, 30), photo(40, 30)]),
            extra: vec![ExtraPhoto {
                photo: photo(7, 8),
                camera: Pinhole::ideal(700.0, Vec2::new(3.0, 3.5)),
                camera_from_left: Similarity::rigid(Mat3::identity(), Vec3::x()),
            }],
            pattern: Pattern {
                kind: PatternKind::Dots,
                columns: 85,
                rows: 64,
                rotation: 360.0_f64.to_radians(),
            },
            rig: Some(StereoRig::parallel(150.0, 900.0, Vec2::zeros(), Vec2::zeros())),
            seeds: Some(Seeds {
                head: pair(0.5, -0.5),
                left_ear: pair(39.5, 29.5),
                right_ear: pair(4.0, 4.0),
            }),
            landmarks: [("chin".to_owned(), pair(20.0, 9.0))].into(),
        }
    }

    #[test]
    fn a_capture_with_marks_up_to_the_border_is_valid() {
        assert_eq!(capture().validate(), Ok(()));
        let mut stripes = capture();
        stripes.pattern =
            Pattern { kind: PatternKind::Stripes, columns: 0, rows: 0, rotation: 0.0 };
        assert_eq!(stripes.validate(), Ok(()));
    }

    #[test]
    fn each_fault_is_named_with_what_was_found_and_expected() {
        type Change = fn(&mut Capture);
        let cases: [(Change, &[&str]); 16] = [
            (|c| c.left = photo(0, 30), &["left photo", "0x30"]),
            (|c| c.right = photo(40, 29), &["right photo", "40x29", "40x30"]),
            (|c| c.plain = Some([photo(40, 30), photo(4, 3)]), &["right plain", "4x3", "40x30"]),
            (|c| c.left.gray = Gray::filled(4, 4, 0.0), &["left photo", "4x4", "40x30"]),
            (|c| c.pattern.columns = 1, &["1 columns", "2 to 10000"]),
            (|c| c.pattern.rows = 10_001, &["10001 rows"]),
            (|c| c.pattern.rotation = 7.0, &["401.1", "360"]),
            (|c| c.pattern.rotation = f64::NAN, &["NaN"]),
            (
                |c| c.seeds.as_mut().unwrap().head = pair(40.0, 1.0),
                &["seeds.head", "(40, 1)", "left"],
            ),
            (
                |c| c.seeds.as_mut().unwrap().left_ear = pair(0.0, 1.0),
                &["left_ear", "(-1, 1)", "right"],
            ),
            (
                |c| _ = c.landmarks.insert("chin".into(), pair(1.0, f64::NAN)),
                &["landmarks.chin", "NaN", "40x30"],
            ),
            (
                |c| _ = c.landmarks.insert("nose_tp".into(), pair(1.0, 1.0)),
                &["nose_tp", "did you mean nose_tip"],
            ),
            (|c| c.extra[0].camera.fx = 0.0, &["extra photo 1", "focal lengths are 0 and 700"]),
            (
                |c| c.extra[0].camera_from_left.rotation *= 2.0,
                &["extra photo 1", "rotation", "3.00e0"],
            ),
            (
                |c| c.extra[0].camera_from_left.translation.y = f64::INFINITY,
                &["extra photo 1", "inf"],
            ),
            (|c| c.rig.as_mut().unwrap().image_size = Some((768, 576)), &["768x576", "40x30"]),
        ];
        for (change, words) in cases {
            let mut capture = capture();
            change(&mut capture);
            let error = capture.validate().unwrap_err().to_string();
            assert!(words.iter().all(|w| error.contains(w)), "{words:?}: {error}");
        }
    }
}
