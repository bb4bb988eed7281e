//! The nodes that a ray has yet to visit.

use super::node::{Child, WIDTH};
use std::mem::MaybeUninit;

/// The deepest tree that [`Stack`] serves; the builder keeps trees shallower.
pub(super) const MAX_DEPTH: usize = 72;
const CAPACITY: usize = MAX_DEPTH * (WIDTH - 1) + 8;

/// A child and the distance at which the ray enters its box, in one integer that sorts by distance.
///
/// Distances are never negative, so their bit patterns sort as the numbers do.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[repr(transparent)]
pub(super) struct Entry(u64);

impl Entry {
    #[inline(always)]
    pub fn new(near: f32, child: Child) -> Self {
        Self(u64::from(near.to_bits()) << 32 | u64::from(child.0))
    }
    #[inline(always)]
    pub fn near(self) -> f32 {
        f32::from_bits((self.0 >> 32) as u32)
    }
    #[inline(always)]
    pub fn child(self) -> Child {
        Child(self.0 as u32)
    }
}

/// A stack of fixed size that is never cleaned.
pub(super) struct Stack {
    entries: [MaybeUninit<Entry>; CAPACITY],
    len: usize,
}

impl Stack {
    pub const fn new() -> Self {
        Self { entries: [const { MaybeUninit::uninit() }; CAPACITY], len: 0 }
    }

    #[inline(always)]
    pub fn clear(&mut self) {
        self.len = 0;
    }

    #[inline(always)]
    pub fn push(&mut self, entry: Entry) {
        self.entries[self.len].write(entry);
        self.len += 1;
    }

    #[inline(always)]
    pub fn pop(&mut self) -> Option<Entry> {
        self.len = self.len.checked_sub(1)?;
        // SAFETY: every entry below the old length has been written by `push`.
        Some(unsafe { self.entries[self.len].assume_init() })
    }

    /// Sorts the top `count` entries so that the nearest is popped first.
    #[inline(always)]
    pub fn sort_top(&mut self, count: usize) {
        let top = &mut self.entries[self.len - count..self.len];
        for i in 1..top.len() {
            // SAFETY: every entry below the length has been written by `push`.
            let moving = unsafe { top[i].assume_init() };
            let mut slot = i;
            // SAFETY: as above.
            while slot > 0 && unsafe { top[slot - 1].assume_init() } < moving {
                top[slot] = top[slot - 1];
                slot -= 1;
            }
            top[slot] = MaybeUninit::new(moving);
        }
    }
}
