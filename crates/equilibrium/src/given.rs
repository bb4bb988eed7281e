//! Solving on form factors that are given: `B = E + rho F B` exactly as they are, side by side.
//!
//! The error of the answer is what the errors of the form factors make of it. Where rays found them, each has a standard
//! error and what a side receives has the root of the sum of squares. Where they were found to a tolerance, a row is
//! off by that much of what it sees. Both go through the interreflections as light does, all in one direction.

use crate::answer::{Solver, ratio};
use crate::energy::Energy;
use crate::incident::{Incident, LIGHT_SAMPLES};
use crate::lighting::Lighting;
use crate::report::{Limit, Report, Seconds, SolverReport};
use crate::solve::{Failure, MOST_ITERATIONS, REPLICATES, Settings, Solution, Source, closure};
use radiosity_exchange::FormFactors;
use radiosity_operator::{Cancelled, Control, Operator};
use radiosity_solvers::{Observer, Problem, SolveOptions, SolveReport, Stop, conjugate_gradient};
use std::sync::Arc;
use std::time::Instant;

/// Solves the equations on given form factors to 1e-9. The observer sees every iteration.
pub fn solve_given(
    factors: &Arc<FormFactors>,
    lighting: &Lighting,
    settings: &Settings,
    observer: Option<&Observer>,
    control: &Control,
) -> Result<Solution, Failure> {
    let start = Instant::now();
    let needed = forecast(factors, lighting);
    if needed > settings.memory_limit {
        let patches = factors.enclosure.patches().len();
        return Err(Failure::Memory { patches, needed, limit: settings.memory_limit });
    }
    let task = Task::new(factors, lighting, settings, control)?;
    let method = settings.method;
    let options = SolveOptions { observer, ..task.options() };
    let (radiosity, solver) = task.solve(method.solver(), &task.emission, &task.incident.mean, &options)?;
    let irradiance = task.irradiance(&radiosity, &task.incident.mean);
    let error = task.error(&radiosity, &irradiance)?;
    let energy = task.energy(&radiosity, &irradiance);
    let (mut squares, mut level, mut whole) = (0.0, 0.0, 0.0);
    for (k, h) in irradiance.iter().enumerate() {
        let area = task.area[k / lighting.bands];
        squares += area * error[k] * error[k];
        level += area * h;
        whole += area;
    }
    let estimated_error = ratio((squares * whole).sqrt(), level);
    let sums: Vec<f64> = factors.operator.row_sums().iter().zip(&task.area).map(|(s, a)| ratio(*s, *a)).collect();
    let total = start.elapsed().as_secs_f64();
    let report = Report {
        accuracy: settings.accuracy,
        estimated_error,
        sampling_error: estimated_error,
        limited_by: Some(match solver.stop {
            Stop::Converged if estimated_error <= settings.accuracy => Limit::Accuracy,
            Stop::Converged => Limit::Samples,
            _ => Limit::Solver,
        }),
        patches: factors.enclosure.patches().len(),
        sides: task.area.len(),
        luminaires: lighting.lamps.len(),
        rays: if factors.standard_error.is_some() { factors.report.samples * task.area.len() as u64 } else { 0 },
        shadow_rays: task.incident.tests,
        solver: SolverReport::of(method, solver),
        closure: closure(&sums, &task.area),
        energy,
        memory_bytes: factors.enclosure.memory_bytes() + factors.operator.memory_bytes(),
        seconds: Seconds { sampling: 0.0, solving: total, total },
        ..Report::default()
    };
    Ok(Solution { irradiance, radiosity, error, report, source: Source::Given(factors.clone()) })
}

/// Blocks of sides x bands that a solve holds at a time: what goes in and comes out, the vectors of a solver, and what
/// the parts of a product are summed in.
const BLOCKS: u64 = 40;

/// Bytes that solving takes beside the form factors, which are where they are.
fn forecast(factors: &FormFactors, lighting: &Lighting) -> u64 {
    let sides = factors.enclosure.sides() as u64;
    let squares = factors.standard_error.as_ref().map_or(0, |error| 12 * error.stored() as u64);
    let samples = 16 * sides * u64::from(LIGHT_SAMPLES) * REPLICATES as u64;
    BLOCKS * 8 * sides * lighting.bands as u64 + squares + if lighting.lamps.is_empty() { 0 } else { samples }
}

/// What stays the same through one solve. Blocks are sides x bands.
struct Task<'a> {
    factors: &'a FormFactors,
    lighting: &'a Lighting,
    settings: &'a Settings,
    control: &'a Control,
    area: Vec<f64>,
    reflectance: Vec<f64>,
    emission: Vec<f64>,
    incident: Incident,
}

impl<'a> Task<'a> {
    fn new(
        factors: &'a FormFactors,
        lighting: &'a Lighting,
        settings: &'a Settings,
        control: &'a Control,
    ) -> Result<Self, Cancelled> {
        let enclosure = &factors.enclosure;
        Ok(Self {
            area: (0..enclosure.sides()).map(|side| enclosure.area(side)).collect(),
            reflectance: lighting.per_side(enclosure, |patch| lighting.reflectance_of(patch)),
            emission: lighting.per_side(enclosure, |patch| lighting.emission_of(patch)),
            incident: Incident::new(enclosure, lighting, settings.seed, control)?,
            factors,
            lighting,
            settings,
            control,
        })
    }

    fn options(&self) -> SolveOptions<'static> {
        let tolerance = 1e-9 * (1.0 - self.lighting.highest_reflectance());
        SolveOptions { tolerance, max_iterations: self.settings.most_iterations(self.area.len()), observer: None }
    }

    fn solve(
        &self,
        solver: Solver,
        emission: &[f64],
        incident: &[f64],
        options: &SolveOptions,
    ) -> Result<(Vec<f64>, SolveReport), Cancelled> {
        let problem: Problem = Problem {
            exchange: &self.factors.operator,
            area: &self.area,
            reflectance: &self.reflectance,
            emission,
            incident,
            bands: self.lighting.bands,
        };
        solver(&problem, options, self.control)
    }

    /// `F x`.
    fn gather(&self, operator: &dyn Operator, x: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; x.len()];
        operator.apply(x, &mut y, self.lighting.bands);
        y.iter_mut().enumerate().for_each(|(k, v)| *v = ratio(*v, self.area[k / self.lighting.bands]));
        y
    }

    fn irradiance(&self, radiosity: &[f64], incident: &[f64]) -> Vec<f64> {
        self.gather(&self.factors.operator, radiosity).iter().zip(incident).map(|(h, i)| h + i).collect()
    }

    /// The error of irradiance: its own of each side and what the solver left, carried through the interreflections.
    fn error(&self, radiosity: &[f64], irradiance: &[f64]) -> Result<Vec<f64>, Cancelled> {
        let squares: Vec<f64> = radiosity.iter().map(|b| b * b).collect();
        let variance = match &self.factors.standard_error {
            Some(error) => {
                let area = &self.area;
                // As `gather` divides by the area once, and here it enters squared.
                let squared = error.mapped(|_, _, e| e * e);
                let mut sums = self.gather(&squared, &squares);
                sums.iter_mut().enumerate().for_each(|(k, v)| *v = ratio(*v, area[k / self.lighting.bands]));
                sums
            }
            None => {
                let tolerance = self.factors.report.estimated_error;
                self.gather(&self.factors.operator, &squares).iter().map(|v| tolerance * tolerance * v).collect()
            }
        };
        let own: Vec<f64> =
            variance.iter().zip(&self.incident.standard_error).map(|(v, s)| (v + s * s).max(0.0).sqrt()).collect();
        // Whatever the solver is, its limits are not those of the error.
        let options = SolveOptions { max_iterations: MOST_ITERATIONS, ..self.options() };
        let left: Vec<f64> = (0..own.len())
            .map(|k| (self.emission[k] + self.reflectance[k] * irradiance[k] - radiosity[k]).abs())
            .collect();
        let (carried, _) = self.solve(conjugate_gradient, &left, &own, &options)?;
        Ok(self.irradiance(&carried, &own))
    }

    /// The balance of power. What rows lack of 1 escapes, backs included: form factors do not tell them apart.
    fn energy(&self, radiosity: &[f64], irradiance: &[f64]) -> Energy {
        let bands = self.lighting.bands;
        let none = || vec![0.0; bands];
        let mut energy = Energy {
            emitted: none(),
            from_lights: none(),
            absorbed: none(),
            escaped: none(),
            lost_on_backs: none(),
            imbalance: 0.0,
            escape_share: 0.0,
        };
        let sums = self.factors.operator.row_sums();
        for k in 0..radiosity.len() {
            let (side, band) = (k / bands, k % bands);
            let area = self.area[side];
            energy.emitted[band] += area * self.emission[k];
            energy.from_lights[band] += area * self.incident.mean[k];
            energy.absorbed[band] += area * (1.0 - self.reflectance[k]) * irradiance[k];
            energy.escaped[band] += (area - sums[side]) * radiosity[k];
        }
        let whole: f64 = self.area.iter().sum();
        energy.escape_share = ratio(whole - sums.iter().sum::<f64>(), whole);
        energy.balance();
        energy
    }
}
