//! Form factors as an operator.

use crate::patches::Enclosure;
use crate::scene::LightTuple;
use crate::solution::{Solution, lighting_in, observed, settings};
use crate::{convert, errors, watch};
use numpy::{PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use radiosity_exchange::factors::{FormFactors, Method, Settings, measure};
use radiosity_exchange::{Rows, factors, smoothing};
use radiosity_operator::{Operator, Symmetric};
use std::sync::Arc;

/// The exchange between the fronts of patches (and the backs of two-sided ones, numbered after them).
#[pyclass(frozen, module = "radiosity._native")]
pub struct Factors {
    inner: Arc<FormFactors>,
}

/// Compressed rows: offsets, columns, values.
type Csr<'py> = (Bound<'py, PyArray1<i64>>, Bound<'py, PyArray1<u32>>, Bound<'py, PyArray1<f64>>);

/// Measures the form factors between all sides.
#[pyfunction]
#[pyo3(signature = (enclosure, method, tolerance, samples, resolution, seed, memory_limit, threads=None, progress=None))]
pub fn form_factors(
    py: Python<'_>,
    enclosure: &Enclosure,
    method: &str,
    tolerance: f64,
    samples: Option<u32>,
    resolution: usize,
    seed: u64,
    memory_limit: u64,
    threads: Option<usize>,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<Factors> {
    let method = method_in(method, samples, resolution)?;
    let settings = Settings { method, tolerance, seed, memory_limit };
    let enclosure = enclosure.inner.clone();
    let result = watch::run(py, threads, progress.as_ref(), |control| measure(enclosure, &settings, control))?;
    Ok(Factors { inner: Arc::new(result.map_err(errors::factors)?) })
}

/// Form factors as they were: `values` are F in compressed rows.
#[pyfunction]
pub fn given_factors(
    enclosure: &Enclosure,
    offsets: PyReadonlyArray1<'_, i64>,
    columns: PyReadonlyArray1<'_, u32>,
    values: PyReadonlyArray1<'_, f64>,
) -> PyResult<Factors> {
    let sides = enclosure.inner.sides();
    let (offsets, columns, values) = (offsets.as_array(), columns.as_array(), values.as_array());
    let ascends = offsets.iter().zip(offsets.iter().skip(1)).all(|(a, b)| a <= b);
    let spans = offsets.len() == sides + 1 && offsets[0] == 0 && offsets[sides] == values.len() as i64;
    if !(ascends && spans && columns.len() == values.len() && columns.iter().all(|c| (*c as usize) < sides)) {
        return Err(PyValueError::new_err(format!("these are not compressed rows of {sides} by {sides} form factors")));
    }
    if values.iter().any(|f| !(f.is_finite() && *f >= 0.0)) {
        return Err(PyValueError::new_err("form factors must be finite and not negative"));
    }
    let row = |i: usize| -> Vec<(u32, f64)> {
        let mut row: Vec<_> = (offsets[i] as usize..offsets[i + 1] as usize).map(|k| (columns[k], values[k])).collect();
        row.sort_by_key(|e| e.0);
        row
    };
    let rows = Rows::from_rows((0..sides).map(row).collect());
    let (operator, disagreement) = factors::symmetric(&enclosure.inner, &rows);
    let report = factors::FactorReport { disagreement, estimated_error: disagreement, ..Default::default() };
    let inner = FormFactors { enclosure: enclosure.inner.clone(), operator, standard_error: None, report };
    Ok(Factors { inner: Arc::new(inner) })
}

fn method_in(name: &str, samples: Option<u32>, resolution: usize) -> PyResult<Method> {
    Ok(match name {
        "auto" => Method::Auto,
        "analytic" => Method::Analytic,
        "contour" => Method::Contour,
        "nusselt" => Method::Nusselt { points: samples.map(|n| n as usize) },
        "hemicube" => Method::Hemicube { resolution, positions: samples.map(|n| n as usize) },
        "monte_carlo" => Method::MonteCarlo { rays: samples.unwrap_or(4096) },
        _ => return Err(PyValueError::new_err(format!("there is no method '{name}'"))),
    })
}

#[pymethods]
impl Factors {
    /// The number of sides.
    fn __len__(&self) -> usize {
        self.inner.operator.len()
    }

    /// The patch of each side.
    #[getter]
    fn patch<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        let patches: Vec<u32> =
            (0..self.inner.enclosure.sides()).map(|s| self.inner.enclosure.patch_of(s) as u32).collect();
        convert::vector_out(py, &patches)
    }

    /// `G x` for a block of columns, m2.
    fn exchange<'py>(&self, py: Python<'py>, x: PyReadonlyArray2<'py, f64>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let columns = x.as_array().ncols();
        let x = convert::block_in(&x, self.inner.operator.len(), columns, "x")?;
        let mut y = vec![0.0; x.len()];
        py.detach(|| self.inner.operator.apply(&x, &mut y, columns));
        Ok(convert::block_out(py, y, columns))
    }

    /// The entries of row `i` of G: columns and values.
    fn row<'py>(&self, py: Python<'py>, i: usize) -> (Bound<'py, PyArray1<u32>>, Bound<'py, PyArray1<f64>>) {
        let row = self.inner.operator.row(i);
        let columns: Vec<u32> = row.iter().map(|e| e.0).collect();
        let values: Vec<f64> = row.iter().map(|e| e.1).collect();
        (convert::vector_out(py, &columns), convert::vector_out(py, &values))
    }

    /// All of F as compressed rows.
    fn csr<'py>(&self, py: Python<'py>) -> Csr<'py> {
        self.rows_of(py, &self.inner.operator)
    }

    /// The standard errors of F as compressed rows, where rays found it.
    fn standard_error<'py>(&self, py: Python<'py>) -> Option<Csr<'py>> {
        self.inner.standard_error.as_ref().map(|error| self.rows_of(py, error))
    }

    /// F as a dense matrix.
    fn dense<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let n = self.inner.operator.len();
        let values = py.detach(|| {
            let mut values = vec![0.0; n * n];
            let inverse: Vec<f64> = (0..n).map(|i| 1.0 / self.inner.enclosure.area(i)).collect();
            self.inner.operator.for_each_pair(|i, j, g| {
                values[i * n + j] = g * inverse[i];
                values[j * n + i] = g * inverse[j];
            });
            values
        });
        convert::block_out(py, values, n)
    }

    /// Form factors whose rows sum to `wanted`, and the worst relative deviation that is left.
    #[pyo3(signature = (wanted, threads=None, progress=None))]
    fn smoothed(
        &self,
        py: Python<'_>,
        wanted: Vec<f64>,
        threads: Option<usize>,
        progress: Option<Bound<'_, PyAny>>,
    ) -> PyResult<(Factors, f64)> {
        let enclosure = &self.inner.enclosure;
        if wanted.len() != enclosure.sides() {
            return Err(PyValueError::new_err(format!("give one row sum for each of {} sides", enclosure.sides())));
        }
        let sums: Vec<f64> = wanted.iter().enumerate().map(|(i, w)| w * enclosure.area(i)).collect();
        let result = watch::run(py, threads, progress.as_ref(), |control| {
            let variance = self.inner.standard_error.as_ref().map(|error| error.mapped(|_, _, e| e * e));
            smoothing::with_row_sums(&self.inner.operator, variance.as_ref(), &sums, control)
        })?;
        let (operator, left) = result.map_err(|c| errors::factors(c.into()))?;
        let inner = FormFactors {
            enclosure: enclosure.clone(),
            operator,
            standard_error: self.inner.standard_error.clone(),
            report: self.inner.report,
        };
        Ok((Factors { inner: Arc::new(inner) }, left))
    }

    /// What was done and how wrong it may be.
    fn report<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (r, d) = (&self.inner.report, PyDict::new(py));
        d.set_item("estimated_error", r.estimated_error)?;
        d.set_item("disagreement", r.disagreement)?;
        d.set_item("samples", r.samples)?;
        d.set_item("pairs_in_full_view", r.tally.full)?;
        d.set_item("pairs_partly_hidden", r.tally.partial)?;
        d.set_item("pairs_hidden", r.tally.hidden)?;
        d.set_item("by_areas", r.tally.by_areas)?;
        d.set_item("by_contour", r.tally.by_contour)?;
        d.set_item("by_rays", r.tally.by_rays)?;
        d.set_item("unresolved", r.tally.unresolved)?;
        d.set_item("memory_bytes", self.inner.operator.memory_bytes())?;
        d.set_item("seconds", r.seconds)?;
        Ok(d)
    }

    /// Solves `B = E + rho F B` on these form factors as they are.
    #[pyo3(signature = (reflectance, emission, lamps, accuracy, method, seed, max_iterations=None, threads=None,
                        progress=None, on_iterate=None))]
    fn solve(
        &self,
        py: Python<'_>,
        reflectance: PyReadonlyArray2<'_, f64>,
        emission: PyReadonlyArray2<'_, f64>,
        lamps: Vec<LightTuple>,
        accuracy: f64,
        method: &str,
        seed: u64,
        max_iterations: Option<usize>,
        threads: Option<usize>,
        progress: Option<Bound<'_, PyAny>>,
        on_iterate: Option<Bound<'_, PyAny>>,
    ) -> PyResult<Solution> {
        let settings = settings(accuracy, seed, 0, u64::MAX, method, max_iterations, true)?;
        let lighting = lighting_in(&self.inner.enclosure, reflectance, emission, lamps)?;
        let shape = (self.inner.enclosure.patches().len(), lighting.bands);
        let result = observed(py, threads, progress, on_iterate, shape, |observer, control| {
            radiosity_equilibrium::solve_given(&self.inner, &lighting, &settings, observer, control)
        })?;
        Solution::new(result, lighting.bands)
    }
}

impl Factors {
    fn rows_of<'py>(&self, py: Python<'py>, operator: &Symmetric) -> Csr<'py> {
        let (offsets, columns, values) = py.detach(|| {
            let (offsets, columns, mut values) = operator.to_csr();
            for i in 0..operator.len() {
                let inverse = 1.0 / self.inner.enclosure.area(i);
                values[offsets[i]..offsets[i + 1]].iter_mut().for_each(|v| *v *= inverse);
            }
            (offsets.iter().map(|&o| o as i64).collect::<Vec<_>>(), columns, values)
        });
        use numpy::IntoPyArray;
        (offsets.into_pyarray(py), columns.into_pyarray(py), values.into_pyarray(py))
    }
}
