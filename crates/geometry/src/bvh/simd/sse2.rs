//! The kernel for every x86-64 processor: a pair of 128-bit registers for boxes, one for triangles.
//!
//! SSE2 is part of x86-64, so none of these intrinsics can meet a processor that lacks it.

use super::super::{Bvh, Hit, Ray, traverse};
use super::{Lanes, Simd};
use std::arch::x86_64::*;

/// SSE2 registers.
pub(super) struct Sse2;

impl Simd for Sse2 {
    type Wide = Pair;
    type Quad = __m128;

    #[inline(always)]
    fn prefetch<T>(value: &T) {
        prefetch_lines(value);
    }
}

pub(super) fn closest_hits(bvh: &Bvh, rays: &[Ray], hits: &mut [Hit]) {
    traverse::closest_hits::<Sse2>(bvh, rays, hits);
}

pub(super) fn occlusions(bvh: &Bvh, rays: &[Ray], occluded: &mut [bool]) {
    traverse::occlusions::<Sse2>(bvh, rays, occluded);
}

/// Fetches every cache line of a value.
#[inline(always)]
pub(super) fn prefetch_lines<T>(value: &T) {
    let start = std::ptr::from_ref(value).cast::<i8>();
    for offset in (0..size_of::<T>()).step_by(64) {
        // SAFETY: SSE is part of x86-64; a prefetch reads nothing and the address lies within the value.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(start.add(offset)) }
    }
}

impl Lanes<4> for __m128 {
    #[inline(always)]
    fn splat(value: f32) -> Self {
        // SAFETY: SSE is part of x86-64.
        unsafe { _mm_set1_ps(value) }
    }
    #[inline(always)]
    fn load(values: &[f32; 4]) -> Self {
        // SAFETY: SSE is part of x86-64; the array holds the four floats that an unaligned load reads.
        unsafe { _mm_loadu_ps(values.as_ptr()) }
    }
    #[inline(always)]
    fn store(self, values: &mut [f32; 4]) {
        // SAFETY: SSE is part of x86-64; the array holds the four floats that an unaligned store writes.
        unsafe { _mm_storeu_ps(values.as_mut_ptr(), self) }
    }
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        // SAFETY: SSE is part of x86-64.
        unsafe { _mm_add_ps(self, other) }
    }
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        // SAFETY: SSE is part of x86-64.
        unsafe { _mm_sub_ps(self, other) }
    }
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        // SAFETY: SSE is part of x86-64.
        unsafe { _mm_mul_ps(self, other) }
    }
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        // SAFETY: SSE is part of x86-64.
        unsafe { _mm_div_ps(self, other) }
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        self.mul(factor).add(term)
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        // SAFETY: SSE is part of x86-64.
        unsafe { _mm_min_ps(self, other) }
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        // SAFETY: SSE is part of x86-64.
        unsafe { _mm_max_ps(self, other) }
    }
    #[inline(always)]
    fn le(self, other: Self) -> u32 {
        // SAFETY: SSE is part of x86-64.
        unsafe { _mm_movemask_ps(_mm_cmple_ps(self, other)) as u32 }
    }
}

/// Eight lanes in two registers, the lower lanes first.
#[derive(Clone, Copy)]
pub(super) struct Pair(__m128, __m128);

impl Lanes<8> for Pair {
    #[inline(always)]
    fn splat(value: f32) -> Self {
        Self(__m128::splat(value), __m128::splat(value))
    }
    #[inline(always)]
    fn load(values: &[f32; 8]) -> Self {
        let [a, b, c, d, e, f, g, h] = *values;
        Self(__m128::load(&[a, b, c, d]), __m128::load(&[e, f, g, h]))
    }
    #[inline(always)]
    fn store(self, values: &mut [f32; 8]) {
        let (low, high) = values.split_at_mut(4);
        self.0.store(low.try_into().expect("four of eight"));
        self.1.store(high.try_into().expect("four of eight"));
    }
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(self.0.add(other.0), self.1.add(other.1))
    }
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(self.0.sub(other.0), self.1.sub(other.1))
    }
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self(self.0.mul(other.0), self.1.mul(other.1))
    }
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        Self(self.0.div(other.0), self.1.div(other.1))
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        self.mul(factor).add(term)
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(self.0.min(other.0), self.1.min(other.1))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(self.0.max(other.0), self.1.max(other.1))
    }
    #[inline(always)]
    fn le(self, other: Self) -> u32 {
        self.0.le(other.0) | (self.1.le(other.1) << 4)
    }
}
