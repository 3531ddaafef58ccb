//! Captures: a folder with `capture.toml` and the photos it names, in and out.

mod check;
mod text;
mod write;

use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::calibration::{check_baseline, distortion, read_calibration, rotation};
use super::source::{decode_text, line_of, read_bytes};
use super::{Fault, IoError, read_photo};
use crate::camera::StereoRig;
use crate::data::{Capture, ExtraPhoto, LandmarkPairs, Pattern, PatternKind, Photo, Seeds};
use crate::math::{Similarity, Vec2, Vec3};
pub(crate) use check::unknown_landmark;
pub use text::new_capture_toml;
use text::{CaptureText, ExtraText, RigText};
pub use write::write_capture;

const MAX_FILE_MB: u64 = 1;
const FILE_NAME: &str = "capture.toml";

/// Files and figures given on the command line; they replace what the capture file says, and may
/// lie anywhere.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CaptureFiles {
    /// Left photo with the pattern.
    pub left: Option<PathBuf>,
    /// Right photo with the pattern.
    pub right: Option<PathBuf>,
    /// Left photo without the pattern.
    pub left_plain: Option<PathBuf>,
    /// Right photo without the pattern.
    pub right_plain: Option<PathBuf>,
    /// Stereo calibration.
    pub calibration: Option<PathBuf>,
    /// Columns of the pattern.
    pub columns: Option<usize>,
    /// Rows of the pattern.
    pub rows: Option<usize>,
    /// Rotation of the pattern's lattice, degrees.
    pub rotation_deg: Option<f64>,
    /// Kind of the pattern.
    pub kind: Option<PatternKind>,
}

/// A capture and where it came from.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadedCapture {
    /// The capture.
    pub capture: Capture,
    /// What the user should know: names that are not known, an odd baseline.
    pub warnings: Vec<String>,
    /// Every file that was read, the capture file first.
    pub sources: Vec<PathBuf>,
}

/// Reads a capture folder, or its `capture.toml`.
///
/// # Errors
/// [`IoError`] with the file, what was found and what to do.
pub fn read_capture(path: &Path) -> Result<LoadedCapture, IoError> {
    read_capture_with(Some(path), &CaptureFiles::default())
}

/// Reads a capture with some of it given on the command line, or all of it (`path` is `None`).
///
/// # Errors
/// As [`read_capture`].
pub fn read_capture_with(
    path: Option<&Path>,
    given: &CaptureFiles,
) -> Result<LoadedCapture, IoError> {
    let (file, text, warnings) = match path {
        Some(path) => {
            let file = if path.is_dir() { path.join(FILE_NAME) } else { path.to_owned() };
            if path.is_dir() && !file.exists() {
                let message = format!(
                    "the folder holds no {FILE_NAME}; `facerecon new {}` writes one to fill in",
                    path.display()
                );
                return Err(IoError::malformed(path, message));
            }
            let bytes = read_bytes(&file, "capture file", MAX_FILE_MB)?;
            let (text, warnings) =
                text::parse(&decode_text(&bytes)).map_err(|e| e.in_file(&file))?;
            (Some(file), text, warnings)
        }
        None => (None, CaptureText::default(), Vec::new()),
    };
    let sources = file.iter().cloned().collect();
    Reader { file, given, warnings, sources }.read(text)
}

/// Parses the text of a capture file without reading the files it names; the warnings tell of
/// unknown names.
///
/// # Errors
/// [`Fault`] with the line.
pub fn check_capture_text(bytes: &[u8]) -> Result<Vec<String>, Fault> {
    text::parse(&decode_text(bytes)).map(|(_, warnings)| warnings)
}

/// A photo and its file.
type Sourced = (Photo, PathBuf);

struct Reader<'a> {
    file: Option<PathBuf>,
    given: &'a CaptureFiles,
    warnings: Vec<String>,
    sources: Vec<PathBuf>,
}

impl Reader<'_> {
    fn read(mut self, text: CaptureText) -> Result<LoadedCapture, IoError> {
        let images = text.images.unwrap_or_default();
        let given = self.given;
        let [left, right, left_plain, right_plain] = self.photos([
            (&given.left, images.left),
            (&given.right, images.right),
            (&given.left_plain, images.left_plain),
            (&given.right_plain, images.right_plain),
        ]);
        let (left, left_path) = self.required(left?, "left")?;
        let (right, right_path) = self.required(right?, "right")?;
        same_size(&left, &left_path, &right, &right_path)?;
        let plain = [self.used(left_plain?), self.used(right_plain?)];
        let plain = match plain {
            [Some((l, l_path)), Some((r, r_path))] => {
                same_size(&left, &left_path, &l, &l_path)?;
                same_size(&left, &left_path, &r, &r_path)?;
                Some([l, r])
            }
            [None, None] => None,
            [l, _] => {
                let (has, lacks) = if l.is_some() { ("left", "right") } else { ("right", "left") };
                return Err(self.fault(format!(
                    "{has}_plain is given but {lacks}_plain is not; give both or neither"
                )));
            }
        };
        let rig = self.rig(text.rig, left.size())?;
        let extra = images
            .extra
            .into_iter()
            .enumerate()
            .map(|(i, e)| self.extra(i, e))
            .collect::<Result<_, _>>()?;
        let pattern =
            check::pattern(text.pattern.unwrap_or_default(), given).map_err(|m| self.fault(m))?;
        let seeds = check::seeds(text.seeds, left.size()).map_err(|m| self.fault(m))?;
        let landmarks = check::landmarks(text.landmarks, left.size()).map_err(|m| self.fault(m))?;
        let capture = Capture { left, right, plain, extra, pattern, rig, seeds, landmarks };
        Ok(LoadedCapture { capture, warnings: self.warnings, sources: self.sources })
    }

    /// An error about the capture file, or about the command line.
    fn fault(&self, message: impl Into<String>) -> IoError {
        let path = self.file.clone().unwrap_or_else(|| PathBuf::from("command line"));
        IoError::malformed(&path, message)
    }

    /// Reads photos, given on the command line or named in the file, all at once.
    fn photos<const N: usize>(
        &self,
        places: [(&Option<PathBuf>, Option<PathBuf>); N],
    ) -> [Result<Option<Sourced>, IoError>; N] {
        let mut read = places.map(|(given, named)| {
            let path = match (given, named) {
                (Some(path), _) => path.clone(),
                (None, Some(path)) => self.inside(&path)?,
                (None, None) => return Ok(None),
            };
            Ok(Some((path, None)))
        });
        read.par_iter_mut().for_each(|slot| {
            if let Ok(Some((path, photo))) = slot {
                *photo = Some(read_photo(path));
            }
        });
        read.map(|slot| match slot? {
            Some((path, Some(photo))) => Ok(Some((photo?, path))),
            _ => Ok(None),
        })
    }

    fn required(&mut self, photo: Option<Sourced>, side: &str) -> Result<Sourced, IoError> {
        self.used(photo).ok_or_else(|| {
            self.fault(format!(
                "the {side} photo with the pattern is missing; write {side} = \"FILE\" under \
                 [images], or give --{side} FILE"
            ))
        })
    }

    /// Notes where a photo came from.
    fn used(&mut self, photo: Option<Sourced>) -> Option<Sourced> {
        self.sources.extend(photo.iter().map(|(_, path)| path.clone()));
        photo
    }

    /// The place of a path that the capture file names, which must lie in its folder, links
    /// followed.
    fn inside(&self, named: &Path) -> Result<PathBuf, IoError> {
        let file = self.file.clone().unwrap_or_default();
        let folder = match file.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        let outside = || IoError::Outside { file: file.clone(), path: named.to_owned() };
        let joined = folder.join(named);
        let climbs = named.components().any(|c| matches!(c, std::path::Component::ParentDir));
        let read = |source| IoError::Read { path: joined.clone(), source };
        match joined.canonicalize() {
            Ok(real) => {
                let root = folder.canonicalize().map_err(read)?;
                if real.starts_with(root) { Ok(joined) } else { Err(outside()) }
            }
            // What is not there is only said of places inside the folder.
            Err(_) if climbs || named.is_absolute() => Err(outside()),
            Err(source) => Err(read(source)),
        }
    }

    fn rig(
        &mut self,
        text: Option<RigText>,
        photo_size: (usize, usize),
    ) -> Result<Option<StereoRig>, IoError> {
        let text = text.unwrap_or_default();
        let path = match (self.given.calibration.clone(), &text.calibration) {
            (Some(path), _) => Some(path),
            (None, Some(named)) => Some(self.inside(named)?),
            (None, None) => None,
        };
        let (rig, path) = match path {
            Some(path) => {
                let found = read_calibration(&path)?;
                self.warnings
                    .extend(found.warnings.iter().map(|w| format!("{}: {w}", path.display())));
                self.sources.push(path.clone());
                (found.rig, path)
            }
            None => match self.parallel_rig(&text, photo_size)? {
                Some(rig) => (rig, self.file.clone().unwrap_or_default()),
                None => return Ok(None),
            },
        };
        rig.validate(photo_size).map_err(|source| IoError::Rig { path, source })?;
        Ok(Some(rig))
    }

    fn parallel_rig(
        &mut self,
        text: &RigText,
        (width, height): (usize, usize),
    ) -> Result<Option<StereoRig>, IoError> {
        let (baseline, focal) = match (text.baseline_mm, text.focal_px) {
            (Some(baseline), Some(focal)) => (baseline, focal),
            (None, None) => return Ok(None),
            (Some(_), None) => return Err(self.fault("[rig] has baseline_mm but no focal_px")),
            (None, Some(_)) => return Err(self.fault("[rig] has focal_px but no baseline_mm")),
        };
        check_baseline(baseline, "baseline_mm", &mut self.warnings)
            .map_err(|e| self.fault(e.message))?;
        if baseline <= 0.0 {
            return Err(self.fault(format!("[rig] baseline_mm is {baseline}; it must be above 0")));
        }
        let centre = [(width as f64 - 1.0) / 2.0, (height as f64 - 1.0) / 2.0];
        let mut principal = |given: Option<[f64; 2]>, name: &str| {
            let [x, y] = given.unwrap_or_else(|| {
                self.warnings
                    .push(format!("[rig] has no {name}; the middle of the photo is taken"));
                centre
            });
            Vec2::new(x, y)
        };
        let left = principal(text.principal_left, "principal_left");
        let right = principal(text.principal_right, "principal_right");
        Ok(Some(StereoRig::parallel(baseline, focal, left, right)))
    }

    fn extra(&mut self, index: usize, text: ExtraText) -> Result<ExtraPhoto, IoError> {
        let named = |e: Fault| {
            IoError::malformed(
                self.file.as_deref().unwrap_or(Path::new("")),
                format!("[[images.extra]] number {}: {}", index + 1, e.message),
            )
        };
        let mut odd = Vec::new();
        let mut camera =
            super::calibration::camera(text.k.as_flattened(), &[], &mut odd).map_err(named)?;
        camera.distortion = distortion(&text.d).map_err(named)?;
        let r = rotation(text.r.as_flattened()).map_err(named)?;
        let deviation = (r * r.transpose() - crate::math::Mat3::identity()).amax();
        let t = Vec3::from(text.t);
        let finite = camera.is_plausible() && t.iter().all(|v| v.is_finite());
        if !(finite && deviation < 1e-4 && r.determinant() > 0.0) {
            return Err(named(Fault::new(
                "K D R T are no camera: K needs focal lengths above 0, R must be a rotation",
            )));
        }
        let path = self.inside(&text.image)?;
        let photo = read_photo(&path)?;
        self.sources.push(path);
        self.warnings.extend(odd);
        Ok(ExtraPhoto { photo, camera, camera_from_left: Similarity::rigid(r, t) })
    }
}

fn same_size(
    first: &Photo,
    first_path: &Path,
    second: &Photo,
    second_path: &Path,
) -> Result<(), IoError> {
    if first.size() == second.size() {
        return Ok(());
    }
    Err(IoError::PhotoSizes {
        first: first_path.to_owned(),
        first_size: first.size(),
        second: second_path.to_owned(),
        second_size: second.size(),
    })
}

#[cfg(test)]
mod tests;
