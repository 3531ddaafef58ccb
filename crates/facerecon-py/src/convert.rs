//! Conversion of arrays. The facade passes C-ordered arrays of the right type; shapes are checked
//! here again.

use facerecon_core::data::{Cloud, Gray, Mesh, Photo, Raster, Rgb};
use facerecon_core::math::{Similarity, Vec2, Vec3};
use numpy::{
    Element, PyArray1, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2,
    PyReadonlyArray3, PyUntypedArrayMethods,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// `(vertices, faces, uvs, face_uvs, colors, sigmas, measured)`.
pub(crate) type MeshIn<'py> = (
    PyReadonlyArray2<'py, f64>,
    PyReadonlyArray2<'py, u32>,
    Option<PyReadonlyArray2<'py, f64>>,
    Option<PyReadonlyArray2<'py, u32>>,
    Option<PyReadonlyArray2<'py, u8>>,
    Option<PyReadonlyArray1<'py, f64>>,
    Option<PyReadonlyArray1<'py, bool>>,
);
/// See [`MeshIn`].
pub(crate) type MeshOut<'py> = (
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<u32>>,
    Option<Bound<'py, PyArray2<f64>>>,
    Option<Bound<'py, PyArray2<u32>>>,
    Option<Bound<'py, PyArray2<u8>>>,
    Option<Bound<'py, PyArray1<f64>>>,
    Option<Bound<'py, PyArray1<bool>>>,
);
/// `(points, normals, colors, sigmas)`.
pub(crate) type CloudOut<'py> = (
    Bound<'py, PyArray2<f64>>,
    Option<Bound<'py, PyArray2<f64>>>,
    Option<Bound<'py, PyArray2<u8>>>,
    Option<Bound<'py, PyArray1<f64>>>,
);
/// `(colour, grey)` of a photo; grey where it has more than 8 bits.
pub(crate) type PhotoIn<'py> = (PyReadonlyArray3<'py, u8>, Option<PyReadonlyArray2<'py, f32>>);

fn wrong_shape(what: &str, shape: &[usize], expected: &str) -> PyErr {
    PyValueError::new_err(format!("{what} has shape {shape:?}; expected {expected}"))
}

fn rows<T: Element + Copy, const N: usize>(
    array: &PyReadonlyArray2<'_, T>,
    what: &str,
) -> PyResult<Vec<[T; N]>> {
    let expected = format!("(n, {N}) in C order");
    match array.as_slice() {
        Ok(flat) if array.shape()[1] == N => Ok(flat.as_chunks::<N>().0.to_vec()),
        _ => Err(wrong_shape(what, array.shape(), &expected)),
    }
}

/// `(n, 3)` as points.
pub(crate) fn points(array: &PyReadonlyArray2<'_, f64>, what: &str) -> PyResult<Vec<Vec3>> {
    Ok(rows::<f64, 3>(array, what)?.into_iter().map(Vec3::from).collect())
}

/// `(n, 2)` as pixels.
pub(crate) fn pixels(array: &PyReadonlyArray2<'_, f64>, what: &str) -> PyResult<Vec<Vec2>> {
    Ok(rows::<f64, 2>(array, what)?.into_iter().map(Vec2::from).collect())
}

/// A mesh from its arrays.
pub(crate) fn mesh(parts: &MeshIn<'_>) -> PyResult<Mesh> {
    let (vertices, faces, uvs, face_uvs, colors, sigmas, measured) = parts;
    Ok(Mesh {
        vertices: points(vertices, "vertices")?,
        faces: rows(faces, "faces")?,
        uvs: uvs.as_ref().map(|a| rows(a, "uv")).transpose()?.unwrap_or_default(),
        face_uvs: face_uvs.as_ref().map(|a| rows(a, "uv_faces")).transpose()?.unwrap_or_default(),
        colors: colors.as_ref().map(|a| rows(a, "colors")).transpose()?.unwrap_or_default(),
        sigmas: sigmas.as_ref().map(|a| a.as_array().to_vec()).unwrap_or_default(),
        measured: measured.as_ref().map(|a| a.as_array().to_vec()).unwrap_or_default(),
    })
}

/// `(height, width)` as a grey image.
pub(crate) fn gray(array: &PyReadonlyArray2<'_, f32>) -> PyResult<Gray> {
    let [height, width] = [array.shape()[0], array.shape()[1]];
    let raster = array.as_slice().ok().and_then(|d| Gray::from_vec(width, height, d.to_vec()));
    raster.ok_or_else(|| wrong_shape("the image", array.shape(), "(height, width) in C order"))
}

/// `(height, width, 3)` as a colour image.
pub(crate) fn rgb(array: &PyReadonlyArray3<'_, u8>) -> PyResult<Rgb> {
    let fail = || wrong_shape("the image", array.shape(), "(height, width, 3) in C order");
    let flat = array.as_slice().map_err(|_| fail())?;
    if array.shape()[2] != 3 {
        return Err(fail());
    }
    let data = flat.as_chunks::<3>().0.to_vec();
    Rgb::from_vec(array.shape()[1], array.shape()[0], data).ok_or_else(fail)
}

/// A photo from colour and, where given, grey with more than 8 bits.
pub(crate) fn photo((color, grey): &PhotoIn<'_>) -> PyResult<Photo> {
    let photo = Photo::from_rgb(rgb(color)?);
    match grey {
        Some(grey) => {
            let grey = gray(grey)?;
            if grey.size() != photo.rgb.size() {
                return Err(PyValueError::new_err(
                    "the colour and grey images of a photo have different sizes",
                ));
            }
            Ok(Photo { gray: grey, ..photo })
        }
        None => Ok(photo),
    }
}

/// Rows of `N` as an `(n, N)` array, without a copy.
pub(crate) fn array<'py, T: Element, const N: usize>(
    py: Python<'py>,
    rows: Vec<[T; N]>,
) -> PyResult<Bound<'py, PyArray2<T>>> {
    let count = rows.len();
    PyArray1::from_vec(py, rows.into_flattened()).reshape([count, N])
}

/// Points as `(n, 3)`.
pub(crate) fn points_out<'py>(
    py: Python<'py>,
    points: &[Vec3],
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    array(py, points.iter().map(|p| [p.x, p.y, p.z]).collect())
}

/// Pixels as `(n, 2)`.
pub(crate) fn pixels_out<'py>(
    py: Python<'py>,
    pixels: impl Iterator<Item = Vec2>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    array(py, pixels.map(|p| [p.x, p.y]).collect())
}

/// A mesh as arrays.
pub(crate) fn mesh_out(py: Python<'_>, mesh: Mesh) -> PyResult<MeshOut<'_>> {
    let has_uv = mesh.has_uv();
    let has_colors = !mesh.colors.is_empty();
    let has_uncertainty = mesh.has_uncertainty();
    Ok((
        points_out(py, &mesh.vertices)?,
        array(py, mesh.faces)?,
        has_uv.then(|| array(py, mesh.uvs)).transpose()?,
        has_uv.then(|| array(py, mesh.face_uvs)).transpose()?,
        has_colors.then(|| array(py, mesh.colors)).transpose()?,
        has_uncertainty.then(|| PyArray1::from_vec(py, mesh.sigmas)),
        has_uncertainty.then(|| PyArray1::from_vec(py, mesh.measured)),
    ))
}

/// A cloud as arrays.
pub(crate) fn cloud_out(py: Python<'_>, cloud: Cloud) -> PyResult<CloudOut<'_>> {
    let [normals, colors, sigmas] =
        [cloud.normals.is_empty(), cloud.colors.is_empty(), cloud.sigmas.is_empty()];
    Ok((
        points_out(py, &cloud.points)?,
        (!normals).then(|| points_out(py, &cloud.normals)).transpose()?,
        (!colors).then(|| array(py, cloud.colors)).transpose()?,
        (!sigmas).then(|| PyArray1::from_vec(py, cloud.sigmas)),
    ))
}

/// A one-channel image as `(height, width)`.
pub(crate) fn raster_out<T: Element + Copy>(
    py: Python<'_>,
    image: Raster<T>,
) -> PyResult<Bound<'_, PyArray2<T>>> {
    let (width, height) = image.size();
    PyArray1::from_vec(py, image.into_data()).reshape([height, width])
}

/// A colour image as `(height, width, 3)`.
pub(crate) fn rgb_out(py: Python<'_>, image: Rgb) -> PyResult<Bound<'_, PyArray3<u8>>> {
    let (width, height) = image.size();
    PyArray1::from_vec(py, image.into_data().into_flattened()).reshape([height, width, 3])
}

/// A transform as a 4x4 array.
pub(crate) fn transform_out<'py>(
    py: Python<'py>,
    transform: &Similarity,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    array(py, transform.to_rows().to_vec())
}
