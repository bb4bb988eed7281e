//! What single rays find: for those who examine a scene or draw it, and measure nothing.

use glam::DVec3;
use radiosity_geometry::bvh::{Hit, Ray};
use radiosity_operator::{Cancelled, Control};
use rayon::prelude::*;

use crate::enclosure::Enclosure;

/// What a ray meets first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// A patch, or an obstruction, which are numbered after all patches; nothing where the ray escapes.
    pub polygon: Option<u32>,
    /// How far away it is, in lengths of the direction; infinite where there is nothing.
    pub distance: f32,
    /// Whether the ray comes from the side that the normal points to.
    pub is_front: bool,
}

/// Rays that one thread shoots before it asks whether to go on.
const BATCH: usize = 4096;

/// Looks from points along directions. The caller moves points off the faces that they are on.
///
/// # Panics
/// If there are not as many directions as points.
pub fn looks(
    enclosure: &Enclosure,
    points: &[DVec3],
    directions: &[DVec3],
    control: &Control,
) -> Result<Vec<Look>, Cancelled> {
    assert_eq!(points.len(), directions.len(), "one direction per point");
    control.expect(points.len() as u64);
    let batches: Result<Vec<_>, Cancelled> = points
        .par_chunks(BATCH)
        .zip(directions.par_chunks(BATCH))
        .map(|(points, directions)| {
            control.check()?;
            let found = batch(enclosure, points, directions);
            control.advance(points.len() as u64);
            Ok(found)
        })
        .collect();
    Ok(batches?.concat())
}

fn batch(enclosure: &Enclosure, points: &[DVec3], directions: &[DVec3]) -> Vec<Look> {
    let rays: Vec<Ray> = points.iter().zip(directions).map(|(&p, d)| enclosure.ray(p, d.as_vec3())).collect();
    let mut hits = vec![Hit::MISS; rays.len()];
    enclosure.bvh().closest_hits(&rays, &mut hits);
    let look = |(hit, &direction): (&Hit, &DVec3)| match enclosure.polygon(hit) {
        None => Look { polygon: None, distance: f32::INFINITY, is_front: false },
        Some(polygon) => Look {
            polygon: Some(polygon),
            distance: hit.t,
            is_front: enclosure.patches().normal.get(polygon as usize).is_some_and(|n| direction.dot(*n) < 0.0),
        },
    };
    hits.iter().zip(directions).map(look).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use radiosity_geometry::Patches;

    fn square(z: f64) -> [DVec3; 4] {
        [[-1., -1.], [1., -1.], [1., 1.], [-1., 1.]].map(|[x, y]| DVec3::new(x, y, z))
    }

    #[test]
    fn a_ray_finds_fronts_backs_obstructions_and_nothing() {
        let patches =
            Patches::new(vec![square(0.0)], vec![0], vec![0], vec![false]).with_obstructions(vec![square(3.0)]);
        let enclosure = Enclosure::new(patches);
        let points = [DVec3::Z, -DVec3::Z, DVec3::Z, DVec3::Z];
        let directions = [-DVec3::Z, 0.5 * DVec3::Z, DVec3::Z, DVec3::X];
        let found = looks(&enclosure, &points, &directions, &Control::default()).unwrap();
        let look = |polygon, distance, is_front| Look { polygon, distance, is_front };
        let nothing = look(None, f32::INFINITY, false);
        assert_eq!(found, [look(Some(0), 1.0, true), look(Some(0), 2.0, false), look(Some(1), 2.0, false), nothing]);
    }

    #[test]
    fn whoever_cancels_gets_nothing() {
        let enclosure = Enclosure::new(Patches::new(vec![square(0.0)], vec![0], vec![0], vec![false]));
        let control = Control::default();
        control.cancel();
        assert_eq!(looks(&enclosure, &[DVec3::Z], &[DVec3::X], &control), Err(Cancelled));
    }
}
