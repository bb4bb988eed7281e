//! Rays against the eight boxes of a node, conservatively.

use super::node::{MAX_COORDINATE, Node, WIDTH};
use super::simd::Lanes;
use glam::Vec3;

/// By how much boxes grow, relative to the coordinates of the ray's origin and of the scene.
///
/// The distance to a plane, b (1 / d) - o (1 / d), carries up to four roundings of 2^-24 relative to |o| + |b| over |d|
/// (after Ize, "Robust BVH Ray Traversal", JCGT 2(2), 2013, whose margin is relative to the distance and serves
/// (b - o) / d), and the triangle test displaces corners by up to four roundings of their offset from the origin.
/// Twice the sum covers both, so no box is missed whose triangle would have been hit.
const MARGIN: f32 = 16.0 / (1 << 24) as f32;

/// Components of the direction below this are taken as this, so that reciprocals stay finite. The largest component is
/// 1e12 times as large at least, so what this displaces within reach of the scene lies far below the margin.
const SMALLEST: f32 = 1e-12 / MAX_COORDINATE;

/// A ray in the form that the box test wants.
pub(super) struct Slabs<W> {
    reciprocal: [W; 3],
    /// What to add to a plane's coordinate times the reciprocal: too little for the plane of entry, too much for the
    /// plane of exit.
    enter: [W; 3],
    leave: [W; 3],
    /// Which of a node's planes the ray meets first and second along each axis.
    first: [usize; 3],
    second: [usize; 3],
    t_min: W,
}

impl<W: Lanes<WIDTH>> Slabs<W> {
    /// A ray for boxes whose coordinates do not exceed `reach`.
    #[inline(always)]
    pub fn new(origin: Vec3, direction: Vec3, t_min: f32, reach: f32) -> Self {
        let magnitude = direction.abs().max(Vec3::splat(SMALLEST));
        let reciprocal = Vec3::ONE / magnitude.copysign(direction);
        let zero = origin * reciprocal;
        let margin = (origin.abs() + reach) * reciprocal.abs() * MARGIN;
        let backward = reciprocal.cmplt(Vec3::ZERO);
        let first = [
            3 * usize::from(backward.test(0)),
            1 + 3 * usize::from(backward.test(1)),
            2 + 3 * usize::from(backward.test(2)),
        ];
        Self {
            reciprocal: splat(reciprocal),
            enter: splat(-zero - margin),
            leave: splat(margin - zero),
            first,
            second: [3 - first[0], 5 - first[1], 7 - first[2]],
            t_min: W::splat(t_min),
        }
    }

    /// One bit per child whose box the ray meets between `t_min` and `t_max`, and the distances of entry.
    #[inline(always)]
    pub fn intersect(&self, node: &Node, t_max: f32) -> (u32, W) {
        let near = self.enter(node, 0).max(self.enter(node, 1)).max(self.enter(node, 2).max(self.t_min));
        let far = self.leave(node, 0).min(self.leave(node, 1)).min(self.leave(node, 2).min(W::splat(t_max)));
        (near.le(far), near)
    }

    /// Where the ray meets the first plane of each box along one axis.
    #[inline(always)]
    fn enter(&self, node: &Node, axis: usize) -> W {
        W::load(&node.planes[self.first[axis]]).mul_add(self.reciprocal[axis], self.enter[axis])
    }

    /// Where the ray meets the second plane of each box along one axis.
    #[inline(always)]
    fn leave(&self, node: &Node, axis: usize) -> W {
        W::load(&node.planes[self.second[axis]]).mul_add(self.reciprocal[axis], self.leave[axis])
    }
}

#[inline(always)]
fn splat<W: Lanes<WIDTH>>(v: Vec3) -> [W; 3] {
    [W::splat(v.x), W::splat(v.y), W::splat(v.z)]
}
