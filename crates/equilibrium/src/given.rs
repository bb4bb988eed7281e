//! Solving on form factors that are given: `B = E + rho F B` exactly as they are, side by side.
//!
//! The error of the answer is what the errors of the form factors make of it. Where rays found them, each has a standard
//! error and what a side receives has the root of the sum of squares. Where they were found to a tolerance, a row is
//! off by that much of what it sees. Both go through the interreflections as light does, all in one direction.

use crate::answer::{Solver, ratio};
use crate::energy::Energy;
use crate::error::relative_rms;
use crate::incident::{self, Incident};
use crate::lighting::Lighting;
use crate::report::{Cause, Limit, Report, Seconds, SolverReport};
use crate::solve::{Failure, MOST_ITERATIONS, Settings, Solution, Source, closure};
use radiosity_exchange::FormFactors;
use radiosity_exchange::factors::FactorReport;
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
    factors.enclosure.without_specular("given form factors")?;
    lighting.demand_opaque("given form factors")?;
    let needed = forecast(factors, lighting, settings.accuracy);
    if needed > settings.memory_limit {
        let patches = factors.enclosure.patches().len();
        return Err(Failure::Memory { patches, needed, limit: settings.memory_limit });
    }
    let each = incident::tests(settings.accuracy);
    let lamps = incident::without_area(lighting);
    let incident = Incident::new(&factors.enclosure, lighting, lamps, Arc::default(), each, settings.seed, control)?;
    solve_with(factors, Arc::new(incident), lighting, settings, observer, start, control)
}

/// Solves again with other emission and paint.
pub fn relight_given(
    factors: &Arc<FormFactors>,
    incident: &Arc<Incident>,
    lighting: &Lighting,
    settings: &Settings,
    control: &Control,
) -> Result<Solution, Failure> {
    let start = Instant::now();
    lighting.demand_opaque("given form factors")?;
    let enclosure = &factors.enclosure;
    let of_exchange = factors.operator.pairs().is_none();
    let lamps = if of_exchange { lighting.luminaires(enclosure) } else { incident::without_area(lighting) };
    let relit = match incident.relit(enclosure, lighting, &lamps, control)? {
        Some(relit) => relit,
        None => {
            let (exposed, each) = (incident.exposed().clone(), incident::tests(settings.accuracy));
            Incident::new(enclosure, lighting, lamps, exposed, each, settings.seed, control)?
        }
    };
    solve_with(factors, Arc::new(relit), lighting, settings, None, start, control)
}

pub(crate) fn solve_with(
    factors: &Arc<FormFactors>,
    incident: Arc<Incident>,
    lighting: &Lighting,
    settings: &Settings,
    observer: Option<&Observer>,
    start: Instant,
    control: &Control,
) -> Result<Solution, Failure> {
    let task = Task::new(factors, incident, lighting, settings, control);
    let method = settings.method;
    let options = SolveOptions { observer, ..task.options() };
    let (exchanged, solver) = task.solve(method.solver(), &task.exchanged, &task.incident.mean, &options)?;
    let irradiance = task.irradiance(&exchanged, &task.incident.mean);
    let error = task.error(&exchanged, &irradiance)?;
    // What lamps send that were tested one by one went no way through the exchange.
    let tested = task.emission.iter().zip(&task.exchanged).map(|(e, x)| e - x);
    let radiosity: Vec<f64> = exchanged.iter().zip(tested).map(|(b, e)| b + e).collect();
    let energy = task.energy(&radiosity, &irradiance);
    // The answer is the mean over all of a side, of which what is buried is dark.
    let (irradiance, error) = (task.over_all(irradiance), task.over_all(error));
    let is_whole = |k: usize| task.area[k / lighting.bands] == factors.enclosure.area(k / lighting.bands);
    let radiosity: Vec<f64> = (0..radiosity.len())
        .map(|k| if is_whole(k) { radiosity[k] } else { task.emission[k] + task.reflectance[k] * irradiance[k] })
        .collect();
    let estimated_error = relative_rms(&factors.enclosure, &irradiance, lighting.bands, |k| error[k]);
    let sums: Vec<f64> = factors.row_sums().iter().zip(&task.area).map(|(s, a)| ratio(*s, *a)).collect();
    let total = start.elapsed().as_secs_f64();
    let report = Report {
        accuracy: settings.accuracy,
        estimated_error,
        interval: (0.0, estimated_error),
        causes: vec![(Cause::Sampling, estimated_error)],
        sampling_error: estimated_error,
        limited_by: Some(match solver.stop {
            Stop::Converged if estimated_error <= settings.accuracy => Limit::Accuracy,
            Stop::Converged => Limit::Samples,
            _ => Limit::Solver,
        }),
        patches: factors.enclosure.patches().len(),
        sides: task.area.len(),
        luminaires: lighting.lamps.len(),
        rays: rays_of(factors),
        shadow_rays: task.incident.tests,
        solver: SolverReport::of(method, solver),
        closure: closure(&sums, &task.area),
        energy,
        memory_bytes: factors.enclosure.memory_bytes() + factors.operator.memory_bytes(),
        seconds: Seconds { sampling: 0.0, solving: total, total },
        ..Report::default()
    };
    let causes = vec![(Cause::Sampling, error.clone())];
    let source = Source::Given(factors.clone(), task.incident.clone());
    Ok(Solution { irradiance, radiosity, error, causes, mesh: Vec::new(), report, source })
}

/// Blocks of sides x bands that a solve holds at a time: what goes in and comes out, the vectors of a solver, and what
/// the parts of a product are summed in.
const BLOCKS: u64 = 40;

/// Bytes that solving takes beside the form factors, which are where they are.
fn forecast(factors: &FormFactors, lighting: &Lighting, accuracy: f64) -> u64 {
    let sides = factors.enclosure.sides() as u64;
    let squares = factors.standard_error.as_ref().map_or(0, |error| 12 * error.stored() as u64);
    let samples = incident::forecast(factors.enclosure.sides(), accuracy);
    BLOCKS * 8 * sides * lighting.bands as u64 + squares + if lighting.lamps.is_empty() { 0 } else { samples }
}

/// Rays that found form factors.
fn rays_of(factors: &FormFactors) -> u64 {
    let FactorReport { samples, links, tally, .. } = factors.report;
    if factors.standard_error.is_some() {
        return samples * factors.enclosure.sides() as u64;
    }
    links.rays + tally.rays
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
    /// Of it what goes through the exchange.
    exchanged: Vec<f64>,
    incident: Arc<Incident>,
}

impl<'a> Task<'a> {
    fn new(
        factors: &'a FormFactors,
        incident: Arc<Incident>,
        lighting: &'a Lighting,
        settings: &'a Settings,
        control: &'a Control,
    ) -> Self {
        let enclosure = &factors.enclosure;
        let emission = lighting.per_side(enclosure, |patch| lighting.emission_of(patch));
        Self {
            area: incident.exposed_areas(enclosure),
            reflectance: lighting.per_side(enclosure, |patch| lighting.reflectance_of(patch)),
            exchanged: incident.left(&emission, lighting.bands),
            emission,
            incident,
            factors,
            lighting,
            settings,
            control,
        }
    }

    /// Means over what is exposed as means over all.
    fn over_all(&self, mut values: Vec<f64>) -> Vec<f64> {
        let bands = self.lighting.bands;
        for (side, values) in values.chunks_exact_mut(bands).enumerate() {
            let share = ratio(self.area[side], self.factors.enclosure.area(side));
            values.iter_mut().for_each(|v| *v *= share);
        }
        values
    }

    fn options(&self) -> SolveOptions<'static> {
        // Blocks of rank one are not worth more than the accuracy that they were made for.
        let relative =
            if self.factors.operator.pairs().is_some() { 1e-9 } else { 0.03 * self.settings.accuracy.min(0.1) };
        let tolerance = relative * (1.0 - self.lighting.highest_reflectance());
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
        if self.factors.operator.pairs().is_none() {
            return self.error_of_links(radiosity, irradiance);
        }
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
            .map(|k| (self.exchanged[k] + self.reflectance[k] * irradiance[k] - radiosity[k]).abs())
            .collect();
        let (carried, _) = self.solve(conjugate_gradient, &left, &own, &options)?;
        Ok(self.irradiance(&carried, &own))
    }

    /// The same of blocks of rank one, by what independent rays make of this very radiosity: what differs from side to
    /// side is lost in the next bounce, what they have in common is carried on.
    fn error_of_links(&self, radiosity: &[f64], irradiance: &[f64]) -> Result<Vec<f64>, Cancelled> {
        let bands = self.lighting.bands;
        let arriving: Vec<f64> = irradiance.iter().zip(&self.incident.mean).map(|(h, i)| h - i).collect();
        // Rays count what is buried as dark.
        let on_all = self.over_all(arriving.clone());
        let found = self.factors.check(self.control)?.deviations(radiosity, &on_all, bands);
        let share = |part: f64, k: usize| ratio(part, found[k % bands].mean) * arriving[k];
        let own: Vec<f64> = (0..arriving.len())
            .map(|k| share(found[k % bands].error, k).hypot(self.incident.standard_error[k]))
            .collect();
        // As the light of a room whose reflectance is everywhere the mean.
        let whole: f64 = self.area.iter().sum();
        let mean = |band: usize| {
            let of = |side: usize| self.area[side] * self.reflectance[side * bands + band];
            ratio((0..self.area.len()).map(of).sum(), whole)
        };
        let gains: Vec<f64> = (0..bands).map(|band| 1.0 / (1.0 - mean(band))).collect();
        let carried = |k: usize| gains[k % bands] * share(found[k % bands].bias, k);
        Ok(own.iter().enumerate().map(|(k, own)| own.hypot(carried(k))).collect())
    }

    /// The balance of power. What rows lack of 1 escapes, backs included: form factors do not tell them apart.
    fn energy(&self, radiosity: &[f64], irradiance: &[f64]) -> Energy {
        let bands = self.lighting.bands;
        let none = || vec![0.0; bands];
        let mut energy = Energy {
            emitted: none(),
            from_lights: self.incident.power_of_lights(&self.factors.enclosure, self.lighting),
            absorbed: none(),
            escaped: none(),
            lost_on_backs: none(),
            absorbed_by_mirrors: Vec::new(),
            unfollowed: Vec::new(),
            imbalance: 0.0,
            escape_share: 0.0,
        };
        let sums = self.factors.row_sums();
        for k in 0..radiosity.len() {
            let (side, band) = (k / bands, k % bands);
            let area = self.area[side];
            energy.emitted[band] += area * self.emission[k];
            energy.absorbed[band] += area * (1.0 - self.reflectance[k]) * irradiance[k];
            energy.escaped[band] += (area - sums[side]) * radiosity[k];
        }
        let whole: f64 = self.area.iter().sum();
        energy.escape_share = ratio(whole - sums.iter().sum::<f64>(), whole);
        energy.balance();
        energy
    }
}
