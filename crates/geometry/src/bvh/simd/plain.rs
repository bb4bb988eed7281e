//! The portable kernel: arrays, which the compiler turns into whatever vectors the machine has.

use super::super::{Bvh, Hit, Ray, traverse};
use super::{Lanes, Simd};

/// Plain arrays for both widths.
pub(super) struct Plain;

impl Simd for Plain {
    type Wide = [f32; 8];
    type Quad = [f32; 4];

    #[inline(always)]
    fn prefetch<T>(_: &T) {}
}

pub(super) fn closest_hits(bvh: &Bvh, rays: &[Ray], hits: &mut [Hit]) {
    traverse::closest_hits::<Plain>(bvh, rays, hits);
}

pub(super) fn occlusions(bvh: &Bvh, rays: &[Ray], occluded: &mut [bool]) {
    traverse::occlusions::<Plain>(bvh, rays, occluded);
}

#[inline(always)]
fn zip<const N: usize>(a: [f32; N], b: [f32; N], f: impl Fn(f32, f32) -> f32) -> [f32; N] {
    std::array::from_fn(|i| f(a[i], b[i]))
}

impl<const N: usize> Lanes<N> for [f32; N] {
    #[inline(always)]
    fn splat(value: f32) -> Self {
        [value; N]
    }
    #[inline(always)]
    fn load(values: &[f32; N]) -> Self {
        *values
    }
    #[inline(always)]
    fn store(self, values: &mut [f32; N]) {
        *values = self;
    }
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        zip(self, other, |a, b| a + b)
    }
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        zip(self, other, |a, b| a - b)
    }
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        zip(self, other, |a, b| a * b)
    }
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        zip(self, other, |a, b| a / b)
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        self.mul(factor).add(term)
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        zip(self, other, |a, b| if a < b { a } else { b })
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        zip(self, other, |a, b| if a > b { a } else { b })
    }
    #[inline(always)]
    fn le(self, other: Self) -> u32 {
        (0..N).fold(0, |mask, i| mask | (u32::from(self[i] <= other[i]) << i))
    }
}
