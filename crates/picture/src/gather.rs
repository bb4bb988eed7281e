//! The final gather: from every point that is seen one more look at the lamps and into the solution.
//!
//! Light of lamps has sharp shadows, and points on lamps find it with little noise. All else that arrives is even, and
//! rays find it with much. So each has its own way:
//!
//! 1. Points of a pixel are seen, and from each a point of a lamp is looked for. Pixels that show an edge, of surfaces
//!    or of shadows, are done again with eight times as many.
//! 2. Rays into the solution find what else arrives, and of either part only what it is more than the solution's
//!    interpolated field has: a control variate (Lafortune and Willems 1994, *The ambient term as a variance reducing
//!    technique*).
//! 3. What the field is off by is small, and smooth but at edges of shadows: so it is fitted over the pixels around that
//!    show the same surface (Kontkanen, Rasanen and Keller 2006, *Irradiance filtering for Monte Carlo ray tracing*),
//!    direct light over the nearest only, unless they or the pixel itself differ by more than their noise. Rays of pixels next to one another are parts of one sequence (Keller and
//!    Heidrich 2001, *Interleaved sampling*), so that together they fill the hemisphere evenly.

use std::collections::VecDeque;
use std::ops::Range;

use glam::{DVec3, Vec3};
use radiosity_exchange::images::survival;
use radiosity_geometry::bvh::{Hit, Ray};
use radiosity_geometry::sampling::Sequence;
use radiosity_operator::{Cancelled, Control};
use radiosity_paths::{Effort, Start, Tracer, Walk};
use radiosity_scene::Camera;
use rayon::prelude::*;

use crate::Image;
use crate::eye::{Eye, Point, Surfaces};
use crate::render::offsets;

/// How a gathered picture is made.
#[derive(Clone, Debug, PartialEq)]
pub struct GatherSettings {
    /// Pixels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Rays into the solution from each pixel.
    pub samples: u32,
    /// Whether the backs of one-sided patches let the view through; else they are black.
    pub culls_backs: bool,
}

/// The solution's irradiance in two parts, sides x 4 x bands at corners each, and best as good as it is: what they are
/// off by adds noise, and no bias but of what is sharper than some pixels.
#[derive(Clone, Copy, Debug)]
pub struct Fields<'a> {
    /// What [`Walk::direct`] counts.
    pub direct: &'a [f32],
    /// All else.
    pub rest: &'a [f32],
}

/// A gathered picture.
#[derive(Clone, Debug)]
pub struct Gathered {
    /// What is seen.
    pub image: Image,
    /// Its noise, root mean square over pixels, over its mean; what the solution is off by comes on top, and what edges are
    /// that few points draw.
    pub noise: f64,
    /// Rays traced.
    pub rays: u64,
}

/// Points that are seen in a pixel: as many as rays up to so many, then a quarter of them.
const POINTS: u32 = 16;

/// Pixels that show an edge have so many times more.
const FINER: u32 = 8;

/// A pixel shows the edge of a shadow if lamps that are seen in part make more noise than this in it.
const PARTLY: f64 = 0.005;

/// Or if its halves differ by more than this.
const UNEVEN: f64 = 0.02;

/// The standard deviation of the weights of pixels in a fit: of a large picture so many pixels, else such a part of it.
const SPREAD: f64 = 4.0;
const SPREAD_PART: f64 = 1.0 / 64.0;

/// The square of how many standard deviations are more than noise.
const SURE: f64 = 4.0;

/// What is added to the mean square of distances in a fit, pixels squared, so that few places in a row do not make up a
/// slope.
const RIDGE: f64 = 0.1;

/// Rows that are held at once, three times; not less than a fit reaches.
const ROWS: usize = 32;

/// Pixels that a thread does at once.
const AT_ONCE: usize = 128;

/// Edge of the squares of pixels whose rays are parts of one sequence.
const BLOCK: usize = 8;

/// The stream of the sequence that chooses what is seen in mirrors and through panes.
const SPECULAR: u32 = 10;

/// The round of numbers that rays into the solution have; points have those before.
const REST: u32 = 2;

/// Gathers what arrives where a camera looks; every row is a step of `control`.
///
/// The tracer is one of [`Tracer::gather`]. The same input gives the same bytes on any number of threads.
///
/// # Errors
/// If `control` is cancelled.
///
/// # Panics
/// If `surfaces` or `fields` do not fit the sides and bands of the tracer.
pub fn gather(
    tracer: &Tracer,
    surfaces: Surfaces,
    fields: Fields,
    camera: &Camera,
    settings: &GatherSettings,
    control: &Control,
) -> Result<Gathered, Cancelled> {
    let (width, height, bands) = (settings.width, settings.height, tracer.bands());
    let count = 4 * tracer.enclosure().sides() * bands;
    assert_eq!((fields.direct.len(), fields.rest.len()), (count, count), "values fit the sides and bands");
    let mut image = Image { width, height, bands, pixels: vec![0.0; width * height * bands] };
    if image.pixels.is_empty() {
        return Ok(Gathered { image, noise: 0.0, rays: 0 });
    }
    let eye = Eye::new(tracer, surfaces, camera, (width, height), settings.culls_backs);
    let spread = (SPREAD_PART * width.max(height) as f64).clamp(1.0, SPREAD);
    let gather = Gather { tracer, eye, fields, width, height, samples: settings.samples.max(2), spread };
    control.expect(height as u64);
    let (mut strips, mut noise, mut rays) = (VecDeque::new(), Noise::default(), 0);
    for (k, pixels) in image.pixels.chunks_mut(ROWS * width * bands).enumerate() {
        if k == 0 {
            strips.push_back(gather.strip(0, control)?);
        }
        if (k + 1) * ROWS < height {
            strips.push_back(gather.strip((k + 1) * ROWS, control)?);
        }
        noise = noise.plus(gather.develop(&strips, k * ROWS, pixels));
        if strips.len() == 3 || k > 0 {
            rays += strips.pop_front().map_or(0, |strip| strip.rays);
        }
    }
    rays += strips.iter().map(|strip| strip.rays).sum::<u64>();
    Ok(Gathered { image, noise: noise.relative(), rays })
}

/// Irradiance of given patches in two parts, patches x bands each: what [`Walk::direct`] counts, and the rest; that of
/// the patch that each side is (see [`crate::Sheets`]).
///
/// Both are measured with about as many `rays`, where there are enough for every side: so what is gathered at points
/// differs little from them. Else the rest is what the solution has more than the direct part.
///
/// # Errors
/// If `control` is cancelled.
///
/// # Panics
/// If the patches do not fit the sides.
pub fn direct_and_rest(
    tracer: &Tracer,
    patch_of_side: &[u32],
    irradiance: &[f64],
    rays: usize,
    control: &Control,
) -> Result<[Vec<f64>; 2], Cancelled> {
    let bands = tracer.bands();
    let each = (rays / patch_of_side.len().max(1)).clamp(FEWEST, MOST).ilog2();
    let effort = Effort::at_once(1 << each);
    let of_patches = |of_sides: Vec<f64>| {
        let mut values = vec![0.0; irradiance.len()];
        for (&patch, found) in patch_of_side.iter().zip(of_sides.chunks_exact(bands.max(1))) {
            values[patch as usize * bands..][..bands].copy_from_slice(found);
        }
        values
    };
    let direct = of_patches(radiosity_paths::direct_of_sides(tracer, &effort, control)?.irradiance);
    let rest = if effort.per_round >= ENOUGH {
        of_patches(radiosity_paths::rest_of_sides(tracer, &effort, control)?.irradiance)
    } else {
        irradiance.iter().zip(&direct).map(|(all, direct)| all - direct).collect()
    };
    Ok([direct, rest])
}

/// Samples of a side's direct light, at least and at most.
const FEWEST: usize = 16;
const MOST: usize = 1024;

/// So many rays tell the rest better than the solution.
const ENOUGH: u32 = 128;

/// Everything that one picture needs.
struct Gather<'a> {
    tracer: &'a Tracer<'a>,
    eye: Eye<'a>,
    fields: Fields<'a>,
    width: usize,
    height: usize,
    samples: u32,
    /// Of the weights of pixels in a fit.
    spread: f64,
}

/// A smooth surface as one pixel shows it.
#[derive(Clone, Copy)]
struct Part {
    point: DVec3,
    normal: Vec3,
    /// Whether all of its points see some lamp.
    is_lit: bool,
    /// Points that show it.
    points: u32,
    /// Pairs of rays that leave it.
    pairs: u32,
}

/// What some pixels in a row, or some rows, show.
#[derive(Default)]
struct Strip {
    /// Its first row.
    row: usize,
    /// Where the parts of each pixel begin, and where the last end.
    offsets: Vec<u32>,
    parts: Vec<Part>,
    /// Parts x bands: what of the irradiance of each is seen.
    share: Vec<f32>,
    /// Parts x bands, of the rays of either half: the sum of what they find more than `rest` says.
    excess: [Vec<f32>; 2],
    /// Parts x bands, of the points of either half: what lamps send more than `direct` says, on average.
    direct: [Vec<f32>; 2],
    /// Pixels x bands: what is seen but for both.
    seen: Vec<f32>,
    rays: u64,
}

/// What is seen in some pixels.
#[derive(Default)]
struct Points {
    /// So many looks a pixel.
    each: usize,
    /// What each look shows, and what is on the other side of that; none where nothing is.
    list: Vec<Option<Point>>,
    /// Looks x bands: radiance of lamps in metals.
    glow: Vec<f32>,
    /// Values x bands: irradiance from lamps.
    direct: Vec<f32>,
    /// Values x bands: the same, and all other, as the solution has them.
    fields: [Vec<f32>; 2],
}

/// A point that is seen and the irradiance there.
#[derive(Clone, Copy)]
struct Lit<'a> {
    point: &'a Point,
    direct: &'a [f32],
    /// Direct and rest.
    fields: [&'a [f32]; 2],
}

/// Buffers of one thread.
#[derive(Default)]
struct Buffers {
    rays: Vec<Ray>,
    hits: Vec<Hit>,
    starts: Vec<Start>,
    found: Vec<f32>,
    /// The part that each ray into the solution leaves.
    owners: Vec<u32>,
    /// Rays x bands: what the solution says that they find on average.
    expected: Vec<f32>,
    walk: Walk,
}

impl Gather<'_> {
    fn bands(&self) -> usize {
        self.tracer.bands()
    }

    /// Looks at some rows.
    fn strip(&self, row: usize, control: &Control) -> Result<Strip, Cancelled> {
        let pixels = row * self.width..(row + ROWS).min(self.height) * self.width;
        let firsts: Vec<usize> = pixels.clone().step_by(AT_ONCE).collect();
        let of_pixels = |buffers: &mut Buffers, first: &usize| {
            control.check()?;
            let pixels: Vec<usize> = (*first..(first + AT_ONCE).min(pixels.end)).collect();
            Ok(self.piece(buffers, &pixels))
        };
        let pieces: Vec<Strip> =
            firsts.par_iter().map_init(Buffers::default, of_pixels).collect::<Result<_, Cancelled>>()?;
        control.advance((pixels.len() / self.width) as u64);
        Ok(Strip::joined(row, pieces))
    }

    /// Looks at some pixels.
    fn piece(&self, buffers: &mut Buffers, pixels: &[usize]) -> Strip {
        let bands = self.bands();
        let before = buffers.walk.rays_traced;
        let points = self.samples.min(POINTS.max(self.samples / 4));
        let coarse = self.look(buffers, pixels, points, 0);
        let edges: Vec<usize> =
            (0..pixels.len()).filter(|&k| self.shows_an_edge(&coarse.of(k, pixels.len(), bands))).collect();
        let at_edges: Vec<usize> = edges.iter().map(|&k| pixels[k]).collect();
        let fine = self.look(buffers, &at_edges, FINER * points, 1);
        let mut strip = Strip { rays: (coarse.list.len() + fine.list.len()) as u64, ..Strip::default() };
        buffers.starts.clear();
        buffers.owners.clear();
        buffers.expected.clear();
        let mut edge = edges.iter().enumerate().peekable();
        for (k, &pixel) in pixels.iter().enumerate() {
            let points = match edge.next_if(|(_, edge)| **edge == k) {
                Some((place, _)) => fine.of(place, edges.len(), bands),
                None => coarse.of(k, pixels.len(), bands),
            };
            self.add_pixel(buffers, &mut strip, pixel, &points);
        }
        strip.offsets.push(strip.parts.len() as u32);
        self.shoot(buffers, &mut strip);
        strip.rays += buffers.walk.rays_traced - before;
        strip
    }

    /// Finds the points that are seen in some pixels, and the light there.
    fn look(&self, buffers: &mut Buffers, pixels: &[usize], each: u32, round: u32) -> Points {
        let offsets = offsets(each as usize);
        buffers.rays.clear();
        for &pixel in pixels {
            let (x, y) = ((pixel % self.width) as f64, (pixel / self.width) as f64);
            buffers.rays.extend(offsets.iter().map(|[u, v]| self.eye.ray(x + u, y + v)));
        }
        buffers.hits.resize(buffers.rays.len(), Hit::MISS);
        self.eye.closest_hits(&buffers.rays, &mut buffers.hits);
        let looks = buffers.rays.iter().zip(&buffers.hits).enumerate();
        let bands = self.bands();
        let mut glow = vec![0.0; buffers.rays.len() * bands];
        let seen = looks.zip(glow.chunks_exact_mut(bands)).map(|((i, (ray, hit)), glow)| {
            let (pixel, index) = (pixels[i / offsets.len()] as u32, (i % offsets.len()) as u32);
            let sequence = || Sequence::new(self.tracer.seed(), pixel, round, SPECULAR);
            let point = self.eye.seen(ray, hit, |met| survival(&sequence(), index, met))?;
            self.eye.by_metal(point, ((pixel, index), round), glow)
        });
        let mut list: Vec<Option<Point>> = seen.collect();
        if self.eye.is_translucent() {
            let across = |point: &Option<Point>| point.as_ref().and_then(|point| self.eye.across(point));
            let of_pixel = |points: &[Option<Point>]| points.iter().copied().chain(points.iter().map(across)).collect();
            list = list.chunks_exact(offsets.len()).flat_map(|points| -> Vec<_> { of_pixel(points) }).collect();
        }
        let direct = self.direct(buffers, pixels, &list, round);
        let of_points = |field| list.iter().flat_map(|point| self.at_corners(field, point.as_ref())).collect();
        let fields = [of_points(self.fields.direct), of_points(self.fields.rest)];
        Points { each: offsets.len(), list, glow, direct, fields }
    }

    /// What lamps send to points, of which each looks at them once.
    fn direct(&self, buffers: &mut Buffers, pixels: &[usize], points: &[Option<Point>], round: u32) -> Vec<f32> {
        let (bands, each) = (self.bands(), points.len() / pixels.len().max(1));
        buffers.starts.clear();
        buffers.owners.clear();
        for (i, point) in points.iter().enumerate() {
            if let Some(point) = point.as_ref().filter(|point| self.eye.reflects(point)) {
                let (key, index) = (pixels[i / each] as u32, (i % each) as u32);
                buffers.starts.push(Start { point: point.at, normal: self.eye.normal(point), key, index });
                buffers.owners.push(i as u32);
            }
        }
        buffers.found.resize(buffers.starts.len() * bands, 0.0);
        buffers.walk.direct(self.tracer, &buffers.starts, round, &mut buffers.found);
        let mut direct = vec![0.0; points.len() * bands];
        for (&owner, found) in buffers.owners.iter().zip(buffers.found.chunks_exact(bands)) {
            direct[owner as usize * bands..][..bands].copy_from_slice(found);
        }
        direct
    }

    /// A field at a point; zero where nothing is seen.
    fn at_corners(&self, field: &[f32], point: Option<&Point>) -> impl Iterator<Item = f32> {
        let bands = self.bands();
        let (first, weights) = point.map_or((0, [0.0; 4]), |point| (4 * bands * point.side as usize, point.corners));
        (0..bands).map(move |band| {
            let corner = |k: usize| weights[k] * field[first + k * bands + band];
            corner(0) + corner(1) + corner(2) + corner(3)
        })
    }

    /// Whether the points of a pixel are of several surfaces, or some of them in a shadow.
    fn shows_an_edge(&self, points: &PixelPoints) -> bool {
        let seen = &points.list[..points.looks];
        let Some(first) = seen[0].as_ref() else { return seen.iter().any(Option::is_some) };
        let enclosure = self.tracer.enclosure();
        let surface = |point: &Point| enclosure.patches().surface[enclosure.patch_of(point.side as usize)];
        let is_same = |point: &Point| surface(point) == surface(first) && self.part(point).is_like(&self.part(first));
        if !seen.iter().all(|point| point.as_ref().is_some_and(is_same)) {
            return true;
        }
        let (mut halves, mut squares, mut whole, mut dark) = ([0.0; 2], 0.0, 0.0, 0);
        for (k, Lit { point, direct, fields: [_, rest] }) in points.lit() {
            let shown = |irradiance: &[f32]| -> f64 {
                self.eye.shares(point).zip(irradiance).map(|(share, h)| f64::from(share * h)).sum()
            };
            let lit = shown(direct);
            halves[k % 2] += lit;
            squares += lit * lit;
            whole += lit + shown(rest) + self.eye.emitted(point).map(f64::from).sum::<f64>();
            dark += usize::from(lit == 0.0);
        }
        let (n, sum) = (points.lit().count(), halves[0] + halves[1]);
        let noise = (squares - sum * sum / n as f64).max(0.0).sqrt();
        (dark > 0 && dark < n && noise > PARTLY * whole) || (halves[0] - halves[1]).abs() > UNEVEN * whole
    }

    fn part(&self, point: &Point) -> Part {
        Part { point: point.at, normal: self.eye.normal(point).as_vec3(), is_lit: true, points: 0, pairs: 0 }
    }

    /// Finds the parts of a pixel, adds what they show but for the excess, and has rays start from them.
    fn add_pixel(&self, buffers: &mut Buffers, strip: &mut Strip, pixel: usize, points: &PixelPoints) {
        let (bands, place, first) = (self.bands(), strip.offsets.len(), strip.parts.len());
        strip.offsets.push(first as u32);
        strip.seen.resize((place + 1) * bands, 0.0);
        let scale = 1.0 / points.looks as f32;
        for glow in points.glow.chunks_exact(bands) {
            strip.seen[place * bands..].iter_mut().zip(glow).for_each(|(sum, g)| *sum += scale * g);
        }
        let mut members: Vec<Vec<Lit>> = Vec::new();
        for (_, lit) in points.lit() {
            let seen = strip.seen[place * bands..].iter_mut();
            seen.zip(self.eye.emitted(lit.point)).for_each(|(sum, e)| *sum += scale * e);
            if self.eye.reflects(lit.point) {
                let part = self.part(lit.point);
                let known = strip.parts[first..].iter().position(|other| other.is_like(&part));
                let index = known.unwrap_or(members.len());
                if known.is_none() {
                    strip.parts.push(part);
                    members.push(Vec::new());
                }
                members[index].push(lit);
            }
        }
        strip.share.resize(strip.parts.len() * bands, 0.0);
        let count = strip.parts.len() * bands;
        strip.excess.iter_mut().chain(&mut strip.direct).for_each(|excess| excess.resize(count, 0.0));
        for (index, members) in members.iter().enumerate() {
            self.add_part(strip, (place, first + index), members, scale);
        }
        self.begin(buffers, strip, pixel, &members);
    }

    /// Adds what the points of a part show.
    fn add_part(&self, strip: &mut Strip, (pixel, part): (usize, usize), members: &[Lit], scale: f32) {
        let bands = self.bands();
        strip.parts[part].points = members.len() as u32;
        strip.parts[part].is_lit = members.iter().all(|lit| lit.direct.iter().any(|&h| h > 0.0));
        let share = &mut strip.share[part * bands..][..bands];
        for Lit { point, fields: [field, rest], .. } in members {
            share.iter_mut().zip(self.eye.shares(point)).for_each(|(sum, own)| *sum += scale * own);
            let seen = &mut strip.seen[pixel * bands..][..bands];
            let arrives = field.iter().zip(*rest).map(|(field, rest)| field + rest);
            seen.iter_mut().zip(self.eye.shares(point).zip(arrives)).for_each(|(sum, (s, h))| *sum += scale * s * h);
        }
        for (half, direct) in strip.direct.iter_mut().enumerate() {
            // A single point is both halves.
            let own = members.iter().skip(half % members.len()).step_by(2);
            let (own, sums) = (own.collect::<Vec<_>>(), &mut direct[part * bands..][..bands]);
            for Lit { direct, fields: [field, _], .. } in &own {
                let more = direct.iter().zip(*field).map(|(h, field)| (h - field) / own.len() as f32);
                sums.iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
            }
        }
    }

    /// Has rays start from the last parts of a strip, which one pixel shows, by the number of points that each has.
    fn begin(&self, buffers: &mut Buffers, strip: &mut Strip, pixel: usize, members: &[Vec<Lit>]) {
        let first = strip.parts.len() - members.len();
        let total: usize = members.iter().map(Vec::len).sum();
        let mut place = (0..).map(|ray| self.place_in_sequence(pixel, ray));
        for (k, points) in members.iter().enumerate() {
            let pairs = (self.samples as usize * points.len()).div_ceil(2 * total).max(1);
            strip.parts[first + k].pairs = pairs as u32;
            for (ray, (key, index)) in (0..2 * pairs).zip(&mut place) {
                let Lit { point, fields: [_, rest], .. } = points[ray * points.len() / (2 * pairs)];
                buffers.starts.push(Start { point: point.at, normal: self.eye.normal(point), key, index });
                buffers.owners.push((first + k) as u32);
                buffers.expected.extend(rest);
            }
        }
    }

    /// The sequence that a ray of a pixel is of, and its place there: those of a block are the first of its sequence.
    fn place_in_sequence(&self, pixel: usize, ray: u32) -> (u32, u32) {
        let (x, y) = (pixel % self.width, pixel / self.width);
        let block = (y / BLOCK) * self.width.div_ceil(BLOCK) + x / BLOCK;
        let rank = ((y % BLOCK) * BLOCK + x % BLOCK) as u32;
        let (round, ray) = (ray / self.samples, ray % self.samples);
        (block as u32, (round * (BLOCK * BLOCK) as u32 + rank) * self.samples + ray)
    }

    /// Shoots rays into the solution.
    fn shoot(&self, buffers: &mut Buffers, strip: &mut Strip) {
        let bands = self.bands();
        buffers.found.resize(buffers.starts.len() * bands, 0.0);
        buffers.walk.rest(self.tracer, &buffers.starts, REST, &mut buffers.found);
        let finds = buffers.found.chunks_exact(bands).zip(buffers.expected.chunks_exact(bands));
        for (ray, (&part, (found, expected))) in buffers.owners.iter().zip(finds).enumerate() {
            let sums = &mut strip.excess[ray % 2][part as usize * bands..][..bands];
            sums.iter_mut().zip(found.iter().zip(expected)).for_each(|(sum, (f, e))| *sum += f - e);
        }
    }

    /// Fills in a strip of which those beside it are known; returns its noise.
    fn develop(&self, strips: &VecDeque<Strip>, row: usize, pixels: &mut [f32]) -> Noise {
        let (bands, kernel) = (self.bands(), Kernel::new(self.spread));
        let of_row = |(k, values): (usize, &mut [f32])| {
            let (mut noise, mut sums) = (Noise::default(), vec![0.0; 2 * bands]);
            for (x, value) in values.chunks_exact_mut(bands).enumerate() {
                self.develop_pixel(strips, &kernel, (x, row + k), &mut sums);
                let (one, other) = sums.split_at(bands);
                noise.add_pixel(one, other);
                value
                    .iter_mut()
                    .zip(one.iter().zip(other))
                    .for_each(|(v, (a, b))| *v = (0.5 * (a + b)).max(0.0) as f32);
            }
            noise
        };
        let rows: Vec<Noise> = pixels.par_chunks_exact_mut(self.width * bands).enumerate().map(of_row).collect();
        rows.into_iter().fold(Noise::default(), Noise::plus)
    }

    /// What a pixel shows, of the points and rays of either half: twice as many values as bands.
    fn develop_pixel(&self, strips: &VecDeque<Strip>, kernel: &Kernel, (x, y): (usize, usize), sums: &mut [f64]) {
        let bands = self.bands();
        let Some((strip, pixel)) = at(strips, self.width, (x, y)) else { return };
        for sums in sums.chunks_exact_mut(bands) {
            sums.iter_mut().zip(&strip.seen[pixel * bands..]).for_each(|(sum, &v)| *sum = f64::from(v));
        }
        let mut fit = Fit::new(2 * bands);
        for k in strip.parts_of(pixel) {
            let part = &strip.parts[k];
            self.fit_around(strips, kernel, (x, y), part, &mut fit);
            let (mut excess, near) = (fit.value(), self.mean_around(strips, (x, y), part));
            // What rays find rarely, the nearest pixels may have missed, and know nothing of its noise.
            let variance = near.rest.variance.max(fit.variance());
            Estimate { variance, ..near.rest }.correct(&mut excess);
            let mut direct = near.direct.mean.clone();
            let own = strip.direct.iter().flat_map(|half| &half[k * bands..][..bands]).map(|&v| f64::from(v));
            Estimate { mean: own.collect(), weight: f64::from(part.points), ..near.direct }.correct(&mut direct);
            let share = &strip.share[k * bands..][..bands];
            let all = excess.chunks_exact(bands).zip(direct.chunks_exact(bands));
            for (sums, (excess, direct)) in sums.chunks_exact_mut(bands).zip(all) {
                let more = share.iter().zip(excess.iter().zip(direct)).map(|(&s, (e, d))| f64::from(s) * (e + d));
                sums.iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
            }
        }
    }

    /// Means over the parts like one that the nearest pixels show.
    fn mean_around(&self, strips: &VecDeque<Strip>, (x, y): (usize, usize), part: &Part) -> Near {
        let bands = self.bands();
        let (mut rest, mut direct) = (Mean::new(2 * bands), Mean::new(2 * bands));
        // Half as far as the spread.
        let near = (0.5 * self.spread).ceil() as usize;
        let (columns, rows) = (around(x, near, self.width), around(y, near, self.height));
        for row in rows {
            let Some((strip, first)) = at(strips, self.width, (columns.start, row)) else { continue };
            for k in columns.clone().flat_map(|column| strip.parts_of(first + column - columns.start)) {
                let other = &strip.parts[k];
                if part.is_like(other) {
                    let own = |halves: &[Vec<f32>; 2], i: usize| f64::from(halves[i / bands][k * bands + i % bands]);
                    let pairs = f64::from(other.pairs);
                    rest.add(pairs, |i| own(&strip.excess, i) / pairs);
                    if part.is_lit == other.is_lit {
                        direct.add(f64::from(other.points), |i| own(&strip.direct, i));
                    }
                }
            }
        }
        Near { rest: rest.estimate(), direct: direct.estimate() }
    }

    /// Fits the excess of pixels around one that show more of a part of it.
    fn fit_around(
        &self,
        strips: &VecDeque<Strip>,
        kernel: &Kernel,
        (x, y): (usize, usize),
        part: &Part,
        fit: &mut Fit,
    ) {
        fit.clear();
        let bands = self.bands();
        let (columns, rows) = (around(x, kernel.reach(), self.width), around(y, kernel.reach(), self.height));
        for row in rows {
            let Some((strip, first)) = at(strips, self.width, (columns.start, row)) else { continue };
            for column in columns.clone() {
                for k in strip.parts_of(first + column - columns.start) {
                    let other = &strip.parts[k];
                    if part.is_like(other) {
                        let weight = kernel.weight(x.abs_diff(column), y.abs_diff(row));
                        let from = [column as f64 - x as f64, row as f64 - y as f64];
                        let excess = strip.excess.iter().flat_map(|half| &half[k * bands..][..bands]);
                        fit.add(weight, f64::from(other.pairs), from, excess);
                        let half = |half: &[f32]| half[k * bands..][..bands].iter().sum::<f32>();
                        let difference = f64::from(half(&strip.excess[0]) - half(&strip.excess[1])) / bands as f64;
                        fit.add_noise(difference, f64::from(other.pairs));
                    }
                }
            }
        }
    }
}

/// What the nearest pixels say of what a part has more than expected.
struct Near {
    rest: Estimate,
    direct: Estimate,
}

/// A running mean of quantities that are known twice, from either half, and how noisy they are. Weights are numbers of
/// samples.
struct Mean {
    weight: f64,
    sums: Vec<f64>,
    /// Of the variances of single samples, as the halves tell them.
    variances: f64,
    count: f64,
}

/// An estimate of quantities, each from either half.
struct Estimate {
    mean: Vec<f64>,
    /// The samples that it is made of.
    weight: f64,
    /// The variance of one of them.
    variance: f64,
}

impl Mean {
    fn new(count: usize) -> Self {
        Self { weight: 0.0, sums: vec![0.0; count], variances: 0.0, count: 0.0 }
    }

    fn add(&mut self, weight: f64, value: impl Fn(usize) -> f64) {
        let half = self.sums.len() / 2;
        self.sums.iter_mut().enumerate().for_each(|(i, sum)| *sum += weight * value(i));
        let difference = (0..half).map(|i| value(i) - value(half + i)).sum::<f64>() / half as f64;
        self.variances += weight * (0.5 * difference).powi(2);
        self.weight += weight;
        self.count += 1.0;
    }

    fn estimate(mut self) -> Estimate {
        self.sums.iter_mut().for_each(|sum| *sum /= self.weight);
        Estimate { mean: self.sums, weight: self.weight, variance: self.variances / self.count }
    }
}

impl Estimate {
    /// Moves an estimate from farther around, with less noise and more bias, towards this as far as they differ by more
    /// than twice the noise of this (Lee 1980, *Digital image enhancement and noise filtering by use of local
    /// statistics*).
    fn correct(&self, other: &mut [f64]) {
        let difference =
            self.mean.iter().zip(&*other).map(|(own, other)| own - other).sum::<f64>() / other.len() as f64;
        let variance = self.variance / self.weight;
        let share = 1.0 - SURE * variance / (difference * difference).max(f64::MIN_POSITIVE);
        if share > 0.0 {
            other.iter_mut().zip(&self.mean).for_each(|(other, own)| *other += share * (own - *other));
        }
    }
}

/// A linear fit of several quantities about one place (Cleveland 1979, *Robust locally weighted regression*): unlike a mean
/// it is not drawn to one side where all there is lies there.
struct Fit {
    /// Sums of the weights, times coordinates and their products.
    weight: f64,
    first: [f64; 2],
    second: [f64; 3],
    /// Sums of the quantities, times weights and coordinates.
    sums: Vec<[f64; 3]>,
    /// The variances of single samples, and how many of them there are.
    variances: f64,
    places: f64,
}

impl Fit {
    fn new(count: usize) -> Self {
        let sums = vec![[0.0; 3]; count];
        Self { weight: 0.0, first: [0.0; 2], second: [0.0; 3], sums, variances: 0.0, places: 0.0 }
    }

    fn clear(&mut self) {
        let mut sums = std::mem::take(&mut self.sums);
        sums.fill([0.0; 3]);
        *self = Self { sums, ..Self::new(0) };
    }

    /// Adds `count` times a value of each quantity, which are given in sum, at a place.
    fn add<'a>(&mut self, weight: f64, count: f64, [x, y]: [f64; 2], totals: impl Iterator<Item = &'a f32>) {
        let w = weight * count;
        self.weight += w;
        self.first[0] += w * x;
        self.first[1] += w * y;
        self.second[0] += w * x * x;
        self.second[1] += w * x * y;
        self.second[2] += w * y * y;
        for (sum, &total) in self.sums.iter_mut().zip(totals) {
            let value = weight * f64::from(total);
            sum[0] += value;
            sum[1] += value * x;
            sum[2] += value * y;
        }
    }

    /// Adds by how much the sums over so many pairs of samples differ.
    fn add_noise(&mut self, difference: f64, pairs: f64) {
        self.variances += (0.5 * difference).powi(2) / pairs;
        self.places += 1.0;
    }

    /// The variance of a pair.
    fn variance(&self) -> f64 {
        self.variances / self.places
    }

    /// The fit at the origin.
    fn value(&self) -> Vec<f64> {
        let ([x, y], [xx, xy, yy]) = (self.first, self.second);
        let (xx, yy) = (xx + RIDGE * self.weight, yy + RIDGE * self.weight);
        let cofactors = [xx * yy - xy * xy, y * xy - x * yy, x * xy - y * xx];
        let determinant = self.weight * cofactors[0] + x * cofactors[1] + y * cofactors[2];
        let of = |sums: &[f64; 3]| sums.iter().zip(cofactors).map(|(s, c)| s * c).sum::<f64>() / determinant;
        self.sums.iter().map(of).collect()
    }
}

/// The strip that a pixel is in, and its place there.
fn at(strips: &VecDeque<Strip>, width: usize, (x, y): (usize, usize)) -> Option<(&Strip, usize)> {
    let strip = strips.iter().find(|strip| (strip.row..strip.row + ROWS).contains(&y))?;
    Some((strip, (y - strip.row) * width + x))
}

/// Points of one pixel.
struct PixelPoints<'a> {
    looks: usize,
    glow: &'a [f32],
    list: &'a [Option<Point>],
    direct: &'a [f32],
    fields: [&'a [f32]; 2],
    bands: usize,
}

impl Points {
    /// Those of one of so many pixels.
    fn of(&self, pixel: usize, pixels: usize, bands: usize) -> PixelPoints<'_> {
        let slots = self.list.len() / pixels;
        let (own, values) = (pixel * slots..(pixel + 1) * slots, pixel * slots * bands..(pixel + 1) * slots * bands);
        PixelPoints {
            looks: self.each,
            glow: &self.glow[pixel * self.each * bands..(pixel + 1) * self.each * bands],
            list: &self.list[own],
            direct: &self.direct[values.clone()],
            fields: self.fields.each_ref().map(|field| &field[values.clone()]),
            bands,
        }
    }
}

impl<'a> PixelPoints<'a> {
    /// Those where something is seen, with their places in the list.
    fn lit(&self) -> impl Iterator<Item = (usize, Lit<'a>)> {
        let (bands, direct, fields) = (self.bands, self.direct, self.fields);
        let seen = self.list.iter().enumerate().filter_map(|(k, point)| Some((k, point.as_ref()?)));
        seen.map(move |(k, point)| {
            let own = k * bands..(k + 1) * bands;
            (k, Lit { point, direct: &direct[own.clone()], fields: fields.map(|field| &field[own.clone()]) })
        })
    }
}

impl Part {
    /// Whether it is as if of one smooth surface with another: a little off its plane, and turned little.
    fn is_like(&self, other: &Self) -> bool {
        let to = other.point - self.point;
        let off = to.dot(self.normal.as_dvec3());
        self.normal.dot(other.normal) > 0.9 && off * off <= 0.01 * to.length_squared()
    }
}

impl Strip {
    /// One of many, in their order.
    fn joined(row: usize, pieces: Vec<Self>) -> Self {
        let mut all = Self { row, ..Self::default() };
        for piece in pieces {
            let first = all.parts.len() as u32;
            all.offsets.pop();
            all.offsets.extend(piece.offsets.iter().map(|offset| first + offset));
            all.parts.extend(piece.parts);
            all.share.extend(piece.share);
            for half in 0..2 {
                all.excess[half].extend(&piece.excess[half]);
                all.direct[half].extend(&piece.direct[half]);
            }
            all.seen.extend(piece.seen);
            all.rays += piece.rays;
        }
        all
    }

    fn parts_of(&self, pixel: usize) -> Range<usize> {
        self.offsets[pixel] as usize..self.offsets[pixel + 1] as usize
    }
}

/// Places around one, of so many.
fn around(place: usize, reach: usize, count: usize) -> Range<usize> {
    place.saturating_sub(reach)..(place + reach + 1).min(count)
}

/// Weights of pixels around one.
struct Kernel(Vec<f64>);

impl Kernel {
    fn new(spread: f64) -> Self {
        let reach = (2.0 * spread).ceil() as usize;
        Self((0..=reach).map(|k| (-0.5 * (k as f64 / spread).powi(2)).exp()).collect())
    }

    /// Pixels on each side.
    fn reach(&self) -> usize {
        self.0.len() - 1
    }

    fn weight(&self, columns: usize, rows: usize) -> f64 {
        self.0[columns] * self.0[rows]
    }
}

/// How far two halves of a picture differ.
#[derive(Clone, Copy, Default)]
struct Noise {
    squares: f64,
    sum: f64,
    count: f64,
}

impl Noise {
    fn add_pixel(&mut self, one: &[f64], other: &[f64]) {
        for (a, b) in one.iter().zip(other) {
            // The mean of two halves varies half as much as their difference.
            self.squares += (0.5 * (a - b)).powi(2);
            self.sum += 0.5 * (a + b);
            self.count += 1.0;
        }
    }

    fn plus(self, other: Self) -> Self {
        let (squares, sum, count) = (self.squares + other.squares, self.sum + other.sum, self.count + other.count);
        Self { squares, sum, count }
    }

    /// Root mean square over the mean.
    fn relative(&self) -> f64 {
        if self.sum > 0.0 { (self.squares * self.count).sqrt() / self.sum } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use radiosity_exchange::Enclosure;
    use radiosity_geometry::Patches;
    use radiosity_geometry::corners::CREASE_ANGLE;
    use radiosity_paths::Exitance;

    use super::*;
    use crate::test_scenes::{camera, cube};
    use crate::{Smoother, TraceSettings, trace};

    /// The inside of a unit cube, cut 4 x 4 a side, of which one patch above is a lamp and what meets the others is known
    /// by path tracing.
    struct Room {
        enclosure: Enclosure,
        emission: Vec<f32>,
        reflectance: Vec<f32>,
    }

    impl Room {
        fn new() -> Self {
            let mut polygons = cube(4).polygons;
            polygons.iter_mut().for_each(|p| p.reverse());
            let n = polygons.len();
            let enclosure = Enclosure::new(Patches::new(polygons, vec![0; n], vec![0; n], vec![false; n]));
            let is_lamp = |p: &DVec3| p.z > 0.49 && p.x.abs() < 0.25 && p.y.abs() < 0.25;
            let emission = enclosure.patches().centre.iter().map(|c| if is_lamp(c) { 20.0 } else { 0.0 }).collect();
            Self { enclosure, emission, reflectance: vec![0.5; n] }
        }

        fn surfaces(&self) -> Surfaces<'_> {
            Surfaces::Radiance { emission: &self.emission, reflectance: &self.reflectance, transmittance: &[] }
        }

        fn paths(&self) -> Tracer<'_> {
            let exitance = Exitance::Uniform(self.emission.clone());
            Tracer::paths(&self.enclosure, 1, exitance, self.reflectance.clone(), vec![], 3)
        }

        /// Irradiance of all patches.
        fn solved(&self) -> Vec<f64> {
            radiosity_paths::of_sides(&self.paths(), &Effort::at_once(1 << 12), &Control::default()).unwrap().irradiance
        }

        fn gathered(&self, settings: &GatherSettings, off: f64) -> Gathered {
            let irradiance = self.solved();
            let values = irradiance.iter().zip(self.emission.iter().zip(&self.reflectance));
            let radiosity: Vec<f64> = values.map(|(h, (&e, &rho))| f64::from(e) + f64::from(rho) * h).collect();
            let smoother = Smoother::new(self.enclosure.patches(), CREASE_ANGLE);
            let rho: Vec<f64> = self.reflectance.iter().map(|&rho| f64::from(rho)).collect();
            let corners = smoother.corner_radiosity_of_patches(&radiosity, &irradiance, &rho, &[], 1);
            let exitance = Exitance::Corners(corners.iter().map(|&v| v as f32).collect());
            let tracer = Tracer::gather(&self.enclosure, 1, exitance, vec![], 5);
            let sides: Vec<u32> = (0..irradiance.len() as u32).collect();
            let control = Control::default();
            let parts = direct_and_rest(&tracer, &sides, &irradiance, 1 << 16, &control).unwrap();
            let [direct, rest] = parts
                .map(|part| smoother.corner_values(&part, 1).iter().map(|&v| (off * v) as f32).collect::<Vec<f32>>());
            let fields = Fields { direct: &direct, rest: &rest };
            gather(&tracer, self.surfaces(), fields, &eye(), settings, &control).unwrap()
        }
    }

    fn eye() -> Camera {
        camera(DVec3::new(0.2, 0.3, -0.3), 1.2)
    }

    fn settings(width: usize, height: usize, samples: u32) -> GatherSettings {
        GatherSettings { width, height, samples, culls_backs: true }
    }

    /// Root mean square of the difference over the mean.
    fn off(one: &Image, other: &Image) -> f64 {
        let square = |(a, b): (&f32, &f32)| f64::from(a - b).powi(2);
        let squares: f64 = one.pixels.iter().zip(&other.pixels).map(square).sum();
        (squares * one.pixels.len() as f64).sqrt() / other.pixels.iter().map(|&v| f64::from(v)).sum::<f64>()
    }

    #[test]
    fn a_gather_is_what_paths_find_and_says_how_noisy_it_is() {
        let room = Room::new();
        let found = room.gathered(&settings(40, 34, 16), 1.0);
        let effort = radiosity_paths::Effort::of_samples(4096);
        let settings_of_paths = TraceSettings { width: 40, height: 34, effort, culls_backs: true };
        let truth = trace(&room.paths(), room.surfaces(), &eye(), &settings_of_paths, &Control::default()).unwrap();
        let difference = off(&found.image, &truth.image);
        // Of which the edges of the lamp, which few pixels show, are more than half.
        assert!(truth.rounds.error < 0.01 && difference < 0.045, "{} {difference}", truth.rounds.error);
        assert!(found.noise > 0.1 * difference && found.noise < 0.05, "{} {difference}", found.noise);
        // What it measures itself against may be wrong.
        let from_less = room.gathered(&settings(40, 34, 16), 0.8);
        assert!(off(&from_less.image, &truth.image) < 0.06, "{}", off(&from_less.image, &truth.image));
    }

    #[test]
    fn a_gather_is_the_same_on_any_number_of_threads_and_at_the_edges_of_strips() {
        let room = Room::new();
        for (width, height) in [(9, 70), (1, 33), (5, 1)] {
            let make = || room.gathered(&settings(width, height, 2), 1.0);
            let found = make();
            assert!(found.image.pixels.iter().all(|v| v.is_finite()) && found.rays > (4 * width * height) as u64);
            let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
            assert_eq!(one.install(make).image, found.image);
        }
    }

    #[test]
    fn a_linear_fit_of_a_plane_is_that_plane() {
        let mut fit = Fit::new(1);
        for (x, y) in (0..5).flat_map(|x| (-3..2).map(move |y| (f64::from(x), f64::from(y)))) {
            fit.add(1.0 / (1.0 + x * x), 2.0, [x, y], [2.0 * (7.0 + 0.5 * x as f32 - y as f32)].iter());
        }
        // But for what holds slopes back.
        assert!((fit.value()[0] - 7.0).abs() < 0.1, "{:?}", fit.value());
        fit.clear();
        fit.add(0.3, 1.0, [0.0, 0.0], [4.0].iter());
        assert!((fit.value()[0] - 4.0).abs() < 1e-12);
    }

    #[test]
    fn cancelled_and_empty_pictures() {
        let room = Room::new();
        let tracer = Tracer::gather(&room.enclosure, 1, Exitance::Uniform(room.emission.clone()), vec![], 1);
        let zero = vec![0.0; 4 * room.enclosure.sides()];
        let (fields, control) = (Fields { direct: &zero, rest: &zero }, Control::default());
        let empty = gather(&tracer, Surfaces::Irradiance, fields, &eye(), &settings(0, 5, 4), &control).unwrap();
        assert!(empty.image.pixels.is_empty() && empty.rays == 0);
        control.cancel();
        let cancelled = gather(&tracer, Surfaces::Irradiance, fields, &eye(), &settings(5, 5, 4), &control);
        assert_eq!(cancelled.unwrap_err(), Cancelled);
    }
}
