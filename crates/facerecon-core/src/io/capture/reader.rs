//! From the text of a capture file to the capture: photos, rig and marks.

use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::marks;
use super::text::{CaptureText, ExtraText, ImagesText, RigText};
use super::types::{CaptureFiles, LoadedCapture};
use crate::camera::StereoRig;
use crate::data::{Capture, CaptureError, ExtraPhoto, Photo, PhotoRole};
use crate::io::calibration::{camera, check_baseline, distortion, read_calibration, rotation};
use crate::io::error::{Fault, IoError};
use crate::io::image::read_photo;
use crate::math::{Similarity, Vec2, Vec3};

/// A photo and its file.
type Sourced = (Photo, PathBuf);

/// The two pairs and their files.
struct Pairs {
    left: Photo,
    right: Photo,
    plain: Option<[Photo; 2]>,
    /// Files of the left, right, left plain and right plain photo.
    files: Vec<PathBuf>,
}

pub(super) struct Reader<'a> {
    file: Option<PathBuf>,
    given: &'a CaptureFiles,
    warnings: Vec<String>,
    sources: Vec<PathBuf>,
}

impl<'a> Reader<'a> {
    /// A reader of the capture file `file`; `None` when everything is given on the command line.
    pub(super) fn new(
        file: Option<PathBuf>,
        given: &'a CaptureFiles,
        warnings: Vec<String>,
    ) -> Self {
        let sources = file.iter().cloned().collect();
        Self { file, given, warnings, sources }
    }

    pub(super) fn read(mut self, text: CaptureText) -> Result<LoadedCapture, IoError> {
        let mut images = text.images.unwrap_or_default();
        let extra = std::mem::take(&mut images.extra);
        let Pairs { left, right, plain, files } = self.pairs(images)?;
        let rig = self.rig(text.rig.unwrap_or_default(), left.size())?;
        let extra = extra
            .into_iter()
            .enumerate()
            .map(|(i, e)| self.extra(i + 1, e))
            .collect::<Result<_, _>>()?;
        let pattern = marks::pattern(&text.pattern.unwrap_or_default(), self.given)
            .map_err(|m| self.fault(m))?;
        let seeds = marks::seeds(text.seeds).map_err(|m| self.fault(m))?;
        let landmarks = marks::landmarks(text.landmarks);
        let capture = Capture { left, right, plain, extra, pattern, rig, seeds, landmarks };
        capture.validate().map_err(|e| self.invalid(&e, &files))?;
        Ok(LoadedCapture { capture, warnings: self.warnings, sources: self.sources })
    }

    /// An error about the capture file, or about the command line.
    fn fault(&self, message: impl Into<String>) -> IoError {
        let path = self.file.clone().unwrap_or_else(|| PathBuf::from("command line"));
        IoError::malformed(&path, message)
    }

    /// The error for a capture that is not valid; wrong sizes are those of photo files.
    fn invalid(&self, error: &CaptureError, files: &[PathBuf]) -> IoError {
        let CaptureError::PhotoSize { photo, got, expected } = error else {
            return self.fault(error.to_string());
        };
        let second = match photo {
            PhotoRole::Left => 0,
            PhotoRole::Right => 1,
            PhotoRole::LeftPlain => 2,
            PhotoRole::RightPlain | PhotoRole::Extra(_) => 3,
        };
        let path = |i: usize| files.get(i).cloned().unwrap_or_default();
        IoError::PhotoSizes {
            first: path(0),
            first_size: *expected,
            second: path(second),
            second_size: *got,
        }
    }

    fn pairs(&mut self, images: ImagesText) -> Result<Pairs, IoError> {
        let given = self.given;
        let [left, right, left_plain, right_plain] = self.photos([
            (&given.left, images.left),
            (&given.right, images.right),
            (&given.left_plain, images.left_plain),
            (&given.right_plain, images.right_plain),
        ]);
        let (left, left_file) = self.required(left?, "left")?;
        let (right, right_file) = self.required(right?, "right")?;
        let mut files = vec![left_file, right_file];
        let plain = match [self.used(left_plain?), self.used(right_plain?)] {
            [Some((l, l_file)), Some((r, r_file))] => {
                files.extend([l_file, r_file]);
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
        Ok(Pairs { left, right, plain, files })
    }

    /// Reads photos, given on the command line or named in the file, in parallel.
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

    /// Adds the file of a photo to the sources.
    fn used(&mut self, photo: Option<Sourced>) -> Option<Sourced> {
        self.sources.extend(photo.iter().map(|(_, path)| path.clone()));
        photo
    }

    /// The path of a file that the capture file names. It must be inside the capture's folder,
    /// also after symbolic links are resolved.
    fn inside(&self, named: &Path) -> Result<PathBuf, IoError> {
        let file = self.file.clone().unwrap_or_default();
        let folder = match file.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        let outside = || IoError::Outside { file: file.clone(), path: named.to_owned() };
        let joined = folder.join(named);
        let leaves = named.components().any(|c| matches!(c, std::path::Component::ParentDir));
        let read = |source| IoError::Read { path: joined.clone(), source };
        match joined.canonicalize() {
            Ok(real) => {
                let root = folder.canonicalize().map_err(read)?;
                if real.starts_with(root) { Ok(joined) } else { Err(outside()) }
            }
            // Do not reveal whether a file outside the folder exists.
            Err(_) if leaves || named.is_absolute() => Err(outside()),
            Err(source) => Err(read(source)),
        }
    }

    fn rig(
        &mut self,
        text: RigText,
        photo_size: (usize, usize),
    ) -> Result<Option<StereoRig>, IoError> {
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
                self.warnings.push(format!("[rig] has no {name}; the photo's centre is used"));
                centre
            });
            Vec2::new(x, y)
        };
        let left = principal(text.principal_left, "principal_left");
        let right = principal(text.principal_right, "principal_right");
        Ok(Some(StereoRig::parallel(baseline, focal, left, right)))
    }

    fn extra(&mut self, number: usize, text: ExtraText) -> Result<ExtraPhoto, IoError> {
        let named =
            |e: Fault| self.fault(format!("[[images.extra]] number {number}: {}", e.message));
        let mut warnings = Vec::new();
        let mut camera = camera(text.k.as_flattened(), &[], &mut warnings).map_err(named)?;
        camera.distortion = distortion(&text.d).map_err(named)?;
        let r = rotation(text.r.as_flattened()).map_err(named)?;
        let path = self.inside(&text.image)?;
        let photo = read_photo(&path)?;
        self.sources.push(path);
        self.warnings.append(&mut warnings);
        Ok(ExtraPhoto { photo, camera, camera_from_left: Similarity::rigid(r, Vec3::from(text.t)) })
    }
}
