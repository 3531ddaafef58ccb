//! Captures and rigs, from files and from arrays.

use std::collections::BTreeMap;
use std::path::PathBuf;

use facerecon_core::Error;
use facerecon_core::camera::{Distortion, Pinhole, StereoRig};
use facerecon_core::data::{Capture as CoreCapture, ExtraPhoto, Pair, Pattern, PatternKind, Seeds};
use facerecon_core::io;
use facerecon_core::math::{Mat3, Similarity, Vec2, Vec3};
use numpy::PyArray3;
use pyo3::prelude::*;

use crate::convert::{PhotoIn, photo, rgb_out};
use crate::errors::{argument, to_py};

type Matrix = [[f64; 3]; 3];
/// `(K1, D1, K2, D2, R, T, image size)`.
pub(crate) type RigParts =
    (Matrix, Vec<f64>, Matrix, Vec<f64>, Matrix, [f64; 3], Option<(usize, usize)>);
/// `(photo, K, D, R, T)`.
type ExtraIn<'py> = (PhotoIn<'py>, Matrix, Vec<f64>, Matrix, [f64; 3]);
/// `(kind, columns, rows, rotation in degrees)`.
type PatternParts = (String, usize, usize, f64);
/// `xl, yl, xr, yr` by name.
type Marks = BTreeMap<String, [f64; 4]>;

/// A capture.
#[pyclass(frozen, module = "facerecon._core")]
pub(crate) struct Capture {
    pub(crate) capture: CoreCapture,
    #[pyo3(get)]
    pub(crate) warnings: Vec<String>,
}

#[pymethods]
impl Capture {
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let loaded = py.detach(|| io::read_capture(&path)).map_err(|e| to_py(py, e))?;
        Ok(Self { capture: loaded.capture, warnings: loaded.warnings })
    }

    #[new]
    #[pyo3(signature = (left, right, plain, extra, pattern, rig, seeds, landmarks))]
    fn new(
        py: Python<'_>,
        left: PhotoIn<'_>,
        right: PhotoIn<'_>,
        plain: Option<(PhotoIn<'_>, PhotoIn<'_>)>,
        extra: Vec<ExtraIn<'_>>,
        pattern: PatternParts,
        rig: Option<RigParts>,
        seeds: Option<Marks>,
        landmarks: Marks,
    ) -> PyResult<Self> {
        let left = photo(&left)?;
        let rig = rig.map(|parts| stereo_rig(&parts));
        let seed = |name: &str| {
            let found = seeds.as_ref().and_then(|s| s.get(name)).map(pair);
            found.ok_or_else(|| argument(py, &format!("seeds: {name} is missing")))
        };
        let seeds = match &seeds {
            Some(_) => Some(Seeds {
                head: seed("head")?,
                left_ear: seed("left_ear")?,
                right_ear: seed("right_ear")?,
            }),
            None => None,
        };
        let extra = extra.iter().map(|(image, k, d, r, t)| {
            Ok(ExtraPhoto {
                photo: photo(image)?,
                camera: pinhole(k, d),
                camera_from_left: Similarity::rigid(matrix(r), Vec3::from(*t)),
            })
        });
        let capture = CoreCapture {
            left,
            right: photo(&right)?,
            plain: match &plain {
                Some((l, r)) => Some([photo(l)?, photo(r)?]),
                None => None,
            },
            extra: extra.collect::<PyResult<_>>()?,
            pattern: Pattern {
                kind: PatternKind::from_name(&pattern.0)
                    .map_err(|e| argument(py, &format!("kind: {e}")))?,
                columns: pattern.1,
                rows: pattern.2,
                rotation: pattern.3.to_radians(),
            },
            rig,
            seeds,
            landmarks: landmarks.iter().map(|(name, mark)| (name.clone(), pair(mark))).collect(),
        };
        valid(py, capture, Vec::new())
    }

    /// The same capture with these landmarks marked, in place of its own.
    fn with_landmarks(&self, py: Python<'_>, landmarks: Marks) -> PyResult<Self> {
        let marked = landmarks.iter().map(|(name, mark)| (name.clone(), pair(mark))).collect();
        let capture = CoreCapture { landmarks: marked, ..self.capture.clone() };
        valid(py, capture, self.warnings.clone())
    }

    /// Writes a capture folder; returns the path of its `capture.toml`.
    fn write(&self, py: Python<'_>, folder: PathBuf) -> PyResult<PathBuf> {
        py.detach(|| io::write_capture(&folder, &self.capture)).map_err(|e| to_py(py, e))
    }

    /// A photo by name, `(height, width, 3)`.
    fn photo<'py>(
        &self,
        py: Python<'py>,
        name: &str,
    ) -> PyResult<Option<Bound<'py, PyArray3<u8>>>> {
        let plain = self.capture.plain.as_ref();
        let photo = match name {
            "left" => Some(&self.capture.left),
            "right" => Some(&self.capture.right),
            "left_plain" => plain.map(|p| &p[0]),
            _ => plain.map(|p| &p[1]),
        };
        photo.map(|p| rgb_out(py, p.rgb.clone())).transpose()
    }

    #[getter]
    fn pattern(&self) -> PatternParts {
        let pattern = self.capture.pattern;
        (pattern.kind.to_string(), pattern.columns, pattern.rows, pattern.rotation.to_degrees())
    }

    /// The three seeds by name.
    #[getter]
    fn seeds(&self) -> Option<BTreeMap<&'static str, [f64; 4]>> {
        self.capture.seeds.as_ref().map(|s| {
            [("head", s.head), ("left_ear", s.left_ear), ("right_ear", s.right_ear)]
                .map(|(name, mark)| (name, flat(&mark)))
                .into()
        })
    }

    /// The marked landmarks by name.
    #[getter]
    fn landmarks(&self) -> Marks {
        self.capture.landmarks.iter().map(|(name, mark)| (name.clone(), flat(mark))).collect()
    }

    #[getter]
    fn rig(&self) -> Option<RigParts> {
        self.capture.rig.as_ref().map(rig_parts)
    }
}

/// A capture of arrays, which must be valid.
fn valid(py: Python<'_>, capture: CoreCapture, warnings: Vec<String>) -> PyResult<Capture> {
    capture.validate().map_err(|e| argument(py, &e.to_string()))?;
    Ok(Capture { capture, warnings })
}

/// Reads a stereo calibration file; `(rig, warnings)`.
#[pyfunction]
fn read_rig(py: Python<'_>, path: PathBuf) -> PyResult<(RigParts, Vec<String>)> {
    let found = io::read_calibration(&path).map_err(|e| to_py(py, e))?;
    Ok((rig_parts(&found.rig), found.warnings))
}

/// Writes a stereo calibration file (OpenCV's YAML).
#[pyfunction]
fn write_rig(py: Python<'_>, path: PathBuf, rig: RigParts) -> PyResult<()> {
    io::write_calibration(&path, &stereo_rig(&rig)).map_err(|e| to_py(py, e))
}

/// Reads a photo; `(height, width, 3)`, 8 bit sRGB.
#[pyfunction]
fn read_photo(py: Python<'_>, path: PathBuf) -> PyResult<Bound<'_, PyArray3<u8>>> {
    let photo = py.detach(|| io::read_photo(&path)).map_err(|e| to_py(py, e))?;
    rgb_out(py, photo.rgb)
}

/// Encodes an image as PNG.
#[pyfunction]
fn encode_png<'py>(
    py: Python<'py>,
    image: numpy::PyReadonlyArray3<'py, u8>,
) -> PyResult<Bound<'py, pyo3::types::PyBytes>> {
    let image = crate::convert::rgb(&image)?;
    let png = io::encode_png(&image).map_err(|e| to_py(py, Error::Input(e.to_string())))?;
    Ok(pyo3::types::PyBytes::new(py, &png))
}

fn pair(mark: &[f64; 4]) -> Pair {
    Pair { left: Vec2::new(mark[0], mark[1]), right: Vec2::new(mark[2], mark[3]) }
}

fn flat(mark: &Pair) -> [f64; 4] {
    [mark.left.x, mark.left.y, mark.right.x, mark.right.y]
}

fn matrix(rows: &Matrix) -> Mat3 {
    Mat3::from_fn(|i, j| rows[i][j])
}

fn matrix_rows(m: &Mat3) -> Matrix {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| m[(i, j)]))
}

fn pinhole(k: &Matrix, d: &[f64]) -> Pinhole {
    let mut lens = [0.0; 8];
    lens.iter_mut().zip(d).for_each(|(to, from)| *to = *from);
    Pinhole { fx: k[0][0], fy: k[1][1], cx: k[0][2], cy: k[1][2], distortion: Distortion(lens) }
}

/// A rig from its matrices.
pub(crate) fn stereo_rig((k1, d1, k2, d2, r, t, size): &RigParts) -> StereoRig {
    StereoRig {
        left: pinhole(k1, d1),
        right: pinhole(k2, d2),
        right_from_left: Similarity::rigid(matrix(r), Vec3::from(*t)),
        image_size: *size,
    }
}

/// The matrices of a rig.
pub(crate) fn rig_parts(rig: &StereoRig) -> RigParts {
    let t = rig.right_from_left.translation;
    (
        matrix_rows(&rig.left.matrix()),
        rig.left.distortion.0.to_vec(),
        matrix_rows(&rig.right.matrix()),
        rig.right.distortion.0.to_vec(),
        matrix_rows(&rig.right_from_left.rotation),
        [t.x, t.y, t.z],
        rig.image_size,
    )
}

pub(crate) fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Capture>()?;
    module.add_function(wrap_pyfunction!(read_rig, module)?)?;
    module.add_function(wrap_pyfunction!(write_rig, module)?)?;
    module.add_function(wrap_pyfunction!(read_photo, module)?)?;
    module.add_function(wrap_pyfunction!(encode_png, module)?)
}
