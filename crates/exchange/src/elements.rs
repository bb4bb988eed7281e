//! Elements: the sides cut into equal-area cells, the unit of the computation.
//!
//! Patches are the unit of the answer. Light within a patch varies; cutting sides into elements where it pays makes
//! what other patches see of it more exact while the answer stays one value a patch. Samples remember their cells,
//! so elements can be chosen after sampling and chosen again without a new ray.

use crate::enclosure::Enclosure;
use crate::shots::Cell;

/// `2^level x 2^level` elements per side.
#[derive(Clone, Debug)]
pub struct Elements {
    levels: Vec<u8>,
    offsets: Vec<u32>,
}

impl Elements {
    /// Cuts side `i` into `4^levels[i]` elements.
    pub fn new(levels: Vec<u8>) -> Self {
        let mut offsets = Vec::with_capacity(levels.len() + 1);
        offsets.push(0);
        for &level in &levels {
            offsets.push(offsets.last().unwrap() + (1u32 << (2 * level)));
        }
        Self { levels, offsets }
    }

    /// One element per side.
    pub fn whole(enclosure: &Enclosure) -> Self {
        Self::new(vec![0; enclosure.sides()])
    }

    /// The number of elements.
    pub fn len(&self) -> usize {
        *self.offsets.last().unwrap() as usize
    }

    /// Whether there are no elements.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The number of sides.
    pub fn sides(&self) -> usize {
        self.levels.len()
    }

    /// How often a side is halved in each direction.
    pub fn level(&self, side: usize) -> u32 {
        u32::from(self.levels[side])
    }

    /// The ids of the elements of a side.
    pub fn of(&self, side: usize) -> std::ops::Range<usize> {
        self.offsets[side] as usize..self.offsets[side + 1] as usize
    }

    /// The element of a side that holds a cell.
    #[inline]
    pub fn at(&self, side: usize, cell: Cell) -> usize {
        self.offsets[side] as usize + cell.coarse(u32::from(self.levels[side]))
    }
}
