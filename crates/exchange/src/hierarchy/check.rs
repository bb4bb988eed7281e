//! How wrong the products of an exchange are: against what rays find, from a few sides.

use crate::enclosure::Enclosure;
use crate::samples::Samples;
use crate::shots::{Shot, shoot};
use radiosity_operator::{Cancelled, Control};

/// Sides that are looked from: the estimate is good to about a tenth.
const SIDES: usize = 128;

/// Independent replicates of the rays, which tell how noisy they are themselves.
const REPLICATES: usize = 4;

/// Rays in each replicate.
const RAYS: (u32, u32) = (1 << 9, 1 << 14);

/// The error of rows falls with this power of the number of rays.
const RATE: f64 = 0.6;

/// Rows of a few sides, drawn in proportion to area, by rays that nothing else was made from.
#[derive(Clone, Debug)]
pub struct Check {
    sides: Vec<u32>,
    /// Rays of each side and replicate.
    each: usize,
    /// What each ray hit.
    targets: Vec<u32>,
}

/// What a check found of one column.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Deviation {
    /// Root mean square over area, less what the rays of the check may have added, and what chance may have hidden.
    pub error: f64,
    /// What all rows have in common of it, either way.
    pub bias: f64,
    /// The mean over area by rays.
    pub mean: f64,
}

impl Check {
    /// Looks from some sides, so often that an error of `tolerance` is seen.
    pub fn new(enclosure: &Enclosure, tolerance: f64, seed: u64, control: &Control) -> Result<Self, Cancelled> {
        let enough = (0.5 / tolerance).powf(1.0 / RATE) / REPLICATES as f64;
        let each = (enough as u32).next_power_of_two().clamp(RAYS.0, RAYS.1);
        let sides = by_area(enclosure);
        let mut wanted = vec![0; enclosure.sides()];
        sides.iter().for_each(|&side| wanted[side as usize] = each);
        let mut samples = Samples::<Shot>::new(enclosure.sides(), REPLICATES);
        // Another seed than that of rows which may be part of the same work.
        shoot(enclosure, &mut samples, &wanted, seed ^ 0x5bd1_e995_9d1d_ba3c, control)?;
        let targets =
            sides.iter().flat_map(|&side| samples.of(side as usize).flatten().map(|shot| shot.target())).collect();
        Ok(Self { sides, each: each as usize, targets })
    }

    /// How far `arriving`, what every side receives of `sent`, is from what rays say; blocks of sides x columns. What is
    /// buried under a solid receives nothing, and means are over all of a side.
    pub fn deviations(&self, sent: &[f64], arriving: &[f64], columns: usize) -> Vec<Deviation> {
        (0..columns)
            .map(|c| self.deviation(&|side| sent[side * columns + c], &|side| arriving[side * columns + c]))
            .collect()
    }

    fn deviation(&self, sent: &dyn Fn(usize) -> f64, arriving: &dyn Fn(usize) -> f64) -> Deviation {
        let (mut squares, mut mean, mut off) = (Vec::with_capacity(self.sides.len()), 0.0, 0.0);
        for (&side, targets) in self.sides.iter().zip(self.targets.chunks_exact(REPLICATES * self.each)) {
            let means: Vec<f64> = targets
                .chunks_exact(self.each)
                .map(|ts| {
                    ts.iter().map(|&t| if Shot::is_side(t) { sent(t as usize) } else { 0.0 }).sum::<f64>()
                        / self.each as f64
                })
                .collect();
            let n = REPLICATES as f64;
            let middle = means.iter().sum::<f64>() / n;
            let noise = means.iter().map(|m| (m - middle).powi(2)).sum::<f64>() / (n * (n - 1.0));
            squares.push((arriving(side as usize) - middle).powi(2) - noise);
            mean += middle;
            off += arriving(side as usize) - middle;
        }
        let n = squares.len().max(1) as f64;
        let square = squares.iter().sum::<f64>() / n;
        let spread = squares.iter().map(|s| (s - square).powi(2)).sum::<f64>() / (n * (n - 1.0).max(1.0));
        Deviation { error: (square.max(0.0) + spread.sqrt()).sqrt(), bias: (off / n).abs(), mean: mean / n }
    }

    /// Rays cast.
    pub fn rays(&self) -> usize {
        self.targets.len()
    }
}

/// Sides at equal steps of the area before them.
fn by_area(enclosure: &Enclosure) -> Vec<u32> {
    let whole: f64 = (0..enclosure.sides()).map(|side| enclosure.area(side)).sum();
    let count = SIDES.min(enclosure.sides());
    let (mut sides, mut before) = (Vec::with_capacity(count), 0.0);
    for side in 0..enclosure.sides() {
        before += enclosure.area(side);
        // A side of much area may be due more than once, and counts so often.
        while sides.len() < count && (sides.len() as f64 + 0.5) * whole < before * count as f64 {
            sides.push(side as u32);
        }
    }
    sides
}
