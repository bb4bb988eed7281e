//! What lights without area put on sides, sampled side by side for a solve on whole sides.

use crate::lighting::{Lamp, Lighting};
use crate::solve::REPLICATES;
use radiosity_exchange::luminaires::Luminaires;
use radiosity_exchange::{Enclosure, LightSample, Samples};
use radiosity_operator::{Cancelled, Control};

/// Tests of lights without area from every side, per replicate.
pub(crate) const LIGHT_SAMPLES: u32 = 1024;

/// Irradiance straight from lights without area. Blocks are sides x bands, W/m2.
pub(crate) struct Incident {
    pub mean: Vec<f64>,
    pub standard_error: Vec<f64>,
    pub tests: u64,
}

impl Incident {
    pub fn new(enclosure: &Enclosure, lighting: &Lighting, seed: u64, control: &Control) -> Result<Self, Cancelled> {
        let bands = lighting.bands;
        let size = enclosure.sides() * bands;
        let mut incident = Self { mean: vec![0.0; size], standard_error: vec![0.0; size], tests: 0 };
        if lighting.lamps.is_empty() {
            return Ok(incident);
        }
        let luminaires = Luminaires {
            list: lighting.lamps.iter().map(|lamp| lamp.luminaire).collect(),
            strength: lighting.lamps.iter().map(Lamp::mean_strength).collect(),
        };
        let mut samples = Samples::<LightSample>::new(enclosure.sides(), REPLICATES);
        let wanted = vec![LIGHT_SAMPLES; enclosure.sides()];
        luminaires.sample(enclosure, &mut samples, &wanted, seed, control)?;
        incident.tests = samples.total() as u64;
        for k in 0..size {
            let (side, band) = (k / bands, k % bands);
            let mean = |replicate: usize| {
                let each = |s: &LightSample| f64::from(s.weight) * lighting.lamps[s.luminaire as usize].strength[band];
                samples.replicate(side, replicate).flatten().map(each).sum::<f64>() / f64::from(LIGHT_SAMPLES)
            };
            let means: Vec<f64> = (0..REPLICATES).map(mean).collect();
            let n = REPLICATES as f64;
            let middle = means.iter().sum::<f64>() / n;
            incident.mean[k] = middle;
            incident.standard_error[k] =
                (means.iter().map(|m| (m - middle) * (m - middle)).sum::<f64>() / (n * (n - 1.0))).sqrt();
        }
        Ok(incident)
    }
}
