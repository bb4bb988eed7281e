//! From the samples to irradiance: solve on sides, sweep to elements, gather per replicate.

use crate::lighting::Lighting;
use crate::transport::Transport;
use radiosity_exchange::operator::ElementExchange;
use radiosity_exchange::{Elements, Luminaire};
use radiosity_operator::{Cancelled, Control};
use radiosity_solvers::{Problem, SolveOptions, SolveReport};
use rayon::prelude::*;

/// Radiosity and irradiance with all that the error estimate needs. Blocks are sides x bands.
pub(crate) struct Answer {
    /// Irradiance of each replicate that came by rays: sides x replicates x bands.
    pub by_rays: Vec<f64>,
    /// Irradiance of each replicate that came straight from luminaires: sides x replicates x bands.
    pub by_lights: Vec<f64>,
    /// What the variation of radiosity within sides changed, per side and band.
    pub by_elements: Vec<f64>,
    /// Mean over replicates.
    pub irradiance: Vec<f64>,
    pub solver: SolveReport,
}

/// A solver of the crate `radiosity-solvers`.
pub(crate) type Solver = fn(&Problem, &SolveOptions, &Control) -> Result<(Vec<f64>, SolveReport), Cancelled>;

/// Everything that stays the same through one answer.
pub(crate) struct Task<'a> {
    pub transport: &'a Transport,
    pub lighting: &'a Lighting,
    pub exchange: &'a ElementExchange,
    pub solver: Solver,
    pub options: SolveOptions,
    pub control: &'a Control,
}

/// Sides per parallel task.
const SIDES_PER_TASK: usize = 32;

impl Task<'_> {
    pub fn answer(&self) -> Result<Answer, Cancelled> {
        let (radiosity, solver) = self.solve_on_sides()?;
        self.control.check()?;
        let elements = self.elements();
        let fine = self.sweep(&elements, &radiosity);
        self.control.check()?;
        Ok(self.gather(&elements, &fine, solver))
    }

    fn bands(&self) -> usize {
        self.lighting.bands
    }

    fn sides(&self) -> usize {
        self.transport.enclosure().sides()
    }

    /// A block with each side's patch's values.
    fn per_side(&self, of_patch: impl Fn(usize) -> Vec<f64>) -> Vec<f64> {
        (0..self.sides()).flat_map(|side| of_patch(self.transport.enclosure().patch_of(side))).collect()
    }

    fn solve_on_sides(&self) -> Result<(Vec<f64>, SolveReport), Cancelled> {
        let reflectance = self.per_side(|p| self.lighting.reflectance_of(p).to_vec());
        let emission = self.per_side(|p| self.lighting.emission_of(p).to_vec());
        let incident = self.incident();
        let problem = Problem {
            exchange: &self.exchange.operator,
            area: &self.exchange.exposed_area,
            reflectance: &reflectance,
            emission: &emission,
            incident: &incident,
            bands: self.bands(),
        };
        (self.solver)(&problem, &self.options, self.control)
    }

    /// Irradiance of the exposed part of each side from lights without area.
    fn incident(&self) -> Vec<f64> {
        let bands = self.bands();
        let mut incident = vec![0.0; self.sides() * bands];
        if self.lighting.lamps.is_empty() {
            return incident;
        }
        incident.par_chunks_mut(bands).enumerate().with_min_len(SIDES_PER_TASK).for_each(|(side, out)| {
            for sample in self.transport.lights().of(side) {
                if let Some(lamp) = self.lamp(sample.luminaire) {
                    add(out, f64::from(sample.weight), lamp);
                }
            }
            let count = self.light_samples(side) * self.transport.lights().replicates() as f64;
            scale(out, ratio(1.0, count * self.exposure(side)));
        });
        incident
    }

    /// Power that lights without area put on surfaces, per band, W.
    pub fn incident_power(&self) -> Vec<f64> {
        let bands = self.bands();
        let mut power = vec![0.0; bands];
        for (side, incident) in self.incident().chunks_exact(bands).enumerate() {
            add(&mut power, self.exchange.exposed_area[side], incident);
        }
        power
    }

    /// The strength per band of a luminaire that is a light without area.
    fn lamp(&self, luminaire: u32) -> Option<&[f64]> {
        let emitters = self.transport.luminaires().len() - self.lighting.lamps.len();
        (luminaire as usize).checked_sub(emitters).map(|k| self.lighting.lamps[k].strength.as_slice())
    }

    /// The share of a side that is not buried.
    fn exposure(&self, side: usize) -> f64 {
        ratio(self.exchange.exposed_area[side], self.transport.enclosure().area(side))
    }

    /// Light samples per replicate.
    fn light_samples(&self, side: usize) -> f64 {
        f64::from(self.transport.lights().per_replicate(side))
    }

    /// As many elements as the rays of a side can resolve; a lamp stays whole.
    fn elements(&self) -> Elements {
        let replicates = self.transport.shots().replicates() as u32;
        let level = |side| match self.transport.shots().per_replicate(side) * replicates {
            _ if self.transport.is_lamp(side) => 0,
            0..64 => 0,
            64..256 => 1,
            256..4096 => 2,
            _ => 3,
        };
        Elements::new((0..self.sides()).map(level).collect())
    }

    /// Radiosity of elements after one more bounce through their own rays, beside that of whole sides:
    /// elements x bands, then sides x bands, both of the exposed part.
    fn sweep(&self, elements: &Elements, radiosity: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let bands = self.bands();
        let per_side: Vec<Vec<f64>> = (0..self.sides())
            .into_par_iter()
            .with_min_len(SIDES_PER_TASK)
            .map(|side| self.sweep_side(elements, radiosity, side))
            .collect();
        let means = per_side.iter().flat_map(|fine| fine[fine.len() - bands..].to_vec()).collect();
        let fine = per_side.iter().flat_map(|fine| fine[..fine.len() - bands].to_vec()).collect();
        (fine, means)
    }

    /// The elements of one side, then their mean.
    fn sweep_side(&self, elements: &Elements, radiosity: &[f64], side: usize) -> Vec<f64> {
        let bands = self.bands();
        let (first, count) = (elements.of(side).start, elements.of(side).len());
        let patch = self.transport.enclosure().patch_of(side);
        let (emission, reflectance) = (self.lighting.emission_of(patch), self.lighting.reflectance_of(patch));
        let mut by_rays = vec![0.0; count * bands];
        let mut by_lights = vec![0.0; count * bands];
        let (mut rays, mut lights) = (vec![0u32; count], vec![0u32; count]);
        for shot in self.transport.shots().of(side) {
            let e = elements.at(side, shot.origin_cell) - first;
            rays[e] += u32::from(shot.target != radiosity_exchange::Shot::BURIED);
            if shot.landed() && !self.transport.is_lamp(shot.target as usize) {
                let source = &radiosity[shot.target as usize * bands..][..bands];
                add(&mut by_rays[e * bands..][..bands], 1.0, source);
            }
        }
        for sample in self.transport.lights().of(side) {
            let e = elements.at(side, sample.origin_cell) - first;
            lights[e] += 1;
            if sample.weight > 0.0 {
                add(
                    &mut by_lights[e * bands..][..bands],
                    f64::from(sample.weight),
                    self.source(sample.luminaire, radiosity),
                );
            }
        }
        let shots = self.transport.shots().per_replicate(side) as usize * self.transport.shots().replicates();
        let mut values = vec![0.0; (count + 1) * bands];
        let (elements_out, mean) = values.split_at_mut(count * bands);
        let total = f64::from(rays.iter().sum::<u32>());
        for e in 0..count {
            let open = f64::from(rays[e]);
            let exposure = (open * count as f64 / shots.max(1) as f64).min(1.0);
            for b in 0..bands {
                let k = e * bands + b;
                let irradiance = ratio(by_rays[k], open) + ratio(by_lights[k], f64::from(lights[e]) * exposure);
                elements_out[k] = emission[b] + reflectance[b] * irradiance;
                mean[b] += elements_out[k] * ratio(open, total);
            }
        }
        if total == 0.0 {
            mean.copy_from_slice(emission);
        }
        values
    }

    /// What a luminaire sends per unit of its samples' weight.
    fn source<'b>(&'b self, luminaire: u32, radiosity: &'b [f64]) -> &'b [f64] {
        match self.transport.luminaires()[luminaire as usize] {
            Luminaire::Side(side) => &radiosity[side as usize * self.bands()..][..self.bands()],
            _ => self.lamp(luminaire).expect("luminaires without area stand after the emitters"),
        }
    }

    fn gather(&self, elements: &Elements, (fine, means): &(Vec<f64>, Vec<f64>), solver: SolveReport) -> Answer {
        let (bands, replicates) = (self.bands(), self.transport.shots().replicates());
        let width = replicates * bands;
        let mut by_rays = vec![0.0; self.sides() * width];
        let mut by_lights = vec![0.0; self.sides() * width];
        let mut by_elements = vec![0.0; self.sides() * bands];
        let mut irradiance = vec![0.0; self.sides() * bands];
        by_rays
            .par_chunks_mut(width)
            .zip(by_lights.par_chunks_mut(width))
            .zip(by_elements.par_chunks_mut(bands))
            .zip(irradiance.par_chunks_mut(bands))
            .enumerate()
            .with_min_len(SIDES_PER_TASK)
            .for_each(|(side, (((rays, lights), by_elements), irradiance))| {
                for k in 0..replicates {
                    self.gather_rays(elements, fine, means, side, k, &mut rays[k * bands..][..bands], by_elements);
                    self.gather_lights(means, side, k, &mut lights[k * bands..][..bands]);
                    add(irradiance, 1.0 / replicates as f64, &rays[k * bands..][..bands]);
                    add(irradiance, 1.0 / replicates as f64, &lights[k * bands..][..bands]);
                }
                scale(by_elements, 1.0 / replicates as f64);
            });
        Answer { by_rays, by_lights, by_elements, irradiance, solver }
    }

    /// The irradiance one replicate's rays bring, and (added up) how much of it is due to elements.
    fn gather_rays(
        &self,
        elements: &Elements,
        fine: &[f64],
        means: &[f64],
        side: usize,
        replicate: usize,
        out: &mut [f64],
        by_elements: &mut [f64],
    ) {
        let bands = self.bands();
        let weight = ratio(1.0, f64::from(self.transport.shots().per_replicate(side)));
        for shot in self.transport.shots().replicate(side, replicate) {
            let target = shot.target as usize;
            if shot.landed() && !self.transport.is_lamp(target) {
                let values = &fine[elements.at(target, shot.target_cell) * bands..][..bands];
                let mean = &means[target * bands..][..bands];
                for b in 0..bands {
                    out[b] += weight * values[b];
                    by_elements[b] += weight * (values[b] - mean[b]);
                }
            }
        }
    }

    fn gather_lights(&self, means: &[f64], side: usize, replicate: usize, out: &mut [f64]) {
        let weight = ratio(1.0, self.light_samples(side));
        for sample in self.transport.lights().replicate(side, replicate).filter(|s| s.weight > 0.0) {
            add(out, weight * f64::from(sample.weight), self.source(sample.luminaire, means));
        }
    }
}

fn add(out: &mut [f64], weight: f64, values: &[f64]) {
    for (o, v) in out.iter_mut().zip(values) {
        *o += weight * v;
    }
}

fn scale(out: &mut [f64], factor: f64) {
    out.iter_mut().for_each(|v| *v *= factor);
}

/// Nothing out of nothing is nothing.
pub(crate) fn ratio(a: f64, b: f64) -> f64 {
    if b > 0.0 { a / b } else { 0.0 }
}
