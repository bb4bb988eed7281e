//! Solving on a hierarchical exchange that is made for the light at hand.
//!
//! 1. Lamps, bright sides and lights without area, are **tested** from every side.
//! 2. What matters is guessed: emitters and what they make bright count more in blocks of the exchange.
//! 3. The **exchange** is built, to a tolerance that the accuracy asks for.
//! 4. Conjugate gradient **solves**, and independent rays from a few sides **check** what that radiosity makes arrive.
//! 5. If the error is too large, go to 3 with a lesser tolerance and what is bright by now.
//!
//! Patches are seen at constant radiosity. What that leaves is told by seeing them coarser: four alike that lie together
//! at their mean. Errors of first order are then at most as large as the difference, of second order a third.

use crate::answer::ratio;
use crate::error::relative_rms;
use crate::given::solve_with;
use crate::incident::{self, Incident};
use crate::lighting::{Lighting, mean};
use crate::report::{Cause, Limit, Report, Seconds};
use crate::shooting::exposure_of_sides;
use crate::solve::{Failure, Settings, Solution};
use radiosity_exchange::factors::{self, FormFactors, Method};
use radiosity_exchange::{Enclosure, hierarchy};
use radiosity_operator::{Control, Operator};
use radiosity_solvers::Observer;
use std::sync::Arc;
use std::time::Instant;

/// The tolerances that blocks are worth building to.
const TOLERANCES: (f64, f64) = (5e-4, 5e-2);

/// Exchanges that are built at most.
const MOST_ROUNDS: usize = 3;

/// What is dim matters no less than this share of the mean.
const LEAST_IMPORTANCE: f64 = 0.25;

/// Patches that are seen as one to tell what their size leaves.
const TOGETHER: usize = 4;

/// Solves to the accuracy asked for, or as near as blocks come. The observer sees every iteration of every round.
pub fn solve_linked(
    enclosure: &Arc<Enclosure>,
    lighting: &Lighting,
    settings: &Settings,
    observer: Option<&Observer>,
    control: &Control,
) -> Result<Solution, Failure> {
    let start = Instant::now();
    enclosure.without_specular("a hierarchical exchange")?;
    lighting.demand_opaque("a hierarchical exchange")?;
    let mut each = incident::tests(settings.accuracy);
    let exposed = Arc::new(exposure_of_sides(enclosure, settings.seed, control)?);
    let test = |each: u32| -> Result<Arc<Incident>, Failure> {
        let lamps = lighting.luminaires(enclosure);
        Ok(Arc::new(Incident::new(enclosure, lighting, lamps, exposed.clone(), each, settings.seed, control)?))
    };
    let mut incident = test(each)?;
    let light = Light::guessed(enclosure, lighting, &incident);
    let mut importance = light.importance;
    let mut tolerance = (settings.accuracy * light.arriving_share).clamp(TOLERANCES.0, TOLERANCES.1);
    let (mut rays, mut sampling) = (0, start.elapsed().as_secs_f64());
    let mut factors: Option<Arc<FormFactors>> = None;
    for round in 1.. {
        let before = Instant::now();
        let built = match factors.take() {
            Some(factors) => factors,
            None => Arc::new(exchange(enclosure, tolerance, &importance, settings, control)?),
        };
        sampling += before.elapsed().as_secs_f64();
        let solution = solve_with(&built, incident.clone(), lighting, settings, observer, Instant::now(), control)?;
        let error = MARGIN * solution.report.estimated_error;
        let size = patch_size(&incident.left(&solution.radiosity, lighting.bands), &solution, &built, lighting.bands);
        // What the size of patches leaves to the rest.
        let allowed = (settings.accuracy.powi(2) - size * size).max(0.25 * settings.accuracy.powi(2)).sqrt();
        let is_enough = error <= allowed;
        // What the lamps add to the error, and what the exchange does.
        let direct = incident.relative_error(enclosure, &solution.irradiance, lighting.bands);
        let indirect = (error * error - direct * direct).max(0.0).sqrt();
        let more_tests = direct > SHARE * allowed && each < incident::MOST_TESTS;
        let finer = indirect > SHARE * allowed && tolerance > TOLERANCES.0;
        if is_enough || round == MOST_ROUNDS || !(more_tests || finer) {
            let seconds = Seconds { sampling, total: start.elapsed().as_secs_f64(), ..solution.report.seconds };
            let estimated_error = error.hypot(size);
            let limited_by = match is_enough {
                true if estimated_error <= settings.accuracy => Limit::Accuracy,
                true => Limit::PatchSize,
                false => Limit::Tolerance,
            };
            let report = Report {
                rays: rays + rays_of(&built),
                rounds: round,
                seconds,
                estimated_error,
                interval: (LEAST * estimated_error, estimated_error),
                causes: vec![(Cause::Sampling, error / MARGIN), (Cause::Transport, size)],
                discretisation_error: size,
                limited_by: Some(limited_by),
                ..solution.report.clone()
            };
            return Ok(Solution { report, ..solution });
        }
        rays += rays_of(&built);
        let before = Instant::now();
        if more_tests {
            let wanted = f64::from(each) * (direct / (SHARE * allowed)).powf(1.0 / RATE);
            each = (wanted as u32).next_power_of_two().min(incident::MOST_TESTS);
            incident = test(each)?;
        }
        if finer {
            tolerance = (SHARE * tolerance * allowed / indirect).max(TOLERANCES.0);
            importance = importance_of(enclosure, &incident.left(&solution.radiosity, lighting.bands), lighting.bands);
        } else {
            factors = Some(built);
        }
        sampling += before.elapsed().as_secs_f64();
    }
    unreachable!("the loop ends by returning")
}

fn rays_of(factors: &FormFactors) -> u64 {
    factors.report.links.rays + factors.report.tally.rays
}

/// What is told is the upper end of an interval that holds the error nine times in ten: on scenes with known answers
/// (`validation/coverage.py`) the likeliest value is off by this factor at most, and the size of patches, which is of
/// first order at worst, is often of second.
const MARGIN: f64 = 1.2;
const LEAST: f64 = 0.3;

/// The share of the accuracy that one source of error may take without a cure.
const SHARE: f64 = 0.6;

/// The error of tests falls with this power of their number.
const RATE: f64 = 0.65;

/// The exchange to a tolerance.
fn exchange(
    enclosure: &Arc<Enclosure>,
    tolerance: f64,
    importance: &[f64],
    settings: &Settings,
    control: &Control,
) -> Result<FormFactors, Failure> {
    let asked =
        factors::Settings { method: Method::Hierarchical, tolerance, seed: settings.seed, memory_limit: u64::MAX };
    let of_links = hierarchy::Settings::new(tolerance, settings.seed);
    let needed = hierarchy::forecast(enclosure.sides(), &of_links);
    if needed > settings.memory_limit {
        let patches = enclosure.patches().len();
        return Err(Failure::Memory { patches, needed, limit: settings.memory_limit });
    }
    Ok(factors::by_links(enclosure.clone(), &asked, importance, control)?)
}

/// What is known of the light before it is solved for.
struct Light {
    /// Per side.
    importance: Vec<f64>,
    /// Mean irradiance over mean radiosity: direct light needs no exchange.
    arriving_share: f64,
}

impl Light {
    /// As if what is sent were spread evenly.
    fn guessed(enclosure: &Enclosure, lighting: &Lighting, incident: &Incident) -> Self {
        let bands = lighting.bands;
        let (mut area, mut reflected, mut sent, mut direct) = (0.0, 0.0, 0.0, 0.0);
        let emission = lighting.per_side(enclosure, |patch| lighting.emission_of(patch));
        let exchanged = incident.left(&emission, bands);
        let of = |side: usize| {
            let patch = enclosure.patch_of(side);
            let range = side * bands..(side + 1) * bands;
            let (rho, e) = (mean(lighting.reflectance_of(patch)), mean(&exchanged[range]));
            (enclosure.area(side), rho, e, mean(&incident.mean[side * bands..(side + 1) * bands]))
        };
        for side in 0..enclosure.sides() {
            let (a, rho, e, h) = of(side);
            area += a;
            reflected += a * rho;
            sent += a * (e + rho * h);
            direct += a * h;
        }
        let rho = ratio(reflected, area);
        // A closed room; an open one has less.
        let radiosity = ratio(ratio(sent, area), 1.0 - rho);
        let level = radiosity + ratio(direct, area);
        let importance = (0..enclosure.sides())
            .map(|side| {
                let (_, rho, e, h) = of(side);
                ratio(e + rho * (h + radiosity), radiosity).max(LEAST_IMPORTANCE)
            })
            .collect();
        Self { importance, arriving_share: ratio(level, radiosity).max(1.0) }
    }
}

/// How much brighter than the mean each side is.
fn importance_of(enclosure: &Enclosure, radiosity: &[f64], bands: usize) -> Vec<f64> {
    let (mut power, mut area) = (0.0, 0.0);
    for (side, b) in radiosity.chunks_exact(bands).enumerate() {
        power += enclosure.area(side) * mean(b);
        area += enclosure.area(side);
    }
    let level = ratio(power, area);
    radiosity.chunks_exact(bands).map(|b| ratio(mean(b), level).max(LEAST_IMPORTANCE)).collect()
}

/// What seeing patches at constant radiosity leaves: root mean square over area, relative to the mean irradiance.
fn patch_size(sent: &[f64], solution: &Solution, factors: &FormFactors, bands: usize) -> f64 {
    let enclosure = &factors.enclosure;
    let difference = coarser(factors, sent, bands);
    let mut image = vec![0.0; difference.len()];
    factors.operator.apply(&difference, &mut image, bands);
    let difference = |k: usize| ratio(image[k], enclosure.area(k / bands));
    0.5 * relative_rms(enclosure, &solution.irradiance, bands, difference)
}

/// What radiosity changes by where neighbours that face alike are seen at their mean.
fn coarser(factors: &FormFactors, radiosity: &[f64], bands: usize) -> Vec<f64> {
    let enclosure = &factors.enclosure;
    let mut difference = vec![0.0; radiosity.len()];
    // What is dark altogether, as under what stands on a floor, ends where patches do and is no part of a neighbour.
    let is_lit = |side: usize| radiosity[side * bands..(side + 1) * bands].iter().any(|&b| b != 0.0);
    for group in factors.operator.order().chunks(TOGETHER) {
        let Some(first) = group.iter().map(|&side| side as usize).find(|&side| is_lit(side)) else { continue };
        let normal = enclosure.normal(first);
        let surface = |side: usize| enclosure.patches().surface[enclosure.patch_of(side)];
        let is_alike =
            |&side: &usize| enclosure.normal(side).dot(normal) > 0.9 && surface(side) == surface(first) && is_lit(side);
        let alike: Vec<usize> = group.iter().map(|&side| side as usize).filter(is_alike).collect();
        let area: f64 = alike.iter().map(|&side| enclosure.area(side)).sum();
        for band in 0..bands {
            let power: f64 = alike.iter().map(|&side| enclosure.area(side) * radiosity[side * bands + band]).sum();
            for &side in &alike {
                difference[side * bands + band] = power / area - radiosity[side * bands + band];
            }
        }
    }
    difference
}
