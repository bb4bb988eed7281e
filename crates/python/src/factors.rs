//! Form factors as an operator.

use crate::patches::Enclosure;
use crate::scene::LightTuple;
use crate::solution::{Solution, lighting_in, settings};
use crate::{convert, errors, watch};
use numpy::{PyArray1, PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;
use radiosity_equilibrium::{Failure, Lamp, Lighting, Measurement, Transport};
use radiosity_exchange::luminaires::Luminaires;
use radiosity_operator::{Control, Operator};
use std::sync::Arc;

/// The measured exchange between the fronts of patches (and the backs of two-sided ones, numbered after them).
#[pyclass(frozen, module = "radiosity._native")]
pub struct Factors {
    measurement: Arc<Measurement>,
}

/// Independent replicates of the rows.
const REPLICATES: usize = 4;

/// Shoots `rays` rays from every side.
#[pyfunction]
#[pyo3(signature = (enclosure, rays, seed, threads=None, progress=None))]
pub fn form_factors(
    py: Python<'_>,
    enclosure: &Enclosure,
    rays: u32,
    seed: u64,
    threads: Option<usize>,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<Factors> {
    let enclosure = enclosure.inner.clone();
    let result = watch::run(py, threads, progress.as_ref(), |control| -> Result<_, Failure> {
        let sides = enclosure.sides();
        let mut transport = Transport::new(enclosure, Luminaires::default(), REPLICATES, seed);
        control.expect(u64::from(rays) * sides as u64);
        transport.refine(&vec![rays.div_ceil(REPLICATES as u32); sides], &vec![0; sides], control)?;
        Ok(Factors { measurement: Arc::new(Measurement::raw(transport)) })
    })?;
    result.map_err(errors::failure)
}

#[pymethods]
impl Factors {
    /// The number of sides.
    fn __len__(&self) -> usize {
        self.measurement.exchange.operator.len()
    }

    /// The area of each side, m2.
    #[getter]
    fn area<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let enclosure = self.measurement.transport.enclosure();
        let area: Vec<f64> = (0..enclosure.sides()).map(|s| enclosure.area(s)).collect();
        convert::vector_out(py, &area)
    }

    /// `G x` for a block of columns.
    fn exchange<'py>(&self, py: Python<'py>, x: PyReadonlyArray2<'py, f64>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let columns = x.as_array().ncols();
        let x = convert::block_in(&x, self.measurement.exchange.operator.len(), columns, "x")?;
        let mut y = vec![0.0; x.len()];
        py.detach(|| self.measurement.exchange.operator.apply(&x, &mut y, columns));
        Ok(convert::block_out(py, y, columns))
    }

    /// The entries of row `i` of G: columns and values, a column possibly more than once.
    fn entries<'py>(&self, py: Python<'py>, i: usize) -> (Bound<'py, PyArray1<u32>>, Bound<'py, PyArray1<f64>>) {
        let row = self.measurement.exchange.operator.row(i);
        let columns: Vec<u32> = row.iter().map(|e| e.0).collect();
        let values: Vec<f64> = row.iter().map(|e| f64::from(e.1)).collect();
        (convert::vector_out(py, &columns), convert::vector_out(py, &values))
    }

    /// Solves `B = E + rho F B` on these form factors as they are.
    #[pyo3(signature = (reflectance, emission, lamps, accuracy, method, threads=None, progress=None))]
    fn solve(
        &self,
        py: Python<'_>,
        reflectance: PyReadonlyArray2<'_, f64>,
        emission: PyReadonlyArray2<'_, f64>,
        lamps: Vec<LightTuple>,
        accuracy: f64,
        method: &str,
        threads: Option<usize>,
        progress: Option<Bound<'_, PyAny>>,
    ) -> PyResult<Solution> {
        let settings = settings(accuracy, 0, 0, u64::MAX, method, true)?;
        let lighting = lighting_in(self.measurement.transport.enclosure(), reflectance, emission, lamps)?;
        let result = watch::run(py, threads, progress.as_ref(), |control| {
            let measurement = self.lit_by(&lighting, control)?;
            radiosity_equilibrium::relight(&measurement, &lighting, &settings, control)
        })?;
        Solution::new(result, lighting.bands)
    }
}

impl Factors {
    /// These form factors with samples of a lighting's lights without area.
    fn lit_by(&self, lighting: &Lighting, control: &Control) -> Result<Arc<Measurement>, Failure> {
        if lighting.lamps.is_empty() {
            return Ok(self.measurement.clone());
        }
        let luminaires = Luminaires {
            list: lighting.lamps.iter().map(|lamp| lamp.luminaire).collect(),
            strength: lighting.lamps.iter().map(Lamp::mean_strength).collect(),
        };
        let transport = &self.measurement.transport;
        let rays = transport.shots().per_replicate(0).max(1);
        Ok(Arc::new(Measurement::raw(transport.with_luminaires(luminaires, rays, control)?)))
    }
}
