//! Rows of the exchange by rays: what a side sees when it looks in cosine-distributed directions.
//!
//! Origins fill the patch and directions the hemisphere together, by one four-dimensional low-discrepancy sequence
//! per replicate, so a row of n rays has the error of a four-dimensional quasi-Monte Carlo rule. A ray carries the
//! fraction 1/n of what leaves its side: the form factor to a side is the share of rays that hit it (Malley 1988).
//! There is no singularity where patches touch.
//!
//! Rays that meet mirrors and clear glass go on (`specular.rs`), all of a side in step. Whether one survives is decided
//! by further dimensions of its own sequence, so that a form factor stays the share of the rays that land.

use crate::enclosure::{Enclosure, Sight};
use crate::images::survival;
use crate::samples::Samples;
use crate::specular::{MOST_MEETINGS, Specular, Step};
use radiosity_geometry::bvh::{Hit, Ray};
use radiosity_geometry::sampling::{Sequence, cosine_hemisphere};
use radiosity_operator::{Cancelled, Control};

/// One ray from a side: where it started and what it found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shot {
    /// Where it landed, and in the first bit whether it is beyond images.
    bits: u32,
    /// The cell of the target's chart it hit.
    pub target_cell: Cell,
    /// The cell of its own side's chart it left.
    pub origin_cell: Cell,
}

impl Shot {
    /// The ray left the scene.
    pub const ESCAPED: u32 = !Self::BEYOND_IMAGES;
    /// The ray ended on the black back of a one-sided patch.
    pub const BACK: u32 = Self::ESCAPED - 1;
    /// The ray's origin lies inside a solid that stands on the patch: that part of the patch sees and sends nothing.
    pub const BURIED: u32 = Self::ESCAPED - 2;
    /// The ray met more mirrors and panes than are followed.
    pub const LOST: u32 = Self::ESCAPED - 3;

    const BEYOND_IMAGES: u32 = 1 << 31;

    /// The side it hit, or one of the codes above.
    #[inline]
    pub fn target(&self) -> u32 {
        self.bits & !Self::BEYOND_IMAGES
    }

    /// Whether the ray hit a side.
    #[inline]
    pub fn landed(&self) -> bool {
        Self::is_side(self.target())
    }

    /// Whether a target is a side.
    #[inline]
    pub fn is_side(target: u32) -> bool {
        target < Self::LOST
    }

    /// Whether it came by more mirrors than images of luminaires are followed through: what it sees of a luminaire is
    /// not seen otherwise.
    #[inline]
    pub fn is_beyond_images(&self) -> bool {
        self.bits & Self::BEYOND_IMAGES != 0
    }
}

impl Default for Shot {
    fn default() -> Self {
        Self { bits: Self::ESCAPED, target_cell: Cell::default(), origin_cell: Cell::default() }
    }
}

/// One of the 256 x 256 equal-area cells of a chart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cell(u16);

impl Cell {
    /// The cell of chart coordinates in the unit square.
    #[inline]
    pub fn new(s: f64, t: f64) -> Self {
        let quantised = |x: f64| (x * 256.0).clamp(0.0, 255.0) as u16;
        Cell(quantised(s) << 8 | quantised(t))
    }

    /// Its index in a coarser grid of `2^level x 2^level` cells, row by row.
    #[inline]
    pub fn coarse(self, level: u32) -> usize {
        let (s, t) = (u32::from(self.0 >> 8), u32::from(self.0 & 255));
        ((s >> (8 - level)) << level | t >> (8 - level)) as usize
    }
}

/// The stream of the sequence that feeds rows.
const STREAM: u32 = 1;

/// Shoots until side `i` has `wanted[i]` rays per replicate.
pub fn shoot(
    enclosure: &Enclosure,
    shots: &mut Samples<Shot>,
    wanted: &[u32],
    seed: u64,
    control: &Control,
) -> Result<(), Cancelled> {
    shoot_beyond(enclosure, shots, wanted, seed, 0, control)
}

/// The same, where images of luminaires are followed through so many mirrors: rays remember whether they met more.
pub fn shoot_beyond(
    enclosure: &Enclosure,
    shots: &mut Samples<Shot>,
    wanted: &[u32],
    seed: u64,
    imaged: u32,
    control: &Control,
) -> Result<(), Cancelled> {
    let replicates = shots.replicates();
    shots.draw(wanted, control, Row::default, |row, side, first, items| {
        if enclosure.area(side) > 0.0 {
            row.shoot(enclosure, side, first, replicates, seed, imaged, items);
        }
    })
}

/// Buffers for the rays of one side.
#[derive(Default)]
struct Row {
    rays: Vec<Ray>,
    hits: Vec<Hit>,
    /// Where each ray's shot goes.
    slots: Vec<u32>,
    cells: Vec<Cell>,
    keys: Vec<u8>,
    ordered: Vec<Ray>,
    chains: Vec<Chain>,
}

/// A ray on its way by mirrors and panes.
#[derive(Clone, Copy)]
struct Chain {
    slot: u32,
    /// How many mirrors it met.
    reflections: u32,
}

impl Row {
    fn shoot(
        &mut self,
        enclosure: &Enclosure,
        side: usize,
        first: u32,
        replicates: usize,
        seed: u64,
        imaged: u32,
        out: &mut [Shot],
    ) {
        self.generate(enclosure, side, first, replicates, seed, out.len());
        self.order();
        self.hits.resize(self.ordered.len(), Hit::MISS);
        enclosure.bvh().closest_hits(&self.ordered, &mut self.hits);
        if let Some(specular) = enclosure.specular() {
            let keys = Keys { seed, side, first, each: (out.len() / replicates) as u32 };
            return self.follow(enclosure, specular, &keys, imaged, out);
        }
        for ((ray, hit), &slot) in self.ordered.iter().zip(&self.hits).zip(&self.slots) {
            let sight = enclosure.sight(ray.direction, hit);
            let buried = sight == Sight::Back && is_buried(enclosure, side, ray);
            out[slot as usize] = landed(sight, buried, 0, self.cells[slot as usize]);
        }
    }

    /// Takes rays on from mirrors and panes, all of them by one meeting at a time, until none is left.
    fn follow(&mut self, enclosure: &Enclosure, specular: &Specular, keys: &Keys, imaged: u32, out: &mut [Shot]) {
        self.chains.clear();
        self.chains.extend(self.slots.iter().map(|&slot| Chain { slot, reflections: 0 }));
        let mut met = 0;
        while !self.chains.is_empty() {
            let mut kept = 0;
            for k in 0..self.chains.len() {
                let (mut chain, ray, hit) = (self.chains[k], self.ordered[k], self.hits[k]);
                let origin_cell = self.cells[chain.slot as usize];
                match enclosure.step(specular, &ray, &hit, || keys.survival(chain.slot, met)) {
                    Step::On { ray, reflected } => {
                        chain.reflections += u32::from(reflected);
                        (self.chains[kept], self.ordered[kept]) = (chain, ray);
                        kept += 1;
                    }
                    Step::End(sight) => {
                        let buried = sight == Sight::Back && met == 0 && is_buried(enclosure, keys.side, &ray);
                        let beyond = if chain.reflections > imaged { Shot::BEYOND_IMAGES } else { 0 };
                        out[chain.slot as usize] = landed(sight, buried, beyond, origin_cell);
                    }
                }
            }
            self.chains.truncate(kept);
            self.ordered.truncate(kept);
            met += 1;
            if met == MOST_MEETINGS {
                for chain in self.chains.drain(..) {
                    let origin_cell = self.cells[chain.slot as usize];
                    out[chain.slot as usize] = Shot { bits: Shot::LOST, target_cell: Cell::default(), origin_cell };
                }
            }
            self.hits.resize(kept, Hit::MISS);
            enclosure.bvh().closest_hits(&self.ordered, &mut self.hits);
        }
    }

    /// Fills `rays`, in the order of the sequence.
    fn generate(&mut self, enclosure: &Enclosure, side: usize, first: u32, replicates: usize, seed: u64, count: usize) {
        let frame = enclosure.frame(side);
        let each = (count / replicates) as u32;
        self.rays.clear();
        self.cells.clear();
        self.keys.clear();
        for replicate in 0..replicates {
            let sequence = Sequence::new(seed, side as u32, replicate as u32, STREAM);
            for index in first..first + each {
                let [u, v, s, t] = sequence.point(index);
                let direction = cosine_hemisphere(&frame, u, v);
                self.rays.push(enclosure.ray(enclosure.point_off(side, s, t), direction));
                self.cells.push(Cell::new(s, t));
                self.keys.push(Cell::new(u, v).coarse(DIRECTION_LEVEL) as u8);
            }
        }
    }

    /// Sorts the rays by direction, so that neighbours in the batch take similar ways through the hierarchy.
    fn order(&mut self) {
        let mut starts = [0u32; DIRECTION_CELLS + 1];
        for &key in &self.keys {
            starts[key as usize + 1] += 1;
        }
        for k in 0..DIRECTION_CELLS {
            starts[k + 1] += starts[k];
        }
        self.slots.clear();
        self.slots.resize(self.rays.len(), 0);
        for (slot, &key) in self.keys.iter().enumerate() {
            self.slots[starts[key as usize] as usize] = slot as u32;
            starts[key as usize] += 1;
        }
        self.ordered.clear();
        self.ordered.extend(self.slots.iter().map(|&slot| self.rays[slot as usize]));
    }
}

/// What a ray that ended somewhere is remembered as.
fn landed(sight: Sight, buried: bool, beyond: u32, origin_cell: Cell) -> Shot {
    let (target, target_cell) = match sight {
        Sight::Escaped => (Shot::ESCAPED, Cell::default()),
        Sight::Side(side, s, t) => (side | beyond, Cell::new(s, t)),
        Sight::Back if buried => (Shot::BURIED, Cell::default()),
        Sight::Back => (Shot::BACK, Cell::default()),
    };
    Shot { bits: target, target_cell, origin_cell }
}

/// What the rays of a side are drawn from.
struct Keys {
    seed: u64,
    side: usize,
    first: u32,
    /// Rays per replicate.
    each: u32,
}

impl Keys {
    /// What decides whether a ray survives what it meets after `met` others.
    fn survival(&self, slot: u32, met: u32) -> f64 {
        let (replicate, index) = (slot / self.each, self.first + slot % self.each);
        survival(&Sequence::new(self.seed, self.side as u32, replicate, STREAM), index, met)
    }
}

/// Directions are sorted into 8 x 8 cells of equal solid-angle measure.
const DIRECTION_LEVEL: u32 = 3;
const DIRECTION_CELLS: usize = 1 << (2 * DIRECTION_LEVEL);

/// Whether a ray that found a black back started inside a solid: then every direction finds a back.
///
/// Four more looks decide: straight up and to three sides. A point outside would have to see the inside of faces,
/// that is, wrongly oriented ones, in all five directions to be taken for buried.
pub fn is_buried(enclosure: &Enclosure, side: usize, ray: &Ray) -> bool {
    let frame = enclosure.frame(side);
    let (z, r) = (0.6, 0.8);
    if enclosure.specular().is_some() && !enclosure.is_opaque_back(ray.direction, &enclosure.bvh().closest_hit(ray)) {
        return false;
    }
    [(0.0, 0.0, 1.0), (r, 0.0, z), (-0.5 * r, 0.866 * r, z), (-0.5 * r, -0.866 * r, z)].into_iter().all(|(x, y, z)| {
        let direction = (x * frame.tangent + y * frame.bitangent + z * frame.normal).as_vec3();
        let look = Ray { direction, ..*ray };
        enclosure.is_opaque_back(direction, &enclosure.bvh().closest_hit(&look))
    })
}
