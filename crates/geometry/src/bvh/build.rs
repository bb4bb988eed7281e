//! The binary tree from which the wide one is collapsed: top-down, by the surface area heuristic.
//!
//! Wide ranges are split at one of a few planes per axis (Wald, "On fast Construction of SAH-based Bounding Volume
//! Hierarchies", 2007), narrow ones at the best of all positions. The layout of the tree follows from the number of
//! triangles on each side alone, so halves are built in parallel and the result does not depend on who builds them.

use super::BvhParams;
use super::bounds::Bounds;
use super::node::{MAX_COORDINATE, MAX_TRIANGLES};
use super::stack::MAX_DEPTH;
use glam::{Vec3, Vec3A};
use rayon::prelude::*;

/// Ranges longer than this are built by two threads where there are two.
const PARALLEL: usize = 2048;
/// The most bins per axis.
pub(super) const MAX_BINS: usize = 32;
/// The longest range that is split at the best of all positions.
const MAX_SWEEP: usize = 64;

/// One triangle on its way into the tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct Primitive {
    pub bounds: Bounds,
    /// The caller's triangle index.
    pub triangle: u32,
}

impl Primitive {
    /// Twice the centre of the box.
    #[inline]
    fn centre(&self) -> Vec3A {
        self.bounds.min + self.bounds.max
    }
}

/// A node over `count` consecutive primitives from `first` on.
///
/// A node over one primitive is a leaf. The left child of node `i` is `i + 1`, the right one follows the left subtree.
#[derive(Clone, Copy, Debug)]
pub(super) struct BinaryNode {
    pub bounds: Bounds,
    pub first: u32,
    pub count: u32,
}

impl BinaryNode {
    const UNSET: Self = Self { bounds: Bounds::EMPTY, first: 0, count: 0 };
}

/// A binary tree in depth-first order, and the primitives in the order of its leaves.
pub(super) struct BinaryTree {
    pub nodes: Vec<BinaryNode>,
    pub primitives: Vec<Primitive>,
}

impl BinaryTree {
    /// The children of a node that is not a leaf.
    pub fn children(&self, node: usize) -> [usize; 2] {
        let left = node + 1;
        [left, left + subtree_size(self.nodes[left].count as usize)]
    }

    pub fn build(triangles: &[[Vec3; 3]], params: &BvhParams) -> Self {
        assert!(triangles.len() <= MAX_TRIANGLES, "at most {MAX_TRIANGLES} triangles fit in one tree");
        let mut primitives = primitives(triangles);
        if primitives.is_empty() {
            return Self { nodes: Vec::new(), primitives };
        }
        let mut nodes = vec![BinaryNode::UNSET; subtree_size(primitives.len())];
        let builder = Builder { bins: params.bins.clamp(2, MAX_BINS), sweep: params.sweep.min(MAX_SWEEP) };
        builder.fill(&mut nodes, &mut primitives, 0, 0);
        Self { nodes, primitives }
    }
}

/// Does both, at the same time where the `count` of triangles is worth it.
pub(super) fn join(count: usize, left: impl FnOnce() + Send, right: impl FnOnce() + Send) {
    if count > PARALLEL {
        rayon::join(left, right);
    } else {
        left();
        right();
    }
}

/// How many nodes a binary tree over `leaves` leaves has.
pub(super) fn subtree_size(leaves: usize) -> usize {
    2 * leaves - 1
}

/// The triangles that a ray can hit.
fn primitives(triangles: &[[Vec3; 3]]) -> Vec<Primitive> {
    let usable = triangles.par_iter().enumerate().with_min_len(PARALLEL).filter(|(_, triangle)| can_be_hit(triangle));
    usable.map(|(i, triangle)| Primitive { bounds: Bounds::of_points(triangle), triangle: i as u32 }).collect()
}

/// Whether a triangle has finite corners of sane size and an area.
pub(super) fn can_be_hit(triangle: &[Vec3; 3]) -> bool {
    let [a, b, c] = triangle.map(|corner| corner.as_dvec3());
    triangle.iter().all(|corner| corner.abs().cmple(Vec3::splat(MAX_COORDINATE)).all())
        && (b - a).cross(c - a).length_squared() > 0.0
}

struct Builder {
    bins: usize,
    sweep: usize,
}

impl Builder {
    /// Builds the subtree over `primitives`, whose first one is number `first` of the whole.
    fn fill(&self, nodes: &mut [BinaryNode], primitives: &mut [Primitive], first: u32, depth: usize) {
        let (bounds, centres) = bounds(primitives);
        nodes[0] = BinaryNode { bounds, first, count: primitives.len() as u32 };
        if primitives.len() == 1 {
            return;
        }
        let middle = self.split(primitives, centres, depth);
        let (left, right) = primitives.split_at_mut(middle);
        let (left_nodes, right_nodes) = nodes[1..].split_at_mut(subtree_size(middle));
        let right_first = first + middle as u32;
        join(
            left.len() + right.len(),
            || self.fill(left_nodes, left, first, depth + 1),
            || self.fill(right_nodes, right, right_first, depth + 1),
        );
    }

    /// Parts the primitives in two sets, neither empty, and returns the size of the first.
    fn split(&self, primitives: &mut [Primitive], centres: Bounds, depth: usize) -> usize {
        if primitives.len() == 2 {
            return 1;
        }
        // From here on only halving keeps the tree within the stack of traversal.
        let must_halve = depth + ceil_log2(primitives.len()) >= MAX_DEPTH;
        if must_halve || centres.min == centres.max {
            return halve(primitives, centres);
        }
        if primitives.len() <= self.sweep {
            return sweep(primitives);
        }
        // Few triangles do not repay the clearing of many bins.
        let bins = if primitives.len() <= 4 * self.bins { self.bins.min(8) } else { self.bins };
        let plane = match bins {
            ..=8 => best_plane::<8>(primitives, centres, bins),
            9..=16 => best_plane::<16>(primitives, centres, bins),
            _ => best_plane::<MAX_BINS>(primitives, centres, bins),
        };
        match plane {
            Some(plane) => partition(primitives, |p| plane.is_left(p)),
            None => halve(primitives, centres),
        }
    }
}

/// The cheapest of all planes between bins, of which there are at most `MOST` per axis.
fn best_plane<const MOST: usize>(primitives: &[Primitive], centres: Bounds, bins: usize) -> Option<Plane> {
    let binning = Binning::new(centres, bins);
    let filled = binning.fill::<MOST>(primitives);
    let mut best: Option<(Cost, Plane)> = None;
    for (axis, filled) in filled.iter().enumerate() {
        if centres.min[axis] == centres.max[axis] {
            continue;
        }
        let Some((cost, bin)) = cheapest_cut(filled) else { continue };
        if best.as_ref().is_none_or(|(least, _)| cost < *least) {
            best = Some((cost, Plane { binning, axis, bin }));
        }
    }
    best.map(|(_, plane)| plane)
}

/// The cost of a split; among equals the more even one is cheaper.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
struct Cost {
    area: f32,
    imbalance: usize,
}

impl Cost {
    fn new(left: Bounds, left_count: usize, right: Bounds, right_count: usize) -> Self {
        let area = left.half_area() * left_count as f32 + right.half_area() * right_count as f32;
        Self { area, imbalance: left_count.abs_diff(right_count) }
    }
}

/// How centres map to bins.
#[derive(Clone, Copy)]
struct Binning {
    min: Vec3A,
    scale: Vec3A,
    bins: usize,
}

#[derive(Clone, Copy)]
struct Bin {
    bounds: Bounds,
    count: usize,
}

impl Bin {
    const EMPTY: Self = Self { bounds: Bounds::EMPTY, count: 0 };
}

impl Binning {
    fn new(centres: Bounds, bins: usize) -> Self {
        let extent = centres.max - centres.min;
        let scale = Vec3A::from_array(extent.to_array().map(|e| if e > 0.0 { bins as f32 / e } else { 0.0 }));
        Self { min: centres.min, scale, bins }
    }

    /// The bin along each axis. Casting saturates, so that rounding and infinite scales do no harm.
    #[inline]
    fn bin(&self, primitive: &Primitive) -> [usize; 3] {
        let position = (primitive.centre() - self.min) * self.scale;
        position.to_array().map(|x| (x as usize).min(self.bins - 1))
    }

    fn fill<const MOST: usize>(&self, primitives: &[Primitive]) -> [[Bin; MOST]; 3] {
        let mut bins = [[Bin::EMPTY; MOST]; 3];
        for primitive in primitives {
            for (bins, bin) in bins.iter_mut().zip(self.bin(primitive)) {
                let bin = &mut bins[bin];
                bin.bounds = bin.bounds.union(primitive.bounds);
                bin.count += 1;
            }
        }
        bins
    }
}

/// A plane between two bins.
struct Plane {
    binning: Binning,
    axis: usize,
    /// The first bin on the right.
    bin: usize,
}

impl Plane {
    fn is_left(&self, primitive: &Primitive) -> bool {
        self.binning.bin(primitive)[self.axis] < self.bin
    }
}

/// The cheapest cut through a row of bins that leaves something on both sides: the first bin on the right.
fn cheapest_cut<const MOST: usize>(bins: &[Bin; MOST]) -> Option<(Cost, usize)> {
    let mut right = [Bin::EMPTY; MOST];
    let mut sum = Bin::EMPTY;
    for (i, bin) in bins.iter().enumerate().rev() {
        sum = Bin { bounds: sum.bounds.union(bin.bounds), count: sum.count + bin.count };
        right[i] = sum;
    }
    let mut best: Option<(Cost, usize)> = None;
    let mut left = Bin::EMPTY;
    for i in 1..bins.len() {
        left = Bin { bounds: left.bounds.union(bins[i - 1].bounds), count: left.count + bins[i - 1].count };
        if left.count == 0 || right[i].count == 0 {
            continue;
        }
        let cost = Cost::new(left.bounds, left.count, right[i].bounds, right[i].count);
        if best.is_none_or(|(least, _)| cost < least) {
            best = Some((cost, i));
        }
    }
    best
}

/// Sorts along the axis of the cheapest split of all and returns where it lies.
fn sweep(primitives: &mut [Primitive]) -> usize {
    let mut best: Option<(Cost, usize, usize)> = None;
    let mut right = [Bounds::EMPTY; MAX_SWEEP];
    for axis in 0..3 {
        sort_by_centre(primitives, axis);
        let mut sum = Bounds::EMPTY;
        for (bounds, primitive) in right[..primitives.len()].iter_mut().zip(primitives.iter()).rev() {
            sum = sum.union(primitive.bounds);
            *bounds = sum;
        }
        let mut left = Bounds::EMPTY;
        for i in 1..primitives.len() {
            left = left.union(primitives[i - 1].bounds);
            let cost = Cost::new(left, i, right[i], primitives.len() - i);
            if best.is_none_or(|(least, ..)| cost < least) {
                best = Some((cost, axis, i));
            }
        }
    }
    let (_, axis, middle) = best.expect("there are three axes and at least two primitives");
    if axis != 2 {
        sort_by_centre(primitives, axis);
    }
    middle
}

fn sort_by_centre(primitives: &mut [Primitive], axis: usize) {
    let key = |p: &Primitive| p.centre()[axis];
    primitives.sort_unstable_by(|p, q| key(p).total_cmp(&key(q)).then(p.triangle.cmp(&q.triangle)));
}

/// Halves the primitives along the longest axis of their centres.
fn halve(primitives: &mut [Primitive], centres: Bounds) -> usize {
    let axis = Vec3::from(centres.max - centres.min).max_position();
    let key = |p: &Primitive| p.centre()[axis];
    let middle = primitives.len() / 2;
    primitives.select_nth_unstable_by(middle, |p, q| key(p).total_cmp(&key(q)).then(p.triangle.cmp(&q.triangle)));
    middle
}

/// Moves those that `is_left` to the front and returns how many they are.
fn partition(primitives: &mut [Primitive], is_left: impl Fn(&Primitive) -> bool) -> usize {
    let (mut left, mut right) = (0, primitives.len());
    loop {
        while left < right && is_left(&primitives[left]) {
            left += 1;
        }
        while left < right && !is_left(&primitives[right - 1]) {
            right -= 1;
        }
        if left >= right {
            return left;
        }
        primitives.swap(left, right - 1);
    }
}

/// The bounds of the primitives, and of their centres.
fn bounds(primitives: &[Primitive]) -> (Bounds, Bounds) {
    primitives.iter().fold((Bounds::EMPTY, Bounds::EMPTY), |(all, centres), primitive| {
        (all.union(primitive.bounds), centres.union(Bounds::of_point(primitive.centre())))
    })
}

fn ceil_log2(n: usize) -> usize {
    n.next_power_of_two().trailing_zeros() as usize
}
