//! Patches and their ray hierarchy.

use crate::convert;
use numpy::{PyArray1, PyArray2, PyArray3, PyReadonlyArray1, PyReadonlyArray3};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::sync::Arc;

/// The surface elements of a scene.
#[pyclass(frozen, module = "radiosity._native")]
pub struct Patches {
    pub inner: Arc<radiosity_geometry::Patches>,
}

#[pymethods]
impl Patches {
    /// Polygons (n, 4, 3) with the surface, face and two-sidedness of each; a triangle repeats its last corner.
    #[new]
    fn new(
        polygons: PyReadonlyArray3<'_, f64>,
        surface: PyReadonlyArray1<'_, u32>,
        face: PyReadonlyArray1<'_, u32>,
        two_sided: PyReadonlyArray1<'_, bool>,
    ) -> PyResult<Self> {
        let view = polygons.as_array();
        let n = view.shape()[0];
        let corner = |i: usize, k: usize| glam::DVec3::new(view[[i, k, 0]], view[[i, k, 1]], view[[i, k, 2]]);
        if view.shape()[1..] != [4, 3] || [surface.len()?, face.len()?, two_sided.len()?] != [n; 3] {
            return Err(PyValueError::new_err("polygons must have shape (n, 4, 3), and the other arrays length n"));
        }
        if let Some(i) = (0..n).find(|&i| (0..4).any(|k| !corner(i, k).is_finite())) {
            return Err(PyValueError::new_err(format!("patch {i} has a corner that is not finite")));
        }
        let polygons = (0..n).map(|i| [0, 1, 2, 3].map(|k| corner(i, k))).collect();
        let inner = radiosity_geometry::Patches::new(
            polygons,
            surface.as_array().to_vec(),
            face.as_array().to_vec(),
            two_sided.as_array().to_vec(),
        );
        Ok(Self { inner: Arc::new(inner) })
    }

    fn __len__(&self) -> usize {
        self.inner.len()
    }

    #[getter]
    fn polygons<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray3<f64>> {
        convert::polygons_out(py, &self.inner.polygons)
    }

    #[getter]
    fn surface<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        convert::vector_out(py, &self.inner.surface)
    }

    #[getter]
    fn face<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        convert::vector_out(py, &self.inner.face)
    }

    #[getter]
    fn two_sided<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        convert::vector_out(py, &self.inner.two_sided)
    }

    #[getter]
    fn area<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        convert::vector_out(py, &self.inner.area)
    }

    #[getter]
    fn centre<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        convert::points_out(py, &self.inner.centre)
    }

    #[getter]
    fn normal<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        convert::points_out(py, &self.inner.normal)
    }
}

/// Patches with the hierarchy that rays traverse.
#[pyclass(frozen, module = "radiosity._native")]
pub struct Enclosure {
    pub inner: Arc<radiosity_exchange::Enclosure>,
}

#[pymethods]
impl Enclosure {
    #[new]
    #[pyo3(signature = (patches, threads=None))]
    fn new(py: Python<'_>, patches: &Patches, threads: Option<usize>) -> PyResult<Self> {
        let patches = patches.inner.as_ref().clone();
        let inner = crate::watch::run(py, threads, None, |_| radiosity_exchange::Enclosure::new(patches))?;
        Ok(Self { inner: Arc::new(inner) })
    }

    /// Raises `RuntimeError` if an invariant of the hierarchy does not hold.
    fn validate(&self) -> PyResult<()> {
        self.inner.bvh().validate().map_err(pyo3::exceptions::PyRuntimeError::new_err)
    }

    /// Bytes held.
    #[getter]
    fn memory_bytes(&self) -> usize {
        self.inner.memory_bytes()
    }
}
