//! The way from samples to irradiance in reverse: what everything that shines and reflects is worth, where irradiance
//! of each side is worth so much.
//!
//! Every stage of an answer is linear in light, so its transpose takes worth from what comes out of it to what goes in:
//! gather, sweeps, solve, last stage first. Reflectance enters each as a factor of irradiance, and what it is worth is
//! that irradiance times the worth of the radiosity that it makes (reverse accumulation; Griewank and Walther 2008,
//! *Evaluating derivatives*, chapter 3). So derivatives are those of the very numbers that the samples add up to.

use super::{Fine, SIDES_PER_TASK, SWEEPS, Seen, Task, Values, add, ratio};
use crate::adjoint::{Failure, Gradient, Sides};
use radiosity_exchange::{Elements, Luminaire};
use radiosity_operator::Control;
use rayon::prelude::*;

/// Runs of sides whose samples are added up apart from each other, so that sums do not depend on threads.
const RUNS: usize = 8;

/// What one unit of everything that samples see is worth.
struct Worth<const C: usize> {
    elements: Vec<Values<C>>,
    sides: Vec<Values<C>>,
    lamps: Vec<Values<C>>,
}

/// What is worth what a side sees, by the element of origin: of a ray, and of a light sample of weight one.
struct Seeing<const C: usize> {
    rays: Vec<Values<C>>,
    lights: Vec<Values<C>>,
}

/// What a sweep is worth on its own account, and through what it sees.
struct Swept<const C: usize> {
    emission: Values<C>,
    reflectance: Values<C>,
    seeing: Option<Seeing<C>>,
}

/// Derivatives by emission and reflectance of sides, sides x bands, and by lights without area.
#[derive(Clone)]
struct BySides {
    emission: Vec<f64>,
    reflectance: Vec<f64>,
    lamps: Vec<f64>,
    /// By radiosity of sides before the sweeps.
    radiosity: Vec<f64>,
}

impl Task<'_> {
    /// Derivatives of sums of irradiance of sides with such weights, each sides x bands.
    pub(crate) fn transposed(&self, weights: &[Vec<f64>]) -> Result<Vec<Gradient>, Failure> {
        let (bands, exchange) = (self.lighting.bands, &self.measurement.exchange);
        let (radiosity, report) = self.solve_on_sides(&exchange.exposed_area)?;
        Failure::unless_converged(&report)?;
        let blank = BySides {
            emission: vec![0.0; self.sides() * bands],
            reflectance: vec![0.0; self.sides() * bands],
            lamps: vec![0.0; self.lighting.lamps.len() * bands],
            radiosity: vec![0.0; self.sides() * bands],
        };
        let mut by_sides: Vec<BySides> = weights.iter().map(|_| blank.clone()).collect();
        let elements = self.elements();
        let threes = bands - bands % 3;
        for first in (0..threes).step_by(3) {
            self.start::<3>(first, &elements, &radiosity, weights, &mut by_sides)?;
        }
        for first in threes..bands {
            self.start::<1>(first, &elements, &radiosity, weights, &mut by_sides)?;
        }
        let incident = self.incident(&exchange.exposed_area);
        let reflectance = self.per_side(|p| self.lighting.reflectance_of(p));
        let sides = Sides::new(&exchange.operator, &exchange.exposed_area, &reflectance, bands);
        let irradiance = sides.irradiance(&radiosity, &incident);
        by_sides.into_iter().map(|found| self.through_solve(&sides, &irradiance, found, self.control)).collect()
    }

    /// The last step: what radiosity of sides is worth, through the solve on sides.
    fn through_solve(
        &self,
        sides: &Sides,
        irradiance: &[f64],
        mut found: BySides,
        control: &Control,
    ) -> Result<Gradient, Failure> {
        let sent = sides.transposed(&found.radiosity, control)?;
        found.emission.iter_mut().zip(&sent).for_each(|(out, s)| *out += s);
        let reflected = sides.by_reflectance(&sent, irradiance);
        found.reflectance.iter_mut().zip(&reflected).for_each(|(out, r)| *out += r);
        self.incident_transposed(&sides.by_incident(&sent), &mut found.lamps);
        let enclosure = self.transport().enclosure();
        Ok(Gradient::of_patches(enclosure, self.lighting.bands, &found.emission, &found.reflectance, found.lamps))
    }

    /// What lights without area are worth, where what they put on sides straight away is worth so much.
    fn incident_transposed(&self, worth: &[f64], lamps: &mut [f64]) {
        let bands = self.lighting.bands;
        if lamps.is_empty() {
            return;
        }
        let emitters = self.transport().luminaires().len() - self.lighting.lamps.len();
        let area = &self.measurement.exchange.exposed_area;
        for (side, worth) in worth.chunks_exact(bands).enumerate() {
            let exposure = ratio(area[side], self.transport().enclosure().diffuse_area(side));
            let scale = ratio(1.0, self.light_samples(side) * exposure);
            for sample in self.transport().lights().of(side).flatten() {
                if let Some(lamp) = (sample.luminaire as usize).checked_sub(emitters) {
                    let weight = scale * f64::from(sample.weight);
                    lamps[lamp * bands..][..bands].iter_mut().zip(worth).for_each(|(out, w)| *out += weight * w);
                }
            }
        }
    }

    /// The first steps, for `C` bands: from irradiance back to radiosity of sides.
    fn start<const C: usize>(
        &self,
        first: usize,
        elements: &Elements,
        radiosity: &[f64],
        weights: &[Vec<f64>],
        by_sides: &mut [BySides],
    ) -> Result<(), Failure> {
        let bands = self.lighting.bands;
        let of = |block: &[f64], row: usize| -> Values<C> { std::array::from_fn(|c| block[row * bands + first + c]) };
        let strengths: Vec<Values<C>> = self.lighting.lamps.iter().map(|lamp| of(&lamp.strength, 0)).collect();
        let sides: Vec<Values<C>> = (0..self.sides()).map(|side| of(radiosity, side)).collect();
        let flat = (0..self.sides()).flat_map(|side| elements.of(side).map(move |_| side));
        // What each sweep saw.
        let mut seen = vec![Fine { elements: flat.map(|side| sides[side]).collect(), sides }];
        for sweep in 1..SWEEPS {
            self.control.check()?;
            seen.push(self.sweep(first, elements, &strengths, &seen[sweep - 1]));
        }
        for (weights, found) in weights.iter().zip(by_sides) {
            let weights: Vec<Values<C>> = (0..self.sides()).map(|side| of(weights, side)).collect();
            let mut worth = self.gather_transposed(elements, &weights);
            let mut lamps = worth.lamps.clone();
            for fine in seen.iter().rev() {
                self.control.check()?;
                worth = self.sweep_transposed(first, elements, &strengths, fine, &worth, found);
                lamps.iter_mut().zip(&worth.lamps).for_each(|(sum, lamp)| add(sum, 1.0, lamp));
            }
            let put = |block: &mut [f64], row: usize, values: &Values<C>| {
                block[row * bands + first..][..C].iter_mut().zip(values).for_each(|(out, v)| *out += v);
            };
            lamps.iter().enumerate().for_each(|(k, lamp)| put(&mut found.lamps, k, lamp));
            for side in 0..self.sides() {
                // Before the sweeps, elements are as bright as their sides.
                let mut sum = worth.sides[side];
                elements.of(side).for_each(|e| add(&mut sum, 1.0, &worth.elements[e]));
                put(&mut found.radiosity, side, &sum);
            }
        }
        Ok(())
    }

    /// What everything seen is worth to the last gather.
    fn gather_transposed<const C: usize>(&self, elements: &Elements, weights: &[Values<C>]) -> Worth<C> {
        let (shots, lights) = (self.transport().shots(), self.transport().lights());
        let samples = |per_replicate: u32| ratio(1.0, f64::from(per_replicate) * shots.replicates() as f64);
        let seeing = |side: usize| {
            let all = |per_sample: f64| vec![weights[side].map(|w| w * per_sample); elements.of(side).len()];
            let rays = all(samples(shots.per_replicate(side)));
            Seeing { rays, lights: all(samples(lights.per_replicate(side))) }
        };
        let of = |side: usize| (weights[side] != [0.0; C]).then(|| seeing(side));
        let seeing: Vec<_> = (0..self.sides()).map(of).collect();
        self.spread(elements, &seeing)
    }

    /// What everything seen is worth to a sweep; adds what the sweep's own emission and reflectance are.
    fn sweep_transposed<const C: usize>(
        &self,
        first: usize,
        elements: &Elements,
        strengths: &[Values<C>],
        fine: &Fine<C>,
        worth: &Worth<C>,
        found: &mut BySides,
    ) -> Worth<C> {
        let swept: Vec<Swept<C>> = (0..self.sides())
            .into_par_iter()
            .with_min_len(SIDES_PER_TASK)
            .map(|side| self.swept(first, elements, strengths, fine, worth, side))
            .collect();
        for (side, swept) in swept.iter().enumerate() {
            for c in 0..C {
                let k = side * self.lighting.bands + first + c;
                found.emission[k] += swept.emission[c];
                found.reflectance[k] += swept.reflectance[c];
            }
        }
        let seeing: Vec<_> = swept.into_iter().map(|swept| swept.seeing).collect();
        self.spread(elements, &seeing)
    }

    /// One side of it.
    fn swept<const C: usize>(
        &self,
        first: usize,
        elements: &Elements,
        strengths: &[Values<C>],
        fine: &Fine<C>,
        worth: &Worth<C>,
        side: usize,
    ) -> Swept<C> {
        let mut swept = Swept { emission: [0.0; C], reflectance: [0.0; C], seeing: None };
        let (range, of_mean) = (elements.of(side), &worth.sides[side]);
        if worth.elements[range.clone()].iter().chain([of_mean]).all(|w| *w == [0.0; C]) {
            return swept;
        }
        let reflectance = self.lighting.reflectance_of(self.transport().enclosure().patch_of(side));
        let reflectance: Values<C> = std::array::from_fn(|c| reflectance[first + c]);
        let seen = self.see(elements, strengths, fine, side);
        let whole = seen.iter().fold(Seen::default(), |a, b| a.plus(b));
        if whole.open() == 0.0 {
            // What is all buried counts as bright as it emits.
            add(&mut swept.emission, 1.0, of_mean);
        }
        let (mut rays, mut lights) = (vec![[0.0; C]; seen.len()], vec![[0.0; C]; seen.len()]);
        let (mut any_ray, mut any_light) = ([0.0; C], [0.0; C]);
        for (k, element) in seen.iter().enumerate() {
            let mut of_radiosity = worth.elements[range.start + k];
            add(&mut of_radiosity, ratio(element.open(), whole.open()), of_mean);
            add(&mut swept.emission, 1.0, &of_radiosity);
            let (irradiance, (per_ray, per_light)) = (element.irradiance(&whole), element.weights(&whole));
            let of_irradiance: Values<C> = std::array::from_fn(|c| reflectance[c] * of_radiosity[c]);
            for c in 0..C {
                swept.reflectance[c] += irradiance[c] * of_radiosity[c];
            }
            // An element without samples of its own sees as the whole side does.
            add(if element.shots > 0 { &mut rays[k] } else { &mut any_ray }, per_ray, &of_irradiance);
            add(if element.lights > 0 { &mut lights[k] } else { &mut any_light }, per_light, &of_irradiance);
        }
        rays.iter_mut().for_each(|ray| add(ray, 1.0, &any_ray));
        lights.iter_mut().for_each(|light| add(light, 1.0, &any_light));
        swept.seeing = Some(Seeing { rays, lights });
        swept
    }

    /// Worth of seeing, side by side, spread over what is seen.
    fn spread<const C: usize>(&self, elements: &Elements, seeing: &[Option<Seeing<C>>]) -> Worth<C> {
        let run = self.sides().div_ceil(RUNS).max(1);
        let parts: Vec<Worth<C>> = seeing
            .par_chunks(run)
            .enumerate()
            .map(|(k, seeing)| {
                let mut worth = self.worthless(elements);
                for (side, seeing) in (k * run..).zip(seeing) {
                    if let Some(seeing) = seeing {
                        self.spread_side(elements, seeing, side, &mut worth);
                    }
                }
                worth
            })
            .collect();
        parts.into_iter().reduce(Worth::plus).unwrap_or_else(|| self.worthless(elements))
    }

    fn spread_side<const C: usize>(&self, elements: &Elements, seeing: &Seeing<C>, side: usize, worth: &mut Worth<C>) {
        let start = elements.of(side).start;
        for shot in self.transport().shots().of(side).flatten() {
            if let Some(e) = self.seen_by_ray(elements, shot) {
                add(&mut worth.elements[e], 1.0, &seeing.rays[elements.at(side, shot.origin_cell) - start]);
            }
        }
        let emitters = self.transport().luminaires().len() - self.lighting.lamps.len();
        for sample in self.transport().lights().of(side).flatten().filter(|sample| sample.weight > 0.0) {
            let source = match self.transport().luminaires()[sample.luminaire as usize] {
                Luminaire::Side(lamp) => &mut worth.sides[lamp as usize],
                // Lights without area stand after the emitters.
                _ => &mut worth.lamps[sample.luminaire as usize - emitters],
            };
            let light = &seeing.lights[elements.at(side, sample.origin_cell) - start];
            add(source, f64::from(sample.weight), light);
        }
    }

    fn worthless<const C: usize>(&self, elements: &Elements) -> Worth<C> {
        Worth {
            elements: vec![[0.0; C]; elements.len()],
            sides: vec![[0.0; C]; self.sides()],
            lamps: vec![[0.0; C]; self.lighting.lamps.len()],
        }
    }
}

impl<const C: usize> Worth<C> {
    fn plus(mut self, other: Self) -> Self {
        let pairs =
            [(&mut self.elements, &other.elements), (&mut self.sides, &other.sides), (&mut self.lamps, &other.lamps)];
        for (sum, part) in pairs {
            sum.iter_mut().zip(part).for_each(|(sum, part)| add(sum, 1.0, part));
        }
        self
    }
}
