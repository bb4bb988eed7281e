//! What shoots and receives: equal parts of sides.
//!
//! Sides of small scenes are cut into 4 or 16 cells of their chart, so that what varies within a patch is seen by others
//! as it varies. In large scenes a side is one cell.

use radiosity_exchange::Enclosure;
use radiosity_exchange::enclosure::{Landing, Sight};
use radiosity_exchange::shots::Cell;
use radiosity_geometry::DVec3;
use radiosity_geometry::bvh::{Hit, Ray};
use radiosity_geometry::sampling::Frame;

/// Most sides that are cut into 16 cells, and into 4.
const MOST_SIDES: [(usize, u32); 2] = [(2_500, 2), (100_000, 1)];

/// The share of what the last halving of a side changed that is still wrong, at levels 0, 1 and 2: first order in the
/// size of a cell, which is the worst case. At level 0 what changes is the mean of two neighbours.
const ERROR_LEFT: [f64; 3] = [1.0, 0.5, 0.25];

/// The cells of an enclosure; those of a side follow each other.
pub(super) struct Cells<'a> {
    pub enclosure: &'a Enclosure,
    level: u32,
}

impl<'a> Cells<'a> {
    pub fn new(enclosure: &'a Enclosure) -> Self {
        let level = MOST_SIDES.iter().find(|(most, _)| enclosure.sides() <= *most).map_or(0, |(_, level)| *level);
        Self { enclosure, level }
    }

    /// One a side.
    pub fn whole(enclosure: &'a Enclosure) -> Self {
        Self { enclosure, level: 0 }
    }

    /// The number of cells.
    pub fn count(&self) -> usize {
        self.enclosure.sides() << (2 * self.level)
    }

    /// Cells of each side.
    pub fn per_side(&self) -> usize {
        1 << (2 * self.level)
    }

    pub fn side_of(&self, cell: usize) -> usize {
        cell >> (2 * self.level)
    }

    pub fn patch_of(&self, cell: usize) -> usize {
        self.enclosure.patch_of(self.side_of(cell))
    }

    pub fn area(&self, cell: usize) -> f64 {
        self.enclosure.area(self.side_of(cell)) / self.per_side() as f64
    }

    pub fn frame(&self, cell: usize) -> Frame {
        self.enclosure.frame(self.side_of(cell))
    }

    /// The cell within its side of a point on the chart.
    pub fn within(&self, point: Cell) -> usize {
        point.coarse(self.level)
    }

    /// A point just off a cell at coordinates `(s, t)` of the cell in the unit square.
    #[inline]
    pub fn point_off(&self, cell: usize, s: f64, t: f64) -> DVec3 {
        let within = cell & (self.per_side() - 1);
        let (row, column) = (within >> self.level, within & ((1 << self.level) - 1));
        let scale = 1.0 / f64::from(1u32 << self.level);
        self.enclosure.point_off(self.side_of(cell), scale * (row as f64 + s), scale * (column as f64 + t))
    }

    /// Where a ray landed: a cell in place of its side.
    #[inline]
    pub fn landing(&self, ray: &Ray, hit: &Hit) -> Landing {
        if self.level == 0 {
            return self.enclosure.landing(ray.direction, hit);
        }
        match self.enclosure.sight(ray.direction, hit) {
            Sight::Escaped => Landing::Escaped,
            Sight::Back => Landing::Back,
            Sight::Side(side, s, t) => Landing::Side(side << (2 * self.level) | self.within(Cell::new(s, t)) as u32),
        }
    }

    /// Cells whose mean is what a coarser computation would see in place of this one: those of its side, or, where a
    /// side is one cell, it and its neighbour in the same surface, if that faces about the same way.
    pub fn coarser(&self, cell: usize) -> std::ops::Range<usize> {
        if self.level > 0 {
            let first = self.side_of(cell) << (2 * self.level);
            return first..first + self.per_side();
        }
        let (first, second) = (cell & !1, cell | 1);
        let enclosure = self.enclosure;
        if second >= self.count() || enclosure.is_front(first) != enclosure.is_front(second) {
            return cell..cell + 1;
        }
        let surface = &enclosure.patches().surface;
        let alike = surface[self.patch_of(first)] == surface[self.patch_of(second)]
            && enclosure.normal(first).dot(enclosure.normal(second)) > 0.8;
        if alike { first..second + 1 } else { cell..cell + 1 }
    }

    /// What of the change from coarser to these cells is still wrong.
    pub fn error_left(&self) -> f64 {
        ERROR_LEFT[self.level as usize]
    }
}
