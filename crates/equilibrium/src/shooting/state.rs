//! What shooting remembers, and one more round of it.

use super::bounces::{self, Bounced, Effort};
use super::cells::Cells;
use super::gather::{Round, Seen, Sums, of_level};
use super::salvo::{Counts, Salvo};
use super::{Context, FIRST, REPLICATES, Replicate, SHOT_PER_GATHERED, Shares, WORTH, more};
use crate::lighting::Lighting;
use crate::shooting::answer::Answer;
use radiosity_exchange::luminaires::Luminaires;
use radiosity_exchange::{Enclosure, Luminaire};
use radiosity_geometry::sampling::Sequence;
use radiosity_operator::{Cancelled, Control};
use std::sync::atomic::AtomicU64;

/// Sums over all rays so far: enough to go on from and to answer with.
#[derive(Clone, Debug, PartialEq)]
pub struct Shooting {
    pub(super) seed: u64,
    pub(super) bands: usize,
    /// What it was shot in: of another scene it means nothing.
    pub(super) fingerprint: u64,
    pub(super) rounds: u32,
    /// Rays per cell of level 0 and replicate.
    pub(super) rays: u32,
    /// Light samples per cell and replicate.
    pub(super) light_samples: u32,
    /// Rays and light samples per cell that the next round goes on to.
    pub(super) next: (u32, u32),
    pub(super) rays_shot: u64,
    pub(super) rays_gathered: u64,
    pub(super) rays_escaped: u64,
    pub(super) bounces: u32,
    /// Power that the last bounces left unshot, relative to the first.
    pub(super) left: f64,
    /// The exposed share of each cell.
    pub(super) exposure: Vec<f32>,
    /// What coarser cells would change, times rays, by each half of the replicates, per cell.
    pub(super) changed: [Vec<f32>; 2],
    /// Rays that gathered and landed, per cell.
    pub(super) landed: Vec<u32>,
    pub(super) replicates: Vec<Replicate>,
}

/// Why a state cannot be gone on from.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct StateError(pub String);

/// The stream of sequences that feed salvos of emitters.
const EMITTERS: u32 = 5;

/// Rays of emitters per round and replicate, whose shares need no more than that: 4096 to a million.
const EMITTER_RAYS: (u64, u64) = (1 << 12, 1 << 20);

/// Bytes of a state and of what a round needs beside it.
pub(super) fn memory(cells: usize, bands: usize, luminaires: &Luminaires) -> u64 {
    let emitters = luminaires.list.iter().any(|l| matches!(l, Luminaire::Side(_)));
    let kept = REPLICATES * bands * size_of::<f32>() * if emitters { 4 } else { 3 } + 4 * size_of::<u32>();
    // Power, irradiance, shared irradiance, two counts; what is seen; offsets, levels and densities.
    let round = bands * (5 * size_of::<f64>() + 2 * size_of::<f32>()) + 4 * size_of::<f32>() + size_of::<u64>() + 1;
    (cells * (kept + round)) as u64
}

impl Shooting {
    pub(super) fn new(
        cells: &Cells,
        lighting: &Lighting,
        luminaires: &Luminaires,
        seed: u64,
        control: &Control,
    ) -> Result<Self, Cancelled> {
        let (count, bands) = (cells.count(), lighting.bands);
        let size = count * bands;
        let emitters = luminaires.list.len() > lighting.lamps.len();
        let replicate = Replicate {
            from_lights: vec![0.0; size],
            from_emitters: if emitters { vec![0.0; size] } else { Vec::new() },
            gathered: vec![0.0; size],
            bounced: vec![0.0; size],
            emitters: Shares::new(bands),
            others: Shares::new(bands),
        };
        Ok(Self {
            seed,
            bands,
            fingerprint: fingerprint(cells.enclosure, lighting),
            rounds: 0,
            rays: 0,
            light_samples: 0,
            next: (FIRST, if luminaires.list.is_empty() { 0 } else { FIRST }),
            rays_shot: 0,
            rays_gathered: 0,
            rays_escaped: 0,
            bounces: 0,
            left: 0.0,
            exposure: super::exposure::exposure(cells, seed, control)?,
            changed: [vec![0.0; count], vec![0.0; count]],
            landed: vec![0; count],
            replicates: vec![replicate; REPLICATES],
        })
    }

    /// Decides what the next round adds: what the larger part of the error comes from.
    pub(super) fn plan(&mut self, answer: &Answer) {
        let all = answer.direct_variance + answer.indirect_variance;
        self.next = (self.rays, self.light_samples);
        if answer.indirect_variance >= WORTH * all {
            self.next.0 = more(self.rays);
        }
        if answer.direct_variance >= WORTH * all && self.light_samples > 0 {
            self.next.1 = more(self.light_samples);
        }
    }

    /// One more round by every replicate.
    pub(super) fn round(
        &mut self,
        cells: &Cells,
        lighting: &Lighting,
        luminaires: &Luminaires,
        control: &Control,
    ) -> Result<(), Cancelled> {
        let levels = levels(cells);
        self.announce(&levels, control);
        let (mut landed, mut changed) = (std::mem::take(&mut self.landed), std::mem::take(&mut self.changed));
        for number in 0..REPLICATES {
            let mut replicate = std::mem::take(&mut self.replicates[number]);
            let exposure = std::mem::take(&mut self.exposure);
            let context = Context { cells, lighting, exposure: &exposure, seed: self.seed, control };
            let task = Task { context, luminaires, levels: &levels, number: number as u32 };
            let half = number * changed.len() / REPLICATES;
            task.round(self, &mut replicate, &mut changed[half], &mut landed)?;
            self.replicates[number] = replicate;
            self.exposure = exposure;
        }
        (self.landed, self.changed) = (landed, changed);
        (self.rays, self.light_samples) = self.next;
        self.rounds += 1;
        Ok(())
    }

    fn announce(&self, levels: &[i8], control: &Control) {
        let new = |level: i8| u64::from(of_level(self.next.0, level) - of_level(self.rays, level));
        let gathered: u64 = levels.iter().map(|&l| new(l)).sum();
        let tests = levels.len() as u64 * u64::from(self.next.1 - self.light_samples);
        // Later bounces together take about as many rays as the first.
        let shot = (2.0 * SHOT_PER_GATHERED * gathered as f64) as u64;
        control.expect(REPLICATES as u64 * (gathered + shot + tests));
    }

    /// Light samples of all cells and replicates.
    pub(super) fn shadow_rays(&self) -> u64 {
        (self.exposure.len() * REPLICATES) as u64 * u64::from(self.light_samples)
    }

    /// Bytes held.
    pub fn memory_bytes(&self) -> usize {
        let of = |r: &Replicate| r.from_lights.len() + r.from_emitters.len() + r.gathered.len() + r.bounced.len();
        4 * (4 * self.exposure.len() + self.replicates.iter().map(of).sum::<usize>())
    }

    /// `Err` unless it was shot in this scene.
    pub fn belongs_to(&self, enclosure: &Enclosure, lighting: &Lighting) -> Result<(), StateError> {
        if self.fingerprint == fingerprint(enclosure, lighting) {
            return Ok(());
        }
        let message = "the state was shot in another scene: go on with the patches, materials and lights it began with";
        Err(StateError(message.into()))
    }
}

/// One replicate in one round.
struct Task<'a> {
    context: Context<'a>,
    luminaires: &'a Luminaires,
    levels: &'a [i8],
    number: u32,
}

impl Task<'_> {
    fn round(
        &self,
        state: &mut Shooting,
        replicate: &mut Replicate,
        changed: &mut [f32],
        landed: &mut [u32],
    ) -> Result<(), Cancelled> {
        let (rays, lights) = state.next;
        if lights > state.light_samples {
            let range = (state.light_samples, lights - state.light_samples);
            super::direct::sample(&self.context, self.luminaires, self.number, range, replicate)?;
            self.shoot_from_emitters(state, replicate)?;
        }
        if rays > state.rays {
            self.indirect(state, lights, replicate, changed, landed)?;
        }
        Ok(())
    }

    /// Finds what part of the power of emitters lands: area samples do not say.
    fn shoot_from_emitters(&self, state: &mut Shooting, replicate: &mut Replicate) -> Result<(), Cancelled> {
        if replicate.from_emitters.is_empty() {
            return Ok(());
        }
        let bands = self.context.lighting.bands;
        let power = self.emitter_power();
        let cells = (power.len() / bands) as u64;
        let rays = (cells * u64::from(state.next.1 - state.light_samples) / 4).clamp(EMITTER_RAYS.0, EMITTER_RAYS.1);
        let stream = EMITTERS + (state.rounds << 4);
        let [offset, ..] = Sequence::new(state.seed, u32::MAX, self.number, stream).point(0);
        let salvo = Salvo::new(&power, bands, rays, offset);
        let losses = salvo.shoot(&self.context, self.number, stream, &Counts::new(power.len()), None)?;
        let first: Vec<f64> =
            (0..bands).map(|b| (0..power.len() / bands).map(|s| power[s * bands + b]).sum()).collect();
        let mut shares = Shares::new(bands);
        shares.add(&[losses], &first);
        replicate.emitters.add_weighted(&shares, salvo.rays() as f64);
        state.rays_shot += salvo.rays();
        Ok(())
    }

    /// Power of the exposed part of emitters that are sampled by area, W.
    fn emitter_power(&self) -> Vec<f64> {
        let (cells, lighting) = (self.context.cells, self.context.lighting);
        let mut power = vec![0.0; cells.count() * lighting.bands];
        let each = cells.per_side();
        for luminaire in &self.luminaires.list {
            if let Luminaire::Side(side) = *luminaire {
                for cell in side as usize * each..(side as usize + 1) * each {
                    let area = cells.area(cell) * f64::from(self.context.exposure[cell]);
                    let emission = lighting.emission_of(cells.patch_of(cell));
                    let out = &mut power[cell * lighting.bands..][..lighting.bands];
                    out.iter_mut().zip(emission).for_each(|(p, e)| *p = area * e);
                }
            }
        }
        power
    }

    fn indirect(
        &self,
        state: &mut Shooting,
        lights: u32,
        replicate: &mut Replicate,
        changed: &mut [f32],
        landed: &mut [u32],
    ) -> Result<(), Cancelled> {
        let context = &self.context;
        let (cells, bands) = (context.cells, context.lighting.bands);
        let (count, rays) = (cells.count(), state.next.0);
        let new = |cell: usize| of_level(rays, self.levels[cell]) - of_level(state.rays, self.levels[cell]);
        let density: Vec<f32> = (0..count).map(|c| (f64::from(new(c)) / cells.area(c)) as f32).collect();
        let gathered: u64 = (0..count).map(|c| u64::from(new(c))).sum();
        let direct = super::answer::direct(replicate, context, self.luminaires, lights);
        let power = direct.first_power(context, self.luminaires);
        drop(direct);
        let mut seen = Seen::new(bands, count);
        let effort = Effort {
            replicate: self.number,
            round: state.rounds,
            first: (SHOT_PER_GATHERED * gathered as f64) as u64,
            later: later(context),
        };
        let bounced = bounces::shoot(context, effort, power, &density, |salvo| {
            for (cell, (_, _, shot)) in seen.of_mut().enumerate() {
                let area = cells.area(cell) * f64::from(context.exposure[cell]);
                *shot = if area > 0.0 { (salvo.expected(cell) / area) as f32 } else { 0.0 };
            }
        })?;
        let weight = f64::from(rays - state.rays);
        self.remember(state, replicate, &bounced, weight);
        self.look(state, replicate, &mut seen);
        let escaped = AtomicU64::new(0);
        let span = (state.rays, rays);
        let round =
            Round { replicate: self.number, rays: span, levels: self.levels, density: &density, escaped: &escaped };
        let Bounced { irradiance, shared, .. } = bounced;
        drop(irradiance);
        replicate.gathered.iter_mut().zip(&shared).for_each(|(g, s)| *g += (weight * s) as f32);
        let sums = Sums { gathered: &mut replicate.gathered, changed, landed };
        round.gather(context, &seen, weight, sums)?;
        state.rays_gathered += gathered;
        state.rays_escaped += escaped.into_inner();
        Ok(())
    }

    fn remember(&self, state: &mut Shooting, replicate: &mut Replicate, bounced: &Bounced, weight: f64) {
        replicate.bounced.iter_mut().zip(&bounced.irradiance).for_each(|(b, h)| *b += (weight * h) as f32);
        replicate.others.add_weighted(&bounced.shares, weight);
        state.rays_shot += bounced.rays;
        state.bounces = state.bounces.max(bounced.bounces);
        state.left = bounced.left;
    }

    /// Fills in the radiosity of the exposed parts as far as it is known by now.
    fn look(&self, state: &Shooting, replicate: &Replicate, seen: &mut Seen) {
        let context = &self.context;
        let bands = context.lighting.bands;
        let (before, now) = (f64::from(state.rays), f64::from(state.next.0));
        let direct = super::answer::direct(replicate, context, self.luminaires, state.next.1);
        let emission = direct.emission(context, self.luminaires);
        for (cell, (first, rest, _)) in seen.of_mut().enumerate() {
            let exposure = f64::from(context.exposure[cell]);
            let per_exposed = if exposure > 0.0 { 1.0 / exposure } else { 0.0 };
            let reflectance = context.lighting.reflectance_of(context.cells.patch_of(cell));
            for b in 0..bands {
                let k = cell * bands + b;
                let indirect = indirect(f64::from(replicate.bounced[k]), now, f64::from(replicate.gathered[k]), before);
                first[b] = (emission(cell, b) + reflectance[b] * direct.irradiance(k) * per_exposed) as f32;
                rest[b] = (reflectance[b] * indirect * per_exposed) as f32;
            }
        }
        seen.compare(context.cells);
    }
}

/// Indirect irradiance by both ways as far as they went: sums, each over so many rays.
fn indirect(bounced: f64, shot: f64, gathered: f64, before: f64) -> f64 {
    let by_shooting = bounced / shot;
    if before > 0.0 { 0.5 * (by_shooting + gathered / before) } else { by_shooting }
}

/// Rays per power of later bounces relative to the first: as many rays in all, where much is reflected.
fn later(context: &Context) -> f64 {
    let (enclosure, lighting) = (context.cells.enclosure, context.lighting);
    let (mut reflected, mut area) = (0.0, 0.0);
    for side in 0..enclosure.sides() {
        let highest = lighting.reflectance_of(enclosure.patch_of(side)).iter().fold(0.0, |a: f64, &b| a.max(b));
        reflected += enclosure.area(side) * highest;
        area += enclosure.area(side);
    }
    ((area - reflected) / reflected.max(f64::MIN_POSITIVE)).min(1.0)
}

/// How many more rays than average a cell deserves, as a power of two: an error counts by area, so most is gained by
/// rays in proportion to its square root.
pub(super) fn levels(cells: &Cells) -> Vec<i8> {
    let count = cells.count();
    let mean = (0..count).map(|c| cells.area(c).sqrt()).sum::<f64>() / count.max(1) as f64;
    let level = |cell| {
        let relative = cells.area(cell).sqrt() / mean;
        if relative > 0.0 { relative.log2().round().clamp(-2.0, 6.0) as i8 } else { -2 }
    };
    (0..count).map(level).collect()
}

/// A number that other geometry or lighting would not have (Fowler, Noll and Vo).
fn fingerprint(enclosure: &Enclosure, lighting: &Lighting) -> u64 {
    let patches = enclosure.patches();
    let corners = patches.polygons.iter().chain(&patches.obstructions).flatten().flat_map(|p| p.to_array());
    let lamps = lighting.lamps.iter().flat_map(|lamp| {
        let (a, b, [c, d]) = match lamp.luminaire {
            Luminaire::Point { position } => (position, position, [0.0; 2]),
            Luminaire::Spot { position, direction, cos_inner, cos_outer } => {
                (position, direction, [cos_inner, cos_outer])
            }
            Luminaire::Directional { direction } => (direction, -direction, [0.0; 2]),
            Luminaire::Side(side) => (glam::DVec3::splat(f64::from(side)), glam::DVec3::ZERO, [0.0; 2]),
        };
        [a.to_array(), b.to_array()].concat().into_iter().chain([c, d]).chain(lamp.strength.clone()).collect::<Vec<_>>()
    });
    let numbers =
        corners.chain(lighting.reflectance.iter().copied()).chain(lighting.emission.iter().copied()).chain(lamps);
    let words = numbers.map(f64::to_bits).chain(patches.two_sided.iter().map(|&b| u64::from(b)));
    words.fold(0xcbf2_9ce4_8422_2325, |hash, word| (hash ^ word).wrapping_mul(0x0000_0100_0000_01b3).rotate_left(5))
}
