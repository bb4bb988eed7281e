//! From the sums of the replicates to irradiance, its error, and where the power went.

use super::{Context, REPLICATES, Replicate, Shooting, ShotSolution};
use crate::answer::ratio;
use crate::energy::Energy;
use crate::lighting::Lighting;
use crate::report::{Limit, Report};
use radiosity_exchange::luminaires::Luminaires;
use radiosity_exchange::{Enclosure, Luminaire};
use rayon::prelude::*;
use std::sync::Arc;

/// Direct irradiance of one replicate: its sums and what makes means of them.
pub(super) struct Direct<'a> {
    replicate: &'a Replicate,
    bands: usize,
    per_sample: f64,
    /// Per band: what scales light of emitters to the power of it that lands.
    emitters: Vec<f64>,
}

/// Power per band of what is known without sampling, W.
#[derive(Clone, Debug)]
struct Known {
    /// All that surfaces emit.
    emitted: Vec<f64>,
    /// Of it by sides under solids that stand on them.
    buried: Vec<f64>,
    /// Of it by exposed sides that are sampled by area.
    sampled: Vec<f64>,
}

/// The mean of the replicates with its spread.
pub(super) struct Answer {
    pub irradiance: Vec<f64>,
    pub error: Vec<f64>,
    /// Root mean square over area and bands of the error, relative to the mean irradiance.
    pub relative: f64,
    pub mean_irradiance: f64,
    /// Mean squares of the errors of direct and of indirect light.
    pub direct_variance: f64,
    pub indirect_variance: f64,
    energy: Energy,
}

/// Direct irradiance of a replicate after so many light samples.
pub(super) fn direct<'a>(
    replicate: &'a Replicate,
    context: &Context,
    luminaires: &Luminaires,
    light_samples: u32,
) -> Direct<'a> {
    let known = Known::new(context.enclosure, context.lighting, luminaires, context.exposure);
    Direct::new(replicate, context.enclosure, context.lighting, &known, light_samples)
}

impl<'a> Direct<'a> {
    fn new(
        replicate: &'a Replicate,
        enclosure: &Enclosure,
        lighting: &Lighting,
        known: &Known,
        light_samples: u32,
    ) -> Self {
        let per_sample = ratio(1.0, f64::from(light_samples));
        let bands = lighting.bands;
        let landed = sums(enclosure, bands, &replicate.from_emitters, |_, _| 1.0);
        let scale = |b: usize| {
            let (escaped, on_backs) = replicate.emitters.of(b);
            ratio(known.sampled[b] * (1.0 - escaped - on_backs), landed[b] * per_sample)
        };
        let emitters = if replicate.from_emitters.is_empty() { Vec::new() } else { (0..bands).map(scale).collect() };
        Self { replicate, bands, per_sample, emitters }
    }

    /// Of entry `k` of sides x bands.
    #[inline]
    pub fn irradiance(&self, k: usize) -> f64 {
        let lights = f64::from(self.replicate.from_lights[k]) * self.per_sample;
        match self.emitters.get(k % self.bands) {
            Some(scale) => lights + scale * self.per_sample * f64::from(self.replicate.from_emitters[k]),
            None => lights,
        }
    }

    /// What sides emit that are not sampled by area, W/m2 by side and band.
    pub fn emission<'b>(
        &self,
        context: &'b Context,
        luminaires: &Luminaires,
    ) -> impl Fn(usize, usize) -> f64 + use<'b> {
        let sampled = sampled(context.enclosure, luminaires);
        move |side, band| {
            if sampled[side] { 0.0 } else { context.lighting.emission_of(context.enclosure.patch_of(side))[band] }
        }
    }

    /// What sides send before the first bounce, W, sides x bands: emission that is not sampled by area, and what they
    /// reflect of direct light.
    pub fn first_power(&self, context: &Context, luminaires: &Luminaires) -> Vec<f64> {
        let emission = self.emission(context, luminaires);
        let mut power = vec![0.0; self.replicate.from_lights.len()];
        power.par_chunks_exact_mut(self.bands).enumerate().for_each(|(side, power)| {
            let reflectance = context.lighting.reflectance_of(context.enclosure.patch_of(side));
            let exposure = f64::from(context.exposure[side]);
            for (b, p) in power.iter_mut().enumerate() {
                let reflected = reflectance[b] * self.irradiance(side * self.bands + b);
                *p = context.enclosure.area(side) * (exposure * emission(side, b) + reflected);
            }
        });
        power
    }
}

/// Whether each side is sampled by area.
fn sampled(enclosure: &Enclosure, luminaires: &Luminaires) -> Vec<bool> {
    let mut sampled = vec![false; enclosure.sides()];
    for luminaire in &luminaires.list {
        if let Luminaire::Side(side) = *luminaire {
            sampled[side as usize] = true;
        }
    }
    sampled
}

/// Per band: the sum over sides of area times value times factor.
fn sums(enclosure: &Enclosure, bands: usize, values: &[f32], factor: impl Fn(usize, usize) -> f64) -> Vec<f64> {
    let mut sums = vec![0.0; bands];
    for (side, values) in values.chunks_exact(bands).enumerate() {
        let area = enclosure.area(side);
        for (b, v) in values.iter().enumerate() {
            sums[b] += area * f64::from(*v) * factor(side, b);
        }
    }
    sums
}

impl Known {
    fn new(enclosure: &Enclosure, lighting: &Lighting, luminaires: &Luminaires, exposure: &[f32]) -> Self {
        let none = || vec![0.0; lighting.bands];
        let mut known = Self { emitted: none(), buried: none(), sampled: none() };
        let sampled = sampled(enclosure, luminaires);
        for side in 0..enclosure.sides() {
            let (area, exposed) = (enclosure.area(side), f64::from(exposure[side]));
            for (b, e) in lighting.emission_of(enclosure.patch_of(side)).iter().enumerate() {
                known.emitted[b] += area * e;
                known.buried[b] += area * (1.0 - exposed) * e;
                known.sampled[b] += if sampled[side] { area * exposed * e } else { 0.0 };
            }
        }
        known
    }
}

/// A replicate with what scales its indirect light, and its balance of power.
struct Scaled<'a> {
    direct: Direct<'a>,
    replicate: &'a Replicate,
    indirect: Vec<f64>,
    energy: Energy,
}

impl<'a> Scaled<'a> {
    fn new(
        replicate: &'a Replicate,
        shooting: &Shooting,
        enclosure: &Enclosure,
        lighting: &Lighting,
        known: &Known,
    ) -> Self {
        let bands = lighting.bands;
        let direct = Direct::new(replicate, enclosure, lighting, known, shooting.light_samples);
        let reflectance = |side: usize, b: usize| lighting.reflectance_of(enclosure.patch_of(side))[b];
        let per_sample = ratio(1.0, f64::from(shooting.light_samples));
        let from_lights = sums(enclosure, bands, &replicate.from_lights, |_, _| per_sample);
        let gathered = sums(enclosure, bands, &replicate.gathered, |side, b| 1.0 - reflectance(side, b));
        let (mut landed, mut reflected) = (vec![0.0; bands], vec![0.0; bands]);
        for side in 0..enclosure.sides() {
            for b in 0..bands {
                let power = enclosure.area(side) * direct.irradiance(side * bands + b);
                landed[b] += power;
                reflected[b] += reflectance(side, b) * power;
            }
        }
        let mut energy = Energy {
            emitted: known.emitted.clone(),
            from_lights,
            absorbed: vec![0.0; bands],
            escaped: vec![0.0; bands],
            lost_on_backs: known.buried.clone(),
            imbalance: 0.0,
            escape_share: 0.0,
        };
        let mut indirect = vec![0.0; bands];
        for b in 0..bands {
            let first = known.emitted[b] - known.buried[b] - known.sampled[b] + reflected[b];
            let ((escaped, on_backs), (e, l)) = (replicate.others.of(b), replicate.emitters.of(b));
            energy.escaped[b] = first * escaped + known.sampled[b] * e;
            energy.lost_on_backs[b] += first * on_backs + known.sampled[b] * l;
            indirect[b] = ratio(first * (1.0 - escaped - on_backs), gathered[b]);
            energy.absorbed[b] = landed[b] - reflected[b] + indirect[b] * gathered[b];
        }
        Self { direct, replicate, indirect, energy }
    }

    /// Direct and indirect irradiance of entry `k`.
    #[inline]
    fn irradiance(&self, k: usize) -> (f64, f64) {
        let indirect = self.indirect[k % self.indirect.len()] * f64::from(self.replicate.gathered[k]);
        (self.direct.irradiance(k), indirect)
    }
}

/// Mean and variance of the mean of the replicates' values.
#[inline]
fn moments(values: [f64; REPLICATES]) -> (f64, f64) {
    let n = REPLICATES as f64;
    let mean = values.iter().sum::<f64>() / n;
    (mean, values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / (n * (n - 1.0)))
}

impl Answer {
    pub fn new(shooting: &Shooting, enclosure: &Enclosure, lighting: &Lighting, luminaires: &Luminaires) -> Self {
        let known = Known::new(enclosure, lighting, luminaires, &shooting.exposure);
        let scaled: Vec<Scaled> =
            shooting.replicates.iter().map(|r| Scaled::new(r, shooting, enclosure, lighting, &known)).collect();
        let size = enclosure.sides() * lighting.bands;
        let mut answer = Self {
            irradiance: vec![0.0; size],
            error: vec![0.0; size],
            relative: 0.0,
            mean_irradiance: 0.0,
            direct_variance: 0.0,
            indirect_variance: 0.0,
            energy: mean_energy(&scaled),
        };
        answer.average(&scaled, enclosure, lighting.bands);
        answer
    }

    fn average(&mut self, scaled: &[Scaled], enclosure: &Enclosure, bands: usize) {
        const CHUNK: usize = 4096;
        let parts: Vec<[f64; 5]> = self
            .irradiance
            .par_chunks_mut(CHUNK)
            .zip(self.error.par_chunks_mut(CHUNK))
            .enumerate()
            .map(|(chunk, (irradiance, error))| {
                let mut sums = [0.0; 5];
                for (i, (h, e)) in irradiance.iter_mut().zip(error).enumerate() {
                    let k = chunk * CHUNK + i;
                    let both: [(f64, f64); REPLICATES] = std::array::from_fn(|r| scaled[r].irradiance(k));
                    let (mean, variance) = moments(both.map(|(d, i)| d + i));
                    (*h, *e) = (mean, variance.sqrt());
                    let weight = enclosure.area(k / bands);
                    let parts = [1.0, mean, variance, moments(both.map(|b| b.0)).1, moments(both.map(|b| b.1)).1];
                    sums.iter_mut().zip(parts).for_each(|(s, p)| *s += weight * p);
                }
                sums
            })
            .collect();
        let sum = |p: usize| parts.iter().map(|s| s[p]).sum::<f64>();
        self.mean_irradiance = ratio(sum(1), sum(0));
        self.relative = ratio(ratio(sum(2), sum(0)).sqrt(), self.mean_irradiance);
        self.direct_variance = ratio(sum(3), sum(0));
        self.indirect_variance = ratio(sum(4), sum(0));
    }

    pub fn report(
        &self,
        shooting: &Shooting,
        enclosure: &Enclosure,
        lighting: &Lighting,
        luminaires: &Luminaires,
        accuracy: f64,
        limit: Limit,
    ) -> Report {
        let escape_share = ratio(shooting.rays_escaped as f64, shooting.rays_gathered as f64);
        Report {
            accuracy,
            limited_by: Some(limit),
            estimated_error: self.relative,
            sampling_error: self.relative,
            discretisation_error: 0.0,
            patches: enclosure.patches().len(),
            sides: enclosure.sides(),
            luminaires: luminaires.list.len(),
            rays: shooting.rays_shot + shooting.rays_gathered,
            shadow_rays: if luminaires.list.is_empty() { 0 } else { shooting.shadow_rays() },
            rounds: shooting.rounds as usize,
            iterations: shooting.bounces as usize,
            residual: shooting.left,
            converged: true,
            energy: Energy { escape_share, ..self.energy.clone() },
            closure: shooting.closure(enclosure),
            closure_residual: 0.0,
            memory_bytes: enclosure.memory_bytes()
                + super::state::memory(enclosure.sides(), lighting.bands, luminaires) as usize,
            seconds: Default::default(),
        }
    }

    pub fn solution(self, enclosure: &Enclosure, lighting: &Lighting, report: Report, state: Shooting) -> ShotSolution {
        let bands = lighting.bands;
        let mut radiosity = self.irradiance.clone();
        radiosity.par_chunks_exact_mut(bands).enumerate().for_each(|(side, values)| {
            let patch = enclosure.patch_of(side);
            let optics = lighting.emission_of(patch).iter().zip(lighting.reflectance_of(patch));
            values.iter_mut().zip(optics).for_each(|(h, (e, rho))| *h = e + rho * *h);
        });
        ShotSolution { irradiance: self.irradiance, radiosity, error: self.error, report, state: Arc::new(state) }
    }
}

/// The mean of the replicates' balances, which balances as each of them does.
fn mean_energy(scaled: &[Scaled]) -> Energy {
    let bands = scaled[0].energy.emitted.len();
    let mean = |of: &dyn Fn(&Energy) -> &Vec<f64>| -> Vec<f64> {
        (0..bands).map(|b| scaled.iter().map(|s| of(&s.energy)[b]).sum::<f64>() / scaled.len() as f64).collect()
    };
    let mut energy = Energy {
        emitted: mean(&|e| &e.emitted),
        from_lights: mean(&|e| &e.from_lights),
        absorbed: mean(&|e| &e.absorbed),
        escaped: mean(&|e| &e.escaped),
        lost_on_backs: mean(&|e| &e.lost_on_backs),
        imbalance: 0.0,
        escape_share: 0.0,
    };
    energy.balance();
    energy
}

impl Shooting {
    /// Row sums of F as rays that gathered found them: least, mean by area, greatest.
    fn closure(&self, enclosure: &Enclosure) -> (f64, f64, f64) {
        let levels = super::state::levels(enclosure);
        let rays = |side: usize| REPLICATES as f64 * f64::from(super::gather::of_level(self.rays, levels[side]));
        let row: Vec<f64> = self.landed.iter().enumerate().map(|(s, &n)| ratio(f64::from(n), rays(s))).collect();
        let area: Vec<f64> = (0..enclosure.sides()).map(|s| enclosure.area(s)).collect();
        crate::solve::closure(&row, &area)
    }
}
