//! How to build a tree.

/// How to build a [`Bvh`](super::Bvh): by intent from one of the presets, or field by field.
#[derive(Clone, Debug, PartialEq)]
pub struct BvhParams {
    /// Candidate planes per axis at each split, 2 to 32. More find slightly better splits in slightly more time.
    pub bins: usize,
    /// Ranges of up to this many triangles are split at the best of all positions instead of at a bin, 0 to 64.
    pub sweep: usize,
    /// The most triangles in a leaf, 1 to 32. A leaf is tested four triangles at a time.
    pub max_leaf: usize,
    /// The cost of testing a node's boxes, in any unit. Only its ratio to `block_cost` matters.
    pub node_cost: f32,
    /// The cost of testing four triangles, in the unit of `node_cost`.
    pub block_cost: f32,
}

impl Default for BvhParams {
    /// A good tree soon: for all but the shortest and the longest of computations.
    fn default() -> Self {
        Self { bins: 16, sweep: 16, max_leaf: 8, node_cost: 1.0, block_cost: 0.6 }
    }
}

impl BvhParams {
    /// For scenes that change often and see few rays.
    pub fn fast_build() -> Self {
        Self { bins: 8, sweep: 0, ..Self::default() }
    }

    /// For scenes that see many rays per triangle.
    pub fn fast_rays() -> Self {
        Self { bins: 32, sweep: 64, ..Self::default() }
    }
}
