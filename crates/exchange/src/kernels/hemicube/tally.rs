//! From item buffers to form factors: the delta form factors of every owner's pixels, added up.

use super::delta::Strips;
use super::face::{Grid, TOP};
use super::merge::LANES;
use super::raster::Pixels;

/// Sums over the pixels of each owner.
pub(super) struct Tally {
    sums: Vec<f64>,
    /// A bit for every owner with a sum, so that those without cost nothing to skip and order comes by itself.
    seen: Vec<u64>,
}

impl Tally {
    /// For owners below `owners`.
    pub fn new(owners: usize) -> Self {
        Self { sums: vec![0.0; owners], seen: vec![0; owners.div_ceil(64)] }
    }

    /// Adds the pixels of a face, run by run.
    #[inline(always)]
    pub fn add(&mut self, face: usize, grid: &Grid, strips: &Strips, pixels: &Pixels) {
        let strips = if face == TOP { &strips.top } else { &strips.side };
        for (row, strip) in strips.chunks_exact(grid.columns + 1).enumerate() {
            self.add_row(pixels.owners(row), strip);
        }
    }

    /// `strip[k]` is what the pixels before `k` are worth together. What follows the last pixel ends its run.
    #[inline(always)]
    fn add_row(&mut self, owners: &[u32], strip: &[f64]) {
        let columns = strip.len() - 1;
        let (here, next) = (owners.as_chunks::<LANES>().0, owners[1..].as_chunks::<LANES>().0);
        let mut before = 0.0;
        for (chunk, (here, next)) in here.iter().zip(next).take(columns.div_ceil(LANES)).enumerate() {
            let mut ends = run_ends(here, next);
            while ends != 0 {
                let lane = ends.trailing_zeros() as usize;
                ends &= ends - 1;
                let after = strip[chunk * LANES + lane + 1];
                self.add_run(here[lane], after - before);
                before = after;
            }
        }
    }

    #[inline(always)]
    fn add_run(&mut self, owner: u32, worth: f64) {
        let sum = &mut self.sums[owner as usize];
        if *sum == 0.0 {
            self.seen[owner as usize / 64] |= 1 << (owner % 64);
        }
        *sum += worth;
    }

    /// Takes the sums of owners below `sides`, times `scale`, in ascending order, and begins anew.
    pub fn take(&mut self, sides: usize, scale: f64) -> Vec<(u32, f64)> {
        let count = self.seen.iter().map(|word| word.count_ones() as usize).sum();
        let mut row = Vec::with_capacity(count);
        for (k, word) in self.seen.iter_mut().enumerate() {
            let mut bits = std::mem::take(word);
            while bits != 0 {
                let owner = k * 64 + bits.trailing_zeros() as usize;
                bits &= bits - 1;
                let sum = std::mem::take(&mut self.sums[owner]);
                if owner < sides {
                    row.push((owner as u32, sum * scale));
                }
            }
        }
        row
    }
}

/// A bit for every pixel whose right neighbour has another owner.
#[inline(always)]
fn run_ends(here: &[u32; LANES], next: &[u32; LANES]) -> u32 {
    let mut ends = 0;
    for k in 0..LANES {
        ends |= u32::from(here[k] != next[k]) << k;
    }
    ends
}
