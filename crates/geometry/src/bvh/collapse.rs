//! From the binary tree to the wide one.
//!
//! Which binary nodes become wide nodes, and which subtrees become leaves, is chosen for the least expected cost under
//! the surface area heuristic by dynamic programming (Ylitie, Karras and Laine, "Efficient Incoherent Ray Traversal on
//! GPUs Through Compressed Wide BVHs", HPG 2017, section 3.1).

use super::BvhParams;
use super::build::{BinaryTree, Primitive, join};
use super::node::{BLOCK, Block, BlockId, Child, Node, WIDTH};
use glam::Vec3;

/// The wide tree; its root is node 0. Empty without triangles.
pub(super) struct WideTree {
    pub nodes: Vec<Node>,
    pub blocks: Vec<Block>,
}

impl WideTree {
    pub fn new(tree: &BinaryTree, triangles: &[[Vec3; 3]], params: &BvhParams) -> Self {
        let mut wide = Self { nodes: Vec::new(), blocks: Vec::new() };
        if !tree.nodes.is_empty() {
            let plans = plan(tree, params);
            Collapse { tree, triangles, plans: &plans, wide: &mut wide }.node(0);
        }
        wide
    }
}

/// The least cost of turning one binary subtree into at most so many wide children, and how.
#[derive(Clone, Copy)]
struct Plan {
    /// By the number of children allowed, less one.
    cost: [f32; WIDTH - 1],
    /// How many of the children allowed go to the left half; zero where using one fewer is no worse. By the number of
    /// children allowed, less one. With one child allowed: zero for a leaf, one for a node.
    left: [u8; WIDTH],
}

impl Plan {
    const UNSET: Self = Self { cost: [f32::INFINITY; WIDTH - 1], left: [0; WIDTH] };
    const NODE: u8 = 1;
}

/// Plans all subtrees.
fn plan(tree: &BinaryTree, params: &BvhParams) -> Vec<Plan> {
    let mut plans = vec![Plan::UNSET; tree.nodes.len()];
    let most = params.max_leaf.clamp(1, BLOCK * Child::MAX_BLOCKS);
    Planner { tree, params, most }.fill(&mut plans, 0);
    plans
}

struct Planner<'a> {
    tree: &'a BinaryTree,
    params: &'a BvhParams,
    /// The most triangles in a leaf.
    most: usize,
}

impl Planner<'_> {
    /// Plans one subtree, children before parents. `plans` has the layout of its nodes.
    fn fill(&self, plans: &mut [Plan], index: usize) {
        let node = &self.tree.nodes[index];
        let (area, count) = (node.bounds.half_area(), node.count as usize);
        let leaf = if count <= self.most {
            area * self.params.block_cost * count.div_ceil(BLOCK) as f32
        } else {
            f32::INFINITY
        };
        if count == 1 {
            plans[0] = Plan { cost: [leaf; WIDTH - 1], ..Plan::UNSET };
            return;
        }
        let [left, right] = self.tree.children(index);
        let (this, below) = plans.split_first_mut().expect("a subtree has nodes");
        let (left_plans, right_plans) = below.split_at_mut(right - left);
        join(count, || self.fill(left_plans, left), || self.fill(right_plans, right));
        this.choose(leaf, area * self.params.node_cost, &left_plans[0], &right_plans[0]);
    }
}

impl Plan {
    /// Chooses between a leaf and a node of the given costs, and what to make of the two halves.
    fn choose(&mut self, leaf: f32, node: f32, left: &Self, right: &Self) {
        let (inside, share) = distribute(left, right, WIDTH);
        self.left[WIDTH - 1] = share;
        let node = node + inside;
        self.left[0] = if leaf <= node { 0 } else { Self::NODE };
        self.cost[0] = leaf.min(node);
        for allowed in 2..WIDTH {
            let (cost, share) = distribute(left, right, allowed);
            let fewer = self.cost[allowed - 2];
            (self.cost[allowed - 1], self.left[allowed - 1]) = if cost < fewer { (cost, share) } else { (fewer, 0) };
        }
    }
}

/// The cheapest way to share out `allowed` children among two halves: its cost and the share of the left.
fn distribute(left: &Plan, right: &Plan, allowed: usize) -> (f32, u8) {
    let mut best = (f32::INFINITY, 1);
    for share in 1..allowed {
        let cost = left.cost[share - 1] + right.cost[allowed - share - 1];
        if cost < best.0 {
            best = (cost, share as u8);
        }
    }
    best
}

struct Collapse<'a> {
    tree: &'a BinaryTree,
    triangles: &'a [[Vec3; 3]],
    plans: &'a [Plan],
    wide: &'a mut WideTree,
}

impl Collapse<'_> {
    /// Appends the wide node that stands for a binary one, and all below it.
    fn node(&mut self, binary: usize) -> usize {
        let index = self.wide.nodes.len();
        self.wide.nodes.push(Node::EMPTY);
        let mut members = Members::default();
        if self.tree.nodes[binary].count == 1 {
            members.push(binary);
        } else {
            self.gather_halves(binary, WIDTH, self.plans[binary].left[WIDTH - 1], &mut members);
        }
        for (slot, &member) in members.as_slice().iter().enumerate() {
            let child = self.child(member);
            self.set(index, slot, member, child);
        }
        index
    }

    fn set(&mut self, index: usize, slot: usize, member: usize, child: Child) {
        let node = &mut self.wide.nodes[index];
        let bounds = self.tree.nodes[member].bounds;
        for axis in 0..3 {
            node.planes[axis][slot] = bounds.min[axis];
            node.planes[axis + 3][slot] = bounds.max[axis];
        }
        node.children[slot] = child;
    }

    /// Lists the binary nodes that become the wide children of one subtree.
    fn gather(&self, binary: usize, allowed: usize, members: &mut Members) {
        let mut allowed = allowed;
        while allowed > 1 && self.plans[binary].left[allowed - 1] == 0 {
            allowed -= 1;
        }
        if allowed == 1 || self.tree.nodes[binary].count == 1 {
            members.push(binary);
        } else {
            self.gather_halves(binary, allowed, self.plans[binary].left[allowed - 1], members);
        }
    }

    fn gather_halves(&self, binary: usize, allowed: usize, share: u8, members: &mut Members) {
        let [left, right] = self.tree.children(binary);
        self.gather(left, usize::from(share), members);
        self.gather(right, allowed - usize::from(share), members);
    }

    fn child(&mut self, binary: usize) -> Child {
        let is_node = self.tree.nodes[binary].count > 1 && self.plans[binary].left[0] == Plan::NODE;
        if is_node { Child::node(self.node(binary)) } else { self.leaf(binary) }
    }

    fn leaf(&mut self, binary: usize) -> Child {
        let node = &self.tree.nodes[binary];
        let range = node.first as usize..(node.first + node.count) as usize;
        let first = self.wide.blocks.len();
        let blocks = self.tree.primitives[range].chunks(BLOCK).map(|chunk| block(chunk, self.triangles));
        self.wide.blocks.extend(blocks);
        Child::leaf(first, self.wide.blocks.len() - first)
    }
}

/// The binary nodes that become the children of one wide node.
#[derive(Default)]
struct Members {
    nodes: [usize; WIDTH],
    len: usize,
}

impl Members {
    fn push(&mut self, node: usize) {
        self.nodes[self.len] = node;
        self.len += 1;
    }
    fn as_slice(&self) -> &[usize] {
        &self.nodes[..self.len]
    }
}

/// Packs up to four triangles.
fn block(primitives: &[Primitive], triangles: &[[Vec3; 3]]) -> Block {
    let mut block = Block::EMPTY;
    for (lane, primitive) in primitives.iter().enumerate() {
        let triangle = &triangles[primitive.triangle as usize];
        let rotation = rotation(triangle);
        block.ids[lane] = BlockId::new(primitive.triangle, rotation as u32);
        for corner in 0..3 {
            let point = triangle[(corner + rotation) % 3];
            for axis in 0..3 {
                block.corners[axis][corner][lane] = point[axis];
            }
        }
    }
    block
}

/// The corner that lies between the two shorter edges, the one opposite the longest.
fn rotation(triangle: &[Vec3; 3]) -> usize {
    let opposite = |corner: usize| {
        let [p, q] = [1, 2].map(|step| triangle[(corner + step) % 3].as_dvec3());
        p.distance_squared(q)
    };
    let longest = if opposite(1) > opposite(0) { 1 } else { 0 };
    if opposite(2) > opposite(longest) { 2 } else { longest }
}
