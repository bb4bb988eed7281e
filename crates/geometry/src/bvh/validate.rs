//! The invariants of a tree, for tests and for those who doubt.

use super::Bvh;
use super::bounds::Bounds;
use super::node::{BLOCK, BlockId, Child, WIDTH};
use super::stack::MAX_DEPTH;
use glam::{Vec3, Vec3A};

impl Bvh {
    /// Checks every invariant of the tree.
    ///
    /// That is: boxes contain what lies below them; every node and every block is reached exactly once; every
    /// triangle is in at most one leaf, and in one if it can be hit; the tree is no deeper than traversal can follow.
    ///
    /// # Errors
    /// The first violation found, in words.
    pub fn validate(&self) -> Result<(), String> {
        let mut seen = Seen {
            nodes: vec![false; self.nodes.len()],
            blocks: vec![false; self.blocks.len()],
            triangles: vec![false; self.triangle_count],
        };
        if let Some(root) = self.root() {
            let bounds = self.check_child(root, 1, &mut seen)?;
            if bounds != self.bounds {
                return Err(format!("the root spans {bounds:?}, the tree says {:?}", self.bounds));
            }
        }
        seen.all(self.leaf_triangles)
    }

    /// The expected cost of a random ray that meets the box of the whole, by the surface area heuristic.
    ///
    /// In the unit of [`BvhParams::node_cost`](super::BvhParams::node_cost). Trees over the same triangles compare by
    /// it: half the cost is about twice the rays per second.
    pub fn sah_cost(&self) -> f32 {
        let whole = f64::from(self.bounds.half_area());
        let mut cost = whole * f64::from(self.node_cost);
        for node in &self.nodes {
            for slot in (0..WIDTH).filter(|&slot| node.children[slot] != Child::NONE) {
                let child = node.children[slot];
                let each = if child.is_leaf() { self.block_cost * child.blocks().len() as f32 } else { self.node_cost };
                cost += f64::from(node.bounds(slot).half_area()) * f64::from(each);
            }
        }
        if whole > 0.0 { (cost / whole) as f32 } else { 0.0 }
    }

    /// Checks what lies below one reference and returns its exact bounds.
    fn check_child(&self, child: Child, depth: usize, seen: &mut Seen) -> Result<Bounds, String> {
        if child.is_leaf() {
            return self.check_leaf(child, seen);
        }
        if depth > MAX_DEPTH {
            return Err(format!("deeper than {MAX_DEPTH} levels"));
        }
        mark(&mut seen.nodes, child.index(), "node")?;
        let node = &self.nodes[child.index()];
        let mut all = Bounds::EMPTY;
        for slot in 0..WIDTH {
            let bounds = node.bounds(slot);
            if node.children[slot] == Child::NONE {
                if bounds != Bounds::EMPTY {
                    return Err(format!("empty slot {slot} of node {} has a box", child.index()));
                }
                continue;
            }
            let below = self.check_child(node.children[slot], depth + 1, seen)?;
            if !bounds.contains(below) {
                return Err(format!("box {slot} of node {} does not contain {below:?}", child.index()));
            }
            all = all.union(bounds);
        }
        Ok(all)
    }

    fn check_leaf(&self, child: Child, seen: &mut Seen) -> Result<Bounds, String> {
        let mut all = Bounds::EMPTY;
        for index in child.blocks() {
            mark(&mut seen.blocks, index, "block")?;
            let block = &self.blocks[index];
            for lane in 0..BLOCK {
                let corners = [0, 1, 2].map(|corner| block.corner(corner, lane));
                if block.ids[lane] == BlockId::NONE {
                    if !corners.iter().all(|corner| corner.is_nan()) {
                        return Err(format!("empty lane {lane} of block {index} has corners"));
                    }
                    continue;
                }
                mark(&mut seen.triangles, block.ids[lane].triangle() as usize, "triangle")?;
                if !super::build::can_be_hit(&corners) {
                    return Err(format!("triangle {} cannot be hit", block.ids[lane].triangle()));
                }
                all = all.union(Bounds::of_points(&corners));
            }
        }
        Ok(all)
    }
}

impl super::node::Node {
    fn bounds(&self, slot: usize) -> Bounds {
        let corner = |from: usize| Vec3A::from_array([0, 1, 2].map(|axis| self.planes[from + axis][slot]));
        Bounds { min: corner(0), max: corner(3) }
    }
}

impl super::node::Block {
    fn corner(&self, corner: usize, lane: usize) -> Vec3 {
        Vec3::from_array([0, 1, 2].map(|axis| self.corners[axis][corner][lane]))
    }
}

/// What a walk has come across.
struct Seen {
    nodes: Vec<bool>,
    blocks: Vec<bool>,
    triangles: Vec<bool>,
}

impl Seen {
    /// Nodes, blocks and all triangles that can be hit must have been reached.
    fn all(&self, triangles: usize) -> Result<(), String> {
        let found = self.triangles.iter().filter(|&&seen| seen).count();
        if found != triangles {
            return Err(format!("{found} triangles in leaves where {triangles} can be hit"));
        }
        for (what, seen) in [("node", &self.nodes), ("block", &self.blocks)] {
            if let Some(index) = seen.iter().position(|seen| !seen) {
                return Err(format!("{what} {index} is not part of the tree"));
            }
        }
        Ok(())
    }
}

fn mark(seen: &mut [bool], index: usize, what: &str) -> Result<(), String> {
    match seen.get_mut(index) {
        None => Err(format!("{what} {index} does not exist")),
        Some(true) => Err(format!("{what} {index} is reached twice")),
        Some(mark) => {
            *mark = true;
            Ok(())
        }
    }
}
