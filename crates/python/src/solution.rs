//! Solving and relighting.

use crate::patches::Enclosure;
use crate::scene::LightTuple;
use crate::{convert, errors, watch};
use numpy::{PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use radiosity_equilibrium::{Closure, Failure, Gradient, Lamp, Lighting, Method, Report, Settings, Source};
use radiosity_exchange::Luminaire;
use radiosity_operator::Control;
use radiosity_solvers::{Flow, Observer, Snapshot};

/// The equilibrium of light on an enclosure.
#[pyclass(frozen, module = "radiosity._native")]
pub struct Solution {
    inner: radiosity_equilibrium::Solution,
    bands: usize,
}

#[pymethods]
impl Solution {
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
        let enclosure = self.inner.source.enclosure();
        let range = enclosure.patches().len()..enclosure.sides();
        [&self.inner.irradiance, &self.inner.radiosity, &self.inner.error]
            .map(|values| convert::rows_out(py, values, range.clone(), self.bands))
    }

    /// Estimated standard error by cause: its name, of the fronts, of the backs.
    fn causes<'py>(&self, py: Python<'py>) -> Vec<(&'static str, [Bound<'py, PyArray2<f64>>; 2])> {
        let enclosure = self.inner.source.enclosure();
        let (fronts, sides) = (enclosure.patches().len(), enclosure.sides());
        let out = |values: &Vec<f64>| [0..fronts, fronts..sides].map(|r| convert::rows_out(py, values, r, self.bands));
        self.inner.causes.iter().map(|(cause, values)| (cause.name(), out(values))).collect()
    }

    /// (n_sides, 2): mean square of what the field through the patches' values leaves of the light, possibly negative
    /// by noise, and its standard deviation; without rows where it was not looked at.
    fn mesh<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let values = self.inner.mesh.iter().flat_map(|&(square, deviation)| [square, deviation]).collect();
        convert::block_out(py, values, 2)
    }

    /// What the solve says about itself.
    fn report<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        report_out(py, &self.inner.report)
    }

    /// Solves again on the same measured exchange with other emission, reflectance and lamp strengths.
    #[pyo3(signature = (reflectance, emission, lamps, accuracy, method, exact_closure, max_iterations=None,
                        threads=None, progress=None, as_field=false, diffuse_transmittance=None))]
    fn relight(
        &self,
        py: Python<'_>,
        reflectance: PyReadonlyArray2<'_, f64>,
        emission: PyReadonlyArray2<'_, f64>,
        lamps: Vec<LightTuple>,
        accuracy: f64,
        method: &str,
        exact_closure: bool,
        max_iterations: Option<usize>,
        threads: Option<usize>,
        progress: Option<Bound<'_, PyAny>>,
        as_field: bool,
        diffuse_transmittance: Option<PyReadonlyArray2<'_, f64>>,
    ) -> PyResult<Solution> {
        let settings = settings(accuracy, 0, 0, u64::MAX, method, max_iterations, exact_closure)?;
        let enclosure = self.inner.source.enclosure();
        let lighting = lighting_in(enclosure, reflectance, emission, lamps, diffuse_transmittance)?;
        relight(py, &self.inner.source, &lighting, &Settings { as_field, ..settings }, threads, progress)
    }

    /// Irradiance of sides with other emission, reflectance and lamp strengths, (n_sides, bands), as the exchange between
    /// whole sides has it; None unless that was sampled.
    #[pyo3(signature = (reflectance, emission, lamps, accuracy, method, threads=None, diffuse_transmittance=None))]
    fn on_sides<'py>(
        &self,
        py: Python<'py>,
        reflectance: PyReadonlyArray2<'_, f64>,
        emission: PyReadonlyArray2<'_, f64>,
        lamps: Vec<LightTuple>,
        accuracy: f64,
        method: &str,
        threads: Option<usize>,
        diffuse_transmittance: Option<PyReadonlyArray2<'_, f64>>,
    ) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        let settings = settings(accuracy, 0, 0, u64::MAX, method, None, false)?;
        let source = &self.inner.source;
        let lighting = lighting_in(source.enclosure(), reflectance, emission, lamps, diffuse_transmittance)?;
        let irradiance = watch::run(py, threads, None, |control| {
            radiosity_equilibrium::irradiance_on_sides(source, &lighting, &settings, control)
        })?;
        let irradiance = irradiance.map_err(errors::failure)?;
        Ok(irradiance.map(|values| convert::block_out(py, values, self.bands)))
    }

    /// Derivatives of sums of irradiance of fronts by emission, reflectance and strengths of lamps; sums one below
    /// another: weights (sums x n_patches, bands), answers (sums x n_patches or n_lamps, bands).
    #[pyo3(signature = (reflectance, emission, lamps, weights, threads=None, progress=None))]
    fn gradients<'py>(
        &self,
        py: Python<'py>,
        reflectance: PyReadonlyArray2<'_, f64>,
        emission: PyReadonlyArray2<'_, f64>,
        lamps: Vec<LightTuple>,
        weights: PyReadonlyArray2<'_, f64>,
        threads: Option<usize>,
        progress: Option<Bound<'_, PyAny>>,
    ) -> PyResult<[Bound<'py, PyArray2<f64>>; 3]> {
        let lighting = lighting_in(self.inner.source.enclosure(), reflectance, emission, lamps, None)?;
        let rows = self.inner.source.enclosure().patches().len();
        let sums = weights.as_array().nrows() / rows.max(1);
        let weights = convert::block_in(&weights, sums * rows, self.bands, "weights")?;
        let weights: Vec<Vec<f64>> =
            weights.chunks_exact((rows * self.bands).max(1)).take(sums).map(<[f64]>::to_vec).collect();
        let found = watch::run(py, threads, progress.as_ref(), |control| {
            radiosity_equilibrium::gradients(&self.inner, &lighting, &weights, control)
        })?;
        let found = found.map_err(errors::gradients)?;
        let block = |of: fn(&Gradient) -> &Vec<f64>| {
            convert::block_out(py, found.iter().flat_map(of).copied().collect(), self.bands)
        };
        Ok([block(|g| &g.emission), block(|g| &g.reflectance), block(|g| &g.lamps)])
    }
}

impl Solution {
    pub fn new(result: Result<radiosity_equilibrium::Solution, Failure>, bands: usize) -> PyResult<Self> {
        Ok(Self { inner: result.map_err(errors::failure)?, bands })
    }

    fn fronts<'py>(&self, py: Python<'py>, values: &[f64]) -> Bound<'py, PyArray2<f64>> {
        convert::rows_out(py, values, 0..self.inner.source.enclosure().patches().len(), self.bands)
    }
}

/// Solves to the accuracy asked for or says what kept it.
#[pyfunction]
#[pyo3(signature = (enclosure, reflectance, emission, lamps, accuracy, seed, max_rays, memory_limit, method,
                    exact_closure, max_iterations=None, threads=None, progress=None, as_field=false,
                    importance=None, diffuse_transmittance=None))]
pub fn solve(
    py: Python<'_>,
    enclosure: &Enclosure,
    reflectance: PyReadonlyArray2<'_, f64>,
    emission: PyReadonlyArray2<'_, f64>,
    lamps: Vec<LightTuple>,
    accuracy: f64,
    seed: u64,
    max_rays: u32,
    memory_limit: u64,
    method: &str,
    exact_closure: bool,
    max_iterations: Option<usize>,
    threads: Option<usize>,
    progress: Option<Bound<'_, PyAny>>,
    as_field: bool,
    importance: Option<PyReadonlyArray1<'_, f64>>,
    diffuse_transmittance: Option<PyReadonlyArray2<'_, f64>>,
) -> PyResult<Solution> {
    let importance = importance.map_or(Vec::new(), |array| array.as_array().to_vec());
    let settings = settings(accuracy, seed, max_rays, memory_limit, method, max_iterations, exact_closure)?;
    let settings = Settings { as_field, importance, ..settings };
    let lighting = lighting_in(&enclosure.inner, reflectance, emission, lamps, diffuse_transmittance)?;
    let enclosure = enclosure.inner.clone();
    let result = watch::run(py, threads, progress.as_ref(), |control| {
        radiosity_equilibrium::solve(enclosure, &lighting, &settings, control)
    })?;
    Solution::new(result, lighting.bands)
}

/// Solves by shooting, through rows that are found when they are asked for.
#[pyfunction]
#[pyo3(signature = (enclosure, reflectance, emission, lamps, accuracy, seed, memory_limit, method,
                    max_iterations=None, threads=None, progress=None, on_iterate=None))]
pub fn solve_on_demand(
    py: Python<'_>,
    enclosure: &Enclosure,
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
    let settings = settings(accuracy, seed, 0, memory_limit, method, max_iterations, false)?;
    if settings.method.overshoot().is_none() {
        return Err(PyValueError::new_err(format!("'{method}' needs products, and rows on demand have none")));
    }
    let lighting = lighting_in(&enclosure.inner, reflectance, emission, lamps, None)?;
    let fronts = enclosure.inner.patches().len();
    let result = observed(py, threads, progress, on_iterate, (fronts, lighting.bands), |observer, control| {
        radiosity_equilibrium::solve_on_demand(&enclosure.inner, &lighting, &settings, observer, control)
    })?;
    Solution::new(result, lighting.bands)
}

/// Solves on a hierarchical exchange that is made for this light.
#[pyfunction]
#[pyo3(signature = (enclosure, reflectance, emission, lamps, accuracy, seed, memory_limit, method,
                    max_iterations=None, threads=None, progress=None, on_iterate=None))]
pub fn solve_linked(
    py: Python<'_>,
    enclosure: &Enclosure,
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
    let settings = settings(accuracy, seed, 0, memory_limit, method, max_iterations, false)?;
    let lighting = lighting_in(&enclosure.inner, reflectance, emission, lamps, None)?;
    let fronts = enclosure.inner.patches().len();
    let result = observed(py, threads, progress, on_iterate, (fronts, lighting.bands), |observer, control| {
        radiosity_equilibrium::solve_linked(&enclosure.inner, &lighting, &settings, observer, control)
    })?;
    Solution::new(result, lighting.bands)
}

/// A snapshot on its way to the interpreter.
struct Passing {
    iteration: usize,
    residual: f64,
    unshot: Option<f64>,
    radiosity: Vec<f64>,
    ambient: Vec<f64>,
}

/// Runs a solve that shows its iterations to `on_iterate(iteration, residual, unshot, radiosity, ambient)`, radiosity of
/// so many fronts and bands. The solve waits for it, and ends if it returns `False`.
pub fn observed<T: Send>(
    py: Python<'_>,
    threads: Option<usize>,
    progress: Option<Bound<'_, PyAny>>,
    on_iterate: Option<Bound<'_, PyAny>>,
    (fronts, bands): (usize, usize),
    solve: impl FnOnce(Option<&Observer>, &Control) -> T + Send,
) -> PyResult<T> {
    let Some(callback) = on_iterate else {
        return watch::run(py, threads, progress.as_ref(), |control| solve(None, control));
    };
    let answer = |py: Python<'_>, s: Passing| {
        let radiosity = convert::block_out(py, s.radiosity, bands);
        let answer = callback.call1((s.iteration, s.residual, s.unshot, radiosity, s.ambient))?;
        Ok(!answer.is(&*pyo3::types::PyBool::new(py, false)))
    };
    watch::run_asking(py, threads, progress.as_ref(), answer, |control, desk| {
        let observer = |s: &Snapshot| {
            let (radiosity, ambient) = (s.radiosity[..fronts * bands].to_vec(), s.ambient.to_vec());
            let passing =
                Passing { iteration: s.iteration, residual: s.residual, unshot: s.unshot, radiosity, ambient };
            if desk.ask(passing) { Flow::Continue } else { Flow::Stop }
        };
        solve(Some(&observer), control)
    })
}

fn relight(
    py: Python<'_>,
    source: &Source,
    lighting: &Lighting,
    settings: &Settings,
    threads: Option<usize>,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<Solution> {
    let result = watch::run(py, threads, progress.as_ref(), |control| {
        radiosity_equilibrium::relight(source, lighting, settings, control)
    })?;
    Solution::new(result, lighting.bands)
}

pub fn lighting_in(
    enclosure: &radiosity_exchange::Enclosure,
    reflectance: PyReadonlyArray2<'_, f64>,
    emission: PyReadonlyArray2<'_, f64>,
    lamps: Vec<LightTuple>,
    diffuse_transmittance: Option<PyReadonlyArray2<'_, f64>>,
) -> PyResult<Lighting> {
    let (n, bands) = (enclosure.patches().len(), reflectance.as_array().ncols());
    let reflectance = convert::block_in(&reflectance, n, bands, "reflectance")?;
    let emission = convert::block_in(&emission, n, bands, "emission")?;
    let diffuse_transmittance = convert::through_in(diffuse_transmittance.as_ref(), n, bands)?;
    let finite = |v: &f64| v.is_finite() && *v >= 0.0;
    if let Some(k) = reflectance.iter().position(|r| !(0.0..1.0).contains(r)) {
        let (patch, value) = (k / bands, reflectance[k]);
        return Err(PyValueError::new_err(format!("patch {patch}: reflectance {value} is outside [0, 1)")));
    }
    if let Some(k) = emission.iter().position(|e| !finite(e)) {
        let (patch, value) = (k / bands, emission[k]);
        return Err(PyValueError::new_err(format!("patch {patch}: emission {value} is not a nonnegative number")));
    }
    let scattered = scattered(enclosure, &reflectance, &diffuse_transmittance, bands)?;
    check_diffuse_parts(enclosure, &scattered, &emission, bands)?;
    let lamps = lamps.into_iter().map(|l| lamp_in(l, bands)).collect::<PyResult<_>>()?;
    Ok(Lighting { bands, reflectance, emission, lamps, diffuse_transmittance })
}

/// What patches send back and on together; light passes through those that have a back only.
fn scattered(
    enclosure: &radiosity_exchange::Enclosure,
    reflectance: &[f64],
    through: &[f64],
    bands: usize,
) -> PyResult<Vec<f64>> {
    let passing = through.iter().chain(std::iter::repeat(&0.0));
    let scattered: Vec<f64> = reflectance.iter().zip(passing).map(|(rho, tau)| rho + tau).collect();
    if let Some(k) = scattered.iter().position(|r| *r >= 1.0) {
        return Err(PyValueError::new_err(format!(
            "patch {}: reflectance {} and diffuse transmittance {} must together stay below 1",
            k / bands,
            reflectance[k],
            through[k]
        )));
    }
    let two_sided = &enclosure.patches().two_sided;
    match (0..through.len()).find(|&k| through[k] > 0.0 && !two_sided[k / bands]) {
        None => Ok(scattered),
        Some(k) => Err(PyValueError::new_err(format!(
            "patch {}: light passes through it diffusely, and it has no back: make it two-sided",
            k / bands
        ))),
    }
}

/// Paint and light of patches that are mirrors or let light through, of which only a part is diffuse.
fn check_diffuse_parts(
    enclosure: &radiosity_exchange::Enclosure,
    reflectance: &[f64],
    emission: &[f64],
    bands: usize,
) -> PyResult<()> {
    let Some(specular) = enclosure.specular() else { return Ok(()) };
    for (k, (rho, emission)) in reflectance.iter().zip(emission).enumerate() {
        let (patch, share) = (k / bands, specular.diffuse_share(k / bands));
        let what = match share {
            1.0 => continue,
            share if *rho > 0.0 && *rho >= share => format!("reflectance {rho} must stay below {share:.6}"),
            0.0 if *emission > 0.0 => format!("emission {emission} must be 0"),
            _ => continue,
        };
        return Err(PyValueError::new_err(format!(
            "patch {patch}: its {what}, which is what its mirror reflectance and transmittance leave of it"
        )));
    }
    Ok(())
}

pub fn lamp_in((kind, name, position, direction, inner, outer, strength): LightTuple, bands: usize) -> PyResult<Lamp> {
    if strength.len() != bands || strength.iter().any(|s| !s.is_finite() || *s < 0.0) {
        return Err(PyValueError::new_err(format!("light '{name}' must have {bands} nonnegative strengths")));
    }
    let (position, direction) = (convert::vec3(position), convert::vec3(direction).normalize_or_zero());
    let luminaire = match kind.as_str() {
        "point" => Luminaire::Point { position },
        "spot" => Luminaire::Spot { position, direction, cos_inner: inner.cos(), cos_outer: outer.cos() },
        "directional" => Luminaire::Directional { direction },
        _ => return Err(PyValueError::new_err(format!("there is no light of kind '{kind}'"))),
    };
    Ok(Lamp { luminaire, strength })
}

pub fn settings(
    accuracy: f64,
    seed: u64,
    max_rays: u32,
    memory_limit: u64,
    method: &str,
    max_iterations: Option<usize>,
    exact_closure: bool,
) -> PyResult<Settings> {
    if !(accuracy > 0.0 && accuracy.is_finite()) {
        return Err(PyValueError::new_err(format!("accuracy must be a positive number such as 0.01, not {accuracy}")));
    }
    let method = Method::from_name(method).ok_or_else(|| {
        let known = Method::ALL.map(Method::name).join(", ");
        PyValueError::new_err(format!("there is no solver '{method}'; choose one of {known}"))
    })?;
    let closure = if exact_closure { Closure::Exact } else { Closure::Balanced };
    Ok(Settings { accuracy, seed, max_rays, memory_limit, method, max_iterations, closure, ..Settings::default() })
}

pub fn report_out<'py>(py: Python<'py>, r: &Report) -> PyResult<Bound<'py, PyDict>> {
    let d = PyDict::new(py);
    d.set_item("accuracy", r.accuracy)?;
    d.set_item("estimated_error", r.estimated_error)?;
    d.set_item("interval", r.interval)?;
    d.set_item("of_field", r.of_field)?;
    d.set_item("mesh_error", r.mesh_error)?;
    let causes = PyDict::new(py);
    for (cause, error) in &r.causes {
        causes.set_item(cause.name(), error)?;
    }
    d.set_item("causes", causes)?;
    d.set_item("sampling_error", r.sampling_error)?;
    d.set_item("discretisation_error", r.discretisation_error)?;
    d.set_item("limited_by", r.limited_by.map(|l| l.name()))?;
    d.set_item("patches", r.patches)?;
    d.set_item("sides", r.sides)?;
    d.set_item("luminaires", r.luminaires)?;
    d.set_item("rays", r.rays)?;
    d.set_item("shadow_rays", r.shadow_rays)?;
    d.set_item("rounds", r.rounds)?;
    d.set_item("rows_on_demand", r.rows_on_demand)?;
    d.set_item("hemicubes", r.hemicubes)?;
    d.set_item("solver", r.solver.name)?;
    d.set_item("iterations", r.solver.iterations)?;
    d.set_item("products", r.solver.products)?;
    d.set_item("residual", r.solver.residual)?;
    d.set_item("converged", r.solver.converged)?;
    d.set_item("stop", r.solver.stop)?;
    d.set_item("history_iterations", r.solver.history.iterations.clone())?;
    d.set_item("residual_history", r.solver.history.residuals.clone())?;
    d.set_item("unshot_history", r.solver.history.unshot.clone())?;
    d.set_item("emitted", r.energy.emitted.clone())?;
    d.set_item("from_lights", r.energy.from_lights.clone())?;
    d.set_item("absorbed", r.energy.absorbed.clone())?;
    d.set_item("absorbed_by_mirrors", r.energy.absorbed_by_mirrors.clone())?;
    d.set_item("unfollowed", r.energy.unfollowed.clone())?;
    d.set_item("escaped", r.energy.escaped.clone())?;
    d.set_item("lost_on_backs", r.energy.lost_on_backs.clone())?;
    d.set_item("imbalance", r.energy.imbalance)?;
    d.set_item("closure_min", r.closure.0)?;
    d.set_item("closure_mean", r.closure.1)?;
    d.set_item("closure_max", r.closure.2)?;
    d.set_item("escape_share", r.energy.escape_share)?;
    d.set_item("closure_residual", r.closure_residual)?;
    d.set_item("memory_bytes", r.memory_bytes)?;
    d.set_item("sampling_seconds", r.seconds.sampling)?;
    d.set_item("solving_seconds", r.seconds.solving)?;
    d.set_item("seconds", r.seconds.total)?;
    Ok(d)
}
