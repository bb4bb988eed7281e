//! Irradiance at points and of whole sides, with standard errors.

use glam::DVec3;
use radiosity_geometry::sampling::Sequence;
use radiosity_operator::{Cancelled, Control};
use rayon::prelude::*;

use crate::means::Means;
use crate::rounds::{Effort, Rounds, rounds};
use crate::tracer::{Start, Tracer};
use crate::walk::Walk;

/// Irradiance as it was measured.
#[derive(Clone, Debug)]
pub struct Measured {
    /// Places x bands, W/m2.
    pub irradiance: Vec<f64>,
    /// Likewise; NaN after one round.
    pub standard_error: Vec<f64>,
    /// How it went. The error is that of all places, root mean square, relative to the mean.
    pub rounds: Rounds,
    /// Rays traced.
    pub rays: u64,
}

/// The stream of the sequence that spreads starts over a side.
const STREAM: u32 = 8;

/// About how many paths one thread walks at once.
const AT_ONCE: usize = 4096;

/// Irradiance at points of surfaces, or in the open, about unit normals.
///
/// # Errors
/// If `control` is cancelled.
///
/// # Panics
/// If there are not as many normals as points.
pub fn at_points(
    tracer: &Tracer,
    points: &[DVec3],
    normals: &[DVec3],
    effort: &Effort,
    control: &Control,
) -> Result<Measured, Cancelled> {
    assert_eq!(points.len(), normals.len(), "one normal per point");
    let weight = vec![1.0; points.len()];
    measure(tracer, &weight, effort, control, Walk::irradiance, |place, _, index| Start {
        point: tracer.enclosure.before(points[place], normals[place]),
        normal: normals[place],
        key: place as u32,
        index,
    })
}

/// Mean irradiance of every side; what a solid stands on counts as dark.
///
/// # Errors
/// If `control` is cancelled.
pub fn of_sides(tracer: &Tracer, effort: &Effort, control: &Control) -> Result<Measured, Cancelled> {
    measure(tracer, &areas(tracer), effort, control, Walk::irradiance, |side, round, index| {
        on_side(tracer, side, round, index)
    })
}

/// What of that [`Walk::direct`] counts.
///
/// # Errors
/// If `control` is cancelled.
pub fn direct_of_sides(tracer: &Tracer, effort: &Effort, control: &Control) -> Result<Measured, Cancelled> {
    measure(tracer, &areas(tracer), effort, control, Walk::direct, |side, round, index| {
        on_side(tracer, side, round, index)
    })
}

/// What of that [`Walk::rest`] counts.
///
/// # Errors
/// If `control` is cancelled.
pub fn rest_of_sides(tracer: &Tracer, effort: &Effort, control: &Control) -> Result<Measured, Cancelled> {
    measure(tracer, &areas(tracer), effort, control, Walk::rest, |side, round, index| {
        on_side(tracer, side, round, index)
    })
}

fn areas(tracer: &Tracer) -> Vec<f64> {
    (0..tracer.enclosure.sides()).map(|side| tracer.enclosure.area(side)).collect()
}

/// A start on a side.
fn on_side(tracer: &Tracer, side: usize, round: u32, index: u32) -> Start {
    let enclosure = tracer.enclosure;
    let [s, t, ..] = Sequence::new(tracer.seed, side as u32, round, STREAM).point(index);
    Start { point: enclosure.point_off(side, s, t), normal: enclosure.normal(side), key: side as u32, index }
}

/// Which part of what arrives is estimated.
type Estimate = fn(&mut Walk, &Tracer, &[Start], u32, &mut [f32]);

/// Some places next to one another.
struct Block {
    first: usize,
    means: Means,
    rays: u64,
}

fn measure(
    tracer: &Tracer,
    weight: &[f64],
    effort: &Effort,
    control: &Control,
    estimate: Estimate,
    start: impl Fn(usize, u32, u32) -> Start + Sync,
) -> Result<Measured, Cancelled> {
    let (bands, at_once) = (tracer.bands, (AT_ONCE / effort.per_round as usize).max(1));
    let mut blocks: Vec<Block> = (0..weight.len())
        .step_by(at_once)
        .map(|first| {
            let means = Means::new(at_once.min(weight.len() - first) * bands);
            Block { first, means, rays: 0 }
        })
        .collect();
    let steps = blocks.len() as u64;
    let rounds = rounds(effort, steps, control, |round| {
        blocks.par_iter_mut().try_for_each_init(Buffers::default, |buffers, block| {
            control.check()?;
            let places = (block.first..).take(block.means.mean().len() / bands.max(1));
            let starts = places.flat_map(|place| (0..effort.per_round).map(move |index| (place, index)));
            buffers.starts.clear();
            buffers.starts.extend(starts.map(|(place, index)| start(place, round, index)));
            buffers.measure(tracer, estimate, (effort.per_round, round), block);
            control.advance(1);
            Ok(())
        })?;
        Ok(error(&blocks, weight, bands))
    })?;
    Ok(Measured {
        irradiance: blocks.iter().flat_map(|block| block.means.mean()).copied().collect(),
        standard_error: blocks.iter().flat_map(|block| block.means.variance()).map(f64::sqrt).collect(),
        rounds,
        rays: blocks.iter().map(|block| block.rays).sum(),
    })
}

#[derive(Default)]
struct Buffers {
    walk: Walk,
    starts: Vec<Start>,
    found: Vec<f32>,
    sums: Vec<f64>,
}

impl Buffers {
    /// Adds a round to a block whose starts are there.
    fn measure(&mut self, tracer: &Tracer, estimate: Estimate, (per_round, round): (u32, u32), block: &mut Block) {
        let (bands, each) = (tracer.bands, per_round as usize);
        let before = self.walk.rays_traced;
        self.found.resize(self.starts.len() * bands, 0.0);
        estimate(&mut self.walk, tracer, &self.starts, round, &mut self.found);
        self.sums.clear();
        self.sums.resize(block.means.mean().len(), 0.0);
        for (sums, found) in
            self.sums.chunks_exact_mut(bands.max(1)).zip(self.found.chunks_exact((bands * each).max(1)))
        {
            for found in found.chunks_exact(bands) {
                sums.iter_mut().zip(found).for_each(|(sum, &f)| *sum += f64::from(f) / each as f64);
            }
        }
        block.means.add(&self.sums);
        block.rays += self.walk.rays_traced - before;
    }
}

/// Root mean square of the standard errors over the mean, by weight.
fn error(blocks: &[Block], weight: &[f64], bands: usize) -> f64 {
    let of_all = weight.iter().flat_map(|w| std::iter::repeat_n(*w, bands));
    let values = blocks.iter().flat_map(|block| block.means.mean().iter().copied().zip(block.means.variance()));
    let (mut mean, mut square, mut total) = (0.0, 0.0, 0.0);
    for ((value, variance), w) in values.zip(of_all).filter(|(_, w)| *w > 0.0) {
        mean += w * value;
        square += w * variance;
        total += w;
    }
    if mean > 0.0 { (square / total).sqrt() / (mean / total) } else { square }
}
