//! The kernel for processors with AVX2: one 256-bit register for boxes, one 128-bit register for triangles.
//!
//! Soundness: [`Avx2`] is private to this file, so its registers exist only below the two entry points, and those are
//! reached only through [`super::Kernel::Avx2`], which a [`Bvh`] holds only on processors that have AVX2 and FMA.

use super::super::{Bvh, Hit, Ray, traverse};
use super::sse2::prefetch_lines;
use super::{Kernel, Lanes, Simd};
use std::arch::x86_64::*;

/// AVX2 registers.
struct Avx2;

impl Simd for Avx2 {
    type Wide = __m256;
    type Quad = __m128;

    #[inline(always)]
    fn prefetch<T>(value: &T) {
        prefetch_lines(value);
    }
}

pub(super) fn closest_hits(bvh: &Bvh, rays: &[Ray], hits: &mut [Hit]) {
    debug_assert!(Kernel::available().contains(&Kernel::Avx2));
    // SAFETY: a Bvh holds the AVX2 kernel only where `Kernel::available` lists it.
    unsafe { closest_hits_avx2(bvh, rays, hits) }
}

pub(super) fn occlusions(bvh: &Bvh, rays: &[Ray], occluded: &mut [bool]) {
    debug_assert!(Kernel::available().contains(&Kernel::Avx2));
    // SAFETY: a Bvh holds the AVX2 kernel only where `Kernel::available` lists it.
    unsafe { occlusions_avx2(bvh, rays, occluded) }
}

/// All of traversal is inlined here and so compiled for AVX2.
#[target_feature(enable = "avx2,fma")]
fn closest_hits_avx2(bvh: &Bvh, rays: &[Ray], hits: &mut [Hit]) {
    traverse::closest_hits::<Avx2>(bvh, rays, hits);
}

/// As [`closest_hits_avx2`].
#[target_feature(enable = "avx2,fma")]
fn occlusions_avx2(bvh: &Bvh, rays: &[Ray], occluded: &mut [bool]) {
    traverse::occlusions::<Avx2>(bvh, rays, occluded);
}

impl Lanes<8> for __m256 {
    #[inline(always)]
    fn splat(value: f32) -> Self {
        // SAFETY: runs only below an AVX2 entry point, see the head of this file.
        unsafe { _mm256_set1_ps(value) }
    }
    #[inline(always)]
    fn load(values: &[f32; 8]) -> Self {
        // SAFETY: as `splat`; the array holds the eight floats that an unaligned load reads.
        unsafe { _mm256_loadu_ps(values.as_ptr()) }
    }
    #[inline(always)]
    fn store(self, values: &mut [f32; 8]) {
        // SAFETY: as `splat`; the array holds the eight floats that an unaligned store writes.
        unsafe { _mm256_storeu_ps(values.as_mut_ptr(), self) }
    }
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        // SAFETY: as `splat`.
        unsafe { _mm256_add_ps(self, other) }
    }
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        // SAFETY: as `splat`.
        unsafe { _mm256_sub_ps(self, other) }
    }
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        // SAFETY: as `splat`.
        unsafe { _mm256_mul_ps(self, other) }
    }
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        // SAFETY: as `splat`.
        unsafe { _mm256_div_ps(self, other) }
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        // SAFETY: as `splat`.
        unsafe { _mm256_fmadd_ps(self, factor, term) }
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        // SAFETY: as `splat`.
        unsafe { _mm256_min_ps(self, other) }
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        // SAFETY: as `splat`.
        unsafe { _mm256_max_ps(self, other) }
    }
    #[inline(always)]
    fn le(self, other: Self) -> u32 {
        // SAFETY: as `splat`.
        unsafe { _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(self, other)) as u32 }
    }
}
