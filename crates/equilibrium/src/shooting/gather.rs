//! Rays that ask what a side sees, once all else is known roughly.
//!
//! Rays are spread over a side and its hemisphere by one sequence per replicate, which goes on from round to round. A
//! ray brings all that its end sends but what luminaires send, and of what shines by the first bounce only the part
//! that shooting leaves to it (see `Sharing`).

use super::Context;
use super::rays::Batch;
use radiosity_exchange::enclosure::Landing;
use radiosity_geometry::sampling::{Sequence, cosine_hemisphere};
use radiosity_operator::Cancelled;
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};

/// The stream of the sequence that feeds rays that gather.
const STREAM: u32 = 3;

/// What rays see of every side.
pub(super) struct Seen {
    bands: usize,
    /// Per side: radiosity by emission and direct light, all other, rays per m2 that shot the former.
    values: Vec<f32>,
}

impl Seen {
    pub fn new(bands: usize, sides: usize) -> Self {
        Self { bands, values: vec![0.0; sides * (2 * bands + 1)] }
    }

    pub fn of_mut(&mut self) -> impl Iterator<Item = (&mut [f32], &mut [f32], &mut f32)> {
        let bands = self.bands;
        self.values.chunks_exact_mut(2 * bands + 1).map(move |side| {
            let (first, rest) = side.split_at_mut(bands);
            let (rest, density) = rest.split_at_mut(bands);
            (first, rest, &mut density[0])
        })
    }

    /// Adds what a ray of a side with so many rays per m2 sees of `side`.
    #[inline]
    fn add(&self, side: usize, gathered: f32, out: &mut [f64]) {
        let bands = self.bands;
        let seen = &self.values[side * (2 * bands + 1)..][..2 * bands + 1];
        let share = gathered / (gathered + seen[2 * bands]);
        for (b, o) in out.iter_mut().enumerate() {
            *o += f64::from(share * seen[b] + seen[bands + b]);
        }
    }
}

/// One round of gathering by one replicate.
pub(super) struct Round<'a> {
    pub replicate: u32,
    /// Rays of a side of level 0 before and after.
    pub rays: (u32, u32),
    /// A side takes `2^level` times as many.
    pub levels: &'a [i8],
    /// Rays of this round per m2.
    pub density: &'a [f32],
    /// Rays that left the scene.
    pub escaped: &'a AtomicU64,
}

/// Rays of a side of a level, when one of level 0 has `rays`.
pub(super) fn of_level(rays: u32, level: i8) -> u32 {
    if level >= 0 { rays << level } else { rays >> -level }
}

impl Round<'_> {
    /// The mean of what rays bring of each side, times `weight`, is added to `sums` (sides x bands), and the rays that
    /// landed to `landed`.
    pub fn gather(
        &self,
        context: &Context,
        seen: &Seen,
        weight: f64,
        sums: &mut [f32],
        landed: &mut [u32],
    ) -> Result<(), Cancelled> {
        let bands = context.lighting.bands;
        let sides = (4096 / (self.rays.1 - self.rays.0).max(1)).clamp(1, 512) as usize;
        sums.par_chunks_mut(sides * bands).zip(landed.par_chunks_mut(sides)).enumerate().try_for_each_init(
            || (Batch::default(), Vec::new()),
            |(batch, arrived), (task, (sums, landed))| {
                context.control.check()?;
                arrived.clear();
                arrived.resize(sums.len(), 0.0);
                let first = task * sides;
                let mut shot = 0;
                for k in 0..landed.len() {
                    shot += self.load(context, first + k, k as u32, batch, |batch| {
                        self.trace(context, seen, first, batch, arrived, landed);
                    });
                }
                self.trace(context, seen, first, batch, arrived, landed);
                for (k, (sum, arrived)) in sums.iter_mut().zip(&*arrived).enumerate() {
                    let rays = self.new_rays(first + k / bands);
                    *sum += (arrived * weight / f64::from(rays.max(1))) as f32;
                }
                context.control.advance(shot);
                Ok(())
            },
        )
    }

    fn new_rays(&self, side: usize) -> u32 {
        of_level(self.rays.1, self.levels[side]) - of_level(self.rays.0, self.levels[side])
    }

    /// Makes the rays of a side; `trace` is called whenever the batch is full.
    fn load(
        &self,
        context: &Context,
        side: usize,
        tag: u32,
        batch: &mut Batch,
        mut trace: impl FnMut(&mut Batch),
    ) -> u64 {
        if context.enclosure.area(side) == 0.0 {
            return 0;
        }
        let sequence = Sequence::new(context.seed, side as u32, self.replicate, STREAM);
        let frame = context.enclosure.frame(side);
        let level = self.levels[side];
        for index in of_level(self.rays.0, level)..of_level(self.rays.1, level) {
            let [u, v, s, t] = sequence.point(index);
            batch.push(context.enclosure.ray(context.enclosure.point_off(side, s, t), cosine_hemisphere(&frame, u, v)), tag);
            if batch.is_full() {
                trace(batch);
            }
        }
        u64::from(self.new_rays(side))
    }

    fn trace(
        &self,
        context: &Context,
        seen: &Seen,
        first: usize,
        batch: &mut Batch,
        arrived: &mut [f64],
        landed: &mut [u32],
    ) {
        let bands = context.lighting.bands;
        let mut escaped = 0;
        batch.trace(context.enclosure, |tag, _, landing| match landing {
            Landing::Escaped => escaped += 1,
            Landing::Back => {}
            Landing::Side(target) => {
                let k = tag as usize;
                landed[k] += 1;
                seen.add(target as usize, self.density[first + k], &mut arrived[k * bands..][..bands]);
            }
        });
        self.escaped.fetch_add(escaped, Ordering::Relaxed);
    }
}
