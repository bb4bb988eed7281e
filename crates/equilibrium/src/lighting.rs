//! What shines and what reflects: the optics of a solve, apart from its geometry.

use crate::answer::ratio;
use crate::solve::Failure;
use radiosity_exchange::luminaires::Luminaires;
use radiosity_exchange::{Enclosure, Luminaire};
use std::borrow::Cow;

/// Emission and reflectance per patch and band, and the lights without area.
#[derive(Clone, Debug, Default)]
pub struct Lighting {
    /// The number of bands.
    pub bands: usize,
    /// Diffuse reflectance in [0, 1), patches x bands.
    pub reflectance: Vec<f64>,
    /// Radiant exitance, W/m2, patches x bands. Both sides of a two-sided patch emit it.
    pub emission: Vec<f64>,
    /// Lights without area.
    pub lamps: Vec<Lamp>,
    /// Diffuse transmittance in [0, 1), patches x bands: what leaves the other side of a two-sided patch. Empty where
    /// nothing passes.
    pub diffuse_transmittance: Vec<f64>,
}

/// A light without area and its strength per band: W/sr for points and spots, W/m2 for directional light.
#[derive(Clone, Debug, PartialEq)]
pub struct Lamp {
    /// Where it is and where it shines.
    pub luminaire: Luminaire,
    /// Per band.
    pub strength: Vec<f64>,
}

impl Lamp {
    /// The mean over bands, by which samples are shared.
    pub fn mean_strength(&self) -> f64 {
        mean(&self.strength)
    }
}

/// An emitter is sampled by area when its exitance exceeds the scene's mean emission this many times: rays find
/// weaker ones often enough, and in a scene where everything glows nothing is a lamp.
const LAMP_CONTRAST: f64 = 6.0;

/// At most this many emitting patches are sampled by area, the strongest; rays find the others.
const MOST_LAMPS: usize = 4096;

pub(crate) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

impl Lighting {
    /// The bands of patch `i`.
    pub fn reflectance_of(&self, patch: usize) -> &[f64] {
        &self.reflectance[patch * self.bands..(patch + 1) * self.bands]
    }

    /// The bands of patch `i`.
    pub fn emission_of(&self, patch: usize) -> &[f64] {
        &self.emission[patch * self.bands..(patch + 1) * self.bands]
    }

    /// The bands of what patch `i` sends from either side to the other; none if nothing.
    pub fn diffuse_transmittance_of(&self, patch: usize) -> Option<&[f64]> {
        let own = self.diffuse_transmittance.get(patch * self.bands..(patch + 1) * self.bands)?;
        own.iter().any(|&tau| tau > 0.0).then_some(own)
    }

    /// What a side absorbs of what meets its diffuse part, as a share of that.
    pub(crate) fn absorptance(&self, patch: usize, band: usize) -> f64 {
        1.0 - self.reflectance_of(patch)[band] - self.diffuse_transmittance_of(patch).map_or(0.0, |tau| tau[band])
    }

    /// Refuses what lets light through diffusely, for a way to solve that takes patches for opaque.
    pub(crate) fn demand_opaque(&self, way: &'static str) -> Result<(), Failure> {
        let patches = self.reflectance.len() / self.bands.max(1);
        match (0..patches).find(|&patch| self.diffuse_transmittance_of(patch).is_some()) {
            Some(patch) => Err(Failure::Translucent { way, patch }),
            None => Ok(()),
        }
    }

    /// A block, sides x bands, with each side's patch's values.
    pub(crate) fn per_side<'a>(&'a self, enclosure: &Enclosure, of_patch: impl Fn(usize) -> &'a [f64]) -> Vec<f64> {
        (0..enclosure.sides()).flat_map(|side| of_patch(enclosure.patch_of(side))).copied().collect()
    }

    /// The largest reflectance of any patch and band, what leaves the other side included: what light loses least by at
    /// a bounce.
    pub fn highest_reflectance(&self) -> f64 {
        let through = self.diffuse_transmittance.iter().chain(std::iter::repeat(&0.0));
        self.reflectance.iter().zip(through).fold(0.0, |a: f64, (rho, tau)| a.max(rho + tau))
    }

    /// The optics of what is neither mirror nor pane of patches, as if the rest of their area were not there: what sends
    /// and reflects as much from less. Perfect mirrors and panes have none.
    pub fn of_diffuse_parts(&self, enclosure: &Enclosure) -> Cow<'_, Self> {
        let Some(specular) = enclosure.specular() else { return Cow::Borrowed(self) };
        let scaled = |block: &[f64]| -> Vec<f64> {
            block.iter().enumerate().map(|(k, v)| ratio(*v, specular.diffuse_share(k / self.bands))).collect()
        };
        let (reflectance, emission) = (scaled(&self.reflectance), scaled(&self.emission));
        let diffuse_transmittance = scaled(&self.diffuse_transmittance);
        let (bands, lamps) = (self.bands, self.lamps.clone());
        Cow::Owned(Self { bands, reflectance, emission, lamps, diffuse_transmittance })
    }

    /// Chooses what is sampled by area: strong emitters and every light without area, in a fixed order.
    pub fn luminaires(&self, enclosure: &Enclosure) -> Luminaires {
        let patches = enclosure.patches();
        let exitance: Vec<f64> = (0..patches.len()).map(|i| mean(self.emission_of(i))).collect();
        let area: f64 = (0..enclosure.sides()).map(|s| enclosure.area(s)).sum();
        let flux: f64 = (0..enclosure.sides()).map(|s| enclosure.area(s) * exitance[enclosure.patch_of(s)]).sum();
        let threshold = LAMP_CONTRAST * flux / area;
        let mut sides: Vec<usize> = (0..enclosure.sides())
            .filter(|&s| enclosure.area(s) > 0.0 && exitance[enclosure.patch_of(s)] > threshold)
            .collect();
        let power = |s: &usize| enclosure.area(*s) * exitance[enclosure.patch_of(*s)];
        sides.sort_by(|a, b| power(b).total_cmp(&power(a)).then(a.cmp(b)));
        sides.truncate(MOST_LAMPS);
        sides.sort_unstable();
        let mut luminaires = Luminaires::default();
        for side in sides {
            luminaires.list.push(Luminaire::Side(side as u32));
            luminaires.strength.push(exitance[enclosure.patch_of(side)]);
        }
        for lamp in &self.lamps {
            luminaires.list.push(lamp.luminaire);
            luminaires.strength.push(lamp.mean_strength());
        }
        luminaires
    }
}
