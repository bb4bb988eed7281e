//! Patches and their ray hierarchy.

use crate::{convert, errors};
use numpy::ndarray::Array3;
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArray3, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use radiosity_exchange::looks::looks;
use radiosity_geometry::Corners;
use radiosity_geometry::corners::CREASE_ANGLE;
use radiosity_scene::meshing::{self, Meshing};
use std::sync::{Arc, OnceLock};

/// The surface elements of a scene.
#[pyclass(frozen, module = "radiosity._native")]
pub struct Patches {
    pub inner: Arc<radiosity_geometry::Patches>,
    /// Which corners belong together, found when first asked for.
    corners: OnceLock<Corners<Arc<radiosity_geometry::Patches>>>,
}

impl From<radiosity_geometry::Patches> for Patches {
    fn from(patches: radiosity_geometry::Patches) -> Self {
        Self { inner: Arc::new(patches), corners: OnceLock::new() }
    }
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
        Ok(inner.with_obstructions(obstructions).into())
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

/// Values at the corners, (n, 4, columns), of the piecewise linear field through values of patches, (n, columns).
#[pyfunction]
pub fn corner_field<'py>(
    py: Python<'py>,
    patches: &Patches,
    values: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyArray3<f64>>> {
    let columns = values.as_array().ncols();
    let values = convert::block_in(&values, patches.inner.len(), columns, "values")?;
    let corners = py.detach(|| {
        patches.corners.get_or_init(|| Corners::new(patches.inner.clone(), CREASE_ANGLE)).field(&values, columns)
    });
    let array = Array3::from_shape_vec((patches.inner.len(), 4, columns), corners);
    Ok(array.map_err(|e| PyValueError::new_err(e.to_string()))?.into_pyarray(py))
}

/// A mesh that is refined where it pays.
#[pyclass(module = "radiosity._native")]
pub struct AdaptiveMesh {
    inner: meshing::AdaptiveMesh,
    scene: radiosity_scene::Scene,
}

#[pymethods]
impl AdaptiveMesh {
    /// Begins with about so many patches.
    #[new]
    fn new(py: Python<'_>, scene: &crate::scene::Scene, count: usize) -> PyResult<Self> {
        let scene = scene.inner.clone();
        let inner = py.detach(|| meshing::AdaptiveMesh::new(&scene, &Meshing::Count(count))).map_err(errors::scene)?;
        Ok(Self { inner, scene })
    }

    /// The patches, and the leaf that each is a piece of.
    fn patches<'py>(&self, py: Python<'py>) -> (Patches, Bound<'py, PyArray1<u32>>) {
        let (patches, leaf) = py.detach(|| self.inner.patches());
        (patches.into(), convert::vector_out(py, &leaf))
    }

    /// Cuts leaves as many times as they are marked with, and what must be cut along; returns how many there are then.
    fn refine(&mut self, py: Python<'_>, marked: PyReadonlyArray1<'_, u8>) -> PyResult<usize> {
        let marked = marked.as_array().to_vec();
        if marked.len() != self.inner.leaves() {
            return Err(PyValueError::new_err(format!("give one mark for each of {} leaves", self.inner.leaves())));
        }
        py.detach(|| self.inner.refine(&self.scene, &marked)).map_err(errors::scene)
    }
}

/// Patch and weights of its corners, of each point.
type Places<'py> = (Bound<'py, PyArray1<i64>>, Bound<'py, PyArray2<f64>>);
/// Polygon, distance and whether it is the front, of each ray.
type Looks<'py> = (Bound<'py, PyArray1<i64>>, Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<bool>>);

/// Patches with the hierarchy that rays traverse.
#[pyclass(frozen, module = "radiosity._native")]
pub struct Enclosure {
    pub inner: Arc<radiosity_exchange::Enclosure>,
}

#[pymethods]
impl Enclosure {
    /// Mirror reflectance and transmittance are (n,), parts of what meets each patch.
    #[new]
    #[pyo3(signature = (patches, threads=None, specular=None, transmittance=None))]
    fn new(
        py: Python<'_>,
        patches: &Patches,
        threads: Option<usize>,
        specular: Option<PyReadonlyArray1<'_, f64>>,
        transmittance: Option<PyReadonlyArray1<'_, f64>>,
    ) -> PyResult<Self> {
        let patches = patches.inner.clone();
        let parts = |array: Option<PyReadonlyArray1<'_, f64>>| {
            array.map_or_else(|| vec![0.0; patches.len()], |array| array.as_array().to_vec())
        };
        let (specular, transmittance) = (parts(specular), parts(transmittance));
        if specular.len() != patches.len() || transmittance.len() != patches.len() {
            return Err(PyValueError::new_err("specular and transmittance must have one entry per patch"));
        }
        let is_part = |(s, t): (&f64, &f64)| *s >= 0.0 && *t >= 0.0 && s + t <= 1.0 + 1e-12;
        if let Some(patch) = specular.iter().zip(&transmittance).position(|parts| !is_part(parts)) {
            return Err(PyValueError::new_err(format!(
                "patch {patch}: specular {} and transmittance {} must be at least 0 and together at most 1",
                specular[patch], transmittance[patch]
            )));
        }
        let inner = crate::watch::run(py, threads, None, |_| {
            radiosity_exchange::Enclosure::new(patches).with_specular(specular, transmittance)
        })?;
        Ok(Self { inner: Arc::new(inner) })
    }

    /// The patch at each point of a surface whose front looks along the normal there (-1: none is within `reach`), and
    /// what each of its corners counts in the interpolation at that point: (k,) and (k, 4).
    fn locate<'py>(
        &self,
        py: Python<'py>,
        points: PyReadonlyArray2<'py, f64>,
        normals: PyReadonlyArray2<'py, f64>,
        reach: f64,
    ) -> PyResult<Places<'py>> {
        let (points, normals) = (convert::points_in(&points, "points")?, convert::points_in(&normals, "normals")?);
        if points.len() != normals.len() {
            return Err(PyValueError::new_err("give one normal per point"));
        }
        let found = py.detach(|| {
            let at =
                |(&p, &n): (&radiosity_geometry::DVec3, &radiosity_geometry::DVec3)| self.inner.locate(p, n, reach);
            points.iter().zip(&normals).map(at).collect::<Vec<_>>()
        });
        let patch: Vec<i64> = found.iter().map(|f| f.map_or(-1, |(patch, _)| patch as i64)).collect();
        let weights = found.iter().flat_map(|f| f.map_or([0.0; 4], |(_, weights)| weights)).collect();
        Ok((convert::vector_out(py, &patch), convert::block_out(py, weights, 4)))
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
