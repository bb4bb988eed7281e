//! An 8-wide bounding volume hierarchy over triangles: which triangle does a ray hit first, and does it hit any.
//!
//! The layout is that of Wald, Benthin and Boulos, "Getting Rid of Packets", RT 2008: each node holds eight boxes that
//! one vector instruction tests together, each leaf a few triangles coordinate by coordinate. The tree is built
//! by the surface area heuristic ([`BvhParams`]), traversal is written once and compiled for several instruction sets
//! ([`Kernel`]).
//!
//! What a caller may rely on:
//!
//! - **Watertight.** A ray does not slip between two triangles that share an edge or a corner exactly.
//! - **Deterministic.** The same triangles give the same tree on any number of threads, and the same ray the same hit,
//!   bit for bit, with every kernel. Of several triangles at the same distance the lowest index is hit.
//! - **Total.** Rays with NaNs, with origins beyond 1e12 or without direction hit nothing. Triangles with NaNs, with
//!   coordinates beyond 1e12 or without area keep their index and are never hit.
//!
//! Deliberately absent: epsilons. A caller who shoots from a surface moves the origin off it or raises `t_min`.

mod bounds;
mod build;
mod collapse;
mod node;
mod params;
mod simd;
mod slabs;
mod stack;
#[cfg(test)]
mod tests;
mod traverse;
mod triangle;
mod validate;

pub use params::BvhParams;
pub use simd::Kernel;

use bounds::Bounds;
use build::BinaryTree;
use collapse::WideTree;
use glam::Vec3;
use node::{Block, Child, Node};

/// A stretch of a line: the points `origin + t direction` for `t_min <= t <= t_max`, both ends included.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Where `t` is zero.
    pub origin: Vec3,
    /// Need not have unit length; its largest component must lie between 1e-12 and 1e12.
    pub direction: Vec3,
    /// The least distance that counts, in units of `direction`; taken as zero when negative.
    pub t_min: f32,
    /// The greatest distance that counts; may be infinite.
    pub t_max: f32,
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The distance in units of the ray's direction.
    pub t: f32,
    /// The weight of the triangle's second corner: the point is `(1 - u - v) a + u b + v c`.
    pub u: f32,
    /// The weight of the triangle's third corner.
    pub v: f32,
    /// The index of the triangle as given to [`Bvh::build`].
    pub triangle: u32,
}

impl Hit {
    /// No hit: no triangle, infinitely far away.
    pub const MISS: Self = Self { t: f32::INFINITY, u: 0.0, v: 0.0, triangle: u32::MAX };

    /// Whether the ray met nothing.
    pub fn is_miss(&self) -> bool {
        self.triangle == u32::MAX
    }
}

/// A hierarchy of boxes over triangles.
///
/// It copies the triangles it can hit, so the caller's may be dropped. Queries take `&self` and run on any number of
/// threads at once; each runs on the thread that asks. Batches save a little per ray, and rays that start close
/// together and are in order of direction save much more, by finding their part of the tree in the cache.
#[derive(Clone, Debug)]
pub struct Bvh {
    nodes: Vec<Node>,
    blocks: Vec<Block>,
    bounds: Bounds,
    /// The largest coordinate in magnitude.
    reach: f32,
    triangle_count: usize,
    /// How many of them can be hit.
    leaf_triangles: usize,
    node_cost: f32,
    block_cost: f32,
    kernel: Kernel,
}

impl Bvh {
    /// Builds the tree over `triangles`, which rays then name by their index.
    ///
    /// # Panics
    /// With more than 2^28 triangles.
    pub fn build(triangles: &[[Vec3; 3]], params: &BvhParams) -> Self {
        let binary = BinaryTree::build(triangles, params);
        let WideTree { nodes, blocks } = WideTree::new(&binary, triangles, params);
        let bounds = binary.nodes.first().map_or(Bounds::EMPTY, |root| root.bounds);
        Self {
            nodes,
            blocks,
            bounds,
            reach: bounds.min.abs().max(bounds.max.abs()).max_element(),
            leaf_triangles: binary.primitives.len(),
            triangle_count: triangles.len(),
            node_cost: params.node_cost,
            block_cost: params.block_cost,
            kernel: Kernel::detect(),
        }
    }

    /// The same tree, traversed by another kernel.
    ///
    /// # Panics
    /// If this processor cannot run it, see [`Kernel::available`].
    pub fn with_kernel(self, kernel: Kernel) -> Self {
        assert!(Kernel::available().contains(&kernel), "this processor cannot run the kernel {kernel:?}");
        Self { kernel, ..self }
    }

    /// The first triangle that the ray meets, from whichever side.
    pub fn closest_hit(&self, ray: &Ray) -> Hit {
        let mut hit = [Hit::MISS];
        simd::closest_hits(self, std::slice::from_ref(ray), &mut hit);
        hit[0]
    }

    /// Whether the ray meets any triangle.
    pub fn occluded(&self, ray: &Ray) -> bool {
        let mut occluded = [false];
        simd::occlusions(self, std::slice::from_ref(ray), &mut occluded);
        occluded[0]
    }

    /// As [`Bvh::closest_hit`] for each of many rays.
    ///
    /// # Panics
    /// If `hits` is not as long as `rays`.
    pub fn closest_hits(&self, rays: &[Ray], hits: &mut [Hit]) {
        assert_eq!(rays.len(), hits.len(), "one hit per ray");
        simd::closest_hits(self, rays, hits);
    }

    /// As [`Bvh::occluded`] for each of many rays.
    ///
    /// # Panics
    /// If `occluded` is not as long as `rays`.
    pub fn occlusions(&self, rays: &[Ray], occluded: &mut [bool]) {
        assert_eq!(rays.len(), occluded.len(), "one answer per ray");
        simd::occlusions(self, rays, occluded);
    }

    /// How many triangles were given, those that cannot be hit included.
    pub fn triangle_count(&self) -> usize {
        self.triangle_count
    }

    /// The kernel that answers queries.
    pub fn kernel(&self) -> Kernel {
        self.kernel
    }

    /// The heap memory of the tree, in bytes.
    pub fn memory_bytes(&self) -> usize {
        size_of_val(self.nodes.as_slice()) + size_of_val(self.blocks.as_slice())
    }

    /// The lower and the upper corner of the box around all triangles that can be hit.
    ///
    /// Without any, the lower is positive infinity and the upper negative.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        (self.bounds.min.into(), self.bounds.max.into())
    }

    fn root(&self) -> Option<Child> {
        (!self.nodes.is_empty()).then(|| Child::node(0))
    }
}
