//! What a solve says about itself.

use crate::energy::Energy;
use crate::method::Method;
use radiosity_solvers::{History, SolveReport, Stop};

/// What kept an answer from being more accurate than it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limit {
    /// Nothing: the accuracy asked for is reached.
    Accuracy,
    /// The most rays per patch were spent.
    Rays,
    /// Light varies within patches more than their elements resolve: a finer mesh is needed.
    PatchSize,
    /// The exchange is as exact as blocks of rank one are worth building.
    Tolerance,
    /// More samples would not fit the memory limit.
    Memory,
    /// The time was up.
    Time,
    /// The samples were given; none were added.
    Samples,
    /// The solver did not converge.
    Solver,
    /// Rows found on demand are not accurate enough with the most hemicubes a side.
    Hemicubes,
}

impl Limit {
    /// A word for tables and files.
    pub fn name(&self) -> &'static str {
        match self {
            Limit::Accuracy => "accuracy",
            Limit::Rays => "max_rays",
            Limit::PatchSize => "patch_size",
            Limit::Tolerance => "tolerance",
            Limit::Memory => "memory",
            Limit::Time => "time",
            Limit::Samples => "samples",
            Limit::Solver => "solver",
            Limit::Hemicubes => "hemicubes",
        }
    }
}

/// Where an error comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// Too few samples of what a patch sees, visibility included.
    Sampling,
    /// The noise of other patches, which arrives as their light does.
    Interreflection,
    /// Light that varies over patches was sent on as if it varied less.
    Transport,
    /// Power that the balance does not explain, and what the solver left.
    Balance,
    /// Light that varies over patches otherwise than the field through their values.
    Mesh,
}

impl Cause {
    /// A word for tables and files.
    pub fn name(&self) -> &'static str {
        match self {
            Cause::Sampling => "sampling",
            Cause::Interreflection => "interreflection",
            Cause::Transport => "transport",
            Cause::Balance => "balance",
            Cause::Mesh => "mesh",
        }
    }
}

/// Energy, closure, error, effort. Powers are W per band.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// The accuracy asked for.
    pub accuracy: f64,
    /// Error of irradiance, root mean square over area and bands, relative to the mean: the upper end of the interval.
    pub estimated_error: f64,
    /// What holds it nine times in ten.
    pub interval: (f64, f64),
    /// Whether it is of the field between the patches' values too, or of their means only.
    pub of_field: bool,
    /// What the piecewise linear field through the patches' values leaves of the light, counted or not: the upper end
    /// of an interval that holds it nine times in ten.
    pub mesh_error: f64,
    /// Error by cause, as far as told apart: root mean square over area and bands, relative to the mean.
    pub causes: Vec<(Cause, f64)>,
    /// The part of the error that more rays would reduce.
    pub sampling_error: f64,
    /// The part of the error that smaller patches would reduce.
    pub discretisation_error: f64,
    /// What limited the accuracy.
    pub limited_by: Option<Limit>,
    /// Patches.
    pub patches: usize,
    /// Sides: one a patch, two where it is two-sided.
    pub sides: usize,
    /// What was sampled by area.
    pub luminaires: usize,
    /// Rays shot for rows.
    pub rays: u64,
    /// Visibility tests of luminaires.
    pub shadow_rays: u64,
    /// Rows that were found on demand.
    pub rows_on_demand: u64,
    /// Hemicubes drawn for them.
    pub hemicubes: u64,
    /// Rounds of sampling.
    pub rounds: usize,
    /// The last solve.
    pub solver: SolverReport,
    /// Where the power went.
    pub energy: Energy,
    /// Least, mean (by area) and greatest raw row sum of the form factors.
    pub closure: (f64, f64, f64),
    /// The worst relative deviation of row sums from their targets after balancing.
    pub closure_residual: f64,
    /// Bytes held by geometry, samples and operator at the end.
    pub memory_bytes: usize,
    /// Wall time by stage.
    pub seconds: Seconds,
}

/// Wall time by stage.
#[derive(Clone, Copy, Debug, Default)]
pub struct Seconds {
    /// Shooting and light sampling.
    pub sampling: f64,
    /// Building operators, solving, gathering, estimating.
    pub solving: f64,
    /// All of it.
    pub total: f64,
}

/// How the equations were solved.
#[derive(Clone, Debug, Default)]
pub struct SolverReport {
    /// By what.
    pub name: &'static str,
    /// Products with the exchange, sweeps or shots.
    pub iterations: usize,
    /// Work in products.
    pub products: f64,
    /// Relative residual at the end.
    pub residual: f64,
    /// A word for why it stopped.
    pub stop: &'static str,
    /// Whether that was because it converged.
    pub converged: bool,
    /// How it got there.
    pub history: History,
}

impl SolverReport {
    pub(crate) fn of(method: Method, report: SolveReport) -> Self {
        Self {
            name: method.name(),
            iterations: report.iterations,
            products: report.products,
            residual: report.residual,
            stop: report.stop.name(),
            converged: report.stop == Stop::Converged,
            history: report.history,
        }
    }
}
