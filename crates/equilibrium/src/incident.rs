//! What lamps put on sides straight away, sampled side by side for a solve on whole sides.
//!
//! Lamps that shine alike, patches of one surface or a light without area, are a group, and what each group puts on a
//! side for each unit of its strength is kept: so their light can be dimmed and coloured without a new ray.

use crate::answer::ratio;
use crate::error::relative_rms;
use crate::lighting::{Lamp, Lighting};
use crate::solve::REPLICATES;
use radiosity_exchange::luminaires::Luminaires;
use radiosity_exchange::{Enclosure, LightSample, Luminaire, Samples};
use radiosity_operator::{Cancelled, Control};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Arc;

/// Tests from every side, per replicate: shadows that cross a side are told by so many.
const TESTS: (u32, u32) = (16, 1024);

/// How often a side must be tested for an accuracy of 1: the error falls faster than the number of tests to the power
/// of 3/4, and few sides are crossed by a shadow.
const TESTS_FOR_ALL: f64 = 0.64;

/// Sides whose samples are in memory at a time.
const BATCH: usize = 1 << 14;

/// More groups are not kept one by one: then other lamps mean new tests.
const MOST_GROUPS: usize = 64;

/// Irradiance straight from lamps. Blocks are sides x bands, W/m2.
pub struct Incident {
    pub(crate) mean: Vec<f64>,
    pub(crate) standard_error: Vec<f64>,
    pub(crate) tests: u64,
    luminaires: Luminaires,
    groups: Groups,
    /// The share of each side on which no solid stands; empty where nobody asked. Means are over that.
    exposed: Arc<Vec<f32>>,
    /// Tests from a side, per replicate, and their seed: the same tests can be made again.
    each: u32,
    seed: u64,
    /// Sides x groups: mean and squared standard error for a strength of one.
    units: Vec<[f32; 2]>,
}

/// Lamps that shine alike.
struct Groups {
    /// Of each luminaire.
    of: Vec<u32>,
    /// A luminaire of each group.
    first: Vec<usize>,
}

impl Groups {
    fn new(luminaires: &Luminaires, lighting: &Lighting, enclosure: &Enclosure) -> Self {
        let mut groups = Self { of: Vec::with_capacity(luminaires.list.len()), first: Vec::new() };
        let surface = |k: usize| match luminaires.list[k] {
            Luminaire::Side(side) => Some(enclosure.patches().surface[enclosure.patch_of(side as usize)]),
            _ => None,
        };
        for k in 0..luminaires.list.len() {
            let strength = strength(luminaires, lighting, enclosure, k);
            let is_alike = |&g: &usize| {
                let other = groups.first[g];
                surface(k).is_some()
                    && surface(other) == surface(k)
                    && self::strength(luminaires, lighting, enclosure, other) == strength
            };
            // The last few: lamps are in the order of their patches.
            let recent = groups.first.len().saturating_sub(MOST_GROUPS)..groups.first.len();
            let group = recent.rev().find(is_alike).unwrap_or_else(|| {
                groups.first.push(k);
                groups.first.len() - 1
            });
            groups.of.push(group as u32);
        }
        groups
    }

    fn are_few(&self) -> bool {
        self.first.len() <= MOST_GROUPS
    }
}

/// What a luminaire shines with, per band.
fn strength<'a>(luminaires: &Luminaires, lighting: &'a Lighting, enclosure: &Enclosure, k: usize) -> &'a [f64] {
    match luminaires.list[k] {
        Luminaire::Side(side) => lighting.emission_of(enclosure.patch_of(side as usize)),
        // Lights without area come last.
        _ => &lighting.lamps[k + lighting.lamps.len() - luminaires.list.len()].strength,
    }
}

/// The lights without area.
pub(crate) fn without_area(lighting: &Lighting) -> Luminaires {
    Luminaires {
        list: lighting.lamps.iter().map(|lamp| lamp.luminaire).collect(),
        strength: lighting.lamps.iter().map(Lamp::mean_strength).collect(),
    }
}

impl Incident {
    /// Tests the lamps from every side, `each` times per replicate.
    pub(crate) fn new(
        enclosure: &Enclosure,
        lighting: &Lighting,
        luminaires: Luminaires,
        exposed: Arc<Vec<f32>>,
        each: u32,
        seed: u64,
        control: &Control,
    ) -> Result<Self, Cancelled> {
        let (sides, size) = (enclosure.sides(), enclosure.sides() * lighting.bands);
        let groups = Groups::new(&luminaires, lighting, enclosure);
        let kept = if groups.are_few() { groups.first.len() } else { 0 };
        let mut incident = Self {
            mean: vec![0.0; size],
            standard_error: vec![0.0; size],
            tests: 0,
            units: vec![[0.0; 2]; sides * kept],
            luminaires,
            groups,
            exposed,
            each,
            seed,
        };
        if incident.luminaires.list.is_empty() {
            return Ok(incident);
        }
        control.expect(sides as u64 * u64::from(each) * REPLICATES as u64);
        for batch in batches(sides) {
            incident.test(enclosure, lighting, batch, control)?;
        }
        Ok(incident)
    }

    /// The same lamps at other strengths, by the same tests: made again if they no longer shine alike that did. None if
    /// there are other lamps.
    pub(crate) fn relit(
        &self,
        enclosure: &Enclosure,
        lighting: &Lighting,
        luminaires: &Luminaires,
        control: &Control,
    ) -> Result<Option<Self>, Cancelled> {
        let (groups, list) = (&self.groups, &self.luminaires.list);
        let of = |k: usize| strength(&self.luminaires, lighting, enclosure, k);
        let are_alike = || (0..list.len()).all(|k| of(k) == of(groups.first[groups.of[k] as usize]));
        // Lamps that are out may be missing among the new.
        let mut old = list.iter();
        // Both are in one order.
        let are_known = luminaires.list.iter().all(|l| old.any(|o| o == l));
        if !are_known {
            return Ok(None);
        }
        if !(groups.are_few() && are_alike()) {
            let (luminaires, exposed) = (self.luminaires.clone(), self.exposed.clone());
            return Self::new(enclosure, lighting, luminaires, exposed, self.each, self.seed, control).map(Some);
        }
        let (bands, count) = (lighting.bands, groups.first.len());
        let mut relit = Self {
            mean: vec![0.0; self.mean.len()],
            standard_error: vec![0.0; self.mean.len()],
            tests: 0,
            luminaires: self.luminaires.clone(),
            groups: Groups { of: groups.of.clone(), first: groups.first.clone() },
            units: self.units.clone(),
            exposed: self.exposed.clone(),
            each: self.each,
            seed: self.seed,
        };
        let errors = relit.standard_error.par_chunks_mut(bands);
        let units = self.units.par_chunks(count.max(1));
        relit.mean.par_chunks_mut(bands).zip(errors).zip(units).for_each(|((mean, error), units)| {
            for (&first, [unit, variance]) in groups.first.iter().zip(units) {
                for (band, s) in of(first).iter().enumerate() {
                    mean[band] += s * f64::from(*unit);
                    error[band] += s * s * f64::from(*variance);
                }
            }
            error.iter_mut().for_each(|e| *e = e.sqrt());
        });
        Ok(Some(relit))
    }

    /// Power from lights without area, W per band: what arrives from sides is theirs.
    pub(crate) fn power_of_lights(&self, enclosure: &Enclosure, lighting: &Lighting) -> Vec<f64> {
        let (bands, count) = (lighting.bands, self.groups.first.len());
        let is_side = |k: usize| matches!(self.luminaires.list[k], Luminaire::Side(_));
        let lights: Vec<usize> = (0..count).filter(|&g| !is_side(self.groups.first[g])).collect();
        let strength = |g: usize| strength(&self.luminaires, lighting, enclosure, self.groups.first[g]);
        // Too many groups to tell apart count as sides, if there are any.
        let is_all = self.units.is_empty() && lights.len() == count;
        let irradiance = |side: usize, band: usize| {
            if is_all {
                return self.mean[side * bands + band];
            }
            let light = |&g: &usize| strength(g)[band] * f64::from(self.units[side * count + g][0]);
            if self.units.is_empty() { 0.0 } else { lights.iter().map(light).sum() }
        };
        let areas = self.exposed_areas(enclosure);
        let power = |band: usize| areas.iter().enumerate().map(|(side, area)| area * irradiance(side, band)).sum();
        (0..bands).map(power).collect()
    }

    /// What the exchange is to carry of what sides emit: not what was tested here.
    pub(crate) fn left(&self, emission: &[f64], bands: usize) -> Vec<f64> {
        let mut left = emission.to_vec();
        for luminaire in &self.luminaires.list {
            if let Luminaire::Side(side) = luminaire {
                left[*side as usize * bands..(*side as usize + 1) * bands].fill(0.0);
            }
        }
        left
    }

    /// The area of each side on which no solid stands, m2.
    pub(crate) fn exposed_areas(&self, enclosure: &Enclosure) -> Vec<f64> {
        (0..enclosure.sides()).map(|side| enclosure.area(side) * self.exposed_share(side)).collect()
    }

    fn exposed_share(&self, side: usize) -> f64 {
        self.exposed.get(side).map_or(1.0, |&share| f64::from(share))
    }

    pub(crate) fn exposed(&self) -> &Arc<Vec<f32>> {
        &self.exposed
    }

    /// Root mean square error over area, relative to the mean of `irradiance`.
    pub(crate) fn relative_error(&self, enclosure: &Enclosure, irradiance: &[f64], bands: usize) -> f64 {
        let error = |k: usize| self.exposed_share(k / bands) * self.standard_error[k];
        relative_rms(enclosure, irradiance, bands, error)
    }

    /// What a strength of one of each luminaire is worth, where irradiance of each side is worth so much: from sides x
    /// columns to luminaires x columns. The tests are made again, as lamps that shine alike are not kept apart.
    pub(crate) fn transposed(
        &self,
        enclosure: &Enclosure,
        worth: &[f64],
        columns: usize,
        control: &Control,
    ) -> Result<Vec<f64>, Cancelled> {
        let mut by_luminaire = vec![0.0; self.luminaires.list.len() * columns];
        if by_luminaire.is_empty() {
            return Ok(by_luminaire);
        }
        for batch in batches(enclosure.sides()) {
            let samples = self.samples(enclosure, &batch, control)?;
            for side in batch {
                let (worth, per_test) = (&worth[side * columns..][..columns], self.per_test(side) / REPLICATES as f64);
                for sample in samples.of(side).flatten().filter(|sample| sample.weight > 0.0) {
                    let weight = f64::from(sample.weight) * per_test;
                    let out = &mut by_luminaire[sample.luminaire as usize * columns..][..columns];
                    out.iter_mut().zip(worth).for_each(|(o, w)| *o += weight * w);
                }
            }
        }
        Ok(by_luminaire)
    }

    /// The luminaires, lights without area last.
    pub(crate) fn luminaires(&self) -> &[Luminaire] {
        &self.luminaires.list
    }

    /// What a test of a side counts in the mean of its replicate. What is buried receives nothing, and does not count.
    fn per_test(&self, side: usize) -> f64 {
        ratio(1.0, self.exposed_share(side)) / f64::from(self.each)
    }

    /// The tests from a few sides.
    fn samples(
        &self,
        enclosure: &Enclosure,
        sides: &Range<usize>,
        control: &Control,
    ) -> Result<Samples<LightSample>, Cancelled> {
        let mut samples = Samples::new(enclosure.sides(), REPLICATES);
        let wanted: Vec<u32> =
            (0..enclosure.sides()).map(|side| if sides.contains(&side) { self.each } else { 0 }).collect();
        self.luminaires.sample(enclosure, &mut samples, &wanted, self.seed, control)?;
        Ok(samples)
    }

    fn test(
        &mut self,
        enclosure: &Enclosure,
        lighting: &Lighting,
        sides: Range<usize>,
        control: &Control,
    ) -> Result<(), Cancelled> {
        let (bands, count) = (lighting.bands, self.groups.first.len());
        let samples = self.samples(enclosure, &sides, control)?;
        self.tests += samples.total() as u64;
        let strengths: Vec<&[f64]> =
            self.groups.first.iter().map(|&k| strength(&self.luminaires, lighting, enclosure, k)).collect();
        let of = &self.groups.of;
        let found: Vec<Tested> = sides
            .clone()
            .into_par_iter()
            .map(|side| {
                let share = self.per_test(side);
                // Per replicate and group, for a strength of one.
                let mut units = vec![[0.0; REPLICATES]; count];
                (0..REPLICATES).for_each(|replicate| {
                    for s in samples.replicate(side, replicate).flatten() {
                        units[of[s.luminaire as usize] as usize][replicate] += f64::from(s.weight) * share;
                    }
                });
                let band = |band: usize| -> (f64, f64) {
                    spread(&std::array::from_fn(|r| units.iter().zip(&strengths).map(|(u, s)| s[band] * u[r]).sum()))
                };
                let (mean, error) = (0..bands).map(band).map(|(m, v)| (m, v.sqrt())).unzip();
                let unit = |u: &[f64; REPLICATES]| {
                    let (mean, variance) = spread(u);
                    [mean as f32, variance as f32]
                };
                (mean, error, units.iter().map(unit).collect())
            })
            .collect();
        for (side, (mean, error, units)) in sides.zip(found) {
            self.mean[side * bands..(side + 1) * bands].copy_from_slice(&mean);
            self.standard_error[side * bands..(side + 1) * bands].copy_from_slice(&error);
            if !self.units.is_empty() {
                self.units[side * count..(side + 1) * count].copy_from_slice(&units);
            }
        }
        Ok(())
    }
}

/// All sides, a few at a time.
fn batches(sides: usize) -> impl Iterator<Item = Range<usize>> {
    (0..sides).step_by(BATCH).map(move |start| start..(start + BATCH).min(sides))
}

/// Of a side: means and errors by band, and what it receives of each group for a strength of one.
type Tested = (Vec<f64>, Vec<f64>, Vec<[f32; 2]>);

/// The mean of replicates and the square of its standard error.
fn spread(values: &[f64; REPLICATES]) -> (f64, f64) {
    let n = REPLICATES as f64;
    let mean = values.iter().sum::<f64>() / n;
    (mean, values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n * (n - 1.0)))
}

/// Tests from a side, per replicate, for an accuracy.
pub(crate) fn tests(accuracy: f64) -> u32 {
    ((TESTS_FOR_ALL / accuracy) as u32).next_power_of_two().clamp(TESTS.0, TESTS.1)
}

/// The most tests from a side that are worth it, per replicate.
pub(crate) const MOST_TESTS: u32 = TESTS.1;

/// Bytes that tests take at most, beside the blocks.
pub(crate) fn forecast(sides: usize, accuracy: f64) -> u64 {
    (12 + 8 * MOST_GROUPS as u64) * sides as u64
        + 12 * (BATCH.min(sides) * REPLICATES) as u64 * u64::from(tests(accuracy))
}
