//! The measured exchange of an enclosure: what survives a change of lamps and paint.

use radiosity_exchange::images::{self, Images};
use radiosity_exchange::luminaires::{self, Luminaires};
use radiosity_exchange::operator::{ElementExchange, Measured};
use radiosity_exchange::{Elements, Enclosure, LightSample, Luminaire, Samples, Shot, shots};
use radiosity_operator::{Cancelled, Control};
use std::sync::Arc;

/// Samples per replicate that an operator keeps however it is thinned.
const FEWEST_OPERATOR_SAMPLES: u32 = 16;

/// Geometry with the samples taken of its exchange.
pub struct Transport {
    enclosure: Arc<Enclosure>,
    luminaires: Luminaires,
    /// Per side: the luminaire it is, if it is one.
    lamp_of: Vec<Option<u32>>,
    shots: Samples<Shot>,
    lights: Samples<LightSample>,
    /// How many mirrors images of emitting sides are followed through, and of lights without area.
    imaged: (u32, u32),
    seed: u64,
}

impl Transport {
    /// A transport without samples.
    pub fn new(enclosure: Arc<Enclosure>, luminaires: Luminaires, replicates: usize, seed: u64) -> Self {
        let sides = enclosure.sides();
        let mut lamp_of = vec![None; sides];
        for (k, luminaire) in luminaires.list.iter().enumerate() {
            if let Luminaire::Side(side) = luminaire {
                lamp_of[*side as usize] = Some(k as u32);
            }
        }
        Self {
            lamp_of,
            shots: Samples::new(sides, replicates),
            lights: Samples::new(sides, replicates),
            imaged: {
                let images = Images::new(&enclosure, &luminaires);
                (images.turns_of_sides, images.turns_of_lights)
            },
            enclosure,
            luminaires,
            seed,
        }
    }

    /// Samples until every side has what is wanted, per replicate.
    pub fn refine(&mut self, rays: &[u32], lights: &[u32], control: &Control) -> Result<(), Cancelled> {
        shots::shoot_beyond(&self.enclosure, &mut self.shots, rays, self.seed, self.imaged.0, control)?;
        self.luminaires.sample(&self.enclosure, &mut self.lights, lights, self.seed, control)
    }

    /// The operator on elements from `1/thinning` of the samples (but not fewer than [`FEWEST_OPERATOR_SAMPLES`] per
    /// replicate), balanced if told how well and how long to try.
    pub fn on(&self, elements: &Elements, thinning: u32, balance: Option<(f64, usize)>) -> ElementExchange {
        let thinned = |drawn: u32| (drawn / thinning).max(FEWEST_OPERATOR_SAMPLES) as usize;
        let most_shots = |side| thinned(self.shots.per_replicate(side));
        let most_lights = |side| thinned(self.lights.per_replicate(side));
        let measured = Measured {
            enclosure: &self.enclosure,
            shots: &self.shots,
            luminaires: &self.luminaires.list,
            lights: &self.lights,
            most_shots: &most_shots,
            most_lights: &most_lights,
        };
        measured.on(elements, balance)
    }

    /// The geometry.
    pub fn enclosure(&self) -> &Arc<Enclosure> {
        &self.enclosure
    }

    /// What is sampled by area.
    pub fn luminaires(&self) -> &[luminaires::Luminaire] {
        &self.luminaires.list
    }

    /// Whether pairs with a side are measured by area.
    pub fn is_lamp(&self, side: usize) -> bool {
        self.lamp_of[side].is_some()
    }

    /// What arrives from a light without area by more mirrors than images of it are followed through, per unit of its
    /// strength.
    pub fn left_out(&self, luminaire: &Luminaire) -> f64 {
        images::left_out(&self.enclosure, luminaire, self.imaged.1, self.seed)
    }

    /// Rows by rays.
    pub fn shots(&self) -> &Samples<Shot> {
        &self.shots
    }

    /// Columns by area.
    pub fn lights(&self) -> &Samples<LightSample> {
        &self.lights
    }

    /// Bytes held by the samples.
    pub fn memory_bytes(&self) -> usize {
        self.shots.memory_bytes() + self.lights.memory_bytes()
    }
}
