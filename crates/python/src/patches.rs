//! Patches and their ray hierarchy.

use crate::convert;
use numpy::{PyArray1, PyArray2, PyArray3, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use radiosity_exchange::looks::looks;
use std::sync::Arc;

/// The surface elements of a scene.
#[pyclass(frozen, module = "radiosity._native")]
pub struct Patches {
    pub inner: Arc<radiosity_geometry::Patches>,
}

#[pymethods]
impl Patches {
    /// Polygons (n, 4, 3) with the surface, face and two-sidedness of each, and (k, 4, 3) polygons that only block; a
    /// triangle repeats its last corner.
    #[new]
    #[pyo3(signature = (polygons, surface, face, two_sided, obstructions=None))]
    fn new(
        polygons: PyReadonlyArray3<'_, f64>,
        surface: PyReadonlyArray1<'_, u32>,
        face: PyReadonlyArray1<'_, u32>,
        two_sided: PyReadonlyArray1<'_, bool>,
        obstructions: Option<PyReadonlyArray3<'_, f64>>,
    ) -> PyResult<Self> {
        let polygons = convert::polygons_in(&polygons, "polygons")?;
        let n = polygons.len();
        if [surface.len()?, face.len()?, two_sided.len()?] != [n; 3] {
            return Err(PyValueError::new_err("surface, face and two_sided must have one entry per polygon"));
        }
        let obstructions = obstructions.map_or(Ok(Vec::new()), |array| convert::polygons_in(&array, "obstructions"))?;
        let inner = radiosity_geometry::Patches::new(
            polygons,
            surface.as_array().to_vec(),
            face.as_array().to_vec(),
            two_sided.as_array().to_vec(),
        );
        Ok(Self { inner: Arc::new(inner.with_obstructions(obstructions)) })
    }

    fn __len__(&self) -> usize {
        self.inner.len()
    }

    #[getter]
    fn polygons<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray3<f64>> {
        convert::polygons_out(py, &self.inner.polygons)
    }

    #[getter]
    fn obstructions<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray3<f64>> {
        convert::polygons_out(py, &self.inner.obstructions)
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

/// Polygon, distance and whether it is the front, of each ray.
type Looks<'py> = (Bound<'py, PyArray1<i64>>, Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<bool>>);

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
        let patches = patches.inner.clone();
        let inner = crate::watch::run(py, threads, None, |_| radiosity_exchange::Enclosure::new(patches))?;
        Ok(Self { inner: Arc::new(inner) })
    }

    /// Raises `RuntimeError` if an invariant of the hierarchy does not hold.
    fn validate(&self) -> PyResult<()> {
        self.inner.bvh().validate().map_err(pyo3::exceptions::PyRuntimeError::new_err)
    }

    /// What rays from (n, 3) points along (n, 3) directions meet first: (n,) polygon, obstructions after all patches and
    /// -1 for nothing; (n,) distance in lengths of the direction; (n,) whether it is the front.
    #[pyo3(signature = (points, directions, threads=None))]
    fn looks<'py>(
        &self,
        py: Python<'py>,
        points: PyReadonlyArray2<'py, f64>,
        directions: PyReadonlyArray2<'py, f64>,
        threads: Option<usize>,
    ) -> PyResult<Looks<'py>> {
        let (points, directions) =
            (convert::points_in(&points, "points")?, convert::points_in(&directions, "directions")?);
        if points.len() != directions.len() {
            return Err(PyValueError::new_err("there must be as many directions as points"));
        }
        let found = crate::watch::run(py, threads, None, |control| looks(&self.inner, &points, &directions, control))?
            .map_err(|_| pyo3::exceptions::PyKeyboardInterrupt::new_err("cancelled"))?;
        let polygon: Vec<i64> = found.iter().map(|look| look.polygon.map_or(-1, i64::from)).collect();
        let distance: Vec<f64> = found.iter().map(|look| f64::from(look.distance)).collect();
        let is_front: Vec<bool> = found.iter().map(|look| look.is_front).collect();
        Ok((convert::vector_out(py, &polygon), convert::vector_out(py, &distance), convert::vector_out(py, &is_front)))
    }

    /// Bytes held.
    #[getter]
    fn memory_bytes(&self) -> usize {
        self.inner.memory_bytes()
    }
}
