//! What traversal reads: wide nodes, blocks of triangles, and the references between them.

/// How many children a wide node has.
pub(super) const WIDTH: usize = 8;
/// How many triangles one block holds.
pub(super) const BLOCK: usize = 4;
/// The most triangles in one tree: block numbers and triangle ids leave a few bits for other use.
pub(super) const MAX_TRIANGLES: usize = 1 << 28;
/// The largest coordinate that a triangle or an origin may have, and a direction; its inverse is the least speed.
///
/// Within these limits nothing overflows: distances are products of a coordinate with a reciprocal of at most 1e24, and
/// triangle tests multiply three coordinates.
pub(super) const MAX_COORDINATE: f32 = 1e12;

/// A wide node, four cache lines: the boxes of eight children, plane by plane.
///
/// A slot without a child has an inverted infinite box, which no ray hits.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct Node {
    /// Lower planes in x, y, z, then upper planes in x, y, z.
    pub planes: [[f32; WIDTH]; 6],
    /// What lies in each box.
    pub children: [Child; WIDTH],
}

impl Node {
    /// A node without children.
    pub const EMPTY: Self = Self {
        planes: [
            [f32::INFINITY; WIDTH],
            [f32::INFINITY; WIDTH],
            [f32::INFINITY; WIDTH],
            [f32::NEG_INFINITY; WIDTH],
            [f32::NEG_INFINITY; WIDTH],
            [f32::NEG_INFINITY; WIDTH],
        ],
        children: [Child::NONE; WIDTH],
    };
}

/// A reference to a node, or to a run of triangle blocks, or to nothing, in 32 bits.
///
/// Bit 31 marks a leaf. A leaf keeps its number of blocks less one in bits 28 to 30 and its first block below.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(transparent)]
pub(super) struct Child(pub u32);

impl Child {
    /// The empty slot: reads as node 0, which is no child of any node.
    pub const NONE: Self = Self(0);
    /// The most blocks in one leaf.
    pub const MAX_BLOCKS: usize = 8;
    const LEAF: u32 = 1 << 31;
    const COUNT_SHIFT: u32 = 28;
    const FIRST_MASK: u32 = (1 << Self::COUNT_SHIFT) - 1;

    pub fn node(index: usize) -> Self {
        debug_assert!(index < Self::LEAF as usize);
        Self(index as u32)
    }

    pub fn leaf(first_block: usize, blocks: usize) -> Self {
        debug_assert!(first_block <= Self::FIRST_MASK as usize && (1..=Self::MAX_BLOCKS).contains(&blocks));
        Self(Self::LEAF | ((blocks as u32 - 1) << Self::COUNT_SHIFT) | first_block as u32)
    }

    #[inline(always)]
    pub fn is_leaf(self) -> bool {
        self.0 & Self::LEAF != 0
    }

    /// The node's number; only for a child that is not a leaf.
    #[inline(always)]
    pub fn index(self) -> usize {
        self.0 as usize
    }

    /// The numbers of a leaf's blocks.
    #[inline(always)]
    pub fn blocks(self) -> std::ops::Range<usize> {
        let first = (self.0 & Self::FIRST_MASK) as usize;
        let more = (self.0 >> Self::COUNT_SHIFT) as usize & (Self::MAX_BLOCKS - 1);
        first..first + more + 1
    }
}

/// Up to four triangles, coordinate by coordinate.
///
/// The corners of each triangle are rotated so that the first lies between the two shorter edges; `ids` remembers how
/// far. A lane without a triangle holds NaNs, which no ray hits.
#[derive(Clone, Debug)]
#[repr(C, align(16))]
pub(super) struct Block {
    /// By axis, then by corner.
    pub corners: [[[f32; BLOCK]; 3]; 3],
    /// Which triangle, and how far its corners are rotated.
    pub ids: [BlockId; BLOCK],
}

impl Block {
    /// A block without triangles.
    pub const EMPTY: Self = Self { corners: [[[f32::NAN; BLOCK]; 3]; 3], ids: [BlockId::NONE; BLOCK] };
}

/// The caller's triangle index in the upper 30 bits, the rotation of the corners (0, 1 or 2) in the lower two.
///
/// Ordered as the triangle indices are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(transparent)]
pub(super) struct BlockId(u32);

impl BlockId {
    pub const NONE: Self = Self(u32::MAX);

    pub fn new(triangle: u32, rotation: u32) -> Self {
        debug_assert!((triangle as usize) < MAX_TRIANGLES && rotation < 3);
        Self(triangle << 2 | rotation)
    }

    #[inline(always)]
    pub fn triangle(self) -> u32 {
        self.0 >> 2
    }

    /// The caller's corner number of our first corner.
    #[inline(always)]
    pub fn rotation(self) -> u32 {
        self.0 & 3
    }
}
