//! How much of every side is not buried under a solid that stands on it.

use radiosity_exchange::Enclosure;
use radiosity_exchange::enclosure::Landing;
use radiosity_exchange::shots::is_buried;
use radiosity_geometry::bvh::{Hit, Ray};
use radiosity_geometry::sampling::Sequence;
use radiosity_operator::{Cancelled, Control};
use rayon::prelude::*;

/// Points of a side that look up; as many again and again where some are buried and others not.
const PROBES: u32 = 8;
const MORE_PROBES: u32 = 128;

/// The stream of the sequence that feeds them.
const STREAM: u32 = 4;

/// The exposed share of each side: 1 where nothing stands on it.
pub(super) fn exposure(enclosure: &Enclosure, seed: u64, control: &Control) -> Result<Vec<f32>, Cancelled> {
    let sides = enclosure.sides();
    (0..sides)
        .into_par_iter()
        .with_min_len(256)
        .map_init(
            || (Vec::new(), Vec::new()),
            |(rays, hits), side| {
                control.check()?;
                let sequence = Sequence::new(seed, side as u32, 0, STREAM);
                let mut buried = |range: std::ops::Range<u32>| buried(enclosure, side, &sequence, range, rays, hits);
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

fn buried(
    enclosure: &Enclosure,
    side: usize,
    sequence: &Sequence,
    range: std::ops::Range<u32>,
    rays: &mut Vec<Ray>,
    hits: &mut Vec<Hit>,
) -> u32 {
    if enclosure.area(side) == 0.0 {
        return 0;
    }
    let up = enclosure.normal(side).as_vec3();
    rays.clear();
    rays.extend(range.map(|k| {
        let [_, _, s, t] = sequence.point(k);
        enclosure.ray(enclosure.point_off(side, s, t), up)
    }));
    hits.clear();
    hits.resize(rays.len(), Hit::MISS);
    enclosure.bvh().closest_hits(rays, hits);
    let looks = rays.iter().zip(&*hits);
    looks.filter(|(ray, hit)| enclosure.landing(up, hit) == Landing::Back && is_buried(enclosure, side, ray)).count()
        as u32
}
