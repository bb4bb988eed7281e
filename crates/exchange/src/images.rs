//! Luminaires as they are seen in plane mirrors: the method of images.
//!
//! What comes from a luminaire by reflection in planes m1, m2 ... seems to come from its image in m1, mirrored in m2 and
//! so on. So an image is sampled as the luminaire is, and the test of a sample follows the way through the mirrors
//! (Allen and Berkley 1979, *Image method for efficiently simulating small-room acoustics*, of sound). A light without
//! area is found in no other way. Images are taken order by order while they are few, of emitting sides as far as they
//! reduce noise, since rays find the others.

use crate::enclosure::{Enclosure, Sight};
use crate::luminaires::{Luminaire, Luminaires};
use crate::specular::{MOST_MEETINGS, Mirror, Specular, Step};
use glam::DVec3;
use radiosity_geometry::sampling::{Frame, Sequence, mix};
use std::f64::consts::PI;

/// Images that are sampled, of all emitting sides, and of all lights without area. Of the first reflection there may be
/// several times as many: it matters most.
const MOST_OF_SIDES: usize = 1024;
const MOST_OF_LIGHTS: usize = 4096;
const MORE_AT_FIRST: usize = 4;

/// Reflections that they are followed through: between two facing mirrors there is no end of them.
const MOST_OF_SIDES_TURNS: u32 = 4;
const MOST_OF_LIGHTS_TURNS: u32 = 64;

/// The stream of the sequence that feeds rays from lights.
const STREAM: u32 = 12;

/// Rays that tell how much of a light images leave out.
const RAYS_OF_LIGHT: u32 = 1 << 14;

/// A luminaire in mirrors.
#[derive(Clone, Debug)]
pub struct Image {
    /// Which luminaire.
    pub luminaire: u32,
    /// The mirrors that light from it meets, in that order.
    pub mirrors: Vec<u32>,
    /// At most so much of it is left after them.
    pub reflectance: f64,
    /// Corners of an emitting side, or where a light is; of parallel light, where it comes from.
    corners: Vec<DVec3>,
}

/// Images of luminaires, and how far they go.
#[derive(Clone, Debug, Default)]
pub struct Images {
    /// In order of the number of mirrors, those of emitting sides first.
    pub list: Vec<Image>,
    /// They are complete to so many reflections of light from emitting sides.
    pub turns_of_sides: u32,
    /// And of lights without area.
    pub turns_of_lights: u32,
}

impl Images {
    /// Mirrors luminaires. Without mirrors there are no images, and they are complete.
    pub fn new(enclosure: &Enclosure, luminaires: &Luminaires) -> Self {
        let Some(specular) = enclosure.specular().filter(|specular| !specular.mirrors().is_empty()) else {
            return Self { list: Vec::new(), turns_of_sides: u32::MAX, turns_of_lights: u32::MAX };
        };
        let of = |are_sides: bool| -> Vec<Image> {
            let is_wanted = |l: &Luminaire| matches!(l, Luminaire::Side(_)) == are_sides;
            let wanted = luminaires.list.iter().enumerate().filter(|(_, l)| is_wanted(l));
            wanted.map(|(k, l)| Image::itself(enclosure, k, l)).collect()
        };
        let grow = |are_sides, most, turns| grow(enclosure, specular, luminaires, of(are_sides), most, turns);
        let (mut list, turns_of_sides) = grow(true, MOST_OF_SIDES, MOST_OF_SIDES_TURNS);
        let (of_lights, turns_of_lights) = grow(false, MOST_OF_LIGHTS, MOST_OF_LIGHTS_TURNS);
        list.extend(of_lights);
        Self { list, turns_of_sides, turns_of_lights }
    }
}

/// Images of images while they are few; and so many mirrors on the way all of them have.
fn grow(
    enclosure: &Enclosure,
    specular: &Specular,
    luminaires: &Luminaires,
    themselves: Vec<Image>,
    most: usize,
    most_turns: u32,
) -> (Vec<Image>, u32) {
    let margin = enclosure.margin();
    let (mut all, mut last) = (Vec::new(), themselves);
    for turns in 0..most_turns {
        let most = if turns == 0 { MORE_AT_FIRST * most } else { most };
        let mut next = Vec::new();
        for image in &last {
            let is_parallel = matches!(luminaires.list[image.luminaire as usize], Luminaire::Directional { .. });
            for (index, mirror) in specular.mirrors().iter().enumerate() {
                let is_back = |&last: &u32| mirror.is_back_of(&specular.mirrors()[last as usize], 4.0 * margin);
                if image.is_before(mirror, is_parallel, margin) && !image.mirrors.last().is_some_and(is_back) {
                    next.push(image.mirrored(index as u32, mirror, is_parallel));
                }
            }
            if all.len() + next.len() > most {
                return (all, turns);
            }
        }
        if next.is_empty() {
            return (all, u32::MAX);
        }
        all.extend(next.iter().cloned());
        last = next;
    }
    (all, most_turns)
}

impl Image {
    fn itself(enclosure: &Enclosure, index: usize, luminaire: &Luminaire) -> Self {
        let corners = match *luminaire {
            Luminaire::Side(side) => {
                let patch = enclosure.patch_of(side as usize);
                let mut corners = enclosure.patches().corners(patch).to_vec();
                if !enclosure.is_front(side as usize) {
                    corners.reverse();
                }
                corners
            }
            Luminaire::Point { position } | Luminaire::Spot { position, .. } => vec![position],
            Luminaire::Directional { direction } => vec![-direction],
        };
        Self { luminaire: index as u32, mirrors: Vec::new(), reflectance: 1.0, corners }
    }

    fn is_before(&self, mirror: &Mirror, is_parallel: bool, margin: f64) -> bool {
        match is_parallel {
            true => self.corners[0].dot(mirror.normal) > 0.0,
            false => self.corners.iter().any(|&c| mirror.height(c) > margin),
        }
    }

    fn mirrored(&self, index: u32, mirror: &Mirror, is_parallel: bool) -> Self {
        let image = |&c: &DVec3| if is_parallel { mirror.turned(c) } else { mirror.image(c) };
        // Mirrored corners go round the other way.
        let corners = self.corners.iter().rev().map(image).collect();
        let mirrors = self.mirrors.iter().copied().chain([index]).collect();
        Self { luminaire: self.luminaire, mirrors, reflectance: self.reflectance * mirror.reflectance, corners }
    }

    /// Corners of the image of an emitting side, counter-clockwise from before it.
    pub fn corners(&self) -> &[DVec3] {
        &self.corners
    }

    /// The luminaire itself, where it seems to be; of an emitting side, its number alone.
    pub fn seeming(&self, specular: &Specular, luminaire: &Luminaire) -> Luminaire {
        let turned = |direction: DVec3| self.of_mirrors(specular).fold(direction, |d, mirror| mirror.turned(d));
        let image = |point: DVec3| self.of_mirrors(specular).fold(point, |p, mirror| mirror.image(p));
        match *luminaire {
            Luminaire::Side(side) => Luminaire::Side(side),
            Luminaire::Point { position } => Luminaire::Point { position: image(position) },
            Luminaire::Spot { position, direction, cos_inner, cos_outer } => {
                Luminaire::Spot { position: image(position), direction: turned(direction), cos_inner, cos_outer }
            }
            Luminaire::Directional { direction } => Luminaire::Directional { direction: turned(direction) },
        }
    }

    fn of_mirrors<'a>(&self, specular: &'a Specular) -> impl Iterator<Item = &'a Mirror> {
        self.mirrors.iter().map(|&m| &specular.mirrors()[m as usize])
    }
}

/// Power that arrives from a light without area by more than so many reflections, per unit of its strength: m2 of
/// parallel light, sr of others. By rays from the light.
pub fn left_out(enclosure: &Enclosure, luminaire: &Luminaire, turns: u32, seed: u64) -> f64 {
    let Some(specular) = enclosure.specular().filter(|_| turns < u32::MAX) else { return 0.0 };
    let sequence = Sequence::new(seed, 0, 0, STREAM);
    let arrives = |index: u32| -> f64 {
        let [a, b, _, _] = sequence.point(index);
        let Some((origin, direction, weight)) = sent(enclosure, luminaire, a, b) else { return 0.0 };
        let mut ray = enclosure.ray(origin, direction.as_vec3());
        let mut reflections = 0;
        for met in 0..MOST_MEETINGS {
            let hit = enclosure.bvh().closest_hit(&ray);
            match enclosure.step(specular, &ray, &hit, || survival(&sequence, index, met)) {
                Step::End(Sight::Side(..)) if reflections > turns => return weight,
                Step::End(_) => return 0.0,
                Step::On { ray: next, reflected } => {
                    ray = next;
                    reflections += u32::from(reflected);
                }
            }
        }
        weight
    };
    (0..RAYS_OF_LIGHT).map(arrives).sum::<f64>() / f64::from(RAYS_OF_LIGHT)
}

/// Origin, direction and weight of a ray from a light.
fn sent(enclosure: &Enclosure, luminaire: &Luminaire, a: f64, b: f64) -> Option<(DVec3, DVec3, f64)> {
    let sphere = |axis: DVec3, least: f64| {
        let (frame, cosine) = (Frame::new(axis), 1.0 - a * (1.0 - least));
        let (sin, cos) = (2.0 * PI * b).sin_cos();
        let across = cos * frame.tangent + sin * frame.bitangent;
        ((1.0 - cosine * cosine).max(0.0).sqrt() * across + cosine * axis, cosine, 2.0 * PI * (1.0 - least))
    };
    match *luminaire {
        Luminaire::Side(_) => None,
        Luminaire::Point { position } => {
            let (direction, _, angle) = sphere(DVec3::Z, -1.0);
            Some((position, direction, angle))
        }
        Luminaire::Spot { position, direction, cos_inner, cos_outer } => {
            let (sent, cosine, angle) = sphere(direction, cos_outer);
            let ramp = ((cosine - cos_outer) / (cos_inner - cos_outer).max(1e-9)).clamp(0.0, 1.0);
            Some((position, sent, ramp * ramp * angle))
        }
        Luminaire::Directional { direction } => {
            let (middle, radius) = enclosure.ball();
            let (frame, r) = (Frame::new(direction), radius * a.sqrt());
            let (sin, cos) = (2.0 * PI * b).sin_cos();
            let across = r * (cos * frame.tangent + sin * frame.bitangent);
            Some((middle + across - 2.0 * radius * direction, direction, PI * radius * radius))
        }
    }
}

/// What decides in (0, 1) whether ray `index` of a sequence survives what it meets after `met` others: further
/// dimensions of the sequence while there are any worth having, then numbers hashed from it.
pub fn survival(sequence: &Sequence, index: u32, met: u32) -> f64 {
    const EVEN: u32 = 16;
    if met < EVEN {
        sequence.further_point(index, 1 + met / 4)[(met % 4) as usize]
    } else {
        let bits = mix(sequence.hash() ^ (u64::from(index) << 32 | u64::from(met)));
        ((bits >> 11) as f64 + 0.5) / (1u64 << 53) as f64
    }
}
