//! The vector operations that traversal needs, once per instruction set.
//!
//! Traversal is written once, generic over [`Simd`]. On triangles every instruction set performs the same IEEE operations
//! in the same order, and none of them fuses a multiplication with an addition, so all kernels return the same bits.
//! Boxes may be tested by fused operations: what rounding changes there lies within the margin of the test.
//!
//! Vectors must not pass through closures in traversal: those are compiled without the features of the entry point
//! unless they happen to be inlined.

#[cfg(target_arch = "x86_64")]
mod avx2;
mod plain;
#[cfg(target_arch = "x86_64")]
mod sse2;

use super::{Bvh, Hit, Ray};

/// An instruction set that traversal can run on.
///
/// All kernels return identical hits, bit for bit; they differ in speed alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Kernel {
    /// Portable arrays, which the compiler vectorises as it can (NEON on aarch64).
    Plain,
    /// Pairs of 128-bit registers; every x86-64 processor has them.
    Sse2,
    /// 256-bit registers, on x86-64 processors since about 2013.
    Avx2,
}

impl Kernel {
    /// The fastest kernel of the processor at hand.
    pub fn detect() -> Self {
        *Self::available().last().expect("the plain kernel runs everywhere")
    }

    /// The kernels that the processor at hand can run, slowest first.
    pub fn available() -> &'static [Self] {
        #[cfg(target_arch = "x86_64")]
        {
            if std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("fma") {
                &[Self::Plain, Self::Sse2, Self::Avx2]
            } else {
                &[Self::Plain, Self::Sse2]
            }
        }
        #[cfg(not(target_arch = "x86_64"))]
        {
            &[Self::Plain]
        }
    }
}

/// `N` single-precision numbers that are worked on together.
///
/// Comparisons follow IEEE: nothing is `le` a NaN. `min` and `max` return the second operand when either is a NaN, as
/// the x86 instructions do.
pub(super) trait Lanes<const N: usize>: Copy {
    fn splat(value: f32) -> Self;
    fn load(values: &[f32; N]) -> Self;
    fn store(self, values: &mut [f32; N]);
    fn add(self, other: Self) -> Self;
    fn sub(self, other: Self) -> Self;
    fn mul(self, other: Self) -> Self;
    fn div(self, other: Self) -> Self;
    /// `self * factor + term`, rounded once or twice: for box tests alone, whose margin covers either.
    fn mul_add(self, factor: Self, term: Self) -> Self;
    /// `self < other ? self : other`.
    fn min(self, other: Self) -> Self;
    /// `self > other ? self : other`.
    fn max(self, other: Self) -> Self;
    /// One bit per lane, lane 0 lowest: `self <= other`.
    fn le(self, other: Self) -> u32;
}

/// The registers of one instruction set: eight lanes for boxes, four for triangles.
pub(super) trait Simd {
    type Wide: Lanes<8>;
    type Quad: Lanes<4>;

    /// Asks for a value that will be read soon; a hint.
    fn prefetch<T>(value: &T);
}

/// Finds the closest hit of every ray with the kernel of `bvh`.
pub(super) fn closest_hits(bvh: &Bvh, rays: &[Ray], hits: &mut [Hit]) {
    match bvh.kernel {
        #[cfg(target_arch = "x86_64")]
        Kernel::Avx2 => avx2::closest_hits(bvh, rays, hits),
        #[cfg(target_arch = "x86_64")]
        Kernel::Sse2 => sse2::closest_hits(bvh, rays, hits),
        _ => plain::closest_hits(bvh, rays, hits),
    }
}

/// Tells of every ray whether something blocks it, with the kernel of `bvh`.
pub(super) fn occlusions(bvh: &Bvh, rays: &[Ray], occluded: &mut [bool]) {
    match bvh.kernel {
        #[cfg(target_arch = "x86_64")]
        Kernel::Avx2 => avx2::occlusions(bvh, rays, occluded),
        #[cfg(target_arch = "x86_64")]
        Kernel::Sse2 => sse2::occlusions(bvh, rays, occluded),
        _ => plain::occlusions(bvh, rays, occluded),
    }
}
