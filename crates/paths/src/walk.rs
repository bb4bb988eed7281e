//! Many paths at once, one step after another, so that their rays are traced together.
//!
//! With emission E and reflectance rho, what arrives at x is the mean of what leaves where cosine-distributed rays land:
//! H(x) = mean of E(y) + rho(y) H(y) (Kajiya 1986, *The rendering equation*, for diffuse surfaces), and of tau(y) H'(y) of
//! the other side where light passes through. Every step adds what lamps and lights without area send to where paths
//! are, and what rays find where they land, each weighed so that both together count it once. Rays go on by mirrors and panes until they land. Lamps and lights are looked for through
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
    /// What all lamps together could send to each vertex.
    importance: Vec<f64>,
    /// Numbers in (0, 1) that decide whether each path goes on, and on which side.
    fate: Vec<[f64; 2]>,
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
        self.begin(tracer, starts, irradiance);
        self.go(tracer, starts, round, true, irradiance);
    }

    /// Estimates what lamps and lights without area send straight to each start, as far as points on them are the better
    /// way to find it; [`Walk::rest`] is all else.
    ///
    /// # Panics
    /// If `irradiance` does not fit.
    pub fn direct(&mut self, tracer: &Tracer, starts: &[Start], round: u32, irradiance: &mut [f32]) {
        self.begin(tracer, starts, irradiance);
        self.weigh(tracer);
        self.look_at_lamps(tracer, starts, (round, 0), irradiance);
    }

    /// Estimates what arrives at each start but for what [`Walk::direct`] counts.
    ///
    /// # Panics
    /// If `irradiance` does not fit.
    pub fn rest(&mut self, tracer: &Tracer, starts: &[Start], round: u32, irradiance: &mut [f32]) {
        self.begin(tracer, starts, irradiance);
        self.go(tracer, starts, round, false, irradiance);
    }

    /// Puts a path at each start.
    fn begin(&mut self, tracer: &Tracer, starts: &[Start], irradiance: &mut [f32]) {
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
    }

    /// Walks on until nothing is left.
    fn go(&mut self, tracer: &Tracer, starts: &[Start], round: u32, looks_at_once: bool, irradiance: &mut [f32]) {
        let mut step = 0;
        while !self.vertices.is_empty() {
            self.weigh(tracer);
            if looks_at_once || step > 0 {
                self.look_at_lamps(tracer, starts, (round, step), irradiance);
            }
            self.shoot(tracer, starts, (round, step));
            self.land(tracer, starts, (round, step), irradiance);
            std::mem::swap(&mut self.vertices, &mut self.next);
            step += 1;
        }
    }

    /// Finds what lamps could send to each vertex.
    fn weigh(&mut self, tracer: &Tracer) {
        let lamps = &tracer.lamps;
        self.importance.clear();
        self.importance.extend(self.vertices.iter().map(|vertex| lamps.importance(vertex.point, vertex.normal)));
    }

    /// Adds what a point on a lamp and lights without area send to each vertex.
    fn look_at_lamps(&mut self, tracer: &Tracer, starts: &[Start], (round, step): (u32, u32), irradiance: &mut [f32]) {
        self.rays.clear();
        self.shadows.clear();
        for (vertex, importance) in self.vertices.iter().zip(&self.importance) {
            let (point, normal, path) = (vertex.point, vertex.normal, vertex.path);
            let (from, at) = (point, (point, normal));
            let start = &starts[path as usize];
            let sequence = Sequence::new(tracer.seed, start.key, round, STREAM + 2 * step + 1);
            let [s, t, lamp, light] = sequence.point(start.index);
            if let Some(lamp) = tracer.lamps.sample(tracer.enclosure, at, *importance, [lamp, s, t]) {
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
            } else if let Some(seen) = tracer.lights.choose(tracer.enclosure, point, normal, light) {
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
    fn shoot(&mut self, tracer: &Tracer, starts: &[Start], (round, step): (u32, u32)) {
        self.rays.clear();
        self.fate.clear();
        for vertex in &self.vertices {
            let start = &starts[vertex.path as usize];
            let sequence = Sequence::new(tracer.seed, start.key, round, STREAM + 2 * step);
            let [u, v, roulette, through] = sequence.point(start.index);
            self.rays.push(tracer.enclosure.ray(vertex.point, scatter(vertex.normal, u, v)));
            self.fate.push([roulette, through]);
        }
        self.hits.resize(self.rays.len(), Hit::MISS);
        tracer.enclosure.bvh().closest_hits(&self.rays, &mut self.hits);
        self.rays_traced += self.rays.len() as u64;
    }

    /// Adds what rays found, and has paths go on from there.
    fn land(&mut self, tracer: &Tracer, starts: &[Start], (round, step): (u32, u32), irradiance: &mut [f32]) {
        self.next.clear();
        let (enclosure, bands) = (tracer.enclosure, tracer.bands);
        let drawn = self.importance.iter().zip(&self.fate);
        let found = self.rays.iter().zip(&self.hits);
        for ((vertex, (importance, [roulette, through])), (ray, hit)) in self.vertices.iter().zip(drawn).zip(found) {
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
                tracer.lamps.weight(enclosure, (vertex.point, vertex.normal), *importance, found)
            };
            tracer.exitance.add(enclosure, on, weight, throughput, &mut irradiance[of_path]);
            let Some(reflectance) = &tracer.reflectance else { continue };
            let point = enclosure.point_off(side as usize, s, t);
            let texture = tracer.texture_at(side as usize, point);
            let (left, passes) = reflectance.filter(side, texture, *through, throughput);
            if left > 0.0 && (step < SPARED || survives(left, *roulette, throughput)) {
                let across = || enclosure.opposite(side as usize).expect("what light passes through has two sides");
                let side = if passes { across() } else { side as usize };
                let point = if passes { enclosure.point_off(side, s, t) } else { point };
                self.next.push(Vertex { point, normal: enclosure.normal(side), path: vertex.path });
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
