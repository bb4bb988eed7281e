//! Which sides exchange light at all, however indirectly: rooms without a door between them do not.
//!
//! A link whose ends reach into two such rooms would carry light from one to the other, as it knows sums alone. So the
//! tree keeps them apart, and nothing is exchanged between them.

use crate::enclosure::{Enclosure, Sight};
use radiosity_geometry::bvh::{Hit, Ray};
use radiosity_geometry::sampling::{Sequence, cosine_hemisphere};
use rayon::prelude::*;

/// Looks of each side.
const LOOKS: u32 = 16;

/// The stream of the sequences that aim them.
const STREAM: u32 = 5;

/// Of small parts, which are kept together.
pub const NO_PART: u32 = 0;

/// Parts are small below this: they looked too rarely to be sure that they see no other.
const SMALLEST: usize = 64;

/// Looks at a time.
const BATCH: usize = 256;

/// For each side the number of its part, [`NO_PART`] for those of small parts.
pub fn parts(enclosure: &Enclosure, seed: u64) -> Vec<u32> {
    let sides = enclosure.sides();
    let seen: Vec<Vec<u32>> =
        (0..sides).into_par_iter().chunks(BATCH).map(|sides| look(enclosure, &sides, seed)).collect();
    let mut sets = Sets((0..sides as u32).collect());
    for (k, &target) in seen.iter().flatten().enumerate() {
        if target != NOTHING {
            sets.join(k as u32 / LOOKS, target);
        }
    }
    let roots: Vec<u32> = (0..sides as u32).map(|side| sets.root(side)).collect();
    let mut sizes = vec![0; sides];
    roots.iter().for_each(|&root| sizes[root as usize] += 1);
    roots.into_iter().map(|root| if sizes[root as usize] < SMALLEST { NO_PART } else { root + 1 }).collect()
}

/// No side.
const NOTHING: u32 = u32::MAX;

/// What some sides see.
fn look(enclosure: &Enclosure, sides: &[usize], seed: u64) -> Vec<u32> {
    let mut rays: Vec<Ray> = Vec::with_capacity(sides.len() * LOOKS as usize);
    for &side in sides {
        let (frame, sequence) = (enclosure.frame(side), Sequence::new(seed, side as u32, 0, STREAM));
        rays.extend((0..LOOKS).map(|k| {
            let [u, v, s, t] = sequence.point(k);
            enclosure.ray(enclosure.point_off(side, s, t), cosine_hemisphere(&frame, u, v))
        }));
    }
    let mut hits = vec![Hit::MISS; rays.len()];
    enclosure.bvh().closest_hits(&rays, &mut hits);
    let target = |ray: &Ray, hit| match enclosure.sight(ray.direction, hit) {
        Sight::Side(side, ..) => side,
        _ => NOTHING,
    };
    rays.iter().zip(&hits).map(|(ray, hit)| target(ray, hit)).collect()
}

/// Disjoint sets by their least members.
struct Sets(Vec<u32>);

impl Sets {
    fn root(&mut self, mut i: u32) -> u32 {
        while self.0[i as usize] != i {
            let above = self.0[self.0[i as usize] as usize];
            self.0[i as usize] = above;
            i = above;
        }
        i
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}
