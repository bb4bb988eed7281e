//! Samples of every side, kept in the rounds they were taken in.

use radiosity_operator::{Cancelled, Control};
use rayon::prelude::*;

/// Items drawn per side in independent replicates, added round by round.
///
/// Within a round the items of a side are contiguous, replicate after replicate, equally many in each.
#[derive(Clone, Debug)]
pub struct Samples<T> {
    replicates: usize,
    /// Samples per replicate drawn so far, per side.
    drawn: Vec<u32>,
    rounds: Vec<Round<T>>,
}

#[derive(Clone, Debug)]
struct Round<T> {
    /// Where the items of each side start; one more than sides.
    offsets: Vec<usize>,
    items: Vec<T>,
}

impl<T: Copy + Default + Send + Sync> Samples<T> {
    /// No samples yet.
    pub fn new(sides: usize, replicates: usize) -> Self {
        Self { replicates, drawn: vec![0; sides], rounds: Vec::new() }
    }

    /// The number of independent replicates.
    pub fn replicates(&self) -> usize {
        self.replicates
    }

    /// Samples per replicate of a side.
    pub fn per_replicate(&self, side: usize) -> u32 {
        self.drawn[side]
    }

    /// All samples of all sides.
    pub fn total(&self) -> usize {
        self.rounds.iter().map(|r| r.items.len()).sum()
    }

    /// Bytes held.
    pub fn memory_bytes(&self) -> usize {
        self.rounds.iter().map(|r| r.items.len() * size_of::<T>() + r.offsets.len() * size_of::<usize>()).sum()
    }

    /// Adds a round that brings side `i` to `wanted[i]` samples per replicate.
    ///
    /// `draw(scratch, side, first, items)` fills `items` with samples `first..` of all replicates, replicate after
    /// replicate. `scratch` is made once per worker.
    pub fn draw<S: Send>(
        &mut self,
        wanted: &[u32],
        control: &Control,
        scratch: impl Fn() -> S + Sync + Send,
        draw: impl Fn(&mut S, usize, u32, &mut [T]) + Sync + Send,
    ) -> Result<(), Cancelled> {
        let mut offsets = Vec::with_capacity(wanted.len() + 1);
        offsets.push(0);
        for (wanted, drawn) in wanted.iter().zip(&self.drawn) {
            offsets.push(offsets.last().unwrap() + wanted.saturating_sub(*drawn) as usize * self.replicates);
        }
        let mut items = vec![T::default(); *offsets.last().unwrap()];
        split(&mut items, &offsets).into_par_iter().enumerate().with_max_len(64).try_for_each_init(
            scratch,
            |scratch, (side, items)| {
                control.check()?;
                if !items.is_empty() {
                    draw(scratch, side, self.drawn[side], items);
                }
                control.advance(items.len() as u64);
                Ok(())
            },
        )?;
        for (drawn, wanted) in self.drawn.iter_mut().zip(wanted) {
            *drawn = (*drawn).max(*wanted);
        }
        self.rounds.push(Round { offsets, items });
        Ok(())
    }

    /// The samples of one replicate of a side, a slice per round.
    pub fn replicate(&self, side: usize, replicate: usize) -> impl Iterator<Item = &[T]> {
        self.rounds.iter().map(move |round| {
            let all = &round.items[round.offsets[side]..round.offsets[side + 1]];
            let each = all.len() / self.replicates;
            &all[replicate * each..(replicate + 1) * each]
        })
    }

    /// All samples of a side, a slice per round.
    pub fn of(&self, side: usize) -> impl Iterator<Item = &[T]> {
        self.rounds.iter().map(move |round| &round.items[round.offsets[side]..round.offsets[side + 1]])
    }

    /// The first `most` samples of every replicate of a side.
    pub fn first(&self, side: usize, most: usize) -> impl Iterator<Item = &T> {
        (0..self.replicates).flat_map(move |k| self.replicate(side, k).flatten().take(most))
    }
}

/// Cuts a slice at the offsets.
fn split<'a, T>(mut items: &'a mut [T], offsets: &[usize]) -> Vec<&'a mut [T]> {
    offsets
        .windows(2)
        .map(|w| {
            let (head, tail) = std::mem::take(&mut items).split_at_mut(w[1] - w[0]);
            items = tail;
            head
        })
        .collect()
}
