//! Single stages on arrays.

use facerecon_core::Error;
use facerecon_core::data::{Cloud, CloudFrame, Gray, MARKED_LANDMARK_SIGMA_MM};
use facerecon_core::math::Vec3;
use facerecon_core::observer::Observer;
use facerecon_core::output::registration_json;
use facerecon_core::single_stage;
use facerecon_core::spatial::eliminate_multiple;
use facerecon_core::stages::deform::{DeformInput, LandmarkTarget, deform as run_deform};
use facerecon_core::stages::detect::{DetectMethod, DetectParams, detect as run_detect};
use facerecon_core::stages::filter::filter as run_filter;
use facerecon_core::stages::rectify::rectify as run_rectify;
use facerecon_core::stages::register::{RegisterInput, register as run_register};
use facerecon_core::stages::smooth::smooth as run_smooth;
use facerecon_core::template;
use numpy::{PyArray1, PyArray2, PyArray3, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::capture::Capture;
use crate::convert::{
    CloudOut, MeshIn, MeshOut, array, cloud_out, gray, mesh, mesh_out, pixels, pixels_out, points,
    raster_out, rgb_out, transform_out,
};
use crate::meshes::Template;
use crate::params::Params;
use crate::reconstruction::to_json;
use crate::watch::{staged, watched, with_warnings};

type GrayIn<'py> = PyReadonlyArray2<'py, f32>;
type GrayOut<'py> = Bound<'py, PyArray2<f32>>;
/// A filtered photo: `(equalized, sharpened, binary)`.
type FilteredOut<'py> = (Option<GrayOut<'py>>, GrayOut<'py>, GrayOut<'py>);
/// Landmarks, row by row: `(measured, on the model)`.
type LandmarksIn<'py> = (PyReadonlyArray2<'py, f64>, PyReadonlyArray2<'py, f64>);
/// `(model_from_data, facts as JSON, indices of the inliers)`.
type PoseOut<'py> = (Bound<'py, PyArray2<f64>>, String, Vec<usize>);
/// `(texture, coverage)`.
type TextureOut<'py> = (Bound<'py, PyArray3<u8>>, Bound<'py, PyArray2<u8>>);
/// `(mesh, steps, mean movement in each step, enlargement per axis)`.
type SmoothedOut<'py> = (MeshOut<'py>, usize, Vec<f64>, [f64; 3]);
/// Vertices and their target positions.
type TargetsIn<'py> = (Vec<usize>, PyReadonlyArray2<'py, f64>);
/// `(positions, sigmas, amplitudes, scores, spacing, thinned image)`.
type DotsOut<'py> = (
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
    f64,
    Option<GrayOut<'py>>,
);

/// Filters a photo; `(equalized, sharpened, binary)`.
#[pyfunction]
fn filter<'py>(py: Python<'py>, image: GrayIn<'py>, params: &Params) -> PyResult<FilteredOut<'py>> {
    let (image, params) = (gray(&image)?, &params.0.filter);
    let done = watched(py, None, |watch| Ok(run_filter(&image, params, watch)?))?;
    let equalized = done.equalized.map(|e| raster_out(py, e)).transpose()?;
    Ok((equalized, raster_out(py, done.sharpened)?, raster_out(py, done.binary)?))
}

/// Convolution with the kernel `filter.kernel` (by default Eq. 2.1), clipped to 0..255.
#[pyfunction]
fn sharpen<'py>(py: Python<'py>, image: GrayIn<'py>, params: &Params) -> PyResult<GrayOut<'py>> {
    let (image, kernel) = (gray(&image)?, &params.0.filter.kernel);
    let work = || facerecon_core::stages::filter::sharpen(&image, kernel);
    raster_out(py, py.detach(work).map_err(|e| crate::errors::to_py(py, e))?)
}

/// A binary image, 0 or 255.
#[pyfunction]
fn threshold<'py>(py: Python<'py>, image: GrayIn<'py>, params: &Params) -> PyResult<GrayOut<'py>> {
    let image = gray(&image)?;
    let done: Gray =
        py.detach(|| facerecon_core::stages::filter::threshold(&image, &params.0.filter));
    raster_out(py, done)
}

/// Detects the dots of a photo; with `binary`, thins a black and white image.
#[pyfunction]
fn detect<'py>(
    py: Python<'py>,
    image: GrayIn<'py>,
    binary: bool,
    params: &Params,
) -> PyResult<DotsOut<'py>> {
    let (image, params) = (gray(&image)?, &params.0);
    let found = watched(py, None, |watch| {
        if binary {
            let thin = DetectParams { method: DetectMethod::Thin, ..params.detect.clone() };
            Ok(run_detect(&image, &thin, watch)?)
        } else {
            single_stage::detect_dots(&image, params, watch)
        }
    })?;
    let column = |f: fn(&facerecon_core::data::Dot) -> f64| {
        PyArray1::from_vec(py, found.dots.iter().map(f).collect())
    };
    Ok((
        pixels_out(py, found.dots.iter().map(|d| d.position))?,
        column(|d| d.sigma_px),
        column(|d| d.amplitude),
        column(|d| d.score),
        found.spacing_px,
        found.thinned.map(|t| raster_out(py, t)).transpose()?,
    ))
}

/// Rectifies both pairs; the fields of `facerecon.Rectified` as a dictionary.
#[pyfunction]
fn rectify<'py>(
    py: Python<'py>,
    capture: &Capture,
    params: &Params,
) -> PyResult<Bound<'py, PyDict>> {
    let (photos, params) = (&capture.capture, &params.0.rectify);
    let (done, warnings) =
        with_warnings(py, None, |watch| Ok(run_rectify(photos, params, watch)?))?;
    let out = PyDict::new(py);
    out.set_item("left", raster_out(py, done.left)?)?;
    out.set_item("right", raster_out(py, done.right)?)?;
    let plain = match done.plain {
        Some([left, right]) => Some((raster_out(py, left)?, raster_out(py, right)?)),
        None => None,
    };
    out.set_item("plain", plain)?;
    out.set_item("offset_px", done.rows.offset_px)?;
    out.set_item("roll_deg", done.rows.roll_deg)?;
    out.set_item("scale", done.rows.scale)?;
    out.set_item("residual_px", done.rows.residual_px)?;
    out.set_item("corrected", done.rows.corrected)?;
    out.set_item("warnings", warnings)?;
    Ok(out)
}

/// Triangulates pairs of pixels of the original photos; `(cloud, metric)`.
#[pyfunction]
fn triangulate<'py>(
    py: Python<'py>,
    capture: &Capture,
    left: PyReadonlyArray2<'py, f64>,
    right: PyReadonlyArray2<'py, f64>,
    params: &Params,
) -> PyResult<(CloudOut<'py>, bool)> {
    let pairs: Vec<_> = pixels(&left, "left")?.into_iter().zip(pixels(&right, "right")?).collect();
    let (photos, params) = (&capture.capture, &params.0);
    let done = watched(py, None, |watch| {
        single_stage::triangulate_photo_pairs(photos, &pairs, &template::built_in(), params, watch)
    })?;
    Ok((cloud_out(py, done.cloud)?, done.frame.is_metric()))
}

/// Registers points with a model; `(model_from_data, facts as JSON, indices of the inliers)`.
#[pyfunction]
fn register<'py>(
    py: Python<'py>,
    data: PyReadonlyArray2<'py, f64>,
    model: &Template,
    metric: bool,
    landmarks: Option<LandmarksIn<'py>>,
    params: &Params,
    callback: Option<Py<PyAny>>,
) -> PyResult<PoseOut<'py>> {
    let data = Cloud::from_points(points(&data, "data")?);
    let landmarks: Vec<(Vec3, Vec3)> = match &landmarks {
        Some((measured, on_model)) => {
            let on_model = points(on_model, "landmarks")?;
            points(measured, "landmarks")?.into_iter().zip(on_model).collect()
        }
        None => Vec::new(),
    };
    let (head, params) = (&model.template, &params.0.register);
    let pose = staged(py, callback, "register", |watch| {
        let input = RegisterInput {
            data: &data,
            model: &head.mesh,
            coarse: head.coarse.as_ref(),
            chin_y: head.chin_y(),
            landmarks: &landmarks,
            frame: if metric { CloudFrame::Metric } else { CloudFrame::Model },
        };
        Ok(run_register(&input, params, watch)?)
    })?;
    let mut facts = registration_json(&pose);
    facts.insert("scale".to_owned(), pose.model_from_data.scale.into());
    Ok((transform_out(py, &pose.model_from_data)?, to_json(py, &facts)?, pose.inliers))
}

/// Vertices with their target positions.
fn targets((vertices, at): &TargetsIn<'_>, what: &str) -> PyResult<Vec<(usize, Vec3)>> {
    Ok(vertices.iter().copied().zip(points(at, what)?).collect())
}

/// Deforms a head to points; `(mesh, rms before, rms after, number of centres)`.
#[pyfunction]
fn deform<'py>(
    py: Python<'py>,
    head: MeshIn<'py>,
    data: PyReadonlyArray2<'py, f64>,
    assignments: Option<TargetsIn<'py>>,
    landmarks: Option<TargetsIn<'py>>,
    params: &Params,
    callback: Option<Py<PyAny>>,
) -> PyResult<(MeshOut<'py>, f64, f64, usize)> {
    let head = mesh(&head)?;
    let data = Cloud::from_points(points(&data, "data")?);
    let given = assignments.map(|given| targets(&given, "assignments")).transpose()?;
    let landmarks: Vec<LandmarkTarget> = landmarks
        .map(|given| targets(&given, "landmarks"))
        .transpose()?
        .unwrap_or_default()
        .into_iter()
        .map(|(vertex, position)| LandmarkTarget {
            vertex,
            position,
            sigma_mm: MARKED_LANDMARK_SIGMA_MM,
        })
        .collect();
    let params = &params.0.deform;
    let deformed = staged(py, callback, "deform", |watch| {
        let assignments =
            given.unwrap_or_else(|| eliminate_multiple(&data.points, &head.vertices, None));
        let input = DeformInput {
            template: &head,
            data: &data,
            assignments: &assignments,
            landmarks: &landmarks,
            outlines: &[],
        };
        Ok(run_deform(&input, params, watch)?)
    })?;
    let (before, after) = (deformed.rms_before, deformed.rms_after);
    Ok((mesh_out(py, deformed.mesh)?, before, after, deformed.centres))
}

/// Meshes the measured surface of a capture; `(mesh, metric)`.
#[pyfunction]
fn surface<'py>(
    py: Python<'py>,
    capture: &Capture,
    params: &Params,
    callback: Option<Py<PyAny>>,
) -> PyResult<(MeshOut<'py>, bool)> {
    let (photos, params) = (&capture.capture, &params.0);
    let done = watched(py, callback, |watch| {
        single_stage::measure_surface(photos, &template::built_in(), params, watch)
    })?;
    Ok((mesh_out(py, done.mesh)?, done.metric))
}

/// Smooths a mesh; `(mesh, steps, mean movement in each step, enlargement per axis)`.
#[pyfunction]
fn smooth<'py>(
    py: Python<'py>,
    parts: MeshIn<'py>,
    reference: Option<PyReadonlyArray2<'py, f64>>,
    params: &Params,
) -> PyResult<SmoothedOut<'py>> {
    let input = mesh(&parts)?;
    let reference = reference.map(|r| points(&r, "reference")).transpose()?.unwrap_or_default();
    let params = &params.0.smooth;
    let done = watched(py, None, |watch| Ok(run_smooth(&input, &reference, params, watch)?))?;
    let factors = done.enlarged;
    Ok((mesh_out(py, done.mesh)?, done.steps, done.movement, [factors.x, factors.y, factors.z]))
}

/// Textures a mesh in the camera frame; `(texture, coverage)`.
#[pyfunction]
fn texture<'py>(
    py: Python<'py>,
    capture: &Capture,
    parts: MeshIn<'py>,
    params: &Params,
    callback: Option<Py<PyAny>>,
) -> PyResult<TextureOut<'py>> {
    let face = mesh(&parts)?;
    let (photos, params) = (&capture.capture, &params.0);
    let work = |watch: &dyn Observer| single_stage::texture_mesh(photos, &face, params, watch);
    let made = staged(py, callback, "texture", work)?;
    Ok((rgb_out(py, made.image)?, raster_out(py, made.coverage)?))
}

/// The mean of the points whose closest vertex is the same (thesis section 3.2);
/// `(vertices, means)`.
#[pyfunction]
fn assign<'py>(
    py: Python<'py>,
    data: PyReadonlyArray2<'py, f64>,
    vertices: PyReadonlyArray2<'py, f64>,
) -> PyResult<(Vec<usize>, Bound<'py, PyArray2<f64>>)> {
    let (data, vertices) = (points(&data, "data")?, points(&vertices, "vertices")?);
    let work = || -> Result<_, Error> { Ok(eliminate_multiple(&data, &vertices, None)) };
    let found = watched(py, None, |_| work())?;
    let ids = found.iter().map(|f| f.0).collect();
    Ok((ids, array(py, found.iter().map(|f| [f.1.x, f.1.y, f.1.z]).collect())?))
}

pub(crate) fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(filter, module)?)?;
    module.add_function(wrap_pyfunction!(sharpen, module)?)?;
    module.add_function(wrap_pyfunction!(threshold, module)?)?;
    module.add_function(wrap_pyfunction!(detect, module)?)?;
    module.add_function(wrap_pyfunction!(rectify, module)?)?;
    module.add_function(wrap_pyfunction!(triangulate, module)?)?;
    module.add_function(wrap_pyfunction!(register, module)?)?;
    module.add_function(wrap_pyfunction!(deform, module)?)?;
    module.add_function(wrap_pyfunction!(surface, module)?)?;
    module.add_function(wrap_pyfunction!(smooth, module)?)?;
    module.add_function(wrap_pyfunction!(texture, module)?)?;
    module.add_function(wrap_pyfunction!(assign, module)?)
}
