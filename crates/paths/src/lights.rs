//! Lights without area: no ray finds them, so each is looked for, in mirrors at its images.

use glam::DVec3;
use radiosity_exchange::images::Images;
use radiosity_exchange::luminaires::{Luminaires, pointlike};
use radiosity_exchange::{Enclosure, Luminaire, Specular};
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

/// All of a scene, and their images in mirrors.
pub(crate) struct Lights {
    list: Vec<Light>,
    places: Vec<Place>,
}

/// Where a light is, or seems to be.
struct Place {
    light: usize,
    /// It, there.
    luminaire: Luminaire,
    /// Mean over bands of what is left of its strength.
    mean: f64,
    /// Where it seems to be, from the image in all mirrors to the light itself; of parallel light, directions towards it.
    aims: Vec<DVec3>,
    /// The mirrors on the way from a point that is lit.
    mirrors: Vec<u32>,
}

/// One light, as a point sees it.
pub(crate) struct Seen {
    /// Which, among lights and images.
    pub place: usize,
    /// What its strength weighs in the irradiance, if nothing is between.
    pub weight: f32,
    pub ray: Ray,
}

impl Lights {
    /// Finds images as far as the exchange does: all of them, unless mirrors face one another.
    pub fn new(enclosure: &Enclosure, list: Vec<Light>) -> Self {
        let of_light = |light| Place::of(&list, light, list[light].luminaire, 1.0, None);
        let mut places: Vec<Place> = (0..list.len()).map(of_light).collect();
        if let Some(specular) = enclosure.specular() {
            let luminaires = Luminaires {
                list: list.iter().map(|light| light.luminaire).collect(),
                strength: places.iter().map(|place| place.mean).collect(),
            };
            places.extend(Images::new(enclosure, &luminaires).list.iter().map(|image| {
                let light = image.luminaire as usize;
                let seeming = image.seeming(specular, &list[light].luminaire);
                Place::of(&list, light, seeming, image.reflectance, Some((specular, &image.mirrors)))
            }));
        }
        Self { list, places }
    }

    pub fn strength(&self, place: usize) -> &[f32] {
        &self.list[self.places[place].light].strength
    }

    /// Whether a point may look at each of them.
    pub fn are_few(&self) -> bool {
        self.places.len() <= FEW
    }

    /// All that bring anything if nothing is between.
    pub fn all<'a>(&'a self, enclosure: &'a Enclosure, at: DVec3, normal: DVec3) -> impl Iterator<Item = Seen> + 'a {
        let transfer = move |place: &Place| pointlike(&place.luminaire, at, normal);
        let seen = self.places.iter().map(transfer).enumerate().filter(|(_, transfer)| *transfer > 0.0);
        seen.map(move |(place, transfer)| self.seen(enclosure, at, place, transfer))
    }

    /// A light for a number in (0, 1), chosen by what each would bring if nothing were between; none if all bring
    /// nothing.
    pub fn choose(&self, enclosure: &Enclosure, at: DVec3, normal: DVec3, choice: f64) -> Option<Seen> {
        let brings = |i: usize| self.places[i].mean * pointlike(&self.places[i].luminaire, at, normal);
        let total: f64 = (0..self.places.len()).map(brings).sum();
        let mut left = choice * total;
        let mut chosen = None;
        for (i, own) in (0..self.places.len()).map(brings).enumerate().filter(|(_, own)| *own > 0.0) {
            chosen = Some(i);
            if left < own {
                break;
            }
            left -= own;
        }
        // Its transfer over the probability of having chosen it, which is mean * transfer / total.
        chosen.map(|place| self.seen(enclosure, at, place, total / self.places[place].mean))
    }

    /// What is left of a light on its way to a point by mirrors and panes.
    pub fn passage(&self, enclosure: &Enclosure, specular: &Specular, at: DVec3, place: usize) -> f64 {
        let Place { luminaire, aims, mirrors, .. } = &self.places[place];
        let is_parallel = matches!(luminaire, Luminaire::Directional { .. });
        enclosure.passage(specular, at, aims, mirrors, is_parallel)
    }

    fn seen(&self, enclosure: &Enclosure, at: DVec3, place: usize, weight: f64) -> Seen {
        let ray = match self.places[place].luminaire {
            Luminaire::Directional { direction } => enclosure.ray(at, -direction.as_vec3()),
            Luminaire::Point { position } | Luminaire::Spot { position, .. } => enclosure.segment(at, position),
            Luminaire::Side(side) => {
                enclosure.segment(at, enclosure.patches().centre[enclosure.patch_of(side as usize)])
            }
        };
        Seen { place, weight: weight as f32, ray }
    }
}

impl Place {
    /// A light, or an image of it in mirrors in the order that its light meets them.
    fn of(
        list: &[Light],
        light: usize,
        luminaire: Luminaire,
        reflectance: f64,
        mirrors: Option<(&Specular, &[u32])>,
    ) -> Self {
        let itself = match list[light].luminaire {
            Luminaire::Directional { direction } => -direction,
            Luminaire::Point { position } | Luminaire::Spot { position, .. } => position,
            Luminaire::Side(_) => DVec3::ZERO,
        };
        let mean = reflectance * list[light].strength.iter().map(|&s| f64::from(s)).sum::<f64>();
        let (mut aims, mut way) = (vec![itself], Vec::new());
        if let Some((specular, mirrors)) = mirrors {
            let is_parallel = matches!(luminaire, Luminaire::Directional { .. });
            for &index in mirrors {
                let (mirror, last) = (&specular.mirrors()[index as usize], aims[aims.len() - 1]);
                aims.push(if is_parallel { mirror.turned(last) } else { mirror.image(last) });
                way.push(index);
            }
        }
        aims.reverse();
        way.reverse();
        Self { light, luminaire, mean, aims, mirrors: way }
    }
}
