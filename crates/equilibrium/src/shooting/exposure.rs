//! How much of every cell is not buried under a solid that stands on it.

use super::cells::Cells;
use radiosity_exchange::Enclosure;
use radiosity_exchange::enclosure::Landing;
use radiosity_exchange::shots::is_buried;
use radiosity_geometry::bvh::{Hit, Ray};
use radiosity_geometry::sampling::Sequence;
use radiosity_operator::{Cancelled, Control};
use rayon::prelude::*;

/// Points of a cell that look up; as many again and again where some are buried and others not.
const PROBES: u32 = 8;
const MORE_PROBES: u32 = 128;

/// The stream of the sequence that feeds them.
const STREAM: u32 = 4;

/// The exposed share of each cell: 1 where nothing stands on it.
pub(super) fn exposure(cells: &Cells, seed: u64, control: &Control) -> Result<Vec<f32>, Cancelled> {
    (0..cells.count())
        .into_par_iter()
        .with_min_len(256)
        .map_init(
            || (Vec::new(), Vec::new()),
            |(rays, hits), cell| {
                control.check()?;
                let sequence = Sequence::new(seed, cell as u32, 0, STREAM);
                let mut buried = |range: std::ops::Range<u32>| buried(cells, cell, &sequence, range, rays, hits);
                let few = buried(0..PROBES);
                let share = match few {
                    0 => 0.0,
                    PROBES => 1.0,
                    _ => (few + buried(PROBES..MORE_PROBES)) as f32 / MORE_PROBES as f32,
                };
                Ok(1.0 - share)
            },
        )
        .collect()
}

/// The same of whole sides.
pub(crate) fn exposure_of_sides(enclosure: &Enclosure, seed: u64, control: &Control) -> Result<Vec<f32>, Cancelled> {
    exposure(&Cells::whole(enclosure), seed, control)
}

fn buried(
    cells: &Cells,
    cell: usize,
    sequence: &Sequence,
    range: std::ops::Range<u32>,
    rays: &mut Vec<Ray>,
    hits: &mut Vec<Hit>,
) -> u32 {
    let (enclosure, side) = (cells.enclosure, cells.side_of(cell));
    if enclosure.area(side) == 0.0 {
        return 0;
    }
    let up = enclosure.normal(side).as_vec3();
    rays.clear();
    rays.extend(range.map(|k| {
        let [_, _, s, t] = sequence.point(k);
        enclosure.ray(cells.point_off(cell, s, t), up)
    }));
    hits.clear();
    hits.resize(rays.len(), Hit::MISS);
    enclosure.bvh().closest_hits(rays, hits);
    let looks = rays.iter().zip(&*hits);
    looks.filter(|(ray, hit)| enclosure.landing(up, hit) == Landing::Back && is_buried(enclosure, side, ray)).count()
        as u32
}
