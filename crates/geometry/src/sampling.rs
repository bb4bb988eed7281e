//! Low-discrepancy points keyed by what they are for.

use crate::{DVec3, Vec3};

/// A four-dimensional Owen-scrambled Sobol sequence (Burley 2020, *Practical hash-based Owen scrambling*).
///
/// Sequences with different keys are statistically independent; points of one sequence fill the unit hypercube evenly,
/// best at powers of two. The same key gives the same points whatever thread asks.
#[derive(Clone, Copy, Debug)]
pub struct Sequence {
    key: u32,
}

/// The length of one scrambled block of the generator.
const BLOCK: u32 = 1 << 16;

impl Sequence {
    /// The sequence for one purpose (`stream`) of one replicate of one patch.
    pub fn new(seed: u64, patch: u32, replicate: u32, stream: u32) -> Self {
        let mut key = mix(seed ^ 0x9e37_79b9_7f4a_7c15);
        for word in [patch, replicate, stream] {
            key = mix(key ^ u64::from(word).wrapping_mul(0xbf58_476d_1ce4_e5b9));
        }
        Self { key: (key >> 32) as u32 }
    }

    /// Point `index`, each coordinate strictly inside (0, 1).
    #[inline]
    pub fn point(&self, index: u32) -> [f64; 4] {
        self.further_point(index, 0)
    }

    /// Four further coordinates of point `index`, set by set; those of set 0 are [`Sequence::point`].
    #[inline]
    pub fn further_point(&self, index: u32, set: u32) -> [f64; 4] {
        // The generator ends at 2^16 points; a further block is a fresh scramble of it.
        let block = index / BLOCK;
        let key = if block == 0 { self.key } else { (mix(u64::from(self.key) << 32 | u64::from(block)) >> 32) as u32 };
        sobol_burley::sample_4d(index % BLOCK, set, key).map(|x| f64::from(x) + HALF_STEP)
    }
}

impl Sequence {
    /// A number that other sequences do not share, to hash further numbers from.
    pub fn hash(&self) -> u64 {
        mix(u64::from(self.key))
    }
}

/// Half the spacing of the generator's 24-bit floats: moves 0 off the edge and keeps the largest below 1.
const HALF_STEP: f64 = 1.0 / (1u64 << 25) as f64;

/// The finaliser of SplitMix64 (Steele, Lea and Flood 2014).
#[inline]
pub fn mix(mut z: u64) -> u64 {
    z = z.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// A point of the unit disk: Shirley and Chiu's concentric map (1997), which preserves area and strata.
///
/// Single precision: directions are, and the transcendental functions cost half.
#[inline]
pub fn concentric_disk(u: f32, v: f32) -> (f32, f32) {
    let (a, b) = (2.0 * u - 1.0, 2.0 * v - 1.0);
    if a == 0.0 && b == 0.0 {
        return (0.0, 0.0);
    }
    let quarter = std::f32::consts::FRAC_PI_4;
    let (radius, angle) = if a.abs() > b.abs() { (a, quarter * b / a) } else { (b, 2.0 * quarter - quarter * a / b) };
    let (sin, cos) = angle.sin_cos();
    (radius * cos, radius * sin)
}

/// A direction about `normal` with density cos(theta)/pi (Malley's method).
#[inline]
pub fn cosine_hemisphere(frame: &Frame, u: f64, v: f64) -> Vec3 {
    let (x, y) = concentric_disk(u as f32, v as f32);
    // Never along the plane itself, whatever rounding does at the rim of the disk.
    let z = (1.0 - x * x - y * y).max(1e-12).sqrt();
    let single = |v: DVec3| v.as_vec3();
    x * single(frame.tangent) + y * single(frame.bitangent) + z * single(frame.normal)
}

/// A right-handed orthonormal frame about a normal.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// First tangent.
    pub tangent: DVec3,
    /// Second tangent.
    pub bitangent: DVec3,
    /// Unit normal.
    pub normal: DVec3,
}

impl Frame {
    /// Builds the tangents without branches or square roots (Duff et al. 2017).
    pub fn new(normal: DVec3) -> Self {
        let sign = 1f64.copysign(normal.z);
        let a = -1.0 / (sign + normal.z);
        let b = normal.x * normal.y * a;
        Self {
            tangent: DVec3::new(1.0 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x),
            bitangent: DVec3::new(b, sign + normal.y * normal.y * a, -normal.y),
            normal,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_have_the_cosine_moments() {
        let frame = Frame::new(DVec3::new(1.0, -2.0, 3.0).normalize());
        let sequence = Sequence::new(1, 2, 3, 4);
        let n = 4096;
        let (mut mean_cos, mut mean) = (0.0, DVec3::ZERO);
        for i in 0..n {
            let [_, _, u, v] = sequence.point(i);
            let d = cosine_hemisphere(&frame, u, v).as_dvec3();
            assert!((d.length() - 1.0).abs() < 1e-6 && d.dot(frame.normal) > 0.0);
            mean_cos += d.dot(frame.normal) / f64::from(n);
            mean += d / f64::from(n);
        }
        // E[cos] = 2/3 and the mean direction is 2/3 of the normal.
        assert!((mean_cos - 2.0 / 3.0).abs() < 1e-3, "{mean_cos}");
        assert!((mean - 2.0 / 3.0 * frame.normal).length() < 2e-3, "{mean}");
    }

    #[test]
    fn a_power_of_two_of_points_puts_one_in_each_cell() {
        let sequence = Sequence::new(7, 0, 0, 0);
        let mut cells = [0; 64];
        for i in 0..64 {
            let [s, t, _, _] = sequence.point(i);
            cells[(s * 8.0) as usize * 8 + (t * 8.0) as usize] += 1;
        }
        assert!(cells.iter().all(|&c| c == 1), "{cells:?}");
    }

    #[test]
    fn keys_and_blocks_differ() {
        let point = |s: Sequence, i| s.point(i);
        assert_ne!(point(Sequence::new(1, 0, 0, 0), 0), point(Sequence::new(2, 0, 0, 0), 0));
        assert_ne!(point(Sequence::new(1, 0, 0, 0), 0), point(Sequence::new(1, 1, 0, 0), 0));
        assert_ne!(point(Sequence::new(1, 0, 0, 0), 3), point(Sequence::new(1, 0, 0, 0), BLOCK + 3));
    }

    #[test]
    fn frames_are_orthonormal() {
        for normal in [DVec3::Z, -DVec3::Z, DVec3::X, DVec3::new(0.6, 0.0, -0.8)] {
            let f = Frame::new(normal);
            assert!((f.tangent.cross(f.bitangent) - normal).length() < 1e-12);
            assert!((f.tangent.length() - 1.0).abs() < 1e-12);
        }
    }
}
