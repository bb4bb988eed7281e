//! Form factors as an operator.

use crate::patches::Enclosure;
use crate::scene::LightTuple;
use crate::solution::{Solution, relight, settings};
use crate::{convert, errors, watch};
use numpy::{PyArray1, PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;
use radiosity_equilibrium::{Failure, Transport};
use radiosity_exchange::Elements;
use radiosity_exchange::luminaires::Luminaires;
use radiosity_exchange::operator::ElementExchange;
use radiosity_operator::Operator;
use std::sync::Arc;

/// The measured exchange between the fronts of patches (and the backs of two-sided ones, numbered after them).
#[pyclass(frozen, module = "radiosity._native")]
pub struct Factors {
    transport: Arc<Transport>,
    exchange: ElementExchange,
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
        let exchange = transport.on(&Elements::whole(transport.enclosure()), 1, None);
        Ok(Factors { transport: Arc::new(transport), exchange })
    })?;
    result.map_err(errors::failure)
}

#[pymethods]
impl Factors {
    /// The number of sides.
    fn __len__(&self) -> usize {
        self.exchange.operator.len()
    }

    /// The area of each side, m2.
    #[getter]
    fn area<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let enclosure = self.transport.enclosure();
        let area: Vec<f64> = (0..enclosure.sides()).map(|s| enclosure.area(s)).collect();
        convert::vector_out(py, &area)
    }

    /// `G x` for a block of columns.
    fn exchange<'py>(&self, py: Python<'py>, x: PyReadonlyArray2<'py, f64>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let columns = x.as_array().ncols();
        let x = convert::block_in(&x, self.exchange.operator.len(), columns, "x")?;
        let mut y = vec![0.0; x.len()];
        py.detach(|| self.exchange.operator.apply(&x, &mut y, columns));
        Ok(convert::block_out(py, y, columns))
    }

    /// The entries of row `i` of G: columns and values, a column possibly more than once.
    fn entries<'py>(&self, py: Python<'py>, i: usize) -> (Bound<'py, PyArray1<u32>>, Bound<'py, PyArray1<f64>>) {
        let row = self.exchange.operator.row(i);
        let columns: Vec<u32> = row.iter().map(|e| e.0).collect();
        let values: Vec<f64> = row.iter().map(|e| f64::from(e.1)).collect();
        (convert::vector_out(py, &columns), convert::vector_out(py, &values))
    }

    /// Solves on these form factors as they are.
    #[pyo3(signature = (reflectance, emission, lamps, accuracy, method, exact_closure, threads=None, progress=None))]
    fn solve(
        &self,
        py: Python<'_>,
        reflectance: PyReadonlyArray2<'_, f64>,
        emission: PyReadonlyArray2<'_, f64>,
        lamps: Vec<LightTuple>,
        accuracy: f64,
        method: &str,
        exact_closure: bool,
        threads: Option<usize>,
        progress: Option<Bound<'_, PyAny>>,
    ) -> PyResult<Solution> {
        let settings = settings(accuracy, 0, 0, u64::MAX, method, exact_closure)?;
        relight(py, &self.transport, reflectance, emission, lamps, &settings, threads, progress)
    }
}
