//! Rays against blocks of triangles, watertight.
//!
//! The test is that of Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013: shear space
//! such that the ray runs along an axis from the origin, then ask on which side of the origin each edge passes. Two
//! triangles that share an edge shear the same corners to the same numbers and compute edge functions that differ in
//! sign alone. Rounding is monotonic, so the sign of a difference of two rounded products is right or zero, and zero
//! counts as inside; hence no ray passes between the two. Fusing a product into the difference would break this.
//!
//! The distance departs from the article, which interpolates it with the edge functions. On slivers those suffer from
//! cancellation; the plane spanned by the two shorter edges does not.

use super::node::{BLOCK, Block};
use super::simd::Lanes;

/// A ray in the form that the triangle test wants.
pub(super) struct Shear<Q> {
    /// The axes that become x, y and z; z is the one along which the ray runs fastest.
    axes: [usize; 3],
    /// The origin, by new axis.
    origin: [Q; 3],
    /// Shear in x and in y, and the scale from z to t.
    shear: [Q; 3],
    t_min: Q,
}

/// The hits of one block: a bit per lane, distances, and weights of the second and third corner.
pub(super) struct BlockHits<Q> {
    pub mask: u32,
    pub t: Q,
    pub u: Q,
    pub v: Q,
}

impl<Q: Lanes<BLOCK>> Shear<Q> {
    #[inline(always)]
    pub fn new(origin: [f32; 3], direction: [f32; 3], t_min: f32) -> Self {
        let z = largest_axis(direction);
        let [x, y] = [(z + 1) % 3, (z + 2) % 3];
        let scale = 1.0 / direction[z];
        Self {
            axes: [x, y, z],
            origin: [Q::splat(origin[x]), Q::splat(origin[y]), Q::splat(origin[z])],
            shear: [Q::splat(direction[x] * scale), Q::splat(direction[y] * scale), Q::splat(scale)],
            t_min: Q::splat(t_min),
        }
    }

    /// Moves one corner of four triangles into the space of the ray.
    #[inline(always)]
    fn corner(&self, block: &Block, corner: usize) -> [Q; 3] {
        let [x, y, z] = [self.offset(block, corner, 0), self.offset(block, corner, 1), self.offset(block, corner, 2)];
        [x.sub(self.shear[0].mul(z)), y.sub(self.shear[1].mul(z)), z]
    }

    /// How far a corner of each triangle lies from the origin along one new axis.
    #[inline(always)]
    fn offset(&self, block: &Block, corner: usize, axis: usize) -> Q {
        Q::load(&block.corners[self.axes[axis]][corner]).sub(self.origin[axis])
    }

    /// Finds the triangles that the ray hits between its `t_min` and `t_max`, both included.
    #[inline(always)]
    pub fn intersect(&self, block: &Block, t_max: f32) -> Option<BlockHits<Q>> {
        let zero = Q::splat(0.0);
        let [a, b, c] = [self.corner(block, 0), self.corner(block, 1), self.corner(block, 2)];
        let [u, v, w] = [edge(b, c), edge(c, a), edge(a, b)];

        // Inside: the origin lies on the same side of all edges, seen from the front or from behind.
        let front = zero.le(u.min(v).min(w));
        let back = u.max(v).max(w).le(zero);
        if front | back == 0 {
            return None;
        }

        let area = u.add(v).add(w);
        let seen_edge_on = area.le(zero) & zero.le(area);
        let t = depth(a, b, c).mul(self.shear[2]);
        let in_range = self.t_min.le(t) & t.le(Q::splat(t_max));
        let mask = (front | back) & !seen_edge_on & in_range;
        if mask == 0 {
            return None;
        }
        Some(BlockHits { mask, t, u: v.div(area), v: w.div(area) })
    }
}

/// Twice the signed area of the triangle that the origin spans with the edge from `p` to `q`.
///
/// Swapping the ends gives exactly the negative.
#[inline(always)]
fn edge<Q: Lanes<BLOCK>>(p: [Q; 3], q: [Q; 3]) -> Q {
    q[0].mul(p[1]).sub(q[1].mul(p[0]))
}

/// Where the plane of the triangle meets the z axis, never outside the triangle's own range of z.
#[inline(always)]
fn depth<Q: Lanes<BLOCK>>(a: [Q; 3], b: [Q; 3], c: [Q; 3]) -> Q {
    let (p, q) = (difference(b, a), difference(c, a));
    let normal_x = p[1].mul(q[2]).sub(p[2].mul(q[1]));
    let normal_y = p[2].mul(q[0]).sub(p[0].mul(q[2]));
    let normal_z = p[0].mul(q[1]).sub(p[1].mul(q[0]));
    let rise = normal_x.mul(a[0]).add(normal_y.mul(a[1])).div(normal_z);
    let lowest = a[2].min(b[2]).min(c[2]);
    let highest = a[2].max(b[2]).max(c[2]);
    // A NaN (0 / 0, a plane seen edge-on) takes the second operand.
    a[2].add(rise).max(lowest).min(highest)
}

#[inline(always)]
fn difference<Q: Lanes<BLOCK>>(p: [Q; 3], q: [Q; 3]) -> [Q; 3] {
    [p[0].sub(q[0]), p[1].sub(q[1]), p[2].sub(q[2])]
}

/// The axis of the largest component in magnitude, the lowest among equals.
#[inline(always)]
fn largest_axis(direction: [f32; 3]) -> usize {
    let [x, y, z] = direction.map(f32::abs);
    if x >= y && x >= z {
        0
    } else if y >= z {
        1
    } else {
        2
    }
}
