//! Columns of the exchange that carry most of the light: small emitters, sampled by area.
//!
//! Rays from a receiver find a small lamp rarely, and each find weighs much. So lamps are sampled the other way: a
//! point on the receiver, a point on the lamp, a test whether one sees the other, weighted with the closed form from
//! the point to the whole lamp where it is near and with the point kernel cos cos / (pi r^2) where it is far. Which
//! lamp a sample goes to is drawn in proportion to what each would contribute unoccluded (Shirley, Wang and
//! Zimmerman 1996, *Monte Carlo techniques for direct lighting calculations*).
//!
//! Where there are mirrors, images of luminaires in them are sampled as luminaires are (`images.rs`). Clear glass on the
//! way leaves its transmittance of a sample.

use crate::enclosure::Enclosure;
use crate::images::{Image, Images};
use crate::kernels::point_to_polygon::point_to_polygon;
use crate::samples::Samples;
use crate::shots::Cell;
use crate::specular::{Mirror, Specular};
use glam::DVec3;
use radiosity_geometry::bvh::Ray;
use radiosity_geometry::sampling::Sequence;
use radiosity_operator::{Cancelled, Control};
use std::f64::consts::FRAC_1_PI;

/// Something small or without area that sends light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Luminaire {
    /// A side that emits; its samples weigh as form factors.
    Side(u32),
    /// A point; its samples weigh in 1/m2, to be multiplied by an intensity in W/sr.
    Point {
        /// Metres.
        position: DVec3,
    },
    /// A cone with a smooth edge; weighs as a point.
    Spot {
        /// Metres.
        position: DVec3,
        /// Unit vector along the axis, away from the light.
        direction: DVec3,
        /// Cosine of the half angle where the falloff starts.
        cos_inner: f64,
        /// Cosine of the half angle where the light ends.
        cos_outer: f64,
    },
    /// Parallel light; weighs as a cosine, to be multiplied by an irradiance in W/m2.
    Directional {
        /// Unit vector the light travels along.
        direction: DVec3,
    },
}

/// One test of a luminaire from a side.
#[derive(Clone, Copy, Debug, Default)]
pub struct LightSample {
    /// Which luminaire.
    pub luminaire: u32,
    /// Its estimate of the transfer from the luminaire, over the probability of having chosen it; zero if occluded.
    pub weight: f32,
    /// The cell of the side's chart it was taken from.
    pub origin_cell: Cell,
}

/// Luminaires with the strength by which samples are shared among them.
#[derive(Clone, Debug, Default)]
pub struct Luminaires {
    /// What they are.
    pub list: Vec<Luminaire>,
    /// Exitance, intensity or irradiance averaged over bands. Steers samples; does not enter their weights.
    pub strength: Vec<f64>,
}

/// The stream of the sequence that feeds light samples.
const STREAM: u32 = 2;

/// Beyond this many times the sum of the two radii the point kernel varies little over the pair.
const FAR: f64 = 4.0;

/// Share of its mean unoccluded importance that a luminaire keeps wherever any part of it may see any part of a
/// side, so that an unlucky set of probe points never hides it.
const DEFENSIVE: f64 = 0.05;

impl Luminaires {
    /// Takes samples until side `i` has `wanted[i]` per replicate.
    pub fn sample(
        &self,
        enclosure: &Enclosure,
        samples: &mut Samples<LightSample>,
        wanted: &[u32],
        seed: u64,
        control: &Control,
    ) -> Result<(), Cancelled> {
        let probe = Probe::new(enclosure, self, seed);
        let replicates = samples.replicates();
        samples.draw(wanted, control, Scratch::default, |scratch, side, first, items| {
            probe.draw(scratch, side, first, replicates, items);
        })
    }
}

/// What samples luminaires from one side after another.
pub struct Probe<'a> {
    enclosure: &'a Enclosure,
    /// Luminaires and their images.
    sources: Vec<Source>,
    seed: u64,
}

impl<'a> Probe<'a> {
    /// Looks at luminaires once for all sides.
    pub fn new(enclosure: &'a Enclosure, luminaires: &'a Luminaires, seed: u64) -> Self {
        let itself = |(k, l): (usize, &Luminaire)| Source::itself(enclosure, k, l, luminaires.strength[k]);
        let mut sources: Vec<Source> = luminaires.list.iter().enumerate().map(itself).collect();
        if let Some(specular) = enclosure.specular() {
            let images = Images::new(enclosure, luminaires).list;
            sources.extend(images.into_iter().map(|image| Source::mirrored(enclosure, specular, luminaires, image)));
        }
        Self { enclosure, sources, seed }
    }

    /// Fills `items` with samples `first..` of a side, replicate after replicate; leaves them if no luminaire can
    /// reach it.
    pub fn draw(&self, scratch: &mut Scratch, side: usize, first: u32, replicates: usize, items: &mut [LightSample]) {
        let (enclosure, sources) = (self.enclosure, &self.sources[..]);
        if enclosure.area(side) == 0.0 || !scratch.weigh(enclosure, sources, side) {
            return;
        }
        let each = items.len() / replicates;
        for (replicate, items) in items.chunks_mut(each.max(1)).enumerate() {
            let sequence = Sequence::new(self.seed, side as u32, replicate as u32, STREAM);
            scratch.propose(enclosure, sources, side, &sequence, first, items);
            scratch.test(enclosure, sources, items);
        }
    }
}

/// A luminaire or an image of one.
struct Source {
    /// Number of the luminaire.
    index: u32,
    /// It, where it seems to be.
    luminaire: Luminaire,
    shape: Shape,
    /// What samples are shared by.
    strength: f64,
    /// What of the area of a side that emits does so.
    share: f64,
    /// What it is seen in, in the order that light meets it; nothing of a luminaire itself.
    mirrors: Vec<(u32, Mirror)>,
    /// Where a light without area is, and not its image; of parallel light the direction towards it.
    place: DVec3,
}

impl Source {
    fn itself(enclosure: &Enclosure, index: usize, luminaire: &Luminaire, strength: f64) -> Self {
        let share = match *luminaire {
            Luminaire::Side(side) => enclosure.diffuse_share(side as usize),
            _ => 1.0,
        };
        let shape = Shape::new(enclosure, luminaire);
        let place = match *luminaire {
            Luminaire::Directional { direction } => -direction,
            _ => shape.centre,
        };
        Self { index: index as u32, luminaire: *luminaire, shape, strength, share, mirrors: Vec::new(), place }
    }

    fn mirrored(enclosure: &Enclosure, specular: &Specular, luminaires: &Luminaires, image: Image) -> Self {
        let index = image.luminaire as usize;
        let strength = luminaires.strength[index] * image.reflectance;
        let itself = Self::itself(enclosure, index, &luminaires.list[index], strength);
        let luminaire = image.seeming(specular, &itself.luminaire);
        let shape = match luminaire {
            Luminaire::Side(_) => Shape::of_image(image.corners(), itself.shape.area),
            _ => Shape::new(enclosure, &luminaire),
        };
        let mirrors = image.mirrors.iter().map(|&m| (m, specular.mirrors()[m as usize])).collect();
        Self { luminaire, shape, mirrors, ..itself }
    }

    /// Whether a part of a polygon is on the side of the last mirror that reflects.
    fn is_seen_before(&self, corners: &[DVec3]) -> bool {
        self.mirrors.last().is_none_or(|(_, last)| corners.iter().any(|&c| last.height(c) > 0.0))
    }

    /// Where a point of the luminaire seems to be.
    fn seeming(&self, point: DVec3) -> DVec3 {
        self.mirrors.iter().fold(point, |p, (_, mirror)| mirror.image(p))
    }

    /// Fills in where a point of the luminaire, or the direction towards parallel light, seems to be: from the image in
    /// all mirrors to the point itself.
    fn aims(&self, point: DVec3, aims: &mut Vec<DVec3>) {
        aims.clear();
        aims.push(point);
        for (_, mirror) in &self.mirrors {
            let last = aims[aims.len() - 1];
            aims.push(if self.is_parallel() { mirror.turned(last) } else { mirror.image(last) });
        }
        aims.reverse();
    }

    fn is_parallel(&self) -> bool {
        matches!(self.luminaire, Luminaire::Directional { .. })
    }
}

/// What is asked of a luminaire over and over.
struct Shape {
    centre: DVec3,
    radius: f64,
    area: f64,
    normal: DVec3,
    corners: [DVec3; 4],
    count: usize,
    side: Option<usize>,
}

impl Shape {
    fn new(enclosure: &Enclosure, luminaire: &Luminaire) -> Self {
        let at = |centre| Shape {
            centre,
            radius: 0.0,
            area: 0.0,
            normal: DVec3::ZERO,
            corners: [centre; 4],
            count: 0,
            side: None,
        };
        match *luminaire {
            Luminaire::Side(side) => {
                let patch = enclosure.patch_of(side as usize);
                let patches = enclosure.patches();
                let centre = patches.centre[patch];
                Shape {
                    centre,
                    radius: radius(patches.corners(patch), centre),
                    area: patches.area[patch],
                    normal: enclosure.normal(side as usize),
                    corners: patches.polygons[patch],
                    count: patches.corners(patch).len(),
                    side: Some(side as usize),
                }
            }
            Luminaire::Point { position } | Luminaire::Spot { position, .. } => at(position),
            Luminaire::Directional { .. } => at(DVec3::ZERO),
        }
    }

    /// The image of an emitting side.
    fn of_image(polygon: &[DVec3], area: f64) -> Self {
        let mut corners = [polygon[polygon.len() - 1]; 4];
        corners[..polygon.len()].copy_from_slice(polygon);
        let [a, b, c, d] = corners;
        let normal = (c - a).cross(d - b).normalize_or_zero();
        let (first, second) = ((b - a).cross(c - a).dot(normal), (c - a).cross(d - a).dot(normal));
        let whole = first + second;
        let centre = if whole > 0.0 { (first * (a + b + c) + second * (a + c + d)) / (3.0 * whole) } else { a };
        Self { centre, radius: radius(polygon, centre), area, normal, corners, count: polygon.len(), side: None }
    }

    fn polygon(&self) -> &[DVec3] {
        &self.corners[..self.count]
    }
}

fn radius(corners: &[DVec3], centre: DVec3) -> f64 {
    corners.iter().map(|c| c.distance(centre)).fold(0.0, f64::max)
}

/// The transfer from a light without area to a differential area at `x`, unoccluded; zero from sides.
pub fn pointlike(luminaire: &Luminaire, x: DVec3, normal: DVec3) -> f64 {
    match *luminaire {
        Luminaire::Side(_) => 0.0,
        Luminaire::Directional { direction } => (-direction.dot(normal)).max(0.0),
        Luminaire::Point { position } => inverse_square(position - x, normal),
        Luminaire::Spot { position, direction, cos_inner, cos_outer } => {
            // KHR_lights_punctual: the square of a linear ramp in the cosine.
            let cosine = (x - position).normalize_or_zero().dot(direction);
            let ramp = ((cosine - cos_outer) / (cos_inner - cos_outer).max(1e-9)).clamp(0.0, 1.0);
            ramp * ramp * inverse_square(position - x, normal)
        }
    }
}

fn inverse_square(to_light: DVec3, normal: DVec3) -> f64 {
    let r2 = to_light.length_squared();
    if r2 > 0.0 { normal.dot(to_light).max(0.0) / (r2 * r2.sqrt()) } else { 0.0 }
}

/// The form factor density from a differential area at `x` to one at `y`, times the area around `y`.
fn point_kernel(x: DVec3, normal: DVec3, y: DVec3, lamp: &Shape) -> f64 {
    let r = y - x;
    let r2 = r.length_squared();
    let cosines = normal.dot(r).max(0.0) * (-lamp.normal.dot(r)).max(0.0);
    if r2 > 0.0 { cosines / (r2 * r2) * lamp.area * FRAC_1_PI } else { 0.0 }
}

/// Buffers for the samples of one side, made once per worker.
#[derive(Default)]
pub struct Scratch {
    /// Cumulative share of the samples of one side, per luminaire.
    cumulative: Vec<f64>,
    near: Vec<bool>,
    rays: Vec<Ray>,
    proposals: Vec<Proposal>,
    occluded: Vec<bool>,
    /// What is left of the light of each proposal.
    left: Vec<f64>,
    groups: Vec<Group>,
    aims: Vec<DVec3>,
    mirrors: Vec<u32>,
}

/// A sample that awaits its visibility test.
struct Proposal {
    slot: usize,
    /// Which source.
    source: usize,
    /// How much more than average the tested point of a near lamp contributes.
    relative: f64,
    /// The point that is lit, and the point of the luminaire, where it is and not where it seems to be; of parallel
    /// light the direction towards it.
    ends: [DVec3; 2],
}

/// The proposals toward one near lamp.
#[derive(Clone, Copy, Default)]
struct Group {
    count: f64,
    /// The least and the most that is left of any.
    left: Option<[f64; 2]>,
    relative: f64,
}

impl Group {
    /// Whether what is on the way differs from point to point.
    fn varies(&self) -> bool {
        self.left.is_some_and(|[least, most]| least < most)
    }
}

impl Scratch {
    /// Shares the samples of a side among luminaires; false if none can reach it.
    fn weigh(&mut self, enclosure: &Enclosure, sources: &[Source], side: usize) -> bool {
        let patch = enclosure.patch_of(side);
        let normal = enclosure.normal(side);
        let corners = enclosure.patches().corners(patch);
        let centre = enclosure.patches().centre[patch];
        let reach = radius(corners, centre);
        let probes =
            [(0.25, 0.25), (0.75, 0.25), (0.25, 0.75), (0.75, 0.75)].map(|(s, t)| enclosure.point_off(side, s, t));
        self.cumulative.clear();
        self.near.clear();
        let mut total = 0.0;
        for source in sources {
            let shape = &source.shape;
            let far = shape.centre.distance(centre) > FAR * (reach + shape.radius);
            let transfer = match source.luminaire {
                _ if !source.is_seen_before(corners) => 0.0,
                Luminaire::Side(_) => {
                    lamp_importance(shape, side, patch, enclosure, normal, corners, centre, &probes, far)
                }
                _ => pointlike_importance(&source.luminaire, shape, normal, &probes, reach),
            };
            total += source.strength * transfer;
            self.cumulative.push(total);
            self.near.push(!far);
        }
        self.cumulative.iter_mut().for_each(|c| *c /= total);
        total > 0.0
    }

    /// Draws points on both ends and records the unoccluded transfer.
    fn propose(
        &mut self,
        enclosure: &Enclosure,
        sources: &[Source],
        side: usize,
        sequence: &Sequence,
        first: u32,
        items: &mut [LightSample],
    ) {
        self.rays.clear();
        self.proposals.clear();
        self.groups.clear();
        self.groups.resize(sources.len(), Group::default());
        let normal = enclosure.normal(side);
        for (slot, item) in items.iter_mut().enumerate() {
            let [s, t, choice, v] = sequence.point(first + slot as u32);
            let number = self.cumulative.partition_point(|&c| c < choice).min(sources.len() - 1);
            let below = if number == 0 { 0.0 } else { self.cumulative[number - 1] };
            let share = self.cumulative[number] - below;
            let u = ((choice - below) / share).clamp(1e-9, 1.0 - 1e-9);
            let (source, x) = (&sources[number], enclosure.point_off(side, s, t));
            let (shape, luminaire) = (&source.shape, &source.luminaire);
            let (transfer, relative, ray, end) = match *luminaire {
                Luminaire::Side(lamp) => {
                    let end = enclosure.point_off(lamp as usize, u, v);
                    let y = source.seeming(end);
                    let kernel = point_kernel(x, normal, y, shape);
                    let in_front = (x - shape.centre).dot(shape.normal) > 0.0;
                    let whole = if !self.near[number] {
                        kernel
                    } else if in_front {
                        point_to_polygon(x, normal, shape.polygon())
                    } else {
                        0.0
                    };
                    (whole, if whole > 0.0 { kernel / whole } else { 0.0 }, enclosure.segment(x, y), end)
                }
                Luminaire::Directional { direction } => {
                    let ray = enclosure.ray(x, -direction.as_vec3());
                    (pointlike(luminaire, x, normal), 1.0, ray, source.place)
                }
                _ => (pointlike(luminaire, x, normal), 1.0, enclosure.segment(x, shape.centre), source.place),
            };
            let transfer = transfer * source.share;
            let weight = if transfer > 0.0 { transfer / share } else { 0.0 };
            *item = LightSample { luminaire: source.index, weight: weight as f32, origin_cell: Cell::new(s, t) };
            if weight > 0.0 {
                self.rays.push(ray);
                self.proposals.push(Proposal { slot, source: number, relative, ends: [x, end] });
            }
        }
    }

    /// Tests visibility. What an occluder hides of a near lamp is weighed by what the hidden points contribute.
    fn test(&mut self, enclosure: &Enclosure, sources: &[Source], items: &mut [LightSample]) {
        self.look(enclosure, sources);
        for (proposal, &left) in self.proposals.iter().zip(&self.left) {
            let group = &mut self.groups[proposal.source];
            group.count += 1.0;
            group.relative += proposal.relative;
            let [least, most] = group.left.unwrap_or([left; 2]);
            group.left = Some([least.min(left), most.max(left)]);
        }
        for (proposal, &left) in self.proposals.iter().zip(&self.left) {
            let group = &self.groups[proposal.source];
            let item = &mut items[proposal.slot];
            if left == 0.0 {
                item.weight = 0.0;
            } else if group.varies() && self.near[proposal.source] && group.relative > 0.0 {
                item.weight *= (left * proposal.relative * group.count / group.relative) as f32;
            } else {
                item.weight *= left as f32;
            }
        }
    }

    /// Finds what is left of the light of each proposal on its way.
    fn look(&mut self, enclosure: &Enclosure, sources: &[Source]) {
        self.left.clear();
        let Some(specular) = enclosure.specular() else {
            self.occluded.resize(self.rays.len(), false);
            enclosure.bvh().occlusions(&self.rays, &mut self.occluded);
            self.left.extend(self.occluded.iter().map(|&occluded| if occluded { 0.0 } else { 1.0 }));
            return;
        };
        for proposal in &self.proposals {
            let source = &sources[proposal.source];
            let [from, end] = proposal.ends;
            source.aims(end, &mut self.aims);
            self.mirrors.clear();
            self.mirrors.extend(source.mirrors.iter().rev().map(|(index, _)| index));
            self.left.push(enclosure.passage(specular, from, &self.aims, &self.mirrors, source.is_parallel()));
        }
    }
}

/// The mean unoccluded form factor from a side to a lamp, roughly, and never zero where any part sees any part.
fn lamp_importance(
    lamp: &Shape,
    side: usize,
    patch: usize,
    enclosure: &Enclosure,
    normal: DVec3,
    corners: &[DVec3],
    centre: DVec3,
    probes: &[DVec3; 4],
    far: bool,
) -> f64 {
    if lamp.side.is_some_and(|s| s == side || enclosure.patch_of(s) == patch) {
        return 0.0;
    }
    let faces_lamp = lamp.polygon().iter().any(|&y| (y - centre).dot(normal) > 0.0);
    let before_lamp = corners.iter().any(|&x| (x - lamp.centre).dot(lamp.normal) > 0.0);
    if !(faces_lamp && before_lamp) {
        return 0.0;
    }
    let d2 = centre.distance_squared(lamp.centre);
    let floor = DEFENSIVE * lamp.area * FRAC_1_PI / (d2 + lamp.area);
    let mean = if far {
        point_kernel(centre, normal, lamp.centre, lamp)
    } else {
        let visible = |x: &&DVec3| (**x - lamp.centre).dot(lamp.normal) > 0.0;
        0.25 * probes.iter().filter(visible).map(|&x| point_to_polygon(x, normal, lamp.polygon())).sum::<f64>()
    };
    mean.max(floor)
}

/// The mean unoccluded transfer from a light without area, roughly.
fn pointlike_importance(luminaire: &Luminaire, shape: &Shape, normal: DVec3, probes: &[DVec3; 4], reach: f64) -> f64 {
    let mean = 0.25 * probes.iter().map(|&x| pointlike(luminaire, x, normal)).sum::<f64>();
    let middle = 0.25 * probes.iter().sum::<DVec3>();
    let to_light = shape.centre - middle;
    let floor = match *luminaire {
        Luminaire::Directional { .. } => 0.0,
        // The light shines on the patch's bounding sphere only if the cone, widened by the sphere, holds its centre.
        Luminaire::Spot { direction, cos_outer, .. } if !cone_meets_sphere(-to_light, direction, cos_outer, reach) => {
            0.0
        }
        _ if to_light.dot(normal) <= 0.0 && mean == 0.0 => 0.0,
        _ => DEFENSIVE / (to_light.length_squared() + reach * reach).max(f64::MIN_POSITIVE),
    };
    mean.max(floor)
}

fn cone_meets_sphere(to_centre: DVec3, axis: DVec3, cos_half_angle: f64, radius: f64) -> bool {
    let distance = to_centre.length();
    distance <= radius
        || to_centre.angle_between(axis) <= cos_half_angle.clamp(-1.0, 1.0).acos() + (radius / distance).min(1.0).asin()
}
