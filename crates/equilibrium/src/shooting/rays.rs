//! Rays of many sides traced together, in an order in which neighbours take similar ways through the hierarchy.

use super::cells::Cells;
use radiosity_exchange::enclosure::Landing;
use radiosity_geometry::Vec3;
use radiosity_geometry::bvh::{Hit, Ray};

/// Rays of a batch: enough to sort, few enough to stay in the cache.
pub(super) const BATCH: usize = 4096;

/// Directions are sorted into 8 x 8 cells of the octahedron.
const CELLS: usize = 64;

/// Rays that wait to be traced, each with a tag by which its shooter knows it.
#[derive(Default)]
pub(super) struct Batch {
    rays: Vec<Ray>,
    tags: Vec<u32>,
    ordered: Vec<Ray>,
    slots: Vec<u32>,
    hits: Vec<Hit>,
}

impl Batch {
    pub fn push(&mut self, ray: Ray, tag: u32) {
        self.rays.push(ray);
        self.tags.push(tag);
    }

    pub fn is_full(&self) -> bool {
        self.rays.len() >= BATCH
    }

    /// Traces what waits, tells of each ray its tag and where it landed, and is empty again.
    pub fn trace(&mut self, cells: &Cells, mut tell: impl FnMut(u32, &Ray, Landing)) {
        self.order();
        self.hits.clear();
        self.hits.resize(self.ordered.len(), Hit::MISS);
        cells.enclosure.bvh().closest_hits(&self.ordered, &mut self.hits);
        for ((ray, hit), &slot) in self.ordered.iter().zip(&self.hits).zip(&self.slots) {
            tell(self.tags[slot as usize], ray, cells.landing(ray, hit));
        }
        self.rays.clear();
        self.tags.clear();
    }

    /// Sorts by direction; what has one direction stays in the order it came in.
    fn order(&mut self) {
        let mut starts = [0u32; CELLS + 1];
        for ray in &self.rays {
            starts[cell(ray.direction) + 1] += 1;
        }
        for k in 0..CELLS {
            starts[k + 1] += starts[k];
        }
        self.slots.clear();
        self.slots.resize(self.rays.len(), 0);
        for (slot, ray) in self.rays.iter().enumerate() {
            let start = &mut starts[cell(ray.direction)];
            self.slots[*start as usize] = slot as u32;
            *start += 1;
        }
        self.ordered.clear();
        self.ordered.extend(self.slots.iter().map(|&slot| self.rays[slot as usize]));
    }
}

/// The cell of a direction on the unfolded octahedron (Meyer et al. 2010, *On floating-point normal vectors*).
#[inline]
fn cell(direction: Vec3) -> usize {
    let d = direction / (direction.x.abs() + direction.y.abs() + direction.z.abs());
    let (x, y) =
        if d.z >= 0.0 { (d.x, d.y) } else { ((1.0 - d.y.abs()).copysign(d.x), (1.0 - d.x.abs()).copysign(d.y)) };
    let index = |v: f32| ((v * 4.0 + 4.0) as usize).min(7);
    8 * index(x) + index(y)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn opposite_directions_have_cells_of_their_own() {
        let axes = [Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z].map(|d| cell(d + Vec3::splat(1e-3)));
        for (i, a) in axes.iter().enumerate() {
            assert!(*a < CELLS && axes[..i].iter().all(|b| a != b), "{axes:?}");
        }
    }
}
