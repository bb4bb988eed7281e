//! Pictures by random paths from every point that is seen: the final gather, and path tracing.

use std::f64::consts::FRAC_1_PI;

use glam::DVec3;
use radiosity_exchange::enclosure::Sight;
use radiosity_exchange::images::survival;
use radiosity_geometry::Patches;
use radiosity_geometry::bvh::{Hit, Ray};
use radiosity_geometry::sampling::Sequence;
use radiosity_operator::{Cancelled, Control};
use radiosity_paths::{Effort, Means, Rounds, Start, Tracer, Walk, Way};
use radiosity_scene::Camera;
use rayon::prelude::*;

use crate::Image;
use crate::beyond::{Beyond, Shown};
use crate::metals::{Choice, Metal};
use crate::render::{offsets, side_of};
use crate::view::{Frame, Visible};

/// What surfaces show of what arrives: sides x bands each. Textures, which the tracer knows, stand for the reflectance of
/// the sides that have them.
#[derive(Clone, Copy, Debug)]
pub enum Surfaces<'a> {
    /// Radiance, W/(m2 sr).
    Radiance {
        /// Radiant exitance, W/m2.
        emission: &'a [f32],
        /// Diffuse reflectance.
        reflectance: &'a [f32],
    },
    /// Irradiance, W/m2.
    Irradiance,
}

/// How a traced picture is made.
#[derive(Clone, Debug, PartialEq)]
pub struct TraceSettings {
    /// Pixels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Paths per pixel.
    pub effort: Effort,
    /// Paths that start from each point that is seen: what they find varies more than what is seen within a pixel.
    pub paths_per_point: u32,
    /// Whether the backs of one-sided patches let the view through; else they are black.
    pub culls_backs: bool,
}

/// A picture and how good it is.
#[derive(Clone, Debug)]
pub struct Traced {
    /// The means.
    pub image: Image,
    /// Their standard errors; NaN if there was one round only.
    pub standard_error: Image,
    /// How it went. The error is the mean over pixels that are lit of the standard error over the value, the one root
    /// mean square and the other mean over bands.
    pub rounds: Rounds,
    /// Rays traced.
    pub rays: u64,
}

/// How many of so many samples of a pixel should start from one point in a gather: edges need some sixteen points, and
/// what arrives needs the rest.
pub fn paths_per_point(samples: u32) -> u32 {
    (samples / 16).max(1)
}

/// Traces paths from what a camera sees; every tile of every round is a step of `control`.
///
/// The same input gives the same bytes on any number of threads. Radiance is also seen in mirrors and through clear
/// glass; irradiance is that of the mirror or pane itself.
///
/// # Errors
/// If `control` is cancelled.
///
/// # Panics
/// If `surfaces` do not fit the sides and bands of the tracer.
pub fn trace(
    tracer: &Tracer,
    surfaces: Surfaces,
    camera: &Camera,
    settings: &TraceSettings,
    control: &Control,
) -> Result<Traced, Cancelled> {
    let (width, height, bands) = (settings.width, settings.height, tracer.bands());
    let patches = tracer.enclosure().patches();
    if let Surfaces::Radiance { emission, reflectance } = surfaces {
        let count = tracer.enclosure().sides() * bands;
        assert_eq!((emission.len(), reflectance.len()), (count, count), "values fit the sides and bands");
    }
    let paths = settings.paths_per_point.clamp(1, settings.effort.per_round);
    let points = settings.effort.per_round.div_ceil(paths);
    let beyond = tracer.enclosure().specular().map(|specular| Beyond {
        enclosure: tracer.enclosure(),
        specular,
        culls_backs: settings.culls_backs,
    });
    let is_glass = |patch: usize| beyond.is_some_and(|beyond| beyond.specular.transmittance(patch) > 0.0);
    let film = Film {
        tracer,
        surfaces,
        patches,
        visible: Visible::new(patches, camera.position, settings.culls_backs, is_glass),
        beyond: beyond.filter(|_| matches!(surfaces, Surfaces::Radiance { .. })),
        frame: Frame::new(camera, width, height),
        width,
        each: settings.effort.per_round,
        paths,
        offsets: if settings.effort.most == 1 { offsets(points as usize) } else { Vec::new() },
    };
    let mut tiles = if bands == 0 { Vec::new() } else { tiles(width, height, bands) };
    let rounds = radiosity_paths::rounds(&settings.effort, tiles.len() as u64, control, |round| {
        tiles.par_iter_mut().try_for_each_init(Buffers::default, |buffers, tile| {
            control.check()?;
            film.add_round(buffers, tile, round);
            control.advance(1);
            Ok(())
        })?;
        Ok(error(&tiles, bands))
    })?;
    let picture = |value: &dyn Fn(&Means) -> Vec<f32>| {
        let mut image = Image { width, height, bands, pixels: vec![0.0; width * height * bands] };
        tiles.iter().for_each(|tile| tile.paste(&value(&tile.means), &mut image));
        image
    };
    Ok(Traced {
        image: picture(&|means| means.mean().iter().map(|&m| m as f32).collect()),
        standard_error: picture(&|means| means.variance().map(|v| v.sqrt() as f32).collect()),
        rounds,
        rays: tiles.iter().map(|tile| tile.rays).sum(),
    })
}

/// Pixels along the edge of a tile.
const TILE: usize = 16;

/// About how many paths one thread walks at once.
const PATHS_AT_ONCE: usize = 4096;

/// The stream of the sequence that spreads rays over a pixel.
const STREAM: u32 = 9;

/// The stream of the sequence that chooses what is seen in mirrors and through panes.
const SPECULAR: u32 = 10;

/// The same from rough metals on.
const SPECULAR_IN_METALS: u32 = 12;

/// A rectangle of the picture.
struct Tile {
    left: usize,
    top: usize,
    width: usize,
    means: Means,
    rays: u64,
}

fn tiles(width: usize, height: usize, bands: usize) -> Vec<Tile> {
    let corners = (0..height).step_by(TILE).flat_map(|top| (0..width).step_by(TILE).map(move |left| (left, top)));
    corners
        .map(|(left, top)| {
            let (width, height) = (TILE.min(width - left), TILE.min(height - top));
            Tile { left, top, width, means: Means::new(width * height * bands), rays: 0 }
        })
        .collect()
}

impl Tile {
    /// Puts the values of its pixels in their place.
    fn paste(&self, values: &[f32], image: &mut Image) {
        let row_length = self.width * image.bands;
        for (row, values) in values.chunks_exact(row_length).enumerate() {
            let first = ((self.top + row) * image.width + self.left) * image.bands;
            image.pixels[first..first + row_length].copy_from_slice(values);
        }
    }
}

/// Mean over lit pixels of the standard error over the value.
fn error(tiles: &[Tile], bands: usize) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for tile in tiles {
        let variance: Vec<f64> = tile.means.variance().collect();
        for (mean, variance) in tile.means.mean().chunks_exact(bands).zip(variance.chunks_exact(bands)) {
            let (mean, variance) =
                (mean.iter().sum::<f64>() / bands as f64, variance.iter().sum::<f64>() / bands as f64);
            if mean > 0.0 {
                sum += variance.sqrt() / mean;
                count += 1.0;
            }
        }
    }
    if count > 0.0 { sum / count } else { 0.0 }
}

/// Everything that one picture needs.
struct Film<'a> {
    tracer: &'a Tracer<'a>,
    surfaces: Surfaces<'a>,
    patches: &'a Patches,
    visible: Visible,
    /// If mirrors and panes show what is beyond.
    beyond: Option<Beyond<'a>>,
    frame: Frame,
    width: usize,
    /// Paths per pixel and round.
    each: u32,
    /// Paths from each point that is seen.
    paths: u32,
    /// Where rays pass through every pixel, in [0, 1), so that edges are clean; empty if each pixel and round has rays of
    /// its own, so that rounds are independent.
    offsets: Vec<[f64; 2]>,
}

/// Buffers of one thread.
#[derive(Default)]
struct Buffers {
    rays: Vec<Ray>,
    hits: Vec<Hit>,
    starts: Vec<Start>,
    /// The pixel within the tile and the side that each path starts for, and what it weighs.
    owners: Vec<(u32, u32, f32)>,
    /// What each of them weighs besides in each band, starts x bands.
    tints: Vec<f32>,
    irradiance: Vec<f32>,
    pixels: Vec<f64>,
    walk: Walk,
    /// How many rays follow the lobes of metals.
    rays_in_metals: u64,
}

impl Buffers {
    fn clear(&mut self) {
        self.starts.clear();
        self.owners.clear();
        self.tints.clear();
        self.rays_in_metals = 0;
    }

    /// Has a path start for a pixel from a side.
    fn push(&mut self, start: Start, (pixel, seen): (usize, &Seen), bands: usize, tint: impl Fn(usize) -> f64) {
        self.starts.push(start);
        self.owners.push((pixel as u32, seen.side as u32, seen.weight as f32));
        self.tints.extend((0..bands).map(|band| tint(band) as f32));
    }
}

/// What a ray shows of a side.
#[derive(Clone, Copy)]
struct Seen {
    weight: f64,
    side: usize,
    /// Just off the side.
    point: DVec3,
    /// The way that the ray came along last.
    direction: DVec3,
}

/// A point that is seen: for which pixel, and by which key and number of points.
#[derive(Clone, Copy)]
struct Point {
    seen: Seen,
    pixel: usize,
    key: u32,
    index: u32,
}

impl Film<'_> {
    fn add_round(&self, buffers: &mut Buffers, tile: &mut Tile, round: u32) {
        let count = tile.means.mean().len() / self.tracer.bands();
        buffers.pixels.clear();
        buffers.pixels.resize(tile.means.mean().len(), 0.0);
        let at_once = (PATHS_AT_ONCE / self.each as usize).max(1);
        let before = buffers.walk.rays_traced;
        for first in (0..count).step_by(at_once) {
            let pixels = first..(first + at_once).min(count);
            self.look(buffers, tile, pixels.clone(), round);
            self.begin(buffers, tile, pixels, round);
            buffers.irradiance.resize(buffers.starts.len() * self.tracer.bands(), 0.0);
            buffers.walk.irradiance(self.tracer, &buffers.starts, round, &mut buffers.irradiance);
            self.reflect(buffers);
            tile.rays += buffers.rays.len() as u64 + buffers.rays_in_metals;
        }
        tile.rays += buffers.walk.rays_traced - before;
        tile.means.add(&buffers.pixels);
    }

    /// Points that are seen in a pixel and round.
    fn points(&self) -> u32 {
        self.each.div_ceil(self.paths)
    }

    /// The place of a pixel of a tile in the picture.
    fn place(&self, tile: &Tile, pixel: usize) -> (usize, usize) {
        (tile.left + pixel % tile.width, tile.top + pixel / tile.width)
    }

    fn key(&self, (x, y): (usize, usize)) -> u32 {
        (y * self.width + x) as u32
    }

    /// Shoots the rays of some pixels.
    fn look(&self, buffers: &mut Buffers, tile: &Tile, pixels: std::ops::Range<usize>, round: u32) {
        buffers.rays.clear();
        for (x, y) in pixels.map(|pixel| self.place(tile, pixel)) {
            if !self.offsets.is_empty() {
                buffers.rays.extend(self.offsets.iter().map(|[u, v]| self.frame.ray(x as f64 + u, y as f64 + v)));
                continue;
            }
            let sequence = Sequence::new(self.tracer.seed(), self.key((x, y)), round, STREAM);
            buffers.rays.extend((0..self.points()).map(|index| {
                let [u, v, ..] = sequence.point(index);
                self.frame.ray(x as f64 + u, y as f64 + v)
            }));
        }
        buffers.hits.resize(buffers.rays.len(), Hit::MISS);
        self.visible.bvh.closest_hits(&buffers.rays, &mut buffers.hits);
    }

    /// Adds what surfaces emit that were seen, and has paths start from them.
    fn begin(&self, buffers: &mut Buffers, tile: &Tile, pixels: std::ops::Range<usize>, round: u32) {
        let points = self.points() as usize;
        buffers.clear();
        for (k, pixel) in pixels.enumerate() {
            let key = self.key(self.place(tile, pixel));
            let sequence = Sequence::new(self.tracer.seed(), key, round, SPECULAR);
            for index in 0..points {
                let (ray, hit) = (buffers.rays[k * points + index], buffers.hits[k * points + index]);
                let index = index as u32;
                if let Some(seen) = self.seen(&ray, &hit, |met| survival(&sequence, index, met)) {
                    self.begin_at(buffers, Point { seen, pixel, key, index }, round);
                }
            }
        }
    }

    /// Adds what is emitted at a point that is seen, and has paths start from it.
    fn begin_at(&self, buffers: &mut Buffers, point: Point, round: u32) {
        let Point { seen, pixel, key, index } = point;
        let bands = self.tracer.bands();
        let mut metal = None;
        if let Surfaces::Radiance { reflectance, .. } = self.surfaces {
            self.add_emission(buffers, (pixel, &seen), f64::from(self.points()), |_| 1.0);
            if reflectance[seen.side * bands..][..bands].iter().all(|&rho| rho == 0.0) {
                return;
            }
            metal = Metal::new(self.tracer, seen.side, seen.point, seen.direction);
        }
        if let Some(metal) = metal {
            return self.begin_at_metal(buffers, &metal, point, round);
        }
        for path in 0..self.paths {
            let start = self.start(&seen, key, index * self.paths + path);
            buffers.push(start, (pixel, &seen), bands, |_| 1.0);
        }
    }

    fn start(&self, seen: &Seen, key: u32, index: u32) -> Start {
        Start { point: seen.point, normal: self.tracer.enclosure().normal(seen.side), key, index }
    }

    /// Adds the radiance that a side emits, as one of so many that are seen in a pixel.
    fn add_emission(&self, buffers: &mut Buffers, (pixel, seen): (usize, &Seen), of: f64, tint: impl Fn(usize) -> f64) {
        let Surfaces::Radiance { emission, .. } = self.surfaces else { return };
        let bands = self.tracer.bands();
        let (sums, own) = (&mut buffers.pixels[pixel * bands..][..bands], &emission[seen.side * bands..]);
        for (band, (sum, &e)) in sums.iter_mut().zip(own).enumerate() {
            *sum += seen.weight * FRAC_1_PI / of * tint(band) * f64::from(e);
        }
    }

    /// Has the paths from a point of a metal go on by its lobe, or start from it as from other sides.
    fn begin_at_metal(&self, buffers: &mut Buffers, metal: &Metal, point: Point, round: u32) {
        let Surfaces::Radiance { reflectance, .. } = self.surfaces else { return };
        let Point { seen, pixel, key, index } = point;
        let (tracer, bands) = (self.tracer, self.tracer.bands());
        let f0 = self.reflectance_at(seen.side, seen.point, reflectance);
        let tint = |way: Way| move |band: usize| way.fresnel(f64::from(f0(band)));
        let sums = &mut buffers.pixels[pixel * bands..][..bands];
        metal.add_highlights(tracer, f0, seen.weight / f64::from(self.points()), sums);
        let sequence = Sequence::new(tracer.seed(), key, round, SPECULAR_IN_METALS);
        let each = f64::from(self.points() * self.paths);
        for index in (0..self.paths).map(|path| index * self.paths + path) {
            if let Some((side, weight, way)) = metal.lamp(tracer, (key, index), round) {
                let lamp = Seen { side, weight: seen.weight * weight, ..seen };
                self.add_emission(buffers, (pixel, &lamp), each, tint(way));
            }
            let here = self.start(&seen, key, index);
            match metal.choose(tracer, (key, index), round) {
                Choice::Paint => buffers.push(here, (pixel, &seen), bands, |_| 1.0),
                Choice::Spread(way) => buffers.push(here, (pixel, &seen), bands, tint(way)),
                Choice::Along(way) => {
                    buffers.rays_in_metals += 1;
                    let ray = tracer.enclosure().ray(seen.point, way.direction);
                    let Some(there) = self.seen_on(ray, |met| survival(&sequence, index, met)) else { continue };
                    let there = Seen { weight: seen.weight * there.weight, ..there };
                    let glow = there.weight * metal.weight(tracer, &way, (there.side, there.point));
                    self.add_emission(buffers, (pixel, &Seen { weight: glow, ..there }), each, tint(way));
                    buffers.push(self.start(&there, key, index), (pixel, &there), bands, tint(way));
                }
            }
        }
    }

    /// What a ray from a surface shows.
    fn seen_on(&self, ray: Ray, survival: impl Fn(u32) -> f64) -> Option<Seen> {
        let enclosure = self.tracer.enclosure();
        if let Some(beyond) = &self.beyond {
            return match beyond.along(ray, |side| self.is_dark(side), survival)? {
                (weight, Shown::Side { side, point, direction, .. }) => Some(Seen { weight, side, point, direction }),
                (_, Shown::Nothing) => None,
            };
        }
        let hit = enclosure.bvh().closest_hit(&ray);
        let Sight::Side(side, s, t) = enclosure.sight(ray.direction, &hit) else { return None };
        let (side, direction) = (side as usize, ray.direction.as_dvec3());
        Some(Seen { weight: 1.0, side, point: enclosure.point_off(side, s, t), direction })
    }

    /// Whether a side neither emits nor reflects diffusely.
    fn is_dark(&self, side: usize) -> bool {
        let bands = self.tracer.bands();
        match self.surfaces {
            Surfaces::Irradiance => false,
            Surfaces::Radiance { emission, reflectance } => {
                let of_side = |values: &[f32]| values[side * bands..][..bands].iter().all(|&v| v == 0.0);
                of_side(emission) && of_side(reflectance)
            }
        }
    }

    /// What a ray of the camera shows of a side.
    fn seen(&self, ray: &Ray, hit: &Hit, survival: impl Fn(u32) -> f64) -> Option<Seen> {
        let enclosure = self.tracer.enclosure();
        let facet = self.visible.facet(hit)?;
        let (patch, on) = (facet.patch as usize, facet.point(self.patches, hit));
        let (side, direction) = (side_of(enclosure, &facet), ray.direction.as_dvec3());
        let first = side.map(|side| (side, enclosure.off(side, on)));
        match self.beyond.filter(|beyond| beyond.is_of(patch)) {
            None => first.map(|(side, point)| Seen { weight: 1.0, side, point, direction }),
            Some(beyond) => {
                let corners = facet.corner_weights(hit);
                let first = first.map(|(side, point)| Shown::Side { side, point, corners, direction });
                match beyond.one((patch, first), (on, ray.direction), |side| self.is_dark(side), survival)? {
                    (weight, Shown::Side { side, point, direction, .. }) => {
                        Some(Seen { weight, side, point, direction })
                    }
                    (_, Shown::Nothing) => None,
                }
            }
        }
    }

    /// What a side reflects diffusely in each band at a point of it: of those that are given for whole sides, unless it
    /// has a texture.
    fn reflectance_at<'a>(
        &'a self,
        side: usize,
        point: DVec3,
        of_sides: &'a [f32],
    ) -> impl Fn(usize) -> f32 + Copy + 'a {
        let texture = self.tracer.texture_at(side, point);
        let own = &of_sides[side * self.tracer.bands()..];
        move |band| texture.map_or_else(|| own[band], |values| values.band(band))
    }

    /// Adds what is reflected of what arrives.
    fn reflect(&self, buffers: &mut Buffers) {
        let bands = self.tracer.bands();
        let share = 1.0 / f64::from(self.points() * self.paths);
        let found = buffers.starts.iter().zip(buffers.irradiance.chunks_exact(bands));
        let found = found.zip(buffers.tints.chunks_exact(bands));
        for (&(pixel, side, weight), ((start, found), tint)) in buffers.owners.iter().zip(found) {
            let sums = &mut buffers.pixels[pixel as usize * bands..][..bands];
            let share = share * f64::from(weight);
            match self.surfaces {
                Surfaces::Irradiance => {
                    sums.iter_mut().zip(found).for_each(|(sum, &h)| *sum += share * f64::from(h));
                }
                Surfaces::Radiance { reflectance, .. } => {
                    let rho = self.reflectance_at(side as usize, start.point, reflectance);
                    for (band, (sum, &h)) in sums.iter_mut().zip(found).enumerate() {
                        *sum += share * FRAC_1_PI * f64::from(rho(band) * tint[band]) * f64::from(h);
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use radiosity_exchange::Enclosure;
    use radiosity_paths::Exitance;

    use super::*;
    use crate::test_scenes::{camera, cube};

    fn settings(width: usize, height: usize, effort: Effort) -> TraceSettings {
        TraceSettings { width, height, effort, paths_per_point: 2, culls_backs: true }
    }

    /// The inside of a unit cube where all emits 1 and reflects half, so that H = 2 and B = 2 everywhere.
    fn furnace() -> Enclosure {
        let mut polygons = cube(2).polygons;
        polygons.iter_mut().for_each(|p| p.reverse());
        let n = polygons.len();
        Enclosure::new(Patches::new(polygons, vec![0; n], vec![0; n], vec![false; n]))
    }

    #[test]
    fn a_furnace_is_uniform_to_the_errors_it_states() {
        let enclosure = furnace();
        let (ones, half) = (vec![1.0; 24], vec![0.5; 24]);
        let tracer = Tracer::paths(&enclosure, 1, Exitance::Uniform(ones.clone()), half.clone(), vec![], 1);
        // Beyond what the picture takes in one tile, and seen from outside, through the backs.
        let (eye, settings) = (camera(DVec3::new(0.2, 0.3, 2.0), 0.4), settings(21, 18, Effort::of_samples(256)));
        let surfaces = Surfaces::Radiance { emission: &ones, reflectance: &half };
        let traced = trace(&tracer, surfaces, &eye, &settings, &Control::default()).unwrap();
        let truth = (2.0 * FRAC_1_PI) as f32;
        let scores: Vec<f32> = traced
            .image
            .pixels
            .iter()
            .zip(&traced.standard_error.pixels)
            .filter(|(value, _)| **value > 0.5)
            .map(|(value, error)| (value - truth) / error)
            .collect();
        assert!(scores.len() > 200, "{}", scores.len());
        let mean_square = scores.iter().map(|z| z * z).sum::<f32>() / scores.len() as f32;
        // Of Student's t with seven degrees of freedom it is 7 / 5.
        assert!((1.0..1.9).contains(&mean_square), "{mean_square}");
        assert!(traced.rounds.error < 0.03 && traced.rounds.samples == 256 && traced.rays > 21 * 18 * 256);
        let irradiance = trace(&tracer, Surfaces::Irradiance, &eye, &settings, &Control::default()).unwrap();
        let lit: Vec<f32> = irradiance.image.pixels.iter().copied().filter(|h| *h > 1.5).collect();
        assert!((lit.iter().sum::<f32>() / lit.len() as f32 - 2.0).abs() < 0.01);
    }

    #[test]
    fn a_gather_of_the_answer_is_the_answer_on_any_number_of_threads() {
        let enclosure = furnace();
        let tracer = Tracer::gather(&enclosure, 1, Exitance::Corners(vec![2.0; 96]), vec![], 1);
        let (emission, reflectance) = (vec![1.0; 24], vec![0.5; 24]);
        let surfaces = Surfaces::Radiance { emission: &emission, reflectance: &reflectance };
        let (eye, settings) = (camera(DVec3::new(0.1, 0.1, 0.4), 1.0), settings(20, 20, Effort::at_once(8)));
        let make = || trace(&tracer, surfaces, &eye, &settings, &Control::default()).unwrap();
        let traced = make();
        let truth = (2.0 * FRAC_1_PI) as f32;
        assert!(traced.image.pixels.iter().all(|v| (v / truth - 1.0).abs() < 1e-5), "{:?}", traced.image.pixels);
        assert!(traced.standard_error.pixels.iter().all(|e| e.is_nan()));
        let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        assert_eq!(one.install(make).image, traced.image);
    }

    #[test]
    fn cancelled_and_empty_pictures() {
        let enclosure = furnace();
        let tracer = Tracer::gather(&enclosure, 1, Exitance::Corners(vec![2.0; 96]), vec![], 1);
        let (eye, control) = (camera(DVec3::Z, 1.0), Control::default());
        let empty = trace(&tracer, Surfaces::Irradiance, &eye, &settings(0, 5, Effort::at_once(4)), &control).unwrap();
        assert!(empty.image.pixels.is_empty() && empty.rays == 0);
        control.cancel();
        let cancelled = trace(&tracer, Surfaces::Irradiance, &eye, &settings(5, 5, Effort::at_once(4)), &control);
        assert_eq!(cancelled.unwrap_err(), Cancelled);
    }
}
