//! Shooting, and its state as arrays.

use crate::patches::Enclosure;
use crate::scene::LightTuple;
use crate::solution::{lighting_in, report_out};
use crate::{convert, errors, watch};
use numpy::{PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use radiosity_equilibrium::shooting::{self, Parts, ShootingSettings};
use std::sync::Arc;

/// The sums that shooting goes on from.
#[pyclass(frozen, module = "radiosity._native")]
pub struct ShootingState {
    inner: Arc<shooting::Shooting>,
}

type PartsOut<'py> =
    (Bound<'py, PyArray1<u64>>, Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f32>>, Bound<'py, PyArray1<u32>>);

#[pymethods]
impl ShootingState {
    /// From counts, shares, sums and rays that landed, as `parts` gives them.
    #[new]
    fn new(
        counts: PyReadonlyArray1<'_, u64>,
        shares: PyReadonlyArray1<'_, f64>,
        sums: PyReadonlyArray1<'_, f32>,
        landed: PyReadonlyArray1<'_, u32>,
    ) -> PyResult<Self> {
        let parts = Parts {
            counts: counts.as_array().to_vec(),
            shares: shares.as_array().to_vec(),
            sums: sums.as_array().to_vec(),
            landed: landed.as_array().to_vec(),
        };
        let inner = shooting::Shooting::from_parts(parts).map_err(|e| PyValueError::new_err(e.to_string()))?;
        Ok(Self { inner: Arc::new(inner) })
    }

    /// Counts, shares, sums and rays that landed.
    fn parts<'py>(&self, py: Python<'py>) -> PartsOut<'py> {
        let Parts { counts, shares, sums, landed } = self.inner.to_parts();
        (
            PyArray1::from_vec(py, counts),
            PyArray1::from_vec(py, shares),
            PyArray1::from_vec(py, sums),
            PyArray1::from_vec(py, landed),
        )
    }

    /// Bytes held.
    #[getter]
    fn memory_bytes(&self) -> usize {
        self.inner.memory_bytes()
    }
}

/// The equilibrium of light found by shooting.
#[pyclass(frozen, module = "radiosity._native")]
pub struct ShotSolution {
    inner: radiosity_equilibrium::ShotSolution,
    patches: usize,
    bands: usize,
}

#[pymethods]
impl ShotSolution {
    /// Irradiance of the fronts, (n_patches, bands) W/m2.
    #[getter]
    fn irradiance<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        self.fronts(py, &self.inner.irradiance)
    }

    /// Radiosity of the fronts, (n_patches, bands) W/m2.
    #[getter]
    fn radiosity<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        self.fronts(py, &self.inner.radiosity)
    }

    /// Estimated standard error of irradiance of the fronts, (n_patches, bands) W/m2.
    #[getter]
    fn error<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        self.fronts(py, &self.inner.error)
    }

    /// Irradiance, radiosity and error of the backs of the two-sided patches, in patch order.
    fn backs<'py>(&self, py: Python<'py>) -> [Bound<'py, PyArray2<f64>>; 3] {
        let sides = self.inner.irradiance.len() / self.bands.max(1);
        [&self.inner.irradiance, &self.inner.radiosity, &self.inner.error]
            .map(|values| convert::rows_out(py, values, self.patches..sides, self.bands))
    }

    /// What the solve says about itself.
    fn report<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        report_out(py, &self.inner.report)
    }

    /// What it can be gone on from.
    #[getter]
    fn state(&self) -> ShootingState {
        ShootingState { inner: self.inner.state.clone() }
    }
}

impl ShotSolution {
    fn fronts<'py>(&self, py: Python<'py>, values: &[f64]) -> Bound<'py, PyArray2<f64>> {
        convert::rows_out(py, values, 0..self.patches, self.bands)
    }
}

/// Shoots to the accuracy asked for or says what kept it; goes on from `start`.
#[pyfunction]
#[pyo3(signature = (enclosure, reflectance, emission, lamps, accuracy, seed, max_rays, memory_limit, time_limit,
                    start=None, threads=None, progress=None))]
pub fn shoot(
    py: Python<'_>,
    enclosure: &Enclosure,
    reflectance: PyReadonlyArray2<'_, f64>,
    emission: PyReadonlyArray2<'_, f64>,
    lamps: Vec<LightTuple>,
    accuracy: f64,
    seed: u64,
    max_rays: u32,
    memory_limit: u64,
    time_limit: f64,
    start: Option<&ShootingState>,
    threads: Option<usize>,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<ShotSolution> {
    if !(accuracy > 0.0 && accuracy.is_finite()) {
        return Err(PyValueError::new_err(format!("accuracy must be a positive number such as 0.01, not {accuracy}")));
    }
    let lighting = lighting_in(&enclosure.inner, reflectance, emission, lamps, None)?;
    let settings = ShootingSettings { accuracy, seed, max_rays, time_limit, memory_limit };
    let start = start.map(|state| state.inner.as_ref());
    if let Some(start) = start {
        start.belongs_to(&enclosure.inner, &lighting).map_err(|e| PyValueError::new_err(e.to_string()))?;
    }
    let result = watch::run(py, threads, progress.as_ref(), |control| {
        shooting::shoot(&enclosure.inner, &lighting, &settings, start, control)
    })?;
    let inner = result.map_err(errors::failure)?;
    Ok(ShotSolution { inner, patches: enclosure.inner.patches().len(), bands: lighting.bands })
}
