//! Lights without area: no ray finds them, so each is looked for.

use glam::DVec3;
use radiosity_exchange::luminaires::pointlike;
use radiosity_exchange::{Enclosure, Luminaire};
use radiosity_geometry::bvh::Ray;

/// A light without area.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// A point, a spot or parallel light.
    pub luminaire: Luminaire,
    /// Per band: W/sr, or W/m2 of parallel light.
    pub strength: Vec<f32>,
}

/// So many lights are looked at from where paths start, one by one: of a light in whose shadow a point lies, no choice
/// among lights would know.
const FEW: usize = 8;

/// All of a scene.
pub(crate) struct Lights {
    list: Vec<Light>,
    /// Mean over bands.
    mean: Vec<f64>,
}

/// One light, as a point sees it.
pub(crate) struct Seen {
    pub light: usize,
    /// What its strength weighs in the irradiance, if nothing is between.
    pub weight: f32,
    pub ray: Ray,
}

impl Lights {
    pub fn new(list: Vec<Light>) -> Self {
        let mean = list.iter().map(|l| l.strength.iter().map(|&s| f64::from(s)).sum::<f64>()).collect();
        Self { list, mean }
    }

    pub fn strength(&self, light: usize) -> &[f32] {
        &self.list[light].strength
    }

    /// Whether a point may look at each of them.
    pub fn are_few(&self) -> bool {
        self.list.len() <= FEW
    }

    /// All that bring anything if nothing is between.
    pub fn all<'a>(&'a self, enclosure: &'a Enclosure, at: DVec3, normal: DVec3) -> impl Iterator<Item = Seen> + 'a {
        let transfer = move |light: &Light| pointlike(&light.luminaire, at, normal);
        let seen = self.list.iter().map(transfer).enumerate().filter(|(_, transfer)| *transfer > 0.0);
        seen.map(move |(light, transfer)| self.seen(enclosure, at, light, transfer))
    }

    /// A light for a number in (0, 1), chosen by what each would bring if nothing were between; none if all bring
    /// nothing.
    pub fn choose(&self, enclosure: &Enclosure, at: DVec3, normal: DVec3, choice: f64) -> Option<Seen> {
        let brings = |i: usize| self.mean[i] * pointlike(&self.list[i].luminaire, at, normal);
        let total: f64 = (0..self.list.len()).map(brings).sum();
        let mut left = choice * total;
        let mut chosen = None;
        for (i, own) in (0..self.list.len()).map(brings).enumerate().filter(|(_, own)| *own > 0.0) {
            chosen = Some(i);
            if left < own {
                break;
            }
            left -= own;
        }
        // Its transfer over the probability of having chosen it, which is mean * transfer / total.
        chosen.map(|light| self.seen(enclosure, at, light, total / self.mean[light]))
    }

    fn seen(&self, enclosure: &Enclosure, at: DVec3, light: usize, weight: f64) -> Seen {
        let ray = match self.list[light].luminaire {
            Luminaire::Directional { direction } => enclosure.ray(at, -direction.as_vec3()),
            Luminaire::Point { position } | Luminaire::Spot { position, .. } => enclosure.segment(at, position),
            Luminaire::Side(side) => {
                enclosure.segment(at, enclosure.patches().centre[enclosure.patch_of(side as usize)])
            }
        };
        Seen { light, weight: weight as f32, ray }
    }
}
