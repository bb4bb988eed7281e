//! Pictures by random paths from every point that is seen.

use radiosity_exchange::images::survival;
use radiosity_geometry::bvh::{Hit, Ray};
use radiosity_geometry::sampling::Sequence;
use radiosity_operator::{Cancelled, Control};
use radiosity_paths::{Effort, Means, Rounds, Start, Tracer, Walk};
use radiosity_scene::Camera;
use rayon::prelude::*;

use crate::Image;
use crate::eye::{Eye, Point, Surfaces};

/// How a traced picture is made.
#[derive(Clone, Debug, PartialEq)]
pub struct TraceSettings {
    /// Pixels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Paths per pixel.
    pub effort: Effort,
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
    let eye = Eye::new(tracer, surfaces, camera, (width, height), settings.culls_backs);
    let film = Film { tracer, eye, width, each: settings.effort.per_round };
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
    eye: Eye<'a>,
    width: usize,
    /// Paths per pixel and round.
    each: u32,
}

/// Buffers of one thread.
#[derive(Default)]
struct Buffers {
    rays: Vec<Ray>,
    hits: Vec<Hit>,
    starts: Vec<Start>,
    /// The pixel within the tile and the point that each path starts for.
    owners: Vec<(u32, Point)>,
    irradiance: Vec<f32>,
    /// What lamps show in a metal.
    glow: Vec<f32>,
    pixels: Vec<f64>,
    walk: Walk,
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
            tile.rays += buffers.rays.len() as u64;
        }
        tile.rays += buffers.walk.rays_traced - before;
        let share = 1.0 / f64::from(self.each);
        buffers.pixels.iter_mut().for_each(|value| *value *= share);
        tile.means.add(&buffers.pixels);
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
            let sequence = Sequence::new(self.tracer.seed(), self.key((x, y)), round, STREAM);
            buffers.rays.extend((0..self.each).map(|index| {
                let [u, v, ..] = sequence.point(index);
                self.eye.ray(x as f64 + u, y as f64 + v)
            }));
        }
        buffers.hits.resize(buffers.rays.len(), Hit::MISS);
        self.eye.closest_hits(&buffers.rays, &mut buffers.hits);
    }

    /// Adds what surfaces emit that were seen, and has paths start from them.
    fn begin(&self, buffers: &mut Buffers, tile: &Tile, pixels: std::ops::Range<usize>, round: u32) {
        let (bands, each) = (self.tracer.bands(), self.each as usize);
        buffers.starts.clear();
        buffers.owners.clear();
        let seen = buffers.rays.chunks_exact(each).zip(buffers.hits.chunks_exact(each));
        for (pixel, (rays, hits)) in pixels.zip(seen) {
            let key = self.key(self.place(tile, pixel));
            let sequence = Sequence::new(self.tracer.seed(), key, round, SPECULAR);
            for ((ray, hit), index) in rays.iter().zip(hits).zip(0..) {
                let seen = self.eye.seen(ray, hit, |met| survival(&sequence, index, met));
                buffers.glow.clear();
                buffers.glow.resize(bands, 0.0);
                let draw = ((key, index), round);
                let seen = seen.and_then(|point| self.eye.by_metal(point, draw, &mut buffers.glow));
                let sums = &mut buffers.pixels[pixel * bands..][..bands];
                sums.iter_mut().zip(&buffers.glow).for_each(|(sum, &glow)| *sum += f64::from(glow));
                let Some(point) = seen else { continue };
                sums.iter_mut().zip(self.eye.emitted(&point)).for_each(|(sum, e)| *sum += f64::from(e));
                let points = [Some(point), self.eye.across(&point)];
                for point in points.into_iter().flatten().filter(|point| self.eye.reflects(point)) {
                    buffers.starts.push(Start { point: point.at, normal: self.eye.normal(&point), key, index });
                    buffers.owners.push((pixel as u32, point));
                }
            }
        }
    }

    /// Adds what is reflected of what arrives.
    fn reflect(&self, buffers: &mut Buffers) {
        let bands = self.tracer.bands();
        for ((pixel, point), found) in buffers.owners.iter().zip(buffers.irradiance.chunks_exact(bands)) {
            let sums = &mut buffers.pixels[*pixel as usize * bands..][..bands];
            let shown = self.eye.shares(point).zip(found).map(|(share, h)| f64::from(share * h));
            sums.iter_mut().zip(shown).for_each(|(sum, shown)| *sum += shown);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_1_PI;

    use glam::DVec3;
    use radiosity_exchange::Enclosure;
    use radiosity_geometry::Patches;
    use radiosity_paths::Exitance;

    use super::*;
    use crate::test_scenes::{camera, cube};

    fn settings(width: usize, height: usize, effort: Effort) -> TraceSettings {
        TraceSettings { width, height, effort, culls_backs: true }
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
        let (eye, settings) = (camera(DVec3::new(0.2, 0.3, 2.0), 0.4), settings(21, 18, Effort::of_samples(1024)));
        let surfaces = Surfaces::Radiance { emission: &ones, reflectance: &half, transmittance: &[] };
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
        // Of Student's t with fifteen degrees of freedom it is 15 / 13, and paths of few lengths are no normal numbers.
        assert!((0.85..1.6).contains(&mean_square), "{mean_square}");
        assert!(traced.rounds.error < 0.02 && traced.rounds.samples == 1024 && traced.rays > 21 * 18 * 1024);
        let irradiance = trace(&tracer, Surfaces::Irradiance, &eye, &settings, &Control::default()).unwrap();
        let lit: Vec<f32> = irradiance.image.pixels.iter().copied().filter(|h| *h > 1.5).collect();
        assert!((lit.iter().sum::<f32>() / lit.len() as f32 - 2.0).abs() < 0.01);
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
