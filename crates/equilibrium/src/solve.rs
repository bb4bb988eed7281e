//! The loop that raises the sampling until the estimated error meets the request.

use crate::answer::{Answer, CELLS, Task, ratio};
use crate::error::{Estimate, estimate, relative_rms};
use crate::given::relight_given;
use crate::incident::Incident;
use crate::lighting::Lighting;
use crate::method::Method;
use crate::on_demand::solve_on_rows;
use crate::plan::{Kind, plan};
use crate::report::{Cause, Limit, Report, Seconds, SolverReport};
use crate::transport::Transport;
use radiosity_exchange::operator::ElementExchange;
use radiosity_exchange::specular::NotFollowed;
use radiosity_exchange::{Elements, Enclosure, FormFactors, RowsOnDemand};
use radiosity_operator::{Cancelled, Control};
use radiosity_solvers::{SolveOptions, Stop};
use std::sync::Arc;
use std::time::Instant;

/// What to do about row sums that sampling left off their known values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Closure {
    /// Scale rows and columns alike until rows sum to the share of rays that land, to within the accuracy asked for.
    Balanced,
    /// The same to 1e-9.
    Exact,
}

/// What is asked of a solve.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Wanted error of irradiance: root mean square over area and bands, relative to the mean.
    pub accuracy: f64,
    /// The same seed gives the same bytes.
    pub seed: u64,
    /// Most rays per side, all replicates together.
    pub max_rays: u32,
    /// Bytes the samples and the operator may take; a plan that needs more is not begun.
    pub memory_limit: u64,
    /// The solver.
    pub method: Method,
    /// Most iterations of the solver, if not as many as it may need.
    pub max_iterations: Option<usize>,
    /// The treatment of row sums.
    pub closure: Closure,
    /// Whether the answer is wanted as a field over patches. Then the error has a part of the mesh, which samples cannot
    /// reduce, and `accuracy` is for the rest.
    pub as_field: bool,
    /// How much the square of an error on each patch matters; nothing for all the same. It weighs errors where they are
    /// summed up, and so where samples go.
    pub importance: Vec<f64>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            accuracy: 0.01,
            seed: 0,
            max_rays: 1 << 18,
            memory_limit: u64::MAX,
            method: Method::ConjugateGradient,
            max_iterations: None,
            closure: Closure::Balanced,
            as_field: false,
            importance: Vec::new(),
        }
    }
}

impl Settings {
    /// Iterations of the solver on so many elements.
    pub(crate) fn most_iterations(&self, elements: usize) -> usize {
        self.max_iterations.unwrap_or_else(|| self.method.most_iterations(elements))
    }
}

/// Why there is no solution.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Failure {
    /// Stopped on request.
    #[error("stopped on request")]
    Cancelled,
    /// Even the first round does not fit.
    #[error(
        "{patches} patches need at least {:.1} MB for samples and the limit is {:.1} MB; raise the limit or use fewer patches",
        *needed as f64 / 1e6, *limit as f64 / 1e6
    )]
    Memory {
        /// Patches asked for.
        patches: usize,
        /// Bytes needed.
        needed: u64,
        /// Bytes allowed.
        limit: u64,
    },
    /// There are mirrors or clear glass, and what was asked for cannot follow them.
    #[error(transparent)]
    Specular(#[from] NotFollowed),
    /// Light passes through patches diffusely, and what was asked for takes them for opaque.
    #[error("patch {patch} lets light through diffusely, which {way} cannot follow: solve on samples")]
    Translucent {
        /// What was asked for.
        way: &'static str,
        /// The first of those.
        patch: usize,
    },
}

impl From<Cancelled> for Failure {
    fn from(_: Cancelled) -> Self {
        Failure::Cancelled
    }
}

/// The equilibrium of light. Blocks are sides x bands: fronts of all patches, then backs of the two-sided ones.
pub struct Solution {
    /// W/m2.
    pub irradiance: Vec<f64>,
    /// W/m2.
    pub radiosity: Vec<f64>,
    /// Estimated standard error of irradiance, W/m2.
    pub error: Vec<f64>,
    /// The same by cause, as far as told apart.
    pub causes: Vec<(Cause, Vec<f64>)>,
    /// Per side, where the light was compared with the field through the patches' values: the mean square of the
    /// difference, without bias and so possibly negative, and its standard deviation, (W/m2)^2.
    pub mesh: Vec<(f64, f64)>,
    /// What the solve says about itself.
    pub report: Report,
    /// What it was solved on, for another lighting of the same geometry.
    pub source: Source,
}

/// What a solution was solved on.
#[derive(Clone)]
pub enum Source {
    /// Samples taken to an accuracy.
    Measured(Arc<Measurement>),
    /// Form factors, as they were given, and what lights without area put on sides.
    Given(Arc<FormFactors>, Arc<Incident>),
    /// Rows found as they were asked for.
    OnDemand(Arc<RowsOnDemand>),
}

impl Source {
    /// The geometry.
    pub fn enclosure(&self) -> &Arc<Enclosure> {
        match self {
            Source::Measured(measurement) => measurement.transport.enclosure(),
            Source::Given(factors, _) => &factors.enclosure,
            Source::OnDemand(rows) => rows.enclosure(),
        }
    }
}

/// Samples with the operator they add up to.
pub struct Measurement {
    /// The samples.
    pub transport: Transport,
    /// The operator on whole sides.
    pub exchange: ElementExchange,
    /// The operator is built from one sample in this many.
    pub thinning: u32,
}

impl Measurement {
    /// Builds the operator of a share of the samples, rows scaled to their known sums.
    fn balanced(transport: Transport, lighting: &Lighting, settings: &Settings) -> Self {
        // What rows lack is lost at every bounce: it counts 1 / (1 - rho) times.
        let tolerance = match settings.closure {
            Closure::Balanced => 0.1 * settings.accuracy.min(0.1) * (1.0 - lighting.highest_reflectance()),
            Closure::Exact => 1e-9,
        };
        let balance = (tolerance, MOST_BALANCINGS);
        let exchange = transport.on(&Elements::whole(transport.enclosure()), THINNING, Some(balance));
        Self { transport, exchange, thinning: THINNING }
    }
}

/// Independent replicates: enough for an estimate of the error, few enough that each is long.
pub(crate) const REPLICATES: usize = 4;

/// The operator is built from one ray in this many: the noise it leaves in the radiosity of single sides averages out
/// in the gather, which uses all rays, and the error estimate accounts for it.
const THINNING: u32 = 4;

/// Symmetric scaling converges within tens of iterations on rooms; two facing plates take more.
const MOST_BALANCINGS: usize = 500;

/// Far beyond what reflectances below 0.999 need.
pub(crate) const MOST_ITERATIONS: usize = 100_000;

/// A round multiplies the samples of a side by at most this.
const GROWTH: u32 = 32;

/// Bytes per sample while an operator is built: the sample, and of the thinned ones the pair and its two entries.
const BYTES_PER_RAY: u64 = 8 + (12 + 16) / THINNING as u64;
const BYTES_PER_LIGHT_SAMPLE: u64 = 12 + (12 + 16) / THINNING as u64;

/// Solves to the accuracy asked for, or as near as the limits allow; the report says which.
pub fn solve(
    enclosure: Arc<Enclosure>,
    lighting: &Lighting,
    settings: &Settings,
    control: &Control,
) -> Result<Solution, Failure> {
    let start = Instant::now();
    let sides = enclosure.sides();
    let luminaires = lighting.luminaires(&enclosure);
    let (whole, lighting) = (lighting, &*lighting.of_diffuse_parts(&enclosure));
    let has_luminaires = !luminaires.list.is_empty();
    let mut transport = Transport::new(enclosure, luminaires, REPLICATES, settings.seed);
    let most = settings.max_rays.div_ceil(REPLICATES as u32);
    let (rays, lights) = first_round(settings);
    let lights = if has_luminaires { lights.min(most) } else { 0 };
    let mut wanted = (vec![rays.min(most); sides], vec![lights; sides]);
    let needed = forecast(&wanted.0, &wanted.1);
    if needed > settings.memory_limit {
        let patches = transport.enclosure().patches().len();
        return Err(Failure::Memory { patches, needed, limit: settings.memory_limit });
    }
    let mut seconds = Seconds::default();
    for rounds in 1.. {
        let before = Instant::now();
        announce(&transport, &wanted, control);
        transport.refine(&wanted.0, &wanted.1, control)?;
        seconds.sampling += before.elapsed().as_secs_f64();
        let before = Instant::now();
        let measurement = Measurement::balanced(transport, lighting, settings);
        let task = task(&measurement, lighting, settings, control);
        let answer = task.answer()?;
        let estimate = estimate(&task, &answer)?;
        seconds.solving += before.elapsed().as_secs_f64();
        let step = match answer.solver.stop {
            Stop::Converged => next(&task, &estimate, settings, most),
            _ => Step::Stop(Limit::Solver),
        };
        match step {
            Step::Sample(rays, lights) => wanted = (rays, lights),
            Step::Stop(limit) => {
                seconds.total = start.elapsed().as_secs_f64();
                let report = Report { rounds, seconds, ..report(&task, &answer, &estimate, settings, limit) };
                let radiosity = task.radiosity(whole, &answer.irradiance);
                return Ok(solution(answer, radiosity, estimate, report, Arc::new(measurement)));
            }
        }
        transport = measurement.transport;
    }
    unreachable!("the loop ends by returning")
}

/// Solves again on what a solution was solved on: same geometry, other lamps or paint.
pub fn relight(
    source: &Source,
    lighting: &Lighting,
    settings: &Settings,
    control: &Control,
) -> Result<Solution, Failure> {
    let measurement = match source {
        Source::Measured(measurement) => measurement,
        Source::Given(factors, incident) => return relight_given(factors, incident, lighting, settings, control),
        Source::OnDemand(rows) => return solve_on_rows(rows.clone(), lighting, settings, None, control),
    };
    let start = Instant::now();
    let (whole, lighting) = (lighting, &*lighting.of_diffuse_parts(measurement.transport.enclosure()));
    let task = task(measurement, lighting, settings, control);
    let answer = task.answer()?;
    let estimate = estimate(&task, &answer)?;
    let limit = match answer.solver.stop {
        Stop::Converged if estimate.relative_but_mesh <= settings.accuracy => Limit::Accuracy,
        Stop::Converged => Limit::Samples,
        _ => Limit::Solver,
    };
    let total = start.elapsed().as_secs_f64();
    let seconds = Seconds { sampling: 0.0, solving: total, total };
    let report = Report { seconds, ..report(&task, &answer, &estimate, settings, limit) };
    let radiosity = task.radiosity(whole, &answer.irradiance);
    Ok(solution(answer, radiosity, estimate, report, measurement.clone()))
}

/// Irradiance with other lamps or paint as the exchange between whole sides has it, sides x bands; none if it was not
/// sampled.
///
/// It takes a few products. The difference of two of these is nearly that of two relights: what elements, the gather and
/// the noise of the operator change is much the same in both.
pub fn irradiance_on_sides(
    source: &Source,
    lighting: &Lighting,
    settings: &Settings,
    control: &Control,
) -> Result<Option<Vec<f64>>, Failure> {
    let Source::Measured(measurement) = source else { return Ok(None) };
    let lighting = &*lighting.of_diffuse_parts(measurement.transport.enclosure());
    Ok(Some(task(measurement, lighting, settings, control).on_sides()?))
}

fn solution(
    answer: Answer,
    radiosity: Vec<f64>,
    estimate: Estimate,
    report: Report,
    measurement: Arc<Measurement>,
) -> Solution {
    Solution {
        irradiance: answer.irradiance,
        radiosity,
        error: estimate.standard_error,
        causes: estimate.causes,
        mesh: estimate.mesh.into_iter().zip(estimate.mesh_noise.into_iter().map(f64::sqrt)).collect(),
        report,
        source: Source::Measured(measurement),
    }
}

/// Rays and light samples per replicate to begin with: few enough to be surpassed, enough to plan by.
fn first_round(settings: &Settings) -> (u32, u32) {
    match settings {
        // One in each cell.
        Settings { as_field: true, .. } => (CELLS as u32, CELLS as u32),
        Settings { accuracy, .. } if *accuracy >= 0.05 => (8, 4),
        _ => (16, 8),
    }
}

fn forecast(rays: &[u32], lights: &[u32]) -> u64 {
    let total = |counts: &[u32]| counts.iter().map(|&n| u64::from(n)).sum::<u64>() * REPLICATES as u64;
    total(rays) * BYTES_PER_RAY + total(lights) * BYTES_PER_LIGHT_SAMPLE
}

fn announce(transport: &Transport, wanted: &(Vec<u32>, Vec<u32>), control: &Control) {
    let new = |wanted: &[u32], drawn: &dyn Fn(usize) -> u32| -> u64 {
        wanted.iter().enumerate().map(|(i, &n)| u64::from(n.saturating_sub(drawn(i)))).sum()
    };
    let rays = new(&wanted.0, &|i| transport.shots().per_replicate(i));
    let lights = new(&wanted.1, &|i| transport.lights().per_replicate(i));
    control.expect((rays + lights) * REPLICATES as u64);
}

fn task<'a>(
    measurement: &'a Measurement,
    lighting: &'a Lighting,
    settings: &'a Settings,
    control: &'a Control,
) -> Task<'a> {
    // The error of B is at most the residual over 1 - rho.
    let highest = lighting.highest_reflectance();
    let tolerance = match settings.closure {
        Closure::Balanced => 0.02 * settings.accuracy.min(0.1) * (1.0 - highest),
        Closure::Exact => 1e-9 * (1.0 - highest),
    };
    let solver = settings.method.solver();
    let max_iterations = settings.most_iterations(measurement.transport.enclosure().sides());
    let options = SolveOptions { tolerance, max_iterations, observer: None };
    let importance = &settings.importance;
    Task { measurement, lighting, solver, options, as_field: settings.as_field, importance, control }
}

enum Step {
    Sample(Vec<u32>, Vec<u32>),
    Stop(Limit),
}

fn next(task: &Task, estimate: &Estimate, settings: &Settings, most: u32) -> Step {
    let transport = &task.measurement.transport;
    if estimate.relative_but_mesh <= settings.accuracy || estimate.mean_irradiance == 0.0 {
        return Step::Stop(Limit::Accuracy);
    }
    // Leave sampling what elements do not take; if they take nearly all, more rays are wasted.
    // Many more rays will resolve elements of half the size.
    let finer = if estimate.relative_sampling > 2.0 * settings.accuracy { 0.5 } else { 1.0 };
    let fixed = estimate.relative_elements;
    // The bound, which is what must meet the accuracy, is above what is likely.
    let accuracy = settings.accuracy * ratio(estimate.likely_but_mesh, estimate.relative_but_mesh);
    let allowed = accuracy.powi(2) - (finer * fixed).powi(2);
    let patch_size = allowed < 0.25 * accuracy.powi(2);
    if patch_size && estimate.relative_sampling <= 0.5 * accuracy {
        return Step::Stop(Limit::PatchSize);
    }
    // Power that is not accounted for is noise too, and falls along with the rest; if it stays, it is not.
    let unexplained = estimate.energy.imbalance.abs();
    if unexplained > 0.8 * accuracy && estimate.relative_sampling <= 0.2 * accuracy {
        return Step::Stop(Limit::PatchSize);
    }
    let expected = unexplained * ratio(accuracy, estimate.relative_sampling).min(1.0);
    let allowed = (allowed - expected.powi(2)).max(0.2 * accuracy.powi(2));
    let enclosure = transport.enclosure();
    let total: f64 = (0..enclosure.sides()).map(|s| task.weight(s)).sum();
    let share: Vec<f64> = (0..enclosure.sides()).map(|s| task.weight(s) / total).collect();
    // What interreflection adds to the noise falls along with its source.
    let own: f64 = (0..share.len()).map(|s| share[s] * (estimate.ray_variance[s] + estimate.light_variance[s])).sum();
    let all = (estimate.relative_sampling * estimate.mean_irradiance).powi(2);
    let target = allowed * estimate.mean_irradiance.powi(2) * share_of_own(own, all, settings.as_field);
    let counts = |samples: &dyn Fn(usize) -> u32| (0..share.len()).map(samples).collect::<Vec<u32>>();
    let kinds = [
        Kind {
            drawn: counts(&|s| transport.shots().per_replicate(s)),
            variance: &estimate.ray_variance,
            range: (1, most),
        },
        Kind {
            drawn: counts(&|s| transport.lights().per_replicate(s)),
            variance: &estimate.light_variance,
            range: (0, most),
        },
    ];
    let groups: Vec<u32> = (0..share.len()).map(|s| enclosure.patches().surface[enclosure.patch_of(s)]).collect();
    let mut wanted = plan(&kinds, &share, &groups, target, GROWTH);
    let lights = wanted.pop().unwrap_or_default();
    let rays = wanted.pop().unwrap_or_default();
    if rays == kinds[0].drawn && lights == kinds[1].drawn {
        let exhausted = rays.iter().chain(&lights).any(|&n| n >= most);
        return if exhausted {
            Step::Stop(Limit::Rays)
        } else {
            Step::Sample(doubled(&rays, most), doubled(&lights, most))
        };
    }
    if forecast(&rays, &lights) > settings.memory_limit {
        return Step::Stop(Limit::Memory);
    }
    Step::Sample(rays, lights)
}

/// What part of the allowed variance the samples' own may take. A field averages over neighbours, so that it may be more
/// than all of it.
fn share_of_own(own: f64, all: f64, as_field: bool) -> f64 {
    ratio(own, all).min(if as_field { 4.0 } else { 1.0 })
}

fn doubled(counts: &[u32], most: u32) -> Vec<u32> {
    counts.iter().map(|&n| (2 * n).min(most)).collect()
}

fn report(task: &Task, answer: &Answer, estimate: &Estimate, settings: &Settings, limit: Limit) -> Report {
    let Measurement { transport, exchange, .. } = task.measurement;
    let enclosure = transport.enclosure();
    Report {
        accuracy: settings.accuracy,
        limited_by: Some(limit),
        estimated_error: estimate.interval.1,
        interval: estimate.interval,
        of_field: settings.as_field,
        mesh_error: estimate.mesh_bound,
        causes: whole(task, answer, estimate),
        sampling_error: estimate.relative_sampling,
        discretisation_error: estimate.relative_elements,
        patches: enclosure.patches().len(),
        sides: enclosure.sides(),
        luminaires: transport.luminaires().len(),
        rays: transport.shots().total() as u64,
        shadow_rays: transport.lights().total() as u64,
        rows_on_demand: 0,
        hemicubes: 0,
        rounds: 0,
        solver: SolverReport::of(settings.method, answer.solver.clone()),
        energy: estimate.energy.clone(),
        closure: closure(&exchange.raw_closure, &exchange.exposed_area),
        closure_residual: exchange.imbalance,
        memory_bytes: enclosure.memory_bytes() + transport.memory_bytes() + exchange.operator.memory_bytes(),
        seconds: Seconds::default(),
    }
}

/// Errors by cause as root mean squares over the scene relative to the mean irradiance.
fn whole(task: &Task, answer: &Answer, estimate: &Estimate) -> Vec<(Cause, f64)> {
    let enclosure = task.measurement.transport.enclosure();
    let relative = |(cause, error): &(Cause, Vec<f64>)| match cause {
        // Single patches leave out what is negative by noise; the whole does not.
        Cause::Mesh => (*cause, estimate.relative_mesh),
        _ => (*cause, relative_rms(enclosure, &answer.irradiance, task.lighting.bands, |k| error[k])),
    };
    estimate.causes.iter().map(relative).collect()
}

/// The least, the mean by area and the greatest of row sums.
pub(crate) fn closure(sums: &[f64], areas: &[f64]) -> (f64, f64, f64) {
    let (mut least, mut most, mut sum, mut area) = (f64::INFINITY, 0.0f64, 0.0, 0.0);
    for (closure, a) in sums.iter().zip(areas).filter(|(_, a)| **a > 0.0) {
        least = least.min(*closure);
        most = most.max(*closure);
        sum += closure * a;
        area += a;
    }
    (if area > 0.0 { least } else { 0.0 }, ratio(sum, area), most)
}
