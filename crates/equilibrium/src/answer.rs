//! From the samples to irradiance: solve on sides, sweep to elements, gather per replicate.

mod transposed;

use crate::lighting::Lighting;
use crate::solve::Measurement;
use crate::translucency::Translucency;
use crate::transport::Transport;
use radiosity_exchange::{Elements, Luminaire, Shot};
use radiosity_operator::{Cancelled, Control, Operator};
use radiosity_solvers::{Problem, SolveOptions, SolveReport};
use rayon::prelude::*;

/// Irradiance with all that the error estimate needs. Blocks are sides x bands.
pub(crate) struct Answer {
    /// Irradiance of each replicate that came by rays: sides x replicates x bands.
    pub by_rays: Vec<f64>,
    /// Irradiance of each replicate that came straight from luminaires: sides x replicates x bands.
    pub by_lights: Vec<f64>,
    /// The error that constant radiosity on elements leaves, per side and band: a share of what elements changed.
    pub by_elements: Vec<f64>,
    /// Mean over replicates.
    pub irradiance: Vec<f64>,
    /// What each cell of a side received: sides x replicates x [`CELLS`] x bands.
    pub by_cell: Vec<f32>,
    /// What leaves the scene, W per m2 of the side.
    pub escaped: Vec<f64>,
    /// What ends on black backs, or never leaves because a solid stands there, W per m2 of the side.
    pub lost: Vec<f64>,
    /// What is not followed to its end between mirrors, W per m2 of the side.
    pub unfollowed: Vec<f64>,
    /// How the solve on sides went.
    pub solver: SolveReport,
}

/// A solver of the crate `radiosity-solvers`.
pub(crate) type Solver = fn(&Problem, &SolveOptions, &Control) -> Result<(Vec<f64>, SolveReport), Cancelled>;

/// Everything that stays the same through one answer.
pub(crate) struct Task<'a> {
    pub measurement: &'a Measurement,
    pub lighting: &'a Lighting,
    pub solver: Solver,
    pub options: SolveOptions<'a>,
    /// Whether the answer is wanted as a field, not as means of patches only.
    pub as_field: bool,
    /// How much an error on each patch matters; nothing for all the same.
    pub importance: &'a [f64],
    pub control: &'a Control,
}

/// Sides per parallel task.
const SIDES_PER_TASK: usize = 32;

/// Sides are looked at in `2^level x 2^level` cells to tell how light varies over them.
pub(crate) const CELL_LEVEL: u32 = 2;
pub(crate) const CELLS: usize = 1 << (2 * CELL_LEVEL);

/// Bounces on elements after the solve on sides: each takes the error of seeing whole sides to the next order.
const SWEEPS: usize = 2;

/// The error left by halving sides 0, 1, 2, 3 times as a share of the change that made: first order in the size of
/// elements, which is the worst case. A lamp, which is not halved, does not vary.
const ERROR_LEFT: [f64; 4] = [0.0, 0.5, 0.25, 0.125];

/// Values per band of some element, side or luminaire, for `C` bands at a time.
type Values<const C: usize> = [f64; C];

/// Radiosity of elements beside the means of their sides, both of the exposed part.
struct Fine<const C: usize> {
    elements: Vec<Values<C>>,
    sides: Vec<Values<C>>,
}

impl Task<'_> {
    /// Solves on sides, then takes two more bounces on elements.
    pub fn answer(&self) -> Result<Answer, Cancelled> {
        let (radiosity, solver) = self.solve_on_sides(&self.measurement.exchange.exposed_area)?;
        self.finish_all(&self.elements(), SWEEPS, &radiosity, solver)
    }

    /// Irradiance as the exchange between whole sides has it, sides x bands: what an answer begins with.
    pub fn on_sides(&self) -> Result<Vec<f64>, Cancelled> {
        let exchange = &self.measurement.exchange;
        let (area, bands) = (&exchange.exposed_area, self.lighting.bands);
        let (radiosity, _) = self.solve_on_sides(area)?;
        let mut irradiance = vec![0.0; radiosity.len()];
        exchange.operator.apply(&radiosity, &mut irradiance, bands);
        let incident = self.incident(area);
        for (row, (h, h0)) in irradiance.iter_mut().zip(&incident).enumerate() {
            *h = ratio(*h, area[row / bands]) + h0;
        }
        Ok(irradiance)
    }

    /// The area of a side times how much an error on it matters.
    pub fn weight(&self, side: usize) -> f64 {
        let enclosure = self.transport().enclosure();
        enclosure.counted_area(side) * self.importance.get(enclosure.patch_of(side)).unwrap_or(&1.0)
    }

    /// `B = E + rho H + tau H'`, sides x bands, where H' is that of the other side.
    pub fn radiosity(&self, lighting: &Lighting, irradiance: &[f64]) -> Vec<f64> {
        let emission = self.per_side(|p| lighting.emission_of(p));
        let reflectance = self.per_side(|p| lighting.reflectance_of(p));
        let mut radiosity: Vec<f64> =
            emission.iter().zip(&reflectance).zip(irradiance).map(|((e, rho), h)| e + rho * h).collect();
        Translucency::new(self.transport().enclosure(), lighting).add(irradiance, &mut radiosity);
        radiosity
    }

    fn finish_all(
        &self,
        elements: &Elements,
        sweeps: usize,
        radiosity: &[f64],
        solver: SolveReport,
    ) -> Result<Answer, Cancelled> {
        let (sides, bands) = (self.sides(), self.lighting.bands);
        let width = bands * self.transport().shots().replicates();
        let mut answer = Answer {
            by_rays: vec![0.0; sides * width],
            by_lights: vec![0.0; sides * width],
            by_elements: vec![0.0; sides * bands],
            irradiance: vec![0.0; sides * bands],
            by_cell: vec![0.0; sides * width * CELLS],
            escaped: vec![0.0; sides * bands],
            lost: vec![0.0; sides * bands],
            unfollowed: vec![0.0; sides * bands],
            solver,
        };
        // Three bands at a time, as most scenes have, then what is left one by one.
        let threes = bands - bands % 3;
        for first in (0..threes).step_by(3) {
            self.finish::<3>(first, elements, sweeps, radiosity, &mut answer)?;
        }
        for first in threes..bands {
            self.finish::<1>(first, elements, sweeps, radiosity, &mut answer)?;
        }
        Ok(answer)
    }

    fn transport(&self) -> &Transport {
        &self.measurement.transport
    }

    fn sides(&self) -> usize {
        self.transport().enclosure().sides()
    }

    /// A block with each side's patch's values.
    fn per_side<'b>(&'b self, of_patch: impl Fn(usize) -> &'b [f64]) -> Vec<f64> {
        (0..self.sides()).flat_map(|side| of_patch(self.transport().enclosure().patch_of(side))).copied().collect()
    }

    fn solve_on_sides(&self, area: &[f64]) -> Result<(Vec<f64>, SolveReport), Cancelled> {
        let reflectance = self.per_side(|p| self.lighting.reflectance_of(p));
        let emission = self.per_side(|p| self.lighting.emission_of(p));
        let incident = self.incident(area);
        let problem: Problem = Problem {
            exchange: &self.measurement.exchange.operator,
            area,
            reflectance: &reflectance,
            emission: &emission,
            incident: &incident,
            bands: self.lighting.bands,
        };
        let enclosure = self.transport().enclosure();
        let exposure = |side: usize| ratio(area[side], enclosure.diffuse_area(side));
        Translucency::new(enclosure, self.lighting).solve(&problem, exposure, self.solver, &self.options, self.control)
    }

    /// Irradiance of that much of each side from lights without area, sides x bands.
    fn incident(&self, area: &[f64]) -> Vec<f64> {
        let bands = self.lighting.bands;
        let mut incident = vec![0.0; self.sides() * bands];
        if self.lighting.lamps.is_empty() {
            return incident;
        }
        incident.par_chunks_mut(bands).enumerate().with_min_len(SIDES_PER_TASK).for_each(|(side, out)| {
            for sample in self.transport().lights().of(side).flatten() {
                if let Some(lamp) = self.lamp(sample.luminaire) {
                    out.iter_mut().zip(lamp).for_each(|(o, l)| *o += f64::from(sample.weight) * l);
                }
            }
            let exposure = ratio(area[side], self.transport().enclosure().diffuse_area(side));
            let scale = ratio(1.0, self.light_samples(side) * exposure);
            out.iter_mut().for_each(|o| *o *= scale);
        });
        incident
    }

    /// Power that lights without area put on surfaces, per band, W.
    pub fn incident_power(&self) -> Vec<f64> {
        let bands = self.lighting.bands;
        let mut power = vec![0.0; bands];
        let area = &self.measurement.exchange.exposed_area;
        for (side, incident) in self.incident(area).chunks_exact(bands).enumerate() {
            power.iter_mut().zip(incident).for_each(|(p, i)| *p += area[side] * i);
        }
        power
    }

    /// Power of lights without area that arrives by more mirrors than their images are followed through, per band, W.
    pub fn unfollowed_of_lights(&self) -> Vec<f64> {
        let mut power = vec![0.0; self.lighting.bands];
        for lamp in &self.lighting.lamps {
            let left_out = self.transport().left_out(&lamp.luminaire);
            power.iter_mut().zip(&lamp.strength).for_each(|(p, s)| *p += left_out * s);
        }
        power
    }

    /// The other side of a patch that light passes through, and what passes.
    pub fn through(&self, side: usize) -> Option<(usize, &[f64])> {
        let enclosure = self.transport().enclosure();
        let transmittance = self.lighting.diffuse_transmittance_of(enclosure.patch_of(side))?;
        Some((enclosure.opposite(side)?, transmittance))
    }

    /// The strength per band of a luminaire that is a light without area.
    fn lamp(&self, luminaire: u32) -> Option<&[f64]> {
        let emitters = self.transport().luminaires().len() - self.lighting.lamps.len();
        (luminaire as usize).checked_sub(emitters).map(|k| self.lighting.lamps[k].strength.as_slice())
    }

    /// Light samples of a side, all replicates together.
    fn light_samples(&self, side: usize) -> f64 {
        f64::from(self.transport().lights().per_replicate(side)) * self.transport().lights().replicates() as f64
    }

    /// As many elements as the samples of a side can resolve; a lamp stays whole.
    fn elements(&self) -> Elements {
        let (shots, lights) = (self.transport().shots(), self.transport().lights());
        let replicates = shots.replicates() as u32;
        let has_luminaires = !self.transport().luminaires().is_empty();
        let resolved = |side| {
            let rays = shots.per_replicate(side) * replicates;
            // Direct light is smooth but for shadows: a quarter of the samples resolves it as well.
            let tests = if has_luminaires { 4 * lights.per_replicate(side) * replicates } else { u32::MAX };
            match rays.min(tests) {
                _ if self.transport().is_lamp(side) => 0,
                0..64 => 0,
                64..256 => 1,
                256..2048 => 2,
                _ => 3,
            }
        };
        // Both sides of a sheet alike, so that what passes finds the element across.
        let across = |side| self.through(side).map_or(u8::MAX, |(other, _)| resolved(other));
        Elements::new((0..self.sides()).map(|side| resolved(side).min(across(side))).collect())
    }

    /// Takes `C` bands from the solution on sides to the answer.
    fn finish<const C: usize>(
        &self,
        first: usize,
        elements: &Elements,
        sweeps: usize,
        radiosity: &[f64],
        answer: &mut Answer,
    ) -> Result<(), Cancelled> {
        let bands = self.lighting.bands;
        let of = |block: &[f64], row: usize| -> Values<C> { std::array::from_fn(|c| block[row * bands + first + c]) };
        let sides: Vec<Values<C>> = (0..self.sides()).map(|side| of(radiosity, side)).collect();
        let strengths: Vec<Values<C>> =
            self.lighting.lamps.iter().map(|l| std::array::from_fn(|c| l.strength[first + c])).collect();
        let flat = (0..self.sides()).flat_map(|side| elements.of(side).map(move |_| side));
        let mut fine = Fine { elements: flat.map(|side| sides[side]).collect(), sides };
        for _ in 0..sweeps {
            self.control.check()?;
            fine = self.sweep(first, elements, &strengths, &fine);
        }
        self.control.check()?;
        let replicates = self.transport().shots().replicates();
        let gathered: Vec<Gathered<C>> = (0..self.sides())
            .into_par_iter()
            .with_min_len(SIDES_PER_TASK)
            .map(|side| self.gather(first, elements, &strengths, &fine, side))
            .collect();
        for (side, g) in gathered.iter().enumerate() {
            for c in 0..C {
                let k = side * bands + first + c;
                answer.by_elements[k] = g.by_elements[c];
                answer.escaped[k] = g.escaped[c];
                answer.lost[k] = g.lost[c];
                answer.unfollowed[k] = g.unfollowed[c];
                for r in 0..replicates {
                    answer.by_rays[(side * replicates + r) * bands + first + c] = g.by_rays[r][c];
                    answer.by_lights[(side * replicates + r) * bands + first + c] = g.by_lights[r][c];
                    for cell in 0..CELLS {
                        let row = (side * replicates + r) * CELLS + cell;
                        answer.by_cell[row * bands + first + c] = g.by_cell[r * CELLS + cell][c];
                    }
                    answer.irradiance[k] += (g.by_rays[r][c] + g.by_lights[r][c]) / replicates as f64;
                }
            }
        }
        Ok(())
    }

    /// One more bounce, from elements to elements, through each side's own samples.
    fn sweep<const C: usize>(
        &self,
        first: usize,
        elements: &Elements,
        strengths: &[Values<C>],
        fine: &Fine<C>,
    ) -> Fine<C> {
        let per_side: Vec<(Vec<Values<C>>, Values<C>)> = (0..self.sides())
            .into_par_iter()
            .with_min_len(SIDES_PER_TASK)
            .map(|side| self.sweep_side(first, elements, strengths, fine, side))
            .collect();
        Fine {
            sides: per_side.iter().map(|(_, mean)| *mean).collect(),
            elements: per_side.into_iter().flat_map(|(fine, _)| fine).collect(),
        }
    }

    fn sweep_side<const C: usize>(
        &self,
        first: usize,
        elements: &Elements,
        strengths: &[Values<C>],
        fine: &Fine<C>,
        side: usize,
    ) -> (Vec<Values<C>>, Values<C>) {
        let seen = self.see(elements, strengths, fine, side);
        let patch = self.transport().enclosure().patch_of(side);
        let of = |block: &[f64]| -> Values<C> { std::array::from_fn(|c| block[first + c]) };
        let emission = of(self.lighting.emission_of(patch));
        let reflectance = of(self.lighting.reflectance_of(patch));
        let whole = seen.iter().fold(Seen::default(), |a, b| a.plus(b));
        let radiosity = |s: &Seen<C>| {
            let irradiance = s.irradiance(&whole);
            std::array::from_fn(|c| emission[c] + reflectance[c] * irradiance[c])
        };
        let mut values: Vec<Values<C>> = seen.iter().map(radiosity).collect();
        if let Some((other, transmittance)) = self.through(side) {
            let transmittance = of(transmittance);
            for (value, arriving) in values.iter_mut().zip(self.arriving(elements, strengths, fine, other)) {
                (0..C).for_each(|c| value[c] += transmittance[c] * arriving[c]);
            }
        }
        let mean = mean_over_exposed(&seen, &values).unwrap_or(emission);
        (values, mean)
    }

    /// Irradiance of all of each element of a side, where what is buried is dark.
    fn arriving<const C: usize>(
        &self,
        elements: &Elements,
        strengths: &[Values<C>],
        fine: &Fine<C>,
        side: usize,
    ) -> Vec<Values<C>> {
        let seen = self.see(elements, strengths, fine, side);
        let whole = seen.iter().fold(Seen::default(), |a, b| a.plus(b));
        seen.iter().map(|s| s.irradiance(&whole).map(|h| h * s.exposure(&whole))).collect()
    }

    /// What the elements of a side see through its samples.
    fn see<const C: usize>(
        &self,
        elements: &Elements,
        strengths: &[Values<C>],
        fine: &Fine<C>,
        side: usize,
    ) -> Vec<Seen<C>> {
        let (start, count) = (elements.of(side).start, elements.of(side).len());
        let mut seen = vec![Seen::<C>::default(); count];
        for shot in self.transport().shots().of(side).flatten() {
            let element = &mut seen[elements.at(side, shot.origin_cell) - start];
            element.shots += 1;
            element.buried += u32::from(shot.target() == Shot::BURIED);
            if let Some(e) = self.seen_by_ray(elements, shot) {
                add(&mut element.by_rays, 1.0, &fine.elements[e]);
            }
        }
        for sample in self.transport().lights().of(side).flatten() {
            let element = &mut seen[elements.at(side, sample.origin_cell) - start];
            element.lights += 1;
            if sample.weight > 0.0 {
                let source = self.source(sample.luminaire, strengths, fine);
                add(&mut element.by_lights, f64::from(sample.weight), source);
            }
        }
        seen
    }

    /// The element a ray sees, unless that is measured by area or there is none.
    #[inline]
    fn seen_by_ray(&self, elements: &Elements, shot: &Shot) -> Option<usize> {
        let target = shot.target() as usize;
        (shot.landed() && (!self.transport().is_lamp(target) || shot.is_beyond_images()))
            .then(|| elements.at(target, shot.target_cell))
    }

    /// What a luminaire sends per unit of its samples' weight.
    fn source<'b, const C: usize>(
        &self,
        luminaire: u32,
        strengths: &'b [Values<C>],
        fine: &'b Fine<C>,
    ) -> &'b Values<C> {
        match self.transport().luminaires()[luminaire as usize] {
            Luminaire::Side(side) => &fine.sides[side as usize],
            // Lights without area stand after the emitters.
            _ => &strengths[luminaire as usize + strengths.len() - self.transport().luminaires().len()],
        }
    }

    fn gather<const C: usize>(
        &self,
        first: usize,
        elements: &Elements,
        strengths: &[Values<C>],
        fine: &Fine<C>,
        side: usize,
    ) -> Gathered<C> {
        let replicates = self.transport().shots().replicates();
        let per_ray = ratio(1.0, f64::from(self.transport().shots().per_replicate(side)));
        let per_light = ratio(1.0, f64::from(self.transport().lights().per_replicate(side)));
        let per_shot = per_ray / replicates as f64;
        let mut g = Gathered {
            by_rays: vec![[0.0; C]; replicates],
            by_lights: vec![[0.0; C]; replicates],
            by_cell: Vec::with_capacity(replicates * CELLS),
            by_elements: [0.0; C],
            escaped: [0.0; C],
            lost: [0.0; C],
            unfollowed: [0.0; C],
        };
        let own_emission = self.lighting.emission_of(self.transport().enclosure().patch_of(side));
        let own_emission: Values<C> = std::array::from_fn(|c| own_emission[first + c]);
        for r in 0..replicates {
            let (mut rays, mut lights) = ([0.0; C], [0.0; C]);
            let (mut cell_rays, mut cell_lights) = ([Tally::default(); CELLS], [Tally::default(); CELLS]);
            for shot in self.transport().shots().replicate(side, r).flatten() {
                let cell = &mut cell_rays[shot.origin_cell.coarse(CELL_LEVEL)];
                cell.count += 1;
                if let Some(e) = self.seen_by_ray(elements, shot) {
                    let (value, mean) = (&fine.elements[e], &fine.sides[shot.target() as usize]);
                    let left = ERROR_LEFT[elements.level(shot.target() as usize) as usize];
                    add(&mut cell.sum, 1.0, value);
                    for c in 0..C {
                        rays[c] += value[c];
                        g.by_elements[c] += left * (value[c] - mean[c]);
                    }
                } else {
                    let own = || &fine.elements[elements.at(side, shot.origin_cell)];
                    match shot.target() {
                        Shot::ESCAPED => add(&mut g.escaped, per_shot, own()),
                        Shot::BACK => add(&mut g.lost, per_shot, own()),
                        Shot::BURIED => add(&mut g.lost, per_shot, &own_emission),
                        Shot::LOST => add(&mut g.unfollowed, per_shot, own()),
                        _ => {}
                    }
                }
            }
            for sample in self.transport().lights().replicate(side, r).flatten() {
                let cell = &mut cell_lights[sample.origin_cell.coarse(CELL_LEVEL)];
                cell.count += 1;
                if sample.weight > 0.0 {
                    let source = self.source(sample.luminaire, strengths, fine);
                    add(&mut cell.sum, f64::from(sample.weight), source);
                    add(&mut lights, f64::from(sample.weight), source);
                }
            }
            g.by_rays[r] = rays.map(|v| v * per_ray);
            g.by_lights[r] = lights.map(|v| v * per_light);
            for (rays, lights) in cell_rays.iter().zip(&cell_lights) {
                let (rays, lights) = (rays.mean_or(&g.by_rays[r]), lights.mean_or(&g.by_lights[r]));
                g.by_cell.push(std::array::from_fn(|c| (rays[c] + lights[c]) as f32));
            }
        }
        g.by_elements = g.by_elements.map(|v| v * per_shot);
        g
    }
}

/// What the samples of one element add up to.
#[derive(Clone, Copy)]
struct Seen<const C: usize> {
    by_rays: Values<C>,
    by_lights: Values<C>,
    shots: u32,
    buried: u32,
    lights: u32,
}

impl<const C: usize> Default for Seen<C> {
    fn default() -> Self {
        Self { by_rays: [0.0; C], by_lights: [0.0; C], shots: 0, buried: 0, lights: 0 }
    }
}

impl<const C: usize> Seen<C> {
    /// Rays from the part that is not buried.
    fn open(&self) -> f64 {
        f64::from(self.shots - self.buried)
    }

    fn plus(mut self, other: &Seen<C>) -> Self {
        add(&mut self.by_rays, 1.0, &other.by_rays);
        add(&mut self.by_lights, 1.0, &other.by_lights);
        self.shots += other.shots;
        self.buried += other.buried;
        self.lights += other.lights;
        self
    }

    /// Irradiance of the exposed part. An element that no sample of one kind fell on has its side's of that kind.
    fn irradiance(&self, whole: &Seen<C>) -> Values<C> {
        let (by_rays, by_lights) = self.or(whole);
        let (per_ray, per_light) = self.weights(whole);
        std::array::from_fn(|c| by_rays.by_rays[c] * per_ray + by_lights.by_lights[c] * per_light)
    }

    /// Whose rays and whose light samples count.
    fn or<'a>(&'a self, whole: &'a Seen<C>) -> (&'a Seen<C>, &'a Seen<C>) {
        (if self.shots > 0 { self } else { whole }, if self.lights > 0 { self } else { whole })
    }

    /// What a ray and a light sample of those count.
    fn weights(&self, whole: &Seen<C>) -> (f64, f64) {
        let (by_rays, by_lights) = self.or(whole);
        (ratio(1.0, by_rays.open()), ratio(1.0, f64::from(by_lights.lights) * self.exposure(whole)))
    }

    /// The share that is not buried.
    fn exposure(&self, whole: &Seen<C>) -> f64 {
        let by_rays = self.or(whole).0;
        ratio(by_rays.open(), f64::from(by_rays.shots))
    }
}

/// Samples of a cell and their sum.
#[derive(Clone, Copy)]
struct Tally<const C: usize> {
    sum: Values<C>,
    count: u32,
}

impl<const C: usize> Default for Tally<C> {
    fn default() -> Self {
        Self { sum: [0.0; C], count: 0 }
    }
}

impl<const C: usize> Tally<C> {
    /// The mean of the samples; what the whole has where there are none.
    fn mean_or(&self, whole: &Values<C>) -> Values<C> {
        if self.count > 0 { self.sum.map(|v| v / f64::from(self.count)) } else { *whole }
    }
}

/// What a side gathers, per replicate.
struct Gathered<const C: usize> {
    by_rays: Vec<Values<C>>,
    by_lights: Vec<Values<C>>,
    /// Replicates x [`CELLS`].
    by_cell: Vec<[f32; C]>,
    by_elements: Values<C>,
    escaped: Values<C>,
    lost: Values<C>,
    unfollowed: Values<C>,
}

fn mean_over_exposed<const C: usize>(seen: &[Seen<C>], values: &[Values<C>]) -> Option<Values<C>> {
    let total: f64 = seen.iter().map(Seen::open).sum();
    let mut mean = [0.0; C];
    for (s, v) in seen.iter().zip(values) {
        add(&mut mean, ratio(s.open(), total), v);
    }
    (total > 0.0).then_some(mean)
}

#[inline]
fn add<const C: usize>(out: &mut Values<C>, weight: f64, values: &Values<C>) {
    for c in 0..C {
        out[c] += weight * values[c];
    }
}

/// Nothing out of nothing is nothing.
pub(crate) fn ratio(a: f64, b: f64) -> f64 {
    if b > 0.0 { a / b } else { 0.0 }
}
