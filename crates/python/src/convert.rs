//! Between numpy arrays and the engine's vectors.

use glam::DVec3;
use numpy::ndarray::{Array1, Array2, Array3};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArray3, PyReadonlyArray2, PyReadonlyArray3};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// An (n, 3) array of points.
pub fn points_out<'py>(py: Python<'py>, points: &[DVec3]) -> Bound<'py, PyArray2<f64>> {
    let flat: Vec<f64> = points.iter().flat_map(|p| p.to_array()).collect();
    block_out(py, flat, 3)
}

/// A row-major block as an (n, columns) array.
pub fn block_out(py: Python<'_>, values: Vec<f64>, columns: usize) -> Bound<'_, PyArray2<f64>> {
    let rows = values.len() / columns.max(1);
    Array2::from_shape_vec((rows, columns), values).expect("blocks are whole rows").into_pyarray(py)
}

/// The first `rows` rows of a row-major block.
pub fn rows_out<'py>(
    py: Python<'py>,
    values: &[f64],
    rows: std::ops::Range<usize>,
    columns: usize,
) -> Bound<'py, PyArray2<f64>> {
    block_out(py, values[rows.start * columns..rows.end * columns].to_vec(), columns)
}

/// (n, 4, 3) polygons.
pub fn polygons_out<'py>(py: Python<'py>, polygons: &[[DVec3; 4]]) -> Bound<'py, PyArray3<f64>> {
    let flat: Vec<f64> = polygons.iter().flatten().flat_map(|p| p.to_array()).collect();
    Array3::from_shape_vec((polygons.len(), 4, 3), flat).expect("twelve numbers each").into_pyarray(py)
}

/// (n, 2, 3) ends of edges.
pub fn edges_out<'py>(py: Python<'py>, edges: &[[DVec3; 2]]) -> Bound<'py, PyArray3<f64>> {
    let flat: Vec<f64> = edges.iter().flatten().flat_map(|p| p.to_array()).collect();
    Array3::from_shape_vec((edges.len(), 2, 3), flat).expect("six numbers each").into_pyarray(py)
}

/// A copy as a one-dimensional array.
pub fn vector_out<'py, T: numpy::Element + Clone>(py: Python<'py>, values: &[T]) -> Bound<'py, PyArray1<T>> {
    Array1::from_vec(values.to_vec()).into_pyarray(py)
}

/// Points from an (n, 3) array.
pub fn points_in(array: &PyReadonlyArray2<'_, f64>, what: &str) -> PyResult<Vec<DVec3>> {
    let view = array.as_array();
    if view.ncols() != 3 {
        return Err(PyValueError::new_err(format!("{what} must have shape (n, 3), not {:?}", view.shape())));
    }
    Ok(view.rows().into_iter().map(|r| DVec3::new(r[0], r[1], r[2])).collect())
}

/// Polygons from an (n, 4, 3) array of finite numbers.
pub fn polygons_in(array: &PyReadonlyArray3<'_, f64>, what: &str) -> PyResult<Vec<[DVec3; 4]>> {
    let view = array.as_array();
    if view.shape()[1..] != [4, 3] {
        return Err(PyValueError::new_err(format!("{what} must have shape (n, 4, 3), not {:?}", view.shape())));
    }
    let corner = |i: usize, k: usize| DVec3::new(view[[i, k, 0]], view[[i, k, 1]], view[[i, k, 2]]);
    let polygons: Vec<_> = (0..view.shape()[0]).map(|i| [0, 1, 2, 3].map(|k| corner(i, k))).collect();
    match polygons.iter().position(|polygon| polygon.iter().any(|corner| !corner.is_finite())) {
        Some(i) => Err(PyValueError::new_err(format!("{what}: polygon {i} has a corner that is not finite"))),
        None => Ok(polygons),
    }
}

/// A row-major copy of an (n, columns) array, with its shape checked.
pub fn block_in(array: &PyReadonlyArray2<'_, f64>, rows: usize, columns: usize, what: &str) -> PyResult<Vec<f64>> {
    let view = array.as_array();
    if view.shape() != [rows, columns] {
        return Err(PyValueError::new_err(format!(
            "{what} must have shape ({rows}, {columns}), not {:?}",
            view.shape()
        )));
    }
    Ok(view.iter().copied().collect())
}

/// Diffuse transmittance of patches from (n, bands); empty without an array.
pub fn through_in(array: Option<&PyReadonlyArray2<'_, f64>>, n: usize, bands: usize) -> PyResult<Vec<f64>> {
    let Some(array) = array else { return Ok(Vec::new()) };
    let values = block_in(array, n, bands, "diffuse transmittance")?;
    match values.iter().position(|tau| !(0.0..=1.0).contains(tau)) {
        Some(i) => Err(PyValueError::new_err(format!(
            "patch {}: diffuse transmittance {} is not in [0, 1]",
            i / bands,
            values[i]
        ))),
        None => Ok(values),
    }
}

/// Three numbers as a vector.
pub fn vec3(v: [f64; 3]) -> DVec3 {
    DVec3::from_array(v)
}

/// Mirror reflectance and transmittance of patches from (n, 2).
pub fn going_on_in(array: &PyReadonlyArray2<'_, f64>, n: usize) -> PyResult<[Vec<f64>; 2]> {
    let values = block_in(array, n, 2, "specular and transmittance")?;
    if let Some(patch) =
        values.chunks_exact(2).position(|p| !(p[0] >= 0.0 && p[1] >= 0.0 && p[0] + p[1] <= 1.0 + 1e-12))
    {
        return Err(PyValueError::new_err(format!(
            "patch {patch}: specular {} and transmittance {} must be at least 0 and together at most 1",
            values[2 * patch],
            values[2 * patch + 1]
        )));
    }
    Ok([0, 1].map(|part| values.iter().skip(part).step_by(2).copied().collect()))
}
