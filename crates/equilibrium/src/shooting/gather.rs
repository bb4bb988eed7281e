//! Rays that ask what a cell sees, once all else is known roughly.
//!
//! Rays are spread over a cell and its hemisphere by one sequence per replicate, which goes on from round to round. A
//! ray brings all that its end sends but what luminaires send, and of what shines by the first bounce only the part
//! that shooting leaves to it (see `Sharing`).

use super::Context;
use super::cells::Cells;
use super::rays::Batch;
use radiosity_exchange::enclosure::Landing;
use radiosity_geometry::sampling::{Sequence, cosine_hemisphere};
use radiosity_operator::Cancelled;
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};

/// The stream of the sequence that feeds rays that gather.
const STREAM: u32 = 3;

/// What rays see of every cell.
pub(super) struct Seen {
    bands: usize,
    /// Per cell: radiosity by emission and direct light, all other, rays per m2 that shot the former, and what is
    /// changed, in the mean over bands, by not taking coarser cells.
    values: Vec<f32>,
}

impl Seen {
    pub fn new(bands: usize, cells: usize) -> Self {
        Self { bands, values: vec![0.0; cells * (2 * bands + 2)] }
    }

    /// Radiosity by emission and direct light, all other, and rays per m2 that shoot the former, cell by cell.
    pub fn of_mut(&mut self) -> impl Iterator<Item = (&mut [f32], &mut [f32], &mut f32)> {
        let bands = self.bands;
        self.values.chunks_exact_mut(2 * bands + 2).map(move |cell| {
            let (first, rest) = cell.split_at_mut(bands);
            let (rest, density) = rest.split_at_mut(bands);
            (first, rest, &mut density[0])
        })
    }

    /// Works out what coarser cells would change.
    pub fn compare(&mut self, cells: &Cells) {
        let (bands, stride) = (self.bands, 2 * self.bands + 2);
        let mean = |values: &[f32]| values[..2 * bands].iter().sum::<f32>() / bands as f32;
        let means: Vec<f32> = self.values.chunks_exact(stride).map(mean).collect();
        self.values.par_chunks_exact_mut(stride).enumerate().for_each(|(cell, values)| {
            let range = cells.coarser(cell);
            let count = range.len() as f32;
            values[stride - 1] = means[cell] - means[range].iter().sum::<f32>() / count;
        });
    }

    /// Adds what a ray of a cell with so many rays per m2 sees of `cell`; what coarser cells would change.
    #[inline]
    fn add(&self, cell: usize, gathered: f32, out: &mut [f64]) -> f64 {
        let bands = self.bands;
        let seen = &self.values[cell * (2 * bands + 2)..][..2 * bands + 2];
        let share = gathered / (gathered + seen[2 * bands]);
        for (b, o) in out.iter_mut().enumerate() {
            *o += f64::from(share * seen[b] + seen[bands + b]);
        }
        f64::from(seen[2 * bands + 1])
    }
}

/// What rays brought to the cells of one task.
#[derive(Default)]
struct Arrived {
    values: Vec<f64>,
    changed: Vec<f64>,
}

impl Arrived {
    fn clear(&mut self, cells: usize, bands: usize) {
        self.values.clear();
        self.values.resize(cells * bands, 0.0);
        self.changed.clear();
        self.changed.resize(cells, 0.0);
    }
}

/// One round of gathering by one replicate.
pub(super) struct Round<'a> {
    pub replicate: u32,
    /// Rays of a cell of level 0 before and after.
    pub rays: (u32, u32),
    /// A cell takes `2^level` times as many.
    pub levels: &'a [i8],
    /// Rays of this round per m2.
    pub density: &'a [f32],
    /// Rays that left the scene.
    pub escaped: &'a AtomicU64,
}

/// Where a round of gathering adds to.
pub(super) struct Sums<'a> {
    /// What rays brought, cells x bands.
    pub gathered: &'a mut [f32],
    /// What coarser cells would change, in the mean over bands.
    pub changed: &'a mut [f32],
    /// Rays that landed.
    pub landed: &'a mut [u32],
}

/// Rays of a cell of a level, when one of level 0 has `rays`.
pub(super) fn of_level(rays: u32, level: i8) -> u32 {
    if level >= 0 { rays << level } else { rays >> -level }
}

impl Round<'_> {
    /// Adds the mean of what the rays of each cell bring, times `weight`, to `sums`.
    pub fn gather(&self, context: &Context, seen: &Seen, weight: f64, sums: Sums) -> Result<(), Cancelled> {
        let bands = context.lighting.bands;
        let cells = (4096 / (self.rays.1 - self.rays.0).max(1)).clamp(1, 512) as usize;
        let Sums { gathered, changed, landed } = sums;
        let of_cells = changed.par_chunks_mut(cells).zip(landed.par_chunks_mut(cells));
        gathered.par_chunks_mut(cells * bands).zip(of_cells).enumerate().try_for_each_init(
            || (Batch::default(), Arrived::default()),
            |(batch, arrived), (task, (gathered, (changed, landed)))| {
                context.control.check()?;
                arrived.clear(landed.len(), bands);
                let first = task * cells;
                let mut shot = 0;
                for k in 0..landed.len() {
                    shot += self.load(context, first + k, k as u32, batch, |batch| {
                        self.trace(context, seen, first, batch, arrived, landed);
                    });
                }
                self.trace(context, seen, first, batch, arrived, landed);
                for k in 0..landed.len() {
                    let scale = weight / f64::from(self.new_rays(first + k).max(1));
                    let values = gathered[k * bands..].iter_mut().zip(&arrived.values[k * bands..][..bands]);
                    values.for_each(|(g, a)| *g += (scale * a) as f32);
                    changed[k] += (scale * arrived.changed[k]) as f32;
                }
                context.control.advance(shot);
                Ok(())
            },
        )
    }

    fn new_rays(&self, cell: usize) -> u32 {
        of_level(self.rays.1, self.levels[cell]) - of_level(self.rays.0, self.levels[cell])
    }

    /// Makes the rays of a cell; `trace` is called whenever the batch is full.
    fn load(
        &self,
        context: &Context,
        cell: usize,
        tag: u32,
        batch: &mut Batch,
        mut trace: impl FnMut(&mut Batch),
    ) -> u64 {
        if context.cells.area(cell) == 0.0 {
            return 0;
        }
        let sequence = Sequence::new(context.seed, cell as u32, self.replicate, STREAM);
        let frame = context.cells.frame(cell);
        let level = self.levels[cell];
        for index in of_level(self.rays.0, level)..of_level(self.rays.1, level) {
            let [u, v, s, t] = sequence.point(index);
            let origin = context.cells.point_off(cell, s, t);
            batch.push(context.cells.enclosure.ray(origin, cosine_hemisphere(&frame, u, v)), tag);
            if batch.is_full() {
                trace(batch);
            }
        }
        u64::from(self.new_rays(cell))
    }

    fn trace(
        &self,
        context: &Context,
        seen: &Seen,
        first: usize,
        batch: &mut Batch,
        arrived: &mut Arrived,
        landed: &mut [u32],
    ) {
        let bands = context.lighting.bands;
        let mut escaped = 0;
        batch.trace(context.cells, |tag, _, landing| match landing {
            Landing::Escaped => escaped += 1,
            Landing::Back => {}
            Landing::Side(target) => {
                let k = tag as usize;
                landed[k] += 1;
                let values = &mut arrived.values[k * bands..][..bands];
                arrived.changed[k] += seen.add(target as usize, self.density[first + k], values);
            }
        });
        self.escaped.fetch_add(escaped, Ordering::Relaxed);
    }
}
