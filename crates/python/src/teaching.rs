//! What pictures for lectures are made of.

use crate::patches::Enclosure;
use crate::{convert, watch};
use glam::DVec3;
use numpy::ndarray::{Array2, Array3};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArray3, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use radiosity_exchange::kernels::{hemicube, nusselt};
use radiosity_geometry::sampling::Frame;

/// The outline of a polygon on the unit hemisphere above a point, (k, 3) in the frame of the unit normal.
#[pyfunction]
pub fn nusselt_outline<'py>(
    py: Python<'py>,
    point: [f64; 3],
    normal: [f64; 3],
    polygon: PyReadonlyArray2<'py, f64>,
    steps: usize,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let (normal, corners) = corners_in(point, normal, &polygon)?;
    Ok(convert::points_out(py, &nusselt::outline(normal, &corners, steps)))
}

/// The share of the unit disk around a point that a polygon covers, projected onto the hemisphere and down.
#[pyfunction]
pub fn nusselt_share(point: [f64; 3], normal: [f64; 3], polygon: PyReadonlyArray2<'_, f64>) -> PyResult<f64> {
    let (normal, corners) = corners_in(point, normal, &polygon)?;
    Ok(nusselt::covered(normal, &corners))
}

/// Two tangents and the unit normal itself, (3, 3): the frame of the outlines.
#[pyfunction]
pub fn frame<'py>(py: Python<'py>, normal: [f64; 3]) -> Bound<'py, PyArray2<f64>> {
    let Frame { tangent, bitangent, normal } = Frame::new(convert::vec3(normal));
    convert::points_out(py, &[tangent, bitangent, normal])
}

/// The unit normal, and the corners of a polygon that are above the horizon, relative to the point.
fn corners_in(point: [f64; 3], normal: [f64; 3], polygon: &PyReadonlyArray2<'_, f64>) -> PyResult<(DVec3, Vec<DVec3>)> {
    let polygon = convert::points_in(polygon, "polygon")?;
    let normal = convert::vec3(normal);
    Ok((normal, nusselt::seen_from(convert::vec3(point), normal, &polygon)))
}

/// What each pixel of a hemicube sees.
#[pyclass(frozen, module = "radiosity._native")]
pub struct ItemBuffer {
    inner: hemicube::ItemBuffer,
}

/// Draws the scene on the hemicube of a side.
#[pyfunction]
#[pyo3(signature = (enclosure, side, resolution, seed, threads=None))]
pub fn item_buffer(
    py: Python<'_>,
    enclosure: &Enclosure,
    side: usize,
    resolution: usize,
    seed: u64,
    threads: Option<usize>,
) -> PyResult<ItemBuffer> {
    let enclosure = enclosure.inner.clone();
    if side >= enclosure.sides() {
        return Err(PyValueError::new_err(format!("side {side} of {}", enclosure.sides())));
    }
    let settings = hemicube::Settings { resolution, positions: 1, seed };
    let inner = watch::run(py, threads, None, |_| hemicube::item_buffer(&enclosure, side, &settings))?;
    Ok(ItemBuffer { inner })
}

#[pymethods]
impl ItemBuffer {
    /// Pixels along an edge.
    #[getter]
    fn resolution(&self) -> usize {
        self.inner.resolution
    }

    /// Where the hemicube stands, metres.
    #[getter]
    fn position<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        convert::vector_out(py, &self.inner.position.to_array())
    }

    /// Two tangents and the normal, (3, 3).
    #[getter]
    fn axes<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        convert::points_out(py, &self.inner.axes)
    }

    /// The side that each pixel of the five faces sees: (resolution, resolution) and four times half as many rows.
    fn owners<'py>(&self, py: Python<'py>) -> Vec<Bound<'py, PyArray2<u32>>> {
        self.inner.owner.iter().map(|face| self.image(py, face)).collect()
    }

    /// How far what is seen lies along the axis of the face, metres; shapes as of the owners.
    fn depths<'py>(&self, py: Python<'py>) -> Vec<Bound<'py, PyArray2<f32>>> {
        self.inner.depth.iter().map(|face| self.image(py, face)).collect()
    }

    /// Directions through the centres of pixels, not of unit length; one more axis than the owners.
    fn directions<'py>(&self, py: Python<'py>) -> Vec<Bound<'py, PyArray3<f64>>> {
        let columns = self.inner.resolution;
        let face = |(face, owner): (usize, &Vec<u32>)| {
            let pixels = 0..owner.len();
            let flat = pixels.flat_map(|k| self.inner.direction(face, k / columns, k % columns).to_array()).collect();
            let shape = (owner.len() / columns, columns, 3);
            Array3::from_shape_vec(shape, flat).expect("three numbers a pixel").into_pyarray(py)
        };
        self.inner.owner.iter().enumerate().map(face).collect()
    }

    /// Owners on the unfolded hemicube, (2 resolution, 2 resolution).
    fn unfolded<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<u32>> {
        let size = 2 * self.inner.resolution;
        Array2::from_shape_vec((size, size), self.inner.unfolded()).expect("it is square").into_pyarray(py)
    }
}

impl ItemBuffer {
    fn image<'py, T: numpy::Element + Copy>(&self, py: Python<'py>, pixels: &[T]) -> Bound<'py, PyArray2<T>> {
        image_out(py, pixels.to_vec(), self.inner.resolution)
    }
}

/// A value a pixel.
type Image<'py> = Bound<'py, PyArray2<f64>>;

/// The form factors of the pixels of the top, (resolution, resolution), and of a side, half as many rows.
#[pyfunction]
pub fn delta_form_factors(py: Python<'_>, resolution: usize) -> PyResult<(Image<'_>, Image<'_>)> {
    let (top, side) = watch::run(py, Some(1), None, |_| hemicube::delta_form_factors(resolution))?;
    Ok((image_out(py, top, resolution), image_out(py, side, resolution)))
}

fn image_out<T: numpy::Element>(py: Python<'_>, pixels: Vec<T>, columns: usize) -> Bound<'_, PyArray2<T>> {
    let rows = pixels.len() / columns;
    Array2::from_shape_vec((rows, columns), pixels).expect("rows are whole").into_pyarray(py)
}
