//! From the sums of the replicates to irradiance, its error, and where the power went.

use super::cells::Cells;
use super::{Context, REPLICATES, Replicate, Shooting, ShotSolution};
use crate::answer::ratio;
use crate::energy::Energy;
use crate::lighting::{Lighting, mean};
use crate::report::{Cause, Limit, Report, SolverReport};
use radiosity_exchange::luminaires::Luminaires;
use radiosity_exchange::{Enclosure, Luminaire};
use radiosity_solvers::Stop;
use rayon::prelude::*;
use std::sync::Arc;

/// What is told is the upper end of an interval that holds the error nine times in ten: on scenes with known answers
/// (`validation/coverage.py`) the likeliest value is off by this factor at most.
const MARGIN: f64 = 1.12;

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
    /// The part of it that the replicates tell, and that by taking cells as constant.
    pub relative_sampling: f64,
    pub relative_cells: f64,
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
    let known = Known::new(context.cells, context.lighting, luminaires, context.exposure);
    Direct::new(replicate, context.cells, context.lighting, &known, light_samples)
}

impl<'a> Direct<'a> {
    fn new(replicate: &'a Replicate, cells: &Cells, lighting: &Lighting, known: &Known, light_samples: u32) -> Self {
        let per_sample = ratio(1.0, f64::from(light_samples));
        let bands = lighting.bands;
        let landed = sums(cells, bands, &replicate.from_emitters, |_, _| 1.0);
        let scale = |b: usize| {
            let (escaped, on_backs) = replicate.emitters.of(b);
            ratio(known.sampled[b] * (1.0 - escaped - on_backs), landed[b] * per_sample)
        };
        let emitters = if replicate.from_emitters.is_empty() { Vec::new() } else { (0..bands).map(scale).collect() };
        Self { replicate, bands, per_sample, emitters }
    }

    /// Of entry `k` of cells x bands.
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
        let sampled = sampled(context.cells, luminaires);
        move |cell, band| {
            if sampled[cell] { 0.0 } else { context.lighting.emission_of(context.cells.patch_of(cell))[band] }
        }
    }

    /// What cells send before the first bounce, W, cells x bands: emission that is not sampled by area, and what they
    /// reflect of direct light.
    pub fn first_power(&self, context: &Context, luminaires: &Luminaires) -> Vec<f64> {
        let emission = self.emission(context, luminaires);
        let mut power = vec![0.0; self.replicate.from_lights.len()];
        power.par_chunks_exact_mut(self.bands).enumerate().for_each(|(cell, power)| {
            let reflectance = context.lighting.reflectance_of(context.cells.patch_of(cell));
            let exposure = f64::from(context.exposure[cell]);
            for (b, p) in power.iter_mut().enumerate() {
                let reflected = reflectance[b] * self.irradiance(cell * self.bands + b);
                *p = context.cells.area(cell) * (exposure * emission(cell, b) + reflected);
            }
        });
        power
    }
}

/// Whether each cell is sampled by area.
fn sampled(cells: &Cells, luminaires: &Luminaires) -> Vec<bool> {
    let (mut sampled, each) = (vec![false; cells.count()], cells.per_side());
    for luminaire in &luminaires.list {
        if let Luminaire::Side(side) = *luminaire {
            sampled[side as usize * each..][..each].fill(true);
        }
    }
    sampled
}

/// Per band: the sum over cells of area times value times factor.
fn sums(cells: &Cells, bands: usize, values: &[f32], factor: impl Fn(usize, usize) -> f64) -> Vec<f64> {
    let mut sums = vec![0.0; bands];
    for (cell, values) in values.chunks_exact(bands).enumerate() {
        let area = cells.area(cell);
        for (b, v) in values.iter().enumerate() {
            sums[b] += area * f64::from(*v) * factor(cell, b);
        }
    }
    sums
}

impl Known {
    fn new(cells: &Cells, lighting: &Lighting, luminaires: &Luminaires, exposure: &[f32]) -> Self {
        let none = || vec![0.0; lighting.bands];
        let mut known = Self { emitted: none(), buried: none(), sampled: none() };
        let sampled = sampled(cells, luminaires);
        for cell in 0..cells.count() {
            let (area, exposed) = (cells.area(cell), f64::from(exposure[cell]));
            for (b, e) in lighting.emission_of(cells.patch_of(cell)).iter().enumerate() {
                known.emitted[b] += area * e;
                known.buried[b] += area * (1.0 - exposed) * e;
                known.sampled[b] += if sampled[cell] { area * exposed * e } else { 0.0 };
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
    fn new(replicate: &'a Replicate, shooting: &Shooting, cells: &Cells, lighting: &Lighting, known: &Known) -> Self {
        let bands = lighting.bands;
        let direct = Direct::new(replicate, cells, lighting, known, shooting.light_samples);
        let reflectance = |cell: usize, b: usize| lighting.reflectance_of(cells.patch_of(cell))[b];
        let per_sample = ratio(1.0, f64::from(shooting.light_samples));
        let from_lights = sums(cells, bands, &replicate.from_lights, |_, _| per_sample);
        let gathered = sums(cells, bands, &replicate.gathered, |cell, b| 1.0 - reflectance(cell, b));
        let (mut landed, mut reflected) = (vec![0.0; bands], vec![0.0; bands]);
        for cell in 0..cells.count() {
            for b in 0..bands {
                let power = cells.area(cell) * direct.irradiance(cell * bands + b);
                landed[b] += power;
                reflected[b] += reflectance(cell, b) * power;
            }
        }
        let mut energy = Energy {
            emitted: known.emitted.clone(),
            from_lights,
            absorbed: vec![0.0; bands],
            escaped: vec![0.0; bands],
            lost_on_backs: known.buried.clone(),
            absorbed_by_mirrors: Vec::new(),
            unfollowed: Vec::new(),
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

    /// Direct and indirect irradiance of a side.
    #[inline]
    fn irradiance(&self, cells: &Cells, side: usize, band: usize) -> (f64, f64) {
        let (each, bands) = (cells.per_side(), self.indirect.len());
        let (mut direct, mut indirect) = (0.0, 0.0);
        for cell in side * each..(side + 1) * each {
            direct += self.direct.irradiance(cell * bands + band);
            indirect += f64::from(self.replicate.gathered[cell * bands + band]);
        }
        (direct / each as f64, self.indirect[band] * indirect / each as f64)
    }
}

/// Sums over area of weight, irradiance, its variance, its square error by cells, direct and indirect variance.
#[derive(Clone, Copy, Default)]
struct Moments([f64; 6]);

impl Moments {
    fn add(&mut self, weight: f64, values: [f64; 6]) {
        self.0.iter_mut().zip(values).for_each(|(s, v)| *s += weight * v);
    }

    fn mean(&self, of: usize) -> f64 {
        ratio(self.0[of], self.0[0])
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
    pub fn new(shooting: &Shooting, cells: &Cells, lighting: &Lighting, luminaires: &Luminaires) -> Self {
        let known = Known::new(cells, lighting, luminaires, &shooting.exposure);
        let scaled: Vec<Scaled> =
            shooting.replicates.iter().map(|r| Scaled::new(r, shooting, cells, lighting, &known)).collect();
        let size = cells.enclosure.sides() * lighting.bands;
        let mut answer = Self {
            irradiance: vec![0.0; size],
            error: vec![0.0; size],
            relative: 0.0,
            relative_sampling: 0.0,
            relative_cells: 0.0,
            mean_irradiance: 0.0,
            direct_variance: 0.0,
            indirect_variance: 0.0,
            energy: mean_energy(&scaled),
        };
        answer.average(shooting, &scaled, cells, lighting.bands);
        answer
    }

    fn average(&mut self, shooting: &Shooting, scaled: &[Scaled], cells: &Cells, bands: usize) {
        const SIDES: usize = 1024;
        let parts: Vec<Moments> = self
            .irradiance
            .par_chunks_mut(SIDES * bands)
            .zip(self.error.par_chunks_mut(SIDES * bands))
            .enumerate()
            .map(|(chunk, (irradiance, error))| {
                let mut sums = Moments::default();
                for (i, (h, e)) in irradiance.chunks_exact_mut(bands).zip(error.chunks_exact_mut(bands)).enumerate() {
                    let side = chunk * SIDES + i;
                    let by_cells = shooting.error_by_cells(cells, side);
                    let weight = cells.enclosure.area(side);
                    for b in 0..bands {
                        let both: [_; REPLICATES] = std::array::from_fn(|r| scaled[r].irradiance(cells, side, b));
                        let (mean, variance) = moments(both.map(|(d, i)| d + i));
                        (h[b], e[b]) = (mean, variance);
                        let (direct, indirect) = (moments(both.map(|b| b.0)).1, moments(both.map(|b| b.1)).1);
                        sums.add(weight, [1.0, mean, variance, 0.0, direct, indirect]);
                    }
                    // Known of the mean over bands alone: each band has its part of it.
                    let level = mean(h);
                    for (h, e) in h.iter().zip(e) {
                        let by_cells = by_cells * ratio(*h, level).powi(2);
                        *e = (*e + by_cells.max(0.0)).sqrt();
                        sums.add(weight, [0.0, 0.0, 0.0, by_cells, 0.0, 0.0]);
                    }
                }
                sums
            })
            .collect();
        let mut all = Moments::default();
        parts.iter().for_each(|part| all.add(1.0, part.0));
        self.mean_irradiance = all.mean(1);
        self.relative_sampling = ratio(all.mean(2).sqrt(), self.mean_irradiance);
        self.relative_cells = ratio(all.mean(3).max(0.0).sqrt(), self.mean_irradiance);
        self.relative = MARGIN * self.relative_sampling.hypot(self.relative_cells);
        (self.direct_variance, self.indirect_variance) = (all.mean(4), all.mean(5));
    }

    pub fn report(
        &self,
        shooting: &Shooting,
        cells: &Cells,
        lighting: &Lighting,
        luminaires: &Luminaires,
        accuracy: f64,
        limit: Limit,
    ) -> Report {
        let enclosure = cells.enclosure;
        let escape_share = ratio(shooting.rays_escaped as f64, shooting.rays_gathered as f64);
        Report {
            accuracy,
            limited_by: Some(limit),
            estimated_error: self.relative,
            interval: (self.relative / (MARGIN * MARGIN), self.relative),
            causes: vec![(Cause::Sampling, self.relative_sampling), (Cause::Transport, self.relative_cells)],
            sampling_error: self.relative_sampling,
            discretisation_error: self.relative_cells,
            patches: enclosure.patches().len(),
            sides: enclosure.sides(),
            luminaires: luminaires.list.len(),
            rays: shooting.rays_shot + shooting.rays_gathered,
            shadow_rays: if luminaires.list.is_empty() { 0 } else { shooting.shadow_rays() },
            rounds: shooting.rounds as usize,
            solver: SolverReport {
                name: "shooting",
                iterations: shooting.bounces as usize,
                residual: shooting.left,
                stop: Stop::Converged.name(),
                converged: true,
                ..SolverReport::default()
            },
            energy: Energy { escape_share, ..self.energy.clone() },
            closure: shooting.closure(cells),
            memory_bytes: enclosure.memory_bytes()
                + super::state::memory(cells.count(), lighting.bands, luminaires) as usize,
            ..Report::default()
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
        absorbed_by_mirrors: Vec::new(),
        unfollowed: Vec::new(),
        imbalance: 0.0,
        escape_share: 0.0,
    };
    energy.balance();
    energy
}

impl Shooting {
    /// Square of the error that taking cells as constant leaves in a side, in the mean over bands; without bias, so it
    /// may be negative: the product of what both halves of the replicates say.
    fn error_by_cells(&self, cells: &Cells, side: usize) -> f64 {
        let each = cells.per_side();
        let of = |half: &Vec<f32>| half[side * each..][..each].iter().map(|&c| f64::from(c)).sum::<f64>();
        let rays = f64::from(self.rays) * each as f64 * (REPLICATES / 2) as f64;
        let [a, b] = [0, 1].map(|half| cells.error_left() * ratio(of(&self.changed[half]), rays));
        a * b
    }

    /// Row sums of F as rays that gathered found them: least, mean by area, greatest.
    fn closure(&self, cells: &Cells) -> (f64, f64, f64) {
        let levels = super::state::levels(cells);
        let rays = |cell: usize| REPLICATES as f64 * f64::from(super::gather::of_level(self.rays, levels[cell]));
        let row: Vec<f64> = self.landed.iter().enumerate().map(|(c, &n)| ratio(f64::from(n), rays(c))).collect();
        let area: Vec<f64> = (0..cells.count()).map(|c| cells.area(c)).collect();
        crate::solve::closure(&row, &area)
    }
}
