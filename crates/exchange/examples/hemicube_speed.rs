//! How fast hemicubes are beside as many rays, on a generated scene of 50,000 triangles.
//!
//!     cargo run --release -p radiosity-exchange --example hemicube_speed [resolution] [sides]
//!
//! Rays are as many as a hemicube's `3 R^2` pixels: once from the same points through the centres of the pixels, row by
//! row, and once cosine-distributed from all over a side, as the engine shoots them. All run on all cores. Every number
//! is the best of several runs, which take turns.

use glam::DVec3;
use radiosity_exchange::enclosure::Sight;
use radiosity_exchange::kernels::hemicube::{self, ItemBuffer, Settings};
use radiosity_exchange::{Enclosure, Samples, shots};
use radiosity_geometry::Patches;
use radiosity_geometry::bvh::{Hit, Ray};
use radiosity_operator::Control;
use rayon::prelude::*;
use std::time::Instant;

/// How often everything is measured.
const RUNS: usize = 4;

fn main() {
    let mut arguments = std::env::args().skip(1).map(|word| word.parse().expect("a whole number"));
    let resolution = arguments.next().unwrap_or(512);
    let count = arguments.next().unwrap_or(100);
    let enclosure = Enclosure::new(scene());
    let sides: Vec<_> = (0..count).map(|k| k * enclosure.sides() / count).collect();
    let settings = Settings { resolution, ..Settings::default() };
    println!("{} triangles, {} threads, {count} sides", enclosure.patches().len(), rayon::current_num_threads());
    println!("{} samples a side: resolution {resolution}", 3 * resolution * resolution);

    let buffers: Vec<_> =
        sides[..8.min(count)].iter().map(|&s| hemicube::item_buffer(&enclosure, s, &settings)).collect();
    let mut best = [f64::INFINITY; 3];
    for _ in 0..RUNS {
        let seconds = [
            time(|| draw(&enclosure, &sides, &settings)) / count as f64,
            time(|| cast_through_pixels(&enclosure, &buffers)) / buffers.len() as f64,
            time(|| cast_cosine(&enclosure, resolution)) / COSINE_SIDES as f64,
        ];
        best = std::array::from_fn(|k| best[k].min(seconds[k]));
    }
    let names = ["hemicubes", "rays through the pixels, row by row", "cosine-distributed rays"];
    let samples = (3 * resolution * resolution) as f64;
    for (name, seconds) in names.iter().zip(best) {
        println!(
            "{name:36} {:9.1} sides/s  {:8.2} Msamples/s  {:6.1} x",
            1.0 / seconds,
            1e-6 * samples / seconds,
            seconds / best[0]
        );
    }
}

fn time(work: impl FnOnce() -> f64) -> f64 {
    let start = Instant::now();
    assert!(work() > 0.0);
    start.elapsed().as_secs_f64()
}

fn draw(enclosure: &Enclosure, sides: &[usize], settings: &Settings) -> f64 {
    let rows = hemicube::rows_of(enclosure, sides, settings, &Control::default()).expect("nobody cancels");
    rows.entries.iter().map(|(_, f)| f).sum()
}

/// Casts the rays that a hemicube stands for, a row of pixels at a time.
fn cast_through_pixels(enclosure: &Enclosure, buffers: &[ItemBuffer]) -> f64 {
    buffers.par_iter().map(|buffer| cast_through(enclosure, buffer)).sum::<usize>() as f64
}

fn cast_through(enclosure: &Enclosure, buffer: &ItemBuffer) -> usize {
    let resolution = buffer.resolution;
    let off = buffer.position + 1e-6 * buffer.axes[2];
    let (mut rays, mut hits, mut seen) = (Vec::<Ray>::new(), vec![Hit::MISS; resolution], 0);
    for (face, owners) in buffer.owner.iter().enumerate() {
        for row in 0..owners.len() / resolution {
            rays.clear();
            rays.extend((0..resolution).map(|k| enclosure.ray(off, buffer.direction(face, row, k).as_vec3())));
            enclosure.bvh().closest_hits(&rays, &mut hits);
            let sights = rays.iter().zip(&hits).map(|(ray, hit)| enclosure.sight(ray.direction, hit));
            seen += sights.filter(|sight| matches!(sight, Sight::Side(..))).count();
        }
    }
    seen
}

/// How many sides' worth of rays are shot: spread over all sides, as the engine does it.
const COSINE_SIDES: usize = 8;

/// Casts as many rays as `COSINE_SIDES` hemicubes have pixels as rows of the exchange.
fn cast_cosine(enclosure: &Enclosure, resolution: usize) -> f64 {
    let mut shots = Samples::new(enclosure.sides(), 4);
    let mut wanted = vec![0; enclosure.sides()];
    let step = enclosure.sides() / COSINE_SIDES;
    for side in 0..COSINE_SIDES {
        wanted[side * step] = (3 * resolution * resolution / 4) as u32;
    }
    shots::shoot(enclosure, &mut shots, &wanted, 1, &Control::default()).expect("nobody cancels");
    shots.total() as f64
}

/// A room full of boxes and balls, all cut into triangles.
fn scene() -> Patches {
    let mut mesh = Mesh::default();
    mesh.cuboid(DVec3::ZERO, DVec3::new(8.0, 3.0, 6.0), 24, true);
    for k in 0..24 {
        let (column, row) = ((k % 6) as f64, (k / 6) as f64);
        let corner = DVec3::new(0.4 + 1.3 * column, 0.0, 0.5 + 1.4 * row);
        let size = DVec3::new(0.7, 0.3 + 0.1 * (k % 5) as f64, 0.8);
        mesh.cuboid(corner, corner + size, 8, false);
        mesh.ball(corner + DVec3::new(0.35, size.y + 0.35, 0.4), 0.3, 16);
    }
    let count = mesh.triangles.len();
    Patches::new(mesh.triangles, vec![0; count], (0..count as u32).collect(), vec![false; count])
}

#[derive(Default)]
struct Mesh {
    triangles: Vec<[DVec3; 4]>,
}

impl Mesh {
    /// A grid of `n` by `n` pairs of triangles over a bent parallelogram.
    fn grid(&mut self, n: [usize; 2], at: impl Fn(f64, f64) -> DVec3, flip: bool) {
        let point = |i: usize, j: usize| at(i as f64 / n[0] as f64, j as f64 / n[1] as f64);
        for (i, j) in (0..n[0]).flat_map(|i| (0..n[1]).map(move |j| (i, j))) {
            let [p, q, r, s] = [point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)];
            for [a, b, c] in [[p, q, r], [p, r, s]] {
                self.triangles.push(if flip { [a, c, b, b] } else { [a, b, c, c] });
            }
        }
    }

    /// Six walls of `n` by `n` squares, seen from inside or from outside.
    fn cuboid(&mut self, low: DVec3, high: DVec3, n: usize, inward: bool) {
        for (axis, upper) in (0..3).flat_map(|axis| [(axis, false), (axis, true)]) {
            let (j, k) = ((axis + 1) % 3, (axis + 2) % 3);
            let at = |s: f64, t: f64| {
                let mut p = if upper { high } else { low };
                p[j] = low[j] + s * (high[j] - low[j]);
                p[k] = low[k] + t * (high[k] - low[k]);
                p
            };
            self.grid([n, n], at, upper == inward);
        }
    }

    /// A ball of `2 n` by `n` quadrangles.
    fn ball(&mut self, centre: DVec3, radius: f64, n: usize) {
        let at = |s: f64, t: f64| {
            let (sin, cos) = (std::f64::consts::TAU * s).sin_cos();
            let (sine, cosine) = (std::f64::consts::PI * t).sin_cos();
            centre + radius * DVec3::new(sine * cos, cosine, sine * sin)
        };
        self.grid([2 * n, n], at, true);
    }
}
