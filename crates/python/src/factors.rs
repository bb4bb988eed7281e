//! Form factors as an operator.

use crate::patches::{Enclosure, Patches};
use crate::scene::LightTuple;
use crate::solution::{Solution, lighting_in, observed, settings};
use crate::{convert, errors, watch};
use numpy::{PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use radiosity_exchange::factors::{FormFactors, Method, Settings, measure};
use radiosity_exchange::stored::{self, StoredFactors};
use radiosity_exchange::{Exchange, Rows, factors, smoothing};
use radiosity_operator::Operator;
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

/// The exchange between the fronts of patches (and the backs of two-sided ones, numbered after them).
#[pyclass(frozen, module = "radiosity._native")]
pub struct Factors {
    inner: Held,
}

/// Where they are.
enum Held {
    InMemory(Arc<FormFactors>),
    InFile(StoredFactors),
}

impl Factors {
    fn in_memory(factors: FormFactors) -> Self {
        Self { inner: Held::InMemory(Arc::new(factors)) }
    }

    /// For sizes and reports.
    fn unchecked(&self) -> &Arc<FormFactors> {
        match &self.inner {
            Held::InMemory(factors) => factors,
            Held::InFile(stored) => stored.unchecked(),
        }
    }

    /// For numbers: those of a file are checked when they are used for the first time.
    fn checked(&self, py: Python<'_>) -> PyResult<&Arc<FormFactors>> {
        match &self.inner {
            Held::InMemory(factors) => Ok(factors),
            Held::InFile(stored) => py.detach(|| stored.checked()).map_err(errors::store),
        }
    }
}

/// An open file of form factors.
#[pyclass(module = "radiosity._native")]
pub struct ExchangeFile {
    /// None once it has become form factors.
    inner: Option<stored::ExchangeFile>,
}

#[pymethods]
impl ExchangeFile {
    /// Maps a file and checks its structure, and all of its checksums if asked to.
    #[new]
    fn new(py: Python<'_>, path: PathBuf, verify: bool) -> PyResult<Self> {
        let opened = watch::run(py, None, None, |_| stored::ExchangeFile::open(&path, verify))?;
        Ok(Self { inner: Some(opened.map_err(errors::store)?) })
    }

    /// The patches that the form factors are between.
    #[getter]
    fn patches(&self) -> PyResult<Patches> {
        Ok(self.get()?.patches().clone().into())
    }

    /// The text that was saved with them.
    #[getter]
    fn description(&self) -> PyResult<&str> {
        Ok(self.get()?.description())
    }

    /// The form factors, on an enclosure of the same patches; the file is used up.
    fn factors(&mut self, enclosure: &Enclosure, memory_limit: u64) -> PyResult<Factors> {
        self.get()?;
        let file = self.inner.take().expect("there is one");
        let stored = file.on(enclosure.inner.clone(), memory_limit).map_err(errors::store)?;
        Ok(Factors { inner: Held::InFile(stored) })
    }
}

impl ExchangeFile {
    fn get(&self) -> PyResult<&stored::ExchangeFile> {
        self.inner.as_ref().ok_or_else(|| PyValueError::new_err("the file has become form factors already"))
    }
}

/// Columns and values.
type Row<'py> = (Bound<'py, PyArray1<u32>>, Bound<'py, PyArray1<f64>>);

/// Compressed rows: offsets, columns, values.
type Csr<'py> = (Bound<'py, PyArray1<i64>>, Bound<'py, PyArray1<u32>>, Bound<'py, PyArray1<f64>>);

/// Measures the form factors between all sides.
///
/// With a checkpoint, `(path, description)`, onto a file, or on from where that was cut off.
#[pyfunction]
#[pyo3(signature = (
    enclosure, method, tolerance, samples, resolution, seed, memory_limit, checkpoint=None, threads=None, progress=None
))]
pub fn form_factors(
    py: Python<'_>,
    enclosure: &Enclosure,
    method: &str,
    tolerance: f64,
    samples: Option<u32>,
    resolution: usize,
    seed: u64,
    memory_limit: u64,
    checkpoint: Option<(PathBuf, String)>,
    threads: Option<usize>,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<Factors> {
    let method = method_in(method, samples, resolution)?;
    let settings = Settings { method, tolerance, seed, memory_limit };
    let enclosure = enclosure.inner.clone();
    let result = watch::run(py, threads, progress.as_ref(), |control| match &checkpoint {
        None => measure(enclosure, &settings, control).map(|factors| Held::InMemory(Arc::new(factors))),
        Some((path, description)) => {
            stored::measure_onto(path, description, enclosure, &settings, control).map(Held::InFile)
        }
    })?;
    Ok(Factors { inner: result.map_err(errors::factors)? })
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
    let settings = stored::given(&enclosure.inner, &operator);
    Ok(Factors::in_memory(FormFactors {
        enclosure: enclosure.inner.clone(),
        operator: Exchange::Pairs(operator),
        standard_error: None,
        report,
        settings,
        check: OnceLock::new(),
        sums: OnceLock::new(),
    }))
}

fn method_in(name: &str, samples: Option<u32>, resolution: usize) -> PyResult<Method> {
    Ok(match name {
        "auto" => Method::Auto,
        "analytic" => Method::Analytic,
        "contour" => Method::Contour,
        "nusselt" => Method::Nusselt { points: samples.map(|n| n as usize) },
        "hemicube" => Method::Hemicube { resolution, positions: samples.map(|n| n as usize) },
        "hierarchical" => Method::Hierarchical,
        "monte_carlo" => Method::MonteCarlo { rays: samples.unwrap_or(4096) },
        _ => return Err(PyValueError::new_err(format!("there is no method '{name}'"))),
    })
}

#[pymethods]
impl Factors {
    /// The number of sides.
    fn __len__(&self) -> usize {
        self.unchecked().operator.len()
    }

    /// The patch of each side.
    #[getter]
    fn patch<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        let enclosure = &self.unchecked().enclosure;
        let patches: Vec<u32> = (0..enclosure.sides()).map(|s| enclosure.patch_of(s) as u32).collect();
        convert::vector_out(py, &patches)
    }

    /// `G x` for a block of columns, m2.
    fn exchange<'py>(&self, py: Python<'py>, x: PyReadonlyArray2<'py, f64>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let operator = &self.checked(py)?.operator;
        let columns = x.as_array().ncols();
        let x = convert::block_in(&x, operator.len(), columns, "x")?;
        let mut y = vec![0.0; x.len()];
        py.detach(|| operator.apply(&x, &mut y, columns));
        Ok(convert::block_out(py, y, columns))
    }

    /// The entries of row `i` of G: columns and values.
    fn row<'py>(&self, py: Python<'py>, i: usize) -> PyResult<Row<'py>> {
        let row = self.checked(py)?.operator.row(i);
        let columns: Vec<u32> = row.iter().map(|e| e.0).collect();
        let values: Vec<f64> = row.iter().map(|e| e.1).collect();
        Ok((convert::vector_out(py, &columns), convert::vector_out(py, &values)))
    }

    /// All of F as compressed rows.
    fn csr<'py>(&self, py: Python<'py>) -> PyResult<Csr<'py>> {
        let factors = self.checked(py)?;
        Ok(rows_of(py, || factors.operator.to_csr(), factors))
    }

    /// The number of factors above zero.
    fn count(&self, py: Python<'_>) -> PyResult<usize> {
        let factors = self.checked(py)?;
        Ok(py.detach(|| factors.operator.count()))
    }

    /// The standard errors of F as compressed rows, where rays found it.
    fn standard_error<'py>(&self, py: Python<'py>) -> PyResult<Option<Csr<'py>>> {
        let factors = self.checked(py)?;
        Ok(factors.standard_error.as_ref().map(|error| rows_of(py, || error.to_csr(), factors)))
    }

    /// F as a dense matrix.
    fn dense<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let factors = self.checked(py)?;
        let n = factors.operator.len();
        let values = py.detach(|| {
            let mut values = vec![0.0; n * n];
            let inverse: Vec<f64> = (0..n).map(|i| 1.0 / factors.enclosure.area(i)).collect();
            match factors.operator.pairs() {
                Some(pairs) => pairs.for_each_pair(|i, j, g| {
                    values[i * n + j] = g * inverse[i];
                    values[j * n + i] = g * inverse[j];
                }),
                None => {
                    factors.operator.expect_rows();
                    for (i, row) in values.chunks_exact_mut(n.max(1)).enumerate() {
                        factors.operator.row(i).into_iter().for_each(|(j, g)| row[j as usize] = g * inverse[i]);
                    }
                }
            }
            values
        });
        Ok(convert::block_out(py, values, n))
    }

    /// Writes them to a file that appears when it is whole, with a description.
    fn save(&self, py: Python<'_>, path: PathBuf, description: &str) -> PyResult<()> {
        let factors = self.checked(py)?;
        py.detach(|| stored::save(&path, description, factors)).map_err(errors::store)
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
        let inner = self.checked(py)?;
        let pairs = inner.pairs().map_err(|e| PyValueError::new_err(e.to_string()))?;
        let enclosure = &inner.enclosure;
        if wanted.len() != enclosure.sides() {
            return Err(PyValueError::new_err(format!("give one row sum for each of {} sides", enclosure.sides())));
        }
        let sums: Vec<f64> = wanted.iter().enumerate().map(|(i, w)| w * enclosure.area(i)).collect();
        let result = watch::run(py, threads, progress.as_ref(), |control| {
            let variance = inner.standard_error.as_ref().map(|error| error.mapped(|_, _, e| e * e));
            smoothing::with_row_sums(pairs, variance.as_ref(), &sums, control)
        })?;
        let (operator, left) = result.map_err(|c| errors::factors(c.into()))?;
        let factors = FormFactors {
            enclosure: enclosure.clone(),
            settings: stored::given(enclosure, &operator),
            operator: Exchange::Pairs(operator),
            standard_error: inner.standard_error.clone(),
            report: inner.report,
            check: OnceLock::new(),
            sums: OnceLock::new(),
        };
        Ok((Factors::in_memory(factors), left))
    }

    /// What was done and how wrong it may be.
    fn report<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let factors = self.unchecked();
        let (r, d) = (&factors.report, PyDict::new(py));
        d.set_item("estimated_error", r.estimated_error)?;
        d.set_item("disagreement", r.disagreement)?;
        d.set_item("samples", r.samples)?;
        d.set_item("pairs_in_full_view", r.tally.full)?;
        d.set_item("pairs_partly_hidden", r.tally.partial)?;
        d.set_item("pairs_hidden", r.tally.hidden)?;
        d.set_item("by_areas", r.tally.by_areas)?;
        d.set_item("by_contour", r.tally.by_contour)?;
        d.set_item("by_rays", r.tally.by_rays)?;
        d.set_item("links_in_full_view", r.links.clear)?;
        d.set_item("links_partly_hidden", r.links.sampled)?;
        d.set_item("rays", r.links.rays + r.tally.rays)?;
        d.set_item("unresolved", r.tally.unresolved)?;
        d.set_item("memory_bytes", factors.operator.memory_bytes())?;
        d.set_item("seconds", r.seconds)?;
        Ok(d)
    }

    /// Solves `B = E + rho F B` on these form factors as they are.
    #[pyo3(signature = (reflectance, emission, lamps, accuracy, seed, memory_limit, method, max_iterations=None,
                        threads=None, progress=None, on_iterate=None))]
    fn solve(
        &self,
        py: Python<'_>,
        reflectance: PyReadonlyArray2<'_, f64>,
        emission: PyReadonlyArray2<'_, f64>,
        lamps: Vec<LightTuple>,
        accuracy: f64,
        seed: u64,
        memory_limit: u64,
        method: &str,
        max_iterations: Option<usize>,
        threads: Option<usize>,
        progress: Option<Bound<'_, PyAny>>,
        on_iterate: Option<Bound<'_, PyAny>>,
    ) -> PyResult<Solution> {
        let settings = settings(accuracy, seed, 0, memory_limit, method, max_iterations, true)?;
        let factors = self.checked(py)?;
        let lighting = lighting_in(&factors.enclosure, reflectance, emission, lamps, None)?;
        let shape = (factors.enclosure.patches().len(), lighting.bands);
        let result = observed(py, threads, progress, on_iterate, shape, |observer, control| {
            radiosity_equilibrium::solve_given(factors, &lighting, &settings, observer, control)
        })?;
        Solution::new(result, lighting.bands)
    }
}

/// Compressed rows of G as those of F.
fn rows_of<'py>(
    py: Python<'py>,
    exchange: impl FnOnce() -> (Vec<usize>, Vec<u32>, Vec<f64>) + Send,
    factors: &FormFactors,
) -> Csr<'py> {
    let (offsets, columns, values) = py.detach(|| {
        let (offsets, columns, mut values) = exchange();
        for i in 0..factors.operator.len() {
            let inverse = 1.0 / factors.enclosure.area(i);
            values[offsets[i]..offsets[i + 1]].iter_mut().for_each(|v| *v *= inverse);
        }
        (offsets.iter().map(|&o| o as i64).collect::<Vec<_>>(), columns, values)
    });
    use numpy::IntoPyArray;
    (offsets.into_pyarray(py), columns.into_pyarray(py), values.into_pyarray(py))
}
