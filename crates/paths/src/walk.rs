//! Many paths at once, one step after another, so that their rays are traced together.
//!
//! With emission E and reflectance rho, what arrives at x is the mean of what leaves where cosine-distributed rays land:
//! H(x) = mean of E(y) + rho(y) H(y) (Kajiya 1986, *The rendering equation*, for diffuse surfaces). Every step adds what
//! lamps and lights without area send to where paths are, and what rays find where they land, each weighed so that
//! both together count it once. Rays go on by mirrors and panes until they land. Lamps and lights are looked for through
//! panes, lights also at their images in mirrors; lamps in mirrors are found by rays alone.

use glam::DVec3;
use radiosity_exchange::images::survival;
use radiosity_geometry::bvh::{Hit, Ray};
use radiosity_geometry::sampling::Sequence;

use crate::lights::Seen;
use crate::scatter::{Landed, scatter};
use crate::tracer::{Start, Tracer};

/// Buffers of one thread, used again and again.
#[derive(Default)]
pub struct Walk {
    vertices: Vec<Vertex>,
    next: Vec<Vertex>,
    /// Paths x bands: what of the light found now reaches the start.
    throughput: Vec<f32>,
    numbers: Vec<Numbers>,
    rays: Vec<Ray>,
    shadows: Vec<Shadow>,
    occluded: Vec<bool>,
    /// What arrives of the light of each source that is looked at.
    left: Vec<f32>,
    hits: Vec<Hit>,
    /// Rays traced so far.
    pub rays_traced: u64,
}

/// Where a path is.
#[derive(Clone, Copy)]
struct Vertex {
    point: DVec3,
    normal: DVec3,
    path: u32,
}

/// The random numbers of one step of one path.
#[derive(Clone, Copy)]
struct Numbers {
    direction: [f64; 2],
    lamp: [f64; 3],
    light: f64,
    roulette: f64,
    /// What all lamps together could send to the vertex.
    importance: f64,
}

/// A source of light that is in sight unless its ray is blocked.
struct Shadow {
    from: DVec3,
    path: u32,
    weight: f32,
    source: Source,
}

enum Source {
    Lamp { on: (u32, f64, f64), point: DVec3 },
    Light(usize),
}

/// The first stream of the sequences that feed paths; each step takes two.
const STREAM: u32 = 1 << 8;

/// The first stream of the sequences that decide what mirrors and panes send on; each step takes one.
const SPECULAR: u32 = 1 << 24;

/// Steps before roulette begins: the first bounces carry most of the light.
const SPARED: u32 = 1;

impl Walk {
    /// Estimates the irradiance at each start, `starts x bands`; rounds are independent of one another.
    ///
    /// # Panics
    /// If `irradiance` does not fit.
    pub fn irradiance(&mut self, tracer: &Tracer, starts: &[Start], round: u32, irradiance: &mut [f32]) {
        assert_eq!(irradiance.len(), starts.len() * tracer.bands, "one value per start and band");
        irradiance.fill(0.0);
        self.throughput.clear();
        self.throughput.resize(irradiance.len(), 1.0);
        self.vertices.clear();
        self.vertices.extend(starts.iter().zip(0..).map(|(start, path)| Vertex {
            point: start.point,
            normal: start.normal,
            path,
        }));
        let mut step = 0;
        while !self.vertices.is_empty() {
            self.draw(tracer, starts, round, step);
            self.look_at_lamps(tracer, step, irradiance);
            self.shoot(tracer);
            self.land(tracer, starts, (round, step), irradiance);
            std::mem::swap(&mut self.vertices, &mut self.next);
            step += 1;
        }
    }

    /// Draws the numbers of a step.
    fn draw(&mut self, tracer: &Tracer, starts: &[Start], round: u32, step: u32) {
        self.numbers.clear();
        self.numbers.extend(self.vertices.iter().map(|vertex| {
            let start = &starts[vertex.path as usize];
            let point = |k| Sequence::new(tracer.seed, start.key, round, STREAM + 2 * step + k).point(start.index);
            let ([u, v, s, t], [choice, light, roulette, _]) = (point(0), point(1));
            let importance = tracer.lamps.importance(vertex.point, vertex.normal);
            Numbers { direction: [u, v], lamp: [choice, s, t], light, roulette, importance }
        }));
    }

    /// Adds what a point on a lamp and lights without area send to each vertex.
    fn look_at_lamps(&mut self, tracer: &Tracer, step: u32, irradiance: &mut [f32]) {
        self.rays.clear();
        self.shadows.clear();
        for (vertex, numbers) in self.vertices.iter().zip(&self.numbers) {
            let (point, normal, path) = (vertex.point, vertex.normal, vertex.path);
            let (from, at) = (point, (point, normal));
            if let Some(lamp) = tracer.lamps.sample(tracer.enclosure, at, numbers.importance, numbers.lamp) {
                self.rays.push(tracer.enclosure.segment(point, lamp.point));
                let source = Source::Lamp { on: lamp.on, point: lamp.point };
                self.shadows.push(Shadow { from, path, weight: lamp.weight, source });
            }
            let mut look = |Seen { place, weight, ray }| {
                self.rays.push(ray);
                self.shadows.push(Shadow { from, path, weight, source: Source::Light(place) });
            };
            if step == 0 && tracer.lights.are_few() {
                tracer.lights.all(tracer.enclosure, point, normal).for_each(look);
            } else if let Some(seen) = tracer.lights.choose(tracer.enclosure, point, normal, numbers.light) {
                look(seen);
            }
        }
        self.look(tracer);
        for (Shadow { path, weight, source, .. }, left) in
            self.shadows.iter().zip(&self.left).filter(|(_, l)| **l > 0.0)
        {
            let of_path = *path as usize * tracer.bands..(*path as usize + 1) * tracer.bands;
            let (filter, sum) = (&self.throughput[of_path.clone()], &mut irradiance[of_path]);
            let weight = weight * left;
            match source {
                Source::Lamp { on, .. } => tracer.exitance.add(tracer.enclosure, *on, weight, filter, sum),
                Source::Light(place) => {
                    let strength = tracer.lights.strength(*place);
                    sum.iter_mut().zip(strength).zip(filter).for_each(|((sum, s), f)| *sum += weight * s * f);
                }
            }
        }
    }

    /// Finds what arrives of the light of each source; a way by mirrors and panes counts as one ray.
    fn look(&mut self, tracer: &Tracer) {
        self.left.clear();
        self.rays_traced += self.rays.len() as u64;
        let enclosure = tracer.enclosure;
        let Some(specular) = enclosure.specular() else {
            self.occluded.resize(self.rays.len(), false);
            enclosure.bvh().occlusions(&self.rays, &mut self.occluded);
            self.left.extend(self.occluded.iter().map(|&occluded| if occluded { 0.0 } else { 1.0 }));
            return;
        };
        self.left.extend(self.shadows.iter().map(|Shadow { from, source, .. }| match source {
            Source::Lamp { point, .. } => enclosure.passage(specular, *from, &[*point], &[], false) as f32,
            Source::Light(place) => tracer.lights.passage(enclosure, specular, *from, *place) as f32,
        }));
    }

    /// Shoots a ray from each vertex.
    fn shoot(&mut self, tracer: &Tracer) {
        self.rays.clear();
        self.rays.extend(self.vertices.iter().zip(&self.numbers).map(|(vertex, numbers)| {
            let [u, v] = numbers.direction;
            tracer.enclosure.ray(vertex.point, scatter(vertex.normal, u, v))
        }));
        self.hits.resize(self.rays.len(), Hit::MISS);
        tracer.enclosure.bvh().closest_hits(&self.rays, &mut self.hits);
        self.rays_traced += self.rays.len() as u64;
    }

    /// Adds what rays found, and has paths go on from there.
    fn land(&mut self, tracer: &Tracer, starts: &[Start], (round, step): (u32, u32), irradiance: &mut [f32]) {
        self.next.clear();
        let (enclosure, bands) = (tracer.enclosure, tracer.bands);
        for (((vertex, numbers), ray), hit) in self.vertices.iter().zip(&self.numbers).zip(&self.rays).zip(&self.hits) {
            let landed = match enclosure.specular() {
                None => Landed::of(enclosure, ray, hit),
                Some(specular) => {
                    let start = &starts[vertex.path as usize];
                    let sequence = Sequence::new(tracer.seed, start.key, round, SPECULAR + step);
                    let survival = |met| survival(&sequence, start.index, met);
                    Landed::beyond((enclosure, specular), (*ray, *hit), survival, &mut self.rays_traced)
                }
            };
            let Some(Landed { on, direction, distance, share, by_mirror }) = landed else { continue };
            let (side, s, t) = on;
            let of_path = vertex.path as usize * bands..(vertex.path as usize + 1) * bands;
            let throughput = &mut self.throughput[of_path.clone()];
            if share < 1.0 {
                throughput.iter_mut().for_each(|t| *t /= share);
            }
            let weight = if by_mirror {
                1.0
            } else {
                let found = (side as usize, direction, distance);
                tracer.lamps.weight(enclosure, (vertex.point, vertex.normal), numbers.importance, found)
            };
            tracer.exitance.add(enclosure, on, weight, throughput, &mut irradiance[of_path]);
            let Some(reflectance) = &tracer.reflectance else { continue };
            let point = enclosure.point_off(side as usize, s, t);
            let left = reflectance.filter(side, tracer.texture_at(side as usize, point), throughput);
            if left > 0.0 && (step < SPARED || survives(left, numbers.roulette, throughput)) {
                self.next.push(Vertex { point, normal: enclosure.normal(side as usize), path: vertex.path });
            }
        }
    }
}

/// Russian roulette (Arvo and Kirk 1990, *Particle transport and image synthesis*): a path goes on with the probability
/// of what is left in its best band, and then stands for those that did not.
#[inline]
fn survives(left: f32, roulette: f64, throughput: &mut [f32]) -> bool {
    if left >= 1.0 {
        return true;
    }
    if roulette >= f64::from(left) {
        return false;
    }
    throughput.iter_mut().for_each(|t| *t /= left);
    true
}
