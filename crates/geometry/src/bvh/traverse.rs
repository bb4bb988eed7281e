//! The walk of rays through the tree, written once for all instruction sets and both queries.
//!
//! A walk is a chain of steps each of which waits for the one before: for a box to arrive from memory, for a mask to
//! come out of a comparison. So a batch walks several rays in turn, one step each, and the processor works on one while
//! another waits.

use super::node::{BLOCK, Block, BlockId, Child, MAX_COORDINATE, Node, WIDTH};
use super::simd::{Lanes, Simd};
use super::slabs::Slabs;
use super::stack::{Entry, Stack};
use super::triangle::Shear;
use super::{Bvh, Hit, Ray};
use glam::Vec3;

/// How many rays of a batch walk in turn.
const TURNS: usize = 4;
/// Trees smaller than this, in bytes, stay close to the processor, and taking turns would only confuse its guesses.
const NEAR_MEMORY: usize = 1 << 20;

/// Finds the closest hit of each ray.
#[inline(always)]
pub(super) fn closest_hits<S: Simd>(bvh: &Bvh, rays: &[Ray], hits: &mut [Hit]) {
    walk_all::<S, Closest>(bvh, rays, hits);
}

/// Tells of each ray whether it hits anything.
#[inline(always)]
pub(super) fn occlusions<S: Simd>(bvh: &Bvh, rays: &[Ray], occluded: &mut [bool]) {
    walk_all::<S, Any>(bvh, rays, occluded);
}

#[inline(always)]
fn walk_all<S: Simd, G: Goal>(bvh: &Bvh, rays: &[Ray], answers: &mut [G::Answer]) {
    if bvh.nodes.is_empty() {
        answers.fill(G::MISS);
    } else if bvh.memory_bytes() < NEAR_MEMORY || are_coherent(rays, bvh.reach) {
        walk_one_by_one::<S, G>(bvh, rays, answers);
    } else {
        walk_in_turn::<S, G, TURNS>(bvh, rays, answers);
    }
}

/// Whether each of a few rays of the batch resembles the one after it: starts nearby, goes about the same way.
fn are_coherent(rays: &[Ray], reach: f32) -> bool {
    const SAMPLES: usize = 16;
    let nearby = 0.05 * reach;
    let resembles = |pair: &[Ray]| {
        let (d, e) = (pair[0].direction, pair[1].direction);
        let parting = pair[0].origin.distance_squared(pair[1].origin);
        let along = d.dot(e);
        along > 0.0 && along * along > 0.75 * d.length_squared() * e.length_squared() && parting < nearby * nearby
    };
    let step = (rays.len() / SAMPLES).max(1);
    let (mut alike, mut samples) = (0, 0);
    for pair in rays.windows(2).step_by(step) {
        alike += usize::from(resembles(pair));
        samples += 1;
    }
    2 * alike >= samples
}

/// Walks each ray to its end before the next.
#[inline(always)]
fn walk_one_by_one<S: Simd, G: Goal>(bvh: &Bvh, rays: &[Ray], answers: &mut [G::Answer]) {
    let mut stack = Stack::new();
    for (number, ray) in rays.iter().enumerate() {
        answers[number] = G::MISS;
        if is_usable(ray) {
            stack.clear();
            let mut walk = Walk::<S, G>::new(bvh, ray, number);
            while walk.step::<false>(bvh, &mut stack) {}
            answers[number] = walk.goal.answer();
        }
    }
}

/// Walks `N` rays at a time, one step each.
#[inline(always)]
fn walk_in_turn<S: Simd, G: Goal, const N: usize>(bvh: &Bvh, rays: &[Ray], answers: &mut [G::Answer]) {
    let mut stacks = [const { Stack::new() }; N];
    let mut walks = [const { None::<Walk<S, G>> }; N];
    let mut waiting = 0;
    let mut walking = 0;
    for walk in &mut walks {
        *walk = Walk::next(bvh, rays, answers, &mut waiting);
        walking += usize::from(walk.is_some());
    }
    while walking > 0 {
        for (slot, stack) in walks.iter_mut().zip(&mut stacks) {
            let Some(walk) = slot else { continue };
            if walk.step::<true>(bvh, stack) {
                continue;
            }
            answers[walk.ray] = walk.goal.answer();
            stack.clear();
            *slot = Walk::next(bvh, rays, answers, &mut waiting);
            walking -= usize::from(slot.is_none());
        }
    }
}

/// What is asked of a ray, and what is known so far.
trait Goal: Copy {
    type Answer: Copy;
    const MISS: Self::Answer;
    /// Whether nearer children must come before farther ones.
    const ORDERED: bool;
    fn new(t_max: f32) -> Self;
    /// Hits beyond this are of no interest.
    fn t_max(&self) -> f32;
    /// Considers a block of triangles; false if nothing else can matter.
    fn visit<Q: Lanes<BLOCK>>(&mut self, block: &Block, shear: &Shear<Q>) -> bool;
    fn answer(self) -> Self::Answer;
}

/// One ray on its way.
struct Walk<S: Simd, G> {
    slabs: Slabs<S::Wide>,
    shear: Shear<S::Quad>,
    goal: G,
    /// Where the next step goes.
    next: Child,
    /// The number of the ray in its batch.
    ray: usize,
}

impl<S: Simd, G: Goal> Walk<S, G> {
    /// Sets off with the next of the waiting rays. Those that can hit nothing are answered at once.
    #[inline(always)]
    fn next(bvh: &Bvh, rays: &[Ray], answers: &mut [G::Answer], waiting: &mut usize) -> Option<Self> {
        while let Some(ray) = rays.get(*waiting) {
            let number = *waiting;
            *waiting += 1;
            if is_usable(ray) {
                return Some(Self::new(bvh, ray, number));
            }
            answers[number] = G::MISS;
        }
        None
    }

    #[inline(always)]
    fn new(bvh: &Bvh, ray: &Ray, number: usize) -> Self {
        // Positive zero, also for a negative zero: entries of the stack sort by bit pattern.
        let t_min = if ray.t_min > 0.0 { ray.t_min } else { 0.0 };
        Self {
            slabs: Slabs::new(ray.origin, ray.direction, t_min, bvh.reach),
            shear: Shear::new(ray.origin.to_array(), ray.direction.to_array(), t_min),
            goal: G::new(ray.t_max),
            next: Child::node(0),
            ray: number,
        }
    }

    /// Visits one node or one leaf; false at the end of the walk. `PREFETCH` if others step before this one again.
    #[inline(always)]
    fn step<const PREFETCH: bool>(&mut self, bvh: &Bvh, stack: &mut Stack) -> bool {
        if self.next.is_leaf() {
            for block in self.next.blocks() {
                if !self.goal.visit(&bvh.blocks[block], &self.shear) {
                    return false;
                }
            }
        } else {
            let node = &bvh.nodes[self.next.index()];
            let (mask, near) = self.slabs.intersect(node, self.goal.t_max());
            if mask != 0 {
                self.next = nearest_first::<S, G>(node, mask, near, stack);
                self.prefetch::<PREFETCH>(bvh);
                return true;
            }
        }
        while let Some(entry) = stack.pop() {
            if !G::ORDERED || entry.near() <= self.goal.t_max() {
                self.next = entry.child();
                self.prefetch::<PREFETCH>(bvh);
                return true;
            }
        }
        false
    }

    /// Asks for what the next step will read.
    #[inline(always)]
    fn prefetch<const PREFETCH: bool>(&self, bvh: &Bvh) {
        if !PREFETCH {
            return;
        }
        if self.next.is_leaf() {
            S::prefetch(&bvh.blocks[self.next.blocks().start]);
        } else {
            S::prefetch(&bvh.nodes[self.next.index()]);
        }
    }
}

/// Whether a ray can hit anything: no NaNs, no infinities where they make no sense, a direction, a stretch.
#[inline(always)]
fn is_usable(ray: &Ray) -> bool {
    let (origin, direction) = (ray.origin.abs(), ray.direction.abs());
    let most = Vec3::splat(MAX_COORDINATE);
    // A NaN is neither less nor more than anything.
    origin.cmple(most).all()
        && direction.cmple(most).all()
        && direction.cmpge(1.0 / most).any()
        && ray.t_min <= ray.t_max
}

/// Leaves the children in `mask` on the stack, nearest on top if the goal asks for it, and takes that one off.
#[inline(always)]
fn nearest_first<S: Simd, G: Goal>(node: &Node, mask: u32, near: S::Wide, stack: &mut Stack) -> Child {
    let mut rest = mask;
    let first = take_lowest(&mut rest);
    if rest == 0 {
        return node.children[first];
    }
    let mut distances = [0.0; WIDTH];
    near.store(&mut distances);

    let (a, b) = (entry(node, &distances, first), entry(node, &distances, take_lowest(&mut rest)));
    if rest == 0 {
        stack.push(a.max(b));
        return a.min(b).child();
    }
    stack.push(a);
    stack.push(b);
    let mut count = 2;
    while rest != 0 {
        stack.push(entry(node, &distances, take_lowest(&mut rest)));
        count += 1;
    }
    if G::ORDERED {
        stack.sort_top(count);
    }
    stack.pop().expect("just pushed").child()
}

#[inline(always)]
fn entry(node: &Node, distances: &[f32; WIDTH], lane: usize) -> Entry {
    Entry::new(distances[lane], node.children[lane])
}

/// Takes the lowest set bit off a mask of at most eight bits that is not zero.
#[inline(always)]
fn take_lowest(mask: &mut u32) -> usize {
    let lane = mask.trailing_zeros() as usize & (WIDTH - 1);
    *mask &= *mask - 1;
    lane
}

/// Any hit will do.
#[derive(Clone, Copy)]
struct Any {
    t_max: f32,
    hit: bool,
}

impl Goal for Any {
    type Answer = bool;
    const MISS: bool = false;
    const ORDERED: bool = false;

    #[inline(always)]
    fn new(t_max: f32) -> Self {
        Self { t_max, hit: false }
    }
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.t_max
    }
    #[inline(always)]
    fn visit<Q: Lanes<BLOCK>>(&mut self, block: &Block, shear: &Shear<Q>) -> bool {
        self.hit = shear.intersect(block, self.t_max).is_some();
        !self.hit
    }
    #[inline(always)]
    fn answer(self) -> bool {
        self.hit
    }
}

/// The closest hit so far.
#[derive(Clone, Copy)]
struct Closest {
    t: f32,
    u: f32,
    v: f32,
    id: BlockId,
}

impl Goal for Closest {
    type Answer = Hit;
    const MISS: Hit = Hit::MISS;
    const ORDERED: bool = true;

    #[inline(always)]
    fn new(t_max: f32) -> Self {
        Self { t: t_max, u: 0.0, v: 0.0, id: BlockId::NONE }
    }

    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.t
    }

    /// Takes the closest hit of the block if it is nearer, or as near with a lower triangle index.
    #[inline(always)]
    fn visit<Q: Lanes<BLOCK>>(&mut self, block: &Block, shear: &Shear<Q>) -> bool {
        let Some(hits) = shear.intersect(block, self.t) else { return true };
        let (mut t, mut u, mut v) = ([0.0; BLOCK], [0.0; BLOCK], [0.0; BLOCK]);
        hits.t.store(&mut t);
        hits.u.store(&mut u);
        hits.v.store(&mut v);
        let mut mask = hits.mask;
        while mask != 0 {
            let lane = take_lowest(&mut mask) & (BLOCK - 1);
            if t[lane] < self.t || (t[lane] == self.t && block.ids[lane] < self.id) {
                *self = Self { t: t[lane], u: u[lane], v: v[lane], id: block.ids[lane] };
            }
        }
        true
    }

    /// The hit in the caller's order of corners.
    #[inline(always)]
    fn answer(self) -> Hit {
        if self.id == BlockId::NONE {
            return Hit::MISS;
        }
        // Our corner i is the caller's corner i + rotation.
        let weights = [(1.0 - self.u - self.v).max(0.0), self.u, self.v];
        let back = 3 - self.id.rotation() as usize;
        Hit { t: self.t, u: weights[(back + 1) % 3], v: weights[(back + 2) % 3], triangle: self.id.triangle() }
    }
}

/// Tests every triangle of the tree, boxes unseen.
#[cfg(test)]
pub(super) fn brute_force(bvh: &Bvh, ray: &Ray) -> Hit {
    let mut closest = Closest::new(ray.t_max);
    if is_usable(ray) {
        let shear = Shear::<[f32; BLOCK]>::new(ray.origin.to_array(), ray.direction.to_array(), ray.t_min.max(0.0));
        bvh.blocks.iter().for_each(|block| {
            closest.visit(block, &shear);
        });
    }
    closest.answer()
}
