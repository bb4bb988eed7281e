//! What lights without area put on sides, sampled side by side for a solve on whole sides.

use crate::lighting::{Lamp, Lighting};
use crate::solve::REPLICATES;
use radiosity_exchange::luminaires::Luminaires;
use radiosity_exchange::{Enclosure, LightSample, Samples};
use radiosity_operator::{Cancelled, Control};
use rayon::prelude::*;
use std::ops::Range;

/// Tests from every side, per replicate: shadows that cross a side are told by so many.
const TESTS: (u32, u32) = (16, 1024);

/// How often a side must be tested for an accuracy of 1: the error falls faster than the number of tests to the power
/// of 3/4, and few sides are crossed by a shadow.
const TESTS_FOR_ALL: f64 = 0.64;

/// Sides whose samples are in memory at a time.
const BATCH: usize = 1 << 14;

/// Irradiance straight from lights without area. Blocks are sides x bands, W/m2.
pub struct Incident {
    pub(crate) mean: Vec<f64>,
    pub(crate) standard_error: Vec<f64>,
    pub(crate) tests: u64,
    /// The lights it is of.
    lamps: Vec<Lamp>,
}

impl Incident {
    /// Tests the lights from every side as often as an accuracy asks for.
    pub(crate) fn new(
        enclosure: &Enclosure,
        lighting: &Lighting,
        accuracy: f64,
        seed: u64,
        control: &Control,
    ) -> Result<Self, Cancelled> {
        let (sides, size) = (enclosure.sides(), enclosure.sides() * lighting.bands);
        let mut incident =
            Self { mean: vec![0.0; size], standard_error: vec![0.0; size], tests: 0, lamps: lighting.lamps.clone() };
        if lighting.lamps.is_empty() {
            return Ok(incident);
        }
        let each = each(accuracy);
        control.expect(sides as u64 * u64::from(each) * REPLICATES as u64);
        for start in (0..sides).step_by(BATCH) {
            incident.test(enclosure, lighting, start..(start + BATCH).min(sides), each, seed, control)?;
        }
        Ok(incident)
    }

    /// Whether it is of these lights.
    pub(crate) fn is_of(&self, lighting: &Lighting) -> bool {
        self.lamps == lighting.lamps
    }

    fn test(
        &mut self,
        enclosure: &Enclosure,
        lighting: &Lighting,
        sides: Range<usize>,
        each: u32,
        seed: u64,
        control: &Control,
    ) -> Result<(), Cancelled> {
        let (bands, lamps) = (lighting.bands, &lighting.lamps);
        let luminaires = Luminaires {
            list: lamps.iter().map(|lamp| lamp.luminaire).collect(),
            strength: lamps.iter().map(Lamp::mean_strength).collect(),
        };
        let mut samples = Samples::<LightSample>::new(enclosure.sides(), REPLICATES);
        let wanted: Vec<u32> =
            (0..enclosure.sides()).map(|side| if sides.contains(&side) { each } else { 0 }).collect();
        luminaires.sample(enclosure, &mut samples, &wanted, seed, control)?;
        self.tests += samples.total() as u64;
        let range = sides.start * bands..sides.end * bands;
        let errors = self.standard_error[range.clone()].par_chunks_mut(bands);
        self.mean[range].par_chunks_mut(bands).zip(errors).zip(sides).for_each(|((mean, error), side)| {
            for band in 0..bands {
                let value = |s: &LightSample| f64::from(s.weight) * lamps[s.luminaire as usize].strength[band];
                let of = |k| samples.replicate(side, k).flatten().map(value).sum::<f64>() / f64::from(each);
                let means: [f64; REPLICATES] = std::array::from_fn(of);
                let n = REPLICATES as f64;
                mean[band] = means.iter().sum::<f64>() / n;
                error[band] = (means.iter().map(|m| (m - mean[band]).powi(2)).sum::<f64>() / (n * (n - 1.0))).sqrt();
            }
        });
        Ok(())
    }
}

/// Tests from a side, per replicate.
fn each(accuracy: f64) -> u32 {
    ((TESTS_FOR_ALL / accuracy) as u32).next_power_of_two().clamp(TESTS.0, TESTS.1)
}

/// Bytes that tests take at most, beside the blocks.
pub(crate) fn forecast(sides: usize, accuracy: f64) -> u64 {
    12 * sides as u64 + 12 * (BATCH.min(sides) * REPLICATES) as u64 * u64::from(each(accuracy))
}
