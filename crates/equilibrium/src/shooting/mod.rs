//! Monte Carlo shooting: the equilibrium of light without form factors.
//!
//! ```text
//! sample luminaires -> shoot bounce by bounce -> gather what shooting left rough -> estimate the error -> once more
//! ```
//!
//! Sides of small scenes are cut into cells (`cells.rs`), which shoot and gather each for itself.
//!
//! Nothing is kept of a ray but what it carried, so memory is a few numbers a patch. Four independent replicates each
//!
//! 1. **sample** the light that comes straight from luminaires, as every solver here does;
//! 2. **shoot** what sides emit and reflect of it, then what is reflected of that, until little is left: incremental
//!    stochastic Jacobi relaxation (Neumann 1995; Bekaert 1999). Rays carry equal power. This finds the light of the
//!    whole, where power goes and how much of it; single patches stay noisy, like counts of raindrops;
//! 3. **gather** through rays spread evenly over each side, which see the sum of all that was shot so far. The noise of
//!    single patches averages out, and the evenness of the points counts, as each side has a sequence of its own.
//!    The first bounce, which may come from a few bright spots, is found from both ends, each line weighed by the
//!    balance heuristic (Veach and Guibas 1995).
//!
//! What is gathered is scaled, band by band, to the power that shooting says is absorbed, so the balance of power is
//! exact. The spread of the replicates is the error: they share nothing.
//!
//! What a round does follows from the rounds before it and not from the accuracy asked for, so an answer refined in
//! steps is the one asked for at once.

mod answer;
mod bounces;
mod cells;
mod direct;
mod exposure;
mod gather;
mod parts;
mod rays;
mod salvo;
mod state;

pub(crate) use exposure::exposure_of_sides;
pub use parts::Parts;
pub use state::{Shooting, StateError};

use crate::lighting::Lighting;
use crate::report::{Limit, Report, Seconds};
use crate::solve::Failure;
use answer::Answer;
use cells::Cells;
use radiosity_exchange::luminaires::Luminaires;
use radiosity_exchange::{Enclosure, LightSample, Luminaire};
use radiosity_operator::Control;
use salvo::Losses;
use std::sync::Arc;
use std::time::Instant;

/// Independent replicates.
pub(crate) const REPLICATES: usize = 4;

/// Rays per side and replicate, and light samples, of the first round.
const FIRST: u32 = 4;

/// Emitting sides are sampled by area while there are few enough: choosing among them costs every side a look at each.
/// More are shot from instead.
const MOST_LOOKS: usize = 30_000_000;
const FEW_EMITTERS: usize = 64;

/// A part of the error that is less than this share of the whole is not worth samples.
const WORTH: f64 = 0.2;

/// Rays of the first bounce for every ray that gathers. Between a quarter and two, time times squared error differs by
/// less than a fifth, on a room and on a city; without gathering or without sharing it is worse by up to a half or more.
const SHOT_PER_GATHERED: f64 = 1.0;

/// What is asked of shooting.
#[derive(Clone, Debug)]
pub struct ShootingSettings {
    /// Wanted error of irradiance: root mean square over area and bands, relative to the mean.
    pub accuracy: f64,
    /// The same seed gives the same bytes.
    pub seed: u64,
    /// Most rays that a side gathers by, all replicates together.
    pub max_rays: u32,
    /// Seconds after which no round is begun.
    pub time_limit: f64,
    /// Bytes that shooting may take beside patches and hierarchy.
    pub memory_limit: u64,
}

/// The equilibrium of light. Blocks are sides x bands: fronts of all patches, then backs of the two-sided ones.
pub struct ShotSolution {
    /// W/m2.
    pub irradiance: Vec<f64>,
    /// W/m2.
    pub radiosity: Vec<f64>,
    /// Estimated standard error of irradiance, W/m2.
    pub error: Vec<f64>,
    /// What the solve says about itself.
    pub report: Report,
    /// What it goes on from.
    pub state: Arc<Shooting>,
}

/// What all steps look at.
struct Context<'a> {
    cells: &'a Cells<'a>,
    lighting: &'a Lighting,
    exposure: &'a [f32],
    seed: u64,
    control: &'a Control,
}

impl Context<'_> {
    /// The emission of the luminaire of a sample, which is a side.
    fn emission_of(&self, luminaires: &Luminaires, sample: &LightSample) -> &[f64] {
        match luminaires.list[sample.luminaire as usize] {
            Luminaire::Side(side) => self.lighting.emission_of(self.cells.enclosure.patch_of(side as usize)),
            _ => unreachable!("lights without area stand after the emitters"),
        }
    }
}

/// Sums of one replicate, cells x bands each.
#[derive(Clone, Debug, Default, PartialEq)]
struct Replicate {
    /// Light samples toward lights without area.
    from_lights: Vec<f32>,
    /// Light samples toward emitting sides; empty if none is sampled.
    from_emitters: Vec<f32>,
    /// Indirect irradiance by rays that gather, times rays.
    gathered: Vec<f32>,
    /// Indirect irradiance by shooting, times rays.
    bounced: Vec<f32>,
    /// Where the power of emitters that are sampled by area went.
    emitters: Shares,
    /// Where all other power went.
    others: Shares,
}

/// The shares of power that did not land, band by band, summed with weights.
#[derive(Clone, Debug, Default, PartialEq)]
struct Shares {
    escaped: Vec<f64>,
    on_backs: Vec<f64>,
    weight: f64,
}

impl Shares {
    fn new(bands: usize) -> Self {
        Self { escaped: vec![0.0; bands], on_backs: vec![0.0; bands], weight: 0.0 }
    }

    /// Adds the losses of salvos, which belong to power of which there was `first` at first.
    fn add(&mut self, losses: &[Losses], first: &[f64]) {
        for (b, &first) in first.iter().enumerate().filter(|(_, first)| **first > 0.0) {
            self.escaped[b] += losses.iter().map(|l| l.escaped[b]).sum::<f64>() / first;
            self.on_backs[b] += losses.iter().map(|l| l.on_backs[b]).sum::<f64>() / first;
        }
        self.weight += 1.0;
    }

    fn add_weighted(&mut self, other: &Self, weight: f64) {
        for (a, b) in self.escaped.iter_mut().zip(&other.escaped).chain(self.on_backs.iter_mut().zip(&other.on_backs)) {
            *a += weight * b;
        }
        self.weight += weight * other.weight;
    }

    /// Escaped and ended on backs, as shares of a band.
    fn of(&self, band: usize) -> (f64, f64) {
        if self.weight > 0.0 {
            (self.escaped[band] / self.weight, self.on_backs[band] / self.weight)
        } else {
            (0.0, 0.0)
        }
    }
}

/// Bytes that shooting takes beside patches and hierarchy.
pub fn forecast(enclosure: &Enclosure, lighting: &Lighting) -> u64 {
    let luminaires = luminaires(enclosure, lighting);
    state::memory(Cells::new(enclosure).count(), lighting.bands, &luminaires) + output(enclosure, lighting)
}

/// Shoots to the accuracy asked for, or as near as the limits allow; the report says which. Goes on from `start`.
pub fn shoot(
    enclosure: &Enclosure,
    lighting: &Lighting,
    settings: &ShootingSettings,
    start: Option<&Shooting>,
    control: &Control,
) -> Result<ShotSolution, Failure> {
    let began = Instant::now();
    enclosure.without_specular("shooting")?;
    lighting.demand_opaque("shooting")?;
    let luminaires = luminaires(enclosure, lighting);
    let cells = Cells::new(enclosure);
    let needed = forecast(enclosure, lighting);
    if needed > settings.memory_limit {
        let patches = enclosure.patches().len();
        return Err(Failure::Memory { patches, needed, limit: settings.memory_limit });
    }
    let mut shooting = match start {
        Some(start) => start.clone(),
        None => Shooting::new(&cells, lighting, &luminaires, settings.seed, control)?,
    };
    let mut seconds = Seconds::default();
    loop {
        if shooting.rounds > 0 {
            let before = Instant::now();
            let answer = Answer::new(&shooting, &cells, lighting, &luminaires);
            seconds.solving += before.elapsed().as_secs_f64();
            let limit = limit(&shooting, &answer, settings, cells.per_side(), began.elapsed().as_secs_f64());
            if let Some(limit) = limit {
                seconds.total = began.elapsed().as_secs_f64();
                let mut report = answer.report(&shooting, &cells, lighting, &luminaires, settings.accuracy, limit);
                report.seconds = seconds;
                return Ok(answer.solution(enclosure, lighting, report, shooting));
            }
            shooting.plan(&answer);
        }
        let before = Instant::now();
        shooting.round(&cells, lighting, &luminaires, control)?;
        seconds.sampling += before.elapsed().as_secs_f64();
    }
}

/// What to stop for, if anything.
fn limit(
    shooting: &Shooting,
    answer: &Answer,
    settings: &ShootingSettings,
    per_side: usize,
    seconds: f64,
) -> Option<Limit> {
    let most = settings.max_rays / (REPLICATES * per_side) as u32;
    if answer.relative <= settings.accuracy || answer.mean_irradiance == 0.0 {
        Some(Limit::Accuracy)
    } else if answer.relative_cells > settings.accuracy && answer.relative_sampling < 0.5 * answer.relative_cells {
        Some(Limit::PatchSize)
    } else if shooting.rays >= most || shooting.light_samples >= most {
        Some(Limit::Rays)
    } else if seconds >= settings.time_limit {
        Some(Limit::Time)
    } else {
        None
    }
}

/// What is sampled by area: as for other solvers, unless emitters are too many.
fn luminaires(enclosure: &Enclosure, lighting: &Lighting) -> Luminaires {
    let mut luminaires = lighting.luminaires(enclosure);
    let emitters = luminaires.list.len() - lighting.lamps.len();
    if emitters > FEW_EMITTERS.max(MOST_LOOKS / enclosure.sides().max(1)) {
        luminaires.list.drain(..emitters);
        luminaires.strength.drain(..emitters);
    }
    luminaires
}

/// Bytes of an answer.
fn output(enclosure: &Enclosure, lighting: &Lighting) -> u64 {
    (enclosure.sides() * lighting.bands * 3 * size_of::<f64>()) as u64
}

/// The next number of samples after `n`: powers of two and one and a half times these, where sequences are even.
fn more(n: u32) -> u32 {
    match n {
        0 => FIRST,
        4 => 8,
        n if n.is_power_of_two() => n / 2 * 3,
        n => n / 3 * 4,
    }
}

#[cfg(test)]
mod tests;
