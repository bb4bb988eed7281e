//! The depth test, eight pixels at a time, once per instruction set.
//!
//! Both do the same IEEE operations, so they leave the same bits. Written by hand for AVX2 because the compiler turns
//! the portable form into branches as often as into vectors, which costs half of the speed.

#[cfg(target_arch = "x86_64")]
use std::arch::x86_64::*;

/// Pixels that are tested and written together.
pub(super) const LANES: usize = 8;

/// What is in some pixels of a row.
pub(super) struct Pixels8<'a> {
    /// The inverse of depth.
    pub nearness: &'a mut [f32; LANES],
    pub owner: &'a mut [u32; LANES],
}

/// An instruction set that merges pixels.
pub(super) trait Merge {
    /// Replaces those of the first `count` pixels that are farther than `base + ramp`.
    fn merge(pixels: Pixels8, count: usize, base: f32, ramp: &[f32; LANES], owner: u32);
}

/// Arrays.
pub(super) struct Plain;

impl Merge for Plain {
    #[inline(always)]
    fn merge(pixels: Pixels8, count: usize, base: f32, ramp: &[f32; LANES], owner: u32) {
        for (k, step) in ramp.iter().enumerate() {
            let near = base + step;
            let seen = (k < count) & (near > pixels.nearness[k]);
            pixels.nearness[k] = if seen { near } else { pixels.nearness[k] };
            pixels.owner[k] = if seen { owner } else { pixels.owner[k] };
        }
    }
}

/// 256-bit registers. To be used below an entry point that enables AVX2 alone.
#[cfg(target_arch = "x86_64")]
pub(super) struct Avx2;

#[cfg(target_arch = "x86_64")]
impl Merge for Avx2 {
    #[inline(always)]
    fn merge(pixels: Pixels8, count: usize, base: f32, ramp: &[f32; LANES], owner: u32) {
        // SAFETY: runs only below an AVX2 entry point; all loads and stores are unaligned ones of whole arrays.
        unsafe {
            let near = _mm256_add_ps(_mm256_set1_ps(base), _mm256_loadu_ps(ramp.as_ptr()));
            let old = _mm256_loadu_ps(pixels.nearness.as_ptr());
            let lanes = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
            let inside = _mm256_cmpgt_epi32(_mm256_set1_epi32(count as i32), lanes);
            let seen = _mm256_and_ps(_mm256_cmp_ps::<_CMP_GT_OQ>(near, old), _mm256_castsi256_ps(inside));
            _mm256_storeu_ps(pixels.nearness.as_mut_ptr(), _mm256_blendv_ps(old, near, seen));
            let owners = pixels.owner.as_mut_ptr().cast::<f32>();
            let new = _mm256_castsi256_ps(_mm256_set1_epi32(owner as i32));
            _mm256_storeu_ps(owners, _mm256_blendv_ps(_mm256_loadu_ps(owners), new, seen));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn merged<M: Merge>(count: usize) -> ([f32; LANES], [u32; LANES]) {
        let mut nearness = [0.0, 1.0, 2.0, 3.0, f32::NAN, 0.5, 1.5, 2.0];
        let mut owner = [0, 1, 2, 3, 4, 5, 6, 7];
        let ramp: [f32; LANES] = std::array::from_fn(|k| 0.25 * k as f32);
        M::merge(Pixels8 { nearness: &mut nearness, owner: &mut owner }, count, 1.0, &ramp, 9);
        (nearness, owner)
    }

    #[test]
    fn what_is_nearer_and_inside_is_replaced() {
        // New nearness is 1, 1.25, 1.5, 1.75, 2, 2.25, 2.5, 2.75; nothing is nearer than a NaN.
        assert_eq!(merged::<Plain>(8).1, [9, 9, 2, 3, 4, 9, 9, 9]);
        assert_eq!(merged::<Plain>(6).1, [9, 9, 2, 3, 4, 9, 6, 7]);
        assert_eq!(merged::<Plain>(100).0[..4], [1.0, 1.25, 2.0, 3.0]);
    }

    #[test]
    #[cfg(target_arch = "x86_64")]
    fn both_leave_the_same() {
        if !std::arch::is_x86_feature_detected!("avx2") {
            return;
        }
        let bits = |(nearness, owner): ([f32; LANES], [u32; LANES])| (nearness.map(f32::to_bits), owner);
        for count in [0, 1, 5, 8, 4096] {
            assert_eq!(bits(merged::<Plain>(count)), bits(merged::<Avx2>(count)));
        }
    }
}
