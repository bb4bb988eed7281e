//! Places by number: what lies closer together than the tolerance is one place.

use std::collections::HashMap;

use glam::{DVec3, I64Vec3};

/// The side of the cells that places are looked up by, in tolerances.
const CELL: f64 = 4.0;

/// Numbered places. The first of several that are too close to tell apart stands for all.
pub(super) struct Points {
    places: Vec<DVec3>,
    cells: HashMap<I64Vec3, Vec<u32>>,
    tolerance: f64,
}

impl Points {
    pub(super) fn new(tolerance: f64) -> Self {
        Self { places: Vec::new(), cells: HashMap::new(), tolerance }
    }

    pub(super) fn place(&self, id: u32) -> DVec3 {
        self.places[id as usize]
    }

    /// The number of a place, a new one if none is near.
    pub(super) fn id(&mut self, p: DVec3) -> u32 {
        self.nearest(p).unwrap_or_else(|| {
            let id = self.places.len() as u32;
            self.places.push(p);
            self.cells.entry(self.cell(p)).or_default().push(id);
            id
        })
    }

    fn nearest(&self, p: DVec3) -> Option<u32> {
        let (low, high) = (self.cell(p - self.tolerance), self.cell(p + self.tolerance));
        let mut best = (self.tolerance, None);
        for x in low.x..=high.x {
            for y in low.y..=high.y {
                for z in low.z..=high.z {
                    for &id in self.cells.get(&I64Vec3::new(x, y, z)).into_iter().flatten() {
                        let distance = self.place(id).distance(p);
                        let is_closer = distance < best.0 || (distance == best.0 && best.1.is_none_or(|b| id < b));
                        if is_closer {
                            best = (distance, Some(id));
                        }
                    }
                }
            }
        }
        best.1
    }

    fn cell(&self, p: DVec3) -> I64Vec3 {
        (p / (CELL * self.tolerance)).floor().as_i64vec3()
    }
}
