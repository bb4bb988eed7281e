//! Progressive refinement without a matrix: sides shoot through rows that are found when they are asked for.
//!
//! The error of the answer has three parts. Rows have an error by the spread of their hemicubes; what a side receives has
//! the root of the sum of squares of those of all who shot. What that is wrong by is reflected, for which the ambient
//! term stands: rows of sides that never shot are not known. It adds in squares, as too much here is too little elsewhere
//! in the same row. And what is unshot would still arrive. Where the error is larger than wanted, all begins anew with as
//! many hemicubes as it takes.

use crate::answer::ratio;
use crate::energy::Energy;
use crate::incident::{Incident, tests, without_area};
use crate::lighting::Lighting;
use crate::report::{Cause, Limit, Report, Seconds, SolverReport};
use crate::solve::{Failure, Settings, Solution, Source, closure};
use radiosity_exchange::{Enclosure, RowsOnDemand, on_demand};
use radiosity_operator::{Cancelled, Control};
use radiosity_solvers::{Ledger, Light, Observer, Overshoot, Problem, SolveOptions, Stop, shoot};
use std::sync::Arc;
use std::time::Instant;

/// Hemicubes a side to begin with, and the most.
const FIRST_POSITIONS: usize = 8;
const MOST_POSITIONS: usize = 64;

/// Pixels along an edge: several coarse hemicubes tell more of a side than a fine one.
const RESOLUTION: usize = 256;

/// Solves on rows found on demand, with as many hemicubes as the accuracy takes. The observer sees every shot, and those
/// of a new start from 0 on.
pub fn solve_on_demand(
    enclosure: &Arc<Enclosure>,
    lighting: &Lighting,
    settings: &Settings,
    observer: Option<&Observer>,
    control: &Control,
) -> Result<Solution, Failure> {
    let (start, sides) = (Instant::now(), enclosure.sides());
    enclosure.without_specular("rows drawn on hemicubes")?;
    let needed = RowsOnDemand::least_memory(sides);
    if needed > settings.memory_limit {
        let patches = enclosure.patches().len();
        return Err(Failure::Memory { patches, needed, limit: settings.memory_limit });
    }
    let mut positions = FIRST_POSITIONS;
    for rounds in 1.. {
        let (seed, memory_limit) = (settings.seed, settings.memory_limit);
        let how = on_demand::Settings { resolution: RESOLUTION, positions, seed, memory_limit };
        let rows = Arc::new(RowsOnDemand::new(enclosure.clone(), how));
        let mut solution = solve_on_rows(rows, lighting, settings, observer, control)?;
        let report = &mut solution.report;
        report.rounds = rounds;
        report.seconds.total = start.elapsed().as_secs_f64();
        if report.limited_by != Some(Limit::Hemicubes) || positions == MOST_POSITIONS {
            return Ok(solution);
        }
        // Over smooth light the error falls as their number, across shadows as its root.
        let wanted = positions as f64 * (report.sampling_error / settings.accuracy).powf(1.5);
        positions = (wanted.ceil() as usize).next_power_of_two().clamp(2 * positions, MOST_POSITIONS);
    }
    unreachable!("the loop ends by returning")
}

/// Solves on rows as they are found.
pub(crate) fn solve_on_rows(
    rows: Arc<RowsOnDemand>,
    lighting: &Lighting,
    settings: &Settings,
    observer: Option<&Observer>,
    control: &Control,
) -> Result<Solution, Failure> {
    let (start, found_before) = (Instant::now(), rows.found());
    lighting.demand_opaque("rows drawn on hemicubes")?;
    let task = Task::new(&rows, lighting, settings, control)?;
    let overshoot = settings.method.overshoot().unwrap_or(Overshoot::None);
    let tolerance = 0.05 * settings.accuracy.min(0.1) * (1.0 - lighting.highest_reflectance());
    let max_iterations = settings.most_iterations(rows.enclosure().sides());
    let options = SolveOptions { tolerance, max_iterations, observer };
    let (light, solver) = shoot(&task.problem(), overshoot, &options, control)?;
    let (sampling, error) = task.error(&light, control)?;
    let estimated_error = task.relative(&error, &light.irradiance);
    let limit = match solver.stop {
        Stop::Converged if estimated_error <= settings.accuracy => Limit::Accuracy,
        Stop::Converged => Limit::Hemicubes,
        _ => Limit::Solver,
    };
    let found = rows.found() - found_before;
    let total = start.elapsed().as_secs_f64();
    let ledger = solver.ledger.clone().unwrap_or_default();
    let report = Report {
        accuracy: settings.accuracy,
        estimated_error,
        interval: (0.0, estimated_error),
        causes: vec![(Cause::Sampling, estimated_error)],
        sampling_error: task.relative(&sampling, &light.irradiance),
        limited_by: Some(limit),
        patches: rows.enclosure().patches().len(),
        sides: rows.enclosure().sides(),
        luminaires: lighting.lamps.len(),
        shadow_rays: task.incident.tests,
        rows_on_demand: found,
        hemicubes: found * rows.settings().positions as u64,
        rounds: 1,
        solver: SolverReport::of(settings.method, solver),
        closure: task.closure(&light),
        energy: task.energy(&light, &ledger),
        memory_bytes: rows.enclosure().memory_bytes() + rows.memory_bytes(),
        seconds: Seconds { sampling: 0.0, solving: total, total },
        ..Report::default()
    };
    let Light { irradiance, radiosity, .. } = light;
    let causes = vec![(Cause::Sampling, error.clone())];
    let source = Source::OnDemand(rows.clone());
    Ok(Solution { irradiance, radiosity, error, causes, mesh: Vec::new(), report, source })
}

/// What stays the same through one solve. Blocks are sides x bands.
struct Task<'a> {
    rows: &'a RowsOnDemand,
    bands: usize,
    area: Vec<f64>,
    reflectance: Vec<f64>,
    emission: Vec<f64>,
    incident: Incident,
}

impl<'a> Task<'a> {
    fn new(
        rows: &'a RowsOnDemand,
        lighting: &Lighting,
        settings: &Settings,
        control: &Control,
    ) -> Result<Self, Cancelled> {
        let enclosure = rows.enclosure();
        Ok(Self {
            rows,
            bands: lighting.bands,
            area: (0..enclosure.sides()).map(|side| enclosure.area(side)).collect(),
            reflectance: lighting.per_side(enclosure, |patch| lighting.reflectance_of(patch)),
            emission: lighting.per_side(enclosure, |patch| lighting.emission_of(patch)),
            incident: Incident::new(
                enclosure,
                lighting,
                without_area(lighting),
                Arc::default(),
                tests(settings.accuracy),
                settings.seed,
                control,
            )?,
        })
    }

    fn problem(&self) -> Problem<'_, RowsOnDemand> {
        Problem {
            exchange: self.rows,
            area: &self.area,
            reflectance: &self.reflectance,
            emission: &self.emission,
            incident: &self.incident.mean,
            bands: self.bands,
        }
    }

    /// Sides that shot, with what they shot in each band, W/m2.
    fn shooters<'b>(&self, light: &'b Light) -> impl Iterator<Item = (usize, &'b [f64])> {
        light.shot.chunks_exact(self.bands).enumerate().filter(|(_, shot)| shot.iter().any(|v| *v != 0.0))
    }

    /// The error of irradiance by rows and lamps, and all of it.
    fn error(&self, light: &Light, control: &Control) -> Result<(Vec<f64>, Vec<f64>), Cancelled> {
        let mut variance: Vec<f64> = self.incident.standard_error.iter().map(|s| s * s).collect();
        for (i, shot) in self.shooters(light) {
            control.check()?;
            let row = self.rows.row(i);
            for (&(j, _), &error) in row.entries.iter().zip(&row.error) {
                let share = ratio(f64::from(error), self.area[j as usize]);
                for (c, shot) in shot.iter().enumerate() {
                    variance[j as usize * self.bands + c] += (share * shot).powi(2);
                }
            }
        }
        let mut sampling: Vec<f64> = variance.iter().map(|v| v.sqrt()).collect();
        let reflected: Vec<f64> = sampling.iter().zip(&self.reflectance).map(|(e, rho)| e * rho).collect();
        let (carried, missing) = (self.ambient(&reflected), self.ambient(&light.unshot));
        sampling.iter_mut().enumerate().for_each(|(k, e)| *e = e.hypot(carried[k % self.bands]));
        let error = sampling.iter().enumerate().map(|(k, e)| e + missing[k % self.bands]).collect();
        Ok((sampling, error))
    }

    /// Per band the irradiance that `radiosity` comes to, whatever its sign, if it arrives evenly, again and again.
    fn ambient(&self, radiosity: &[f64]) -> Vec<f64> {
        let whole: f64 = self.area.iter().sum();
        let sum = |of: &dyn Fn(usize) -> f64, band: usize| -> f64 {
            (0..self.area.len()).map(|i| self.area[i] * of(i * self.bands + band)).sum()
        };
        let of = |band| ratio(sum(&|k| radiosity[k].abs(), band), whole - sum(&|k| self.reflectance[k], band));
        (0..self.bands).map(of).collect()
    }

    /// Root mean square over area and bands, relative to the mean of the irradiance.
    fn relative(&self, error: &[f64], irradiance: &[f64]) -> f64 {
        let (mut squares, mut level, mut whole) = (0.0, 0.0, 0.0);
        for (k, h) in irradiance.iter().enumerate() {
            let area = self.area[k / self.bands];
            squares += area * error[k] * error[k];
            level += area * h;
            whole += area;
        }
        ratio((squares * whole).sqrt(), level)
    }

    /// Row sums of the sides that shot.
    fn closure(&self, light: &Light) -> (f64, f64, f64) {
        let (mut sums, mut areas) = (Vec::new(), Vec::new());
        for (i, _) in self.shooters(light) {
            // From 0, as the sum of nothing is -0.
            let sum = self.rows.row(i).entries.iter().fold(0.0, |sum, e| sum + f64::from(e.1));
            sums.push(ratio(sum, self.area[i]));
            areas.push(self.area[i]);
        }
        closure(&sums, &areas)
    }

    /// The balance of power: what is unshot is what it cannot explain.
    fn energy(&self, light: &Light, ledger: &Ledger) -> Energy {
        let none = || vec![0.0; self.bands];
        let mut energy = Energy {
            emitted: none(),
            from_lights: none(),
            absorbed: none(),
            escaped: ledger.escaped.clone(),
            lost_on_backs: none(),
            absorbed_by_mirrors: Vec::new(),
            unfollowed: Vec::new(),
            imbalance: 0.0,
            escape_share: 0.0,
        };
        for k in 0..light.irradiance.len() {
            let (area, band) = (self.area[k / self.bands], k % self.bands);
            energy.emitted[band] += area * self.emission[k];
            energy.from_lights[band] += area * self.incident.mean[k];
            energy.absorbed[band] += area * (1.0 - self.reflectance[k]) * light.irradiance[k];
        }
        let (shot, escaped): (f64, f64) = (ledger.shot.iter().sum(), ledger.escaped.iter().sum());
        energy.escape_share = ratio(escaped, shot);
        energy.balance();
        energy
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use radiosity_geometry::Patches;
    use radiosity_operator::Rows;

    /// Rows that are all there, as they were found.
    struct Matrix(Vec<Vec<(u32, f64)>>);

    impl Rows for Matrix {
        fn count(&self) -> usize {
            self.0.len()
        }

        fn find_row(&self, i: usize, row: &mut Vec<(u32, f64)>) {
            row.clone_from(&self.0[i]);
        }
    }

    /// The inside of a unit cube, open on one side, its faces cut in four.
    fn box_without_lid() -> Arc<Enclosure> {
        let mut polygons = Vec::new();
        for (axis, high) in [(0, false), (0, true), (1, false), (1, true), (2, false)] {
            let point = |u: f64, v: f64| {
                let mut p = [0.0; 3];
                p[axis] = if high { 1.0 } else { 0.0 };
                (p[(axis + 1) % 3], p[(axis + 2) % 3]) = (u, v);
                DVec3::from_array(p)
            };
            for (u, v) in [(0.0, 0.0), (0.5, 0.0), (0.0, 0.5), (0.5, 0.5)] {
                let [a, b, c, d] = [point(u, v), point(u + 0.5, v), point(u + 0.5, v + 0.5), point(u, v + 0.5)];
                polygons.push(if high { [a, d, c, b] } else { [a, b, c, d] });
            }
        }
        let n = polygons.len();
        Arc::new(Enclosure::new(Patches::new(polygons, vec![0; n], (0..n as u32).collect(), vec![false; n])))
    }

    /// Two bands; one patch shines.
    fn lighting(n: usize) -> Lighting {
        let mut emission = vec![0.0; 2 * n];
        emission[..2].copy_from_slice(&[3.0, 1.0]);
        Lighting { bands: 2, reflectance: [0.8, 0.4].repeat(n), emission, ..Lighting::default() }
    }

    fn rows(memory_limit: u64) -> RowsOnDemand {
        RowsOnDemand::new(
            box_without_lid(),
            on_demand::Settings { resolution: 32, positions: 4, seed: 3, memory_limit },
        )
    }

    #[test]
    fn rows_on_demand_light_as_a_matrix_of_the_same_rows_does() {
        let (source, few) = (rows(u64::MAX), rows(2000));
        let n = source.count();
        let lighting = lighting(n);
        let whole: Vec<Vec<(u32, f64)>> = (0..n)
            .map(|i| {
                let mut row = Vec::new();
                rows(u64::MAX).find_row(i, &mut row);
                row
            })
            .collect();
        let matrix = Matrix(whole.clone());
        let options = SolveOptions { tolerance: 1e-12, max_iterations: 100_000, observer: None };
        let settings = Settings::default();
        for overshoot in [Overshoot::None, Overshoot::Ambient] {
            let task = Task::new(&source, &lighting, &settings, &Control::default()).unwrap();
            let Problem { area, reflectance, emission, incident, bands, .. } = task.problem();
            let problem = Problem { exchange: &matrix, area, reflectance, emission, incident, bands };
            let (expected, report) = shoot(&problem, overshoot, &options, &Control::default()).unwrap();
            assert_eq!(report.stop, Stop::Converged);
            for source in [&source, &few] {
                let task = Task::new(source, &lighting, &settings, &Control::default()).unwrap();
                let (found, again) = shoot(&task.problem(), overshoot, &options, &Control::default()).unwrap();
                assert_eq!((&found.radiosity, &found.irradiance), (&expected.radiosity, &expected.irradiance));
                assert_eq!(report.history, again.history);
            }
            // What arrives is what all have sent through their rows.
            let mut arrived = vec![0.0; 2 * n];
            for (i, row) in whole.iter().enumerate() {
                for &(j, g) in row {
                    for c in 0..2 {
                        arrived[j as usize * 2 + c] += g / area[j as usize] * expected.radiosity[i * 2 + c];
                    }
                }
            }
            assert!(arrived.iter().zip(&expected.irradiance).all(|(a, h)| (a - h).abs() < 1e-10));
        }
    }

    #[test]
    fn power_is_absorbed_or_escapes_or_is_missing() {
        let source = rows(u64::MAX);
        let lighting = lighting(source.count());
        for max_iterations in [Some(0), Some(1), Some(7), None] {
            let settings =
                Settings { accuracy: 10.0, method: crate::Method::Southwell, max_iterations, ..Settings::default() };
            let rows = Arc::new(rows(u64::MAX));
            let Solution { report, .. } = solve_on_rows(rows, &lighting, &settings, None, &Control::default()).unwrap();
            let unshot = report.solver.history.unshot.last().unwrap();
            let energy = &report.energy;
            let missing = |c: usize| energy.emitted[c] - energy.absorbed[c] - energy.escaped[c];
            let emitted = energy.emitted[0] + energy.emitted[1];
            assert!(((missing(0) + missing(1)) / emitted - unshot).abs() < 1e-12);
            assert_eq!(report.limited_by, Some(if max_iterations.is_none() { Limit::Accuracy } else { Limit::Solver }));
        }
    }
}
