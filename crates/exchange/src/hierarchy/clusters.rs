//! The tree over facets, and what is known of each cluster.

use crate::enclosure::Enclosure;
use crate::facets::{Facets, Grouping};
use glam::DVec3;
use radiosity_geometry::sampling::Sequence;

/// How much of a cluster's own size a turn of the normal by a right angle counts.
const TURN: f64 = 1.1;

/// Points of a facet that rays of links start from and end at.
pub const POINTS: usize = 4;

/// The stream of the sequences that place them.
const STREAM: u32 = 5;

/// Facets in the order of a tree, with what links read of them.
pub struct Clusters {
    pub facets: Facets,
    /// Per node.
    cones: Vec<Cone>,
    /// Middles, normals and areas, coordinate by coordinate.
    pub middles: [Vec<f64>; 7],
    /// Points just off each facet.
    pub points: Vec<[DVec3; POINTS]>,
}

/// The directions that a cluster faces: all within an angle of an axis.
#[derive(Clone, Copy, Debug)]
pub struct Cone {
    pub axis: DVec3,
    /// Of the angle.
    pub cosine: f64,
}

impl Clusters {
    pub fn new(enclosure: &Enclosure, seed: u64) -> Self {
        let facets = Facets::new(enclosure, Grouping::Compact(TURN));
        let coordinate = |k: usize| {
            facets.list.iter().map(|f| if k < 3 { f.centre[k] } else if k < 6 { f.normal[k - 3] } else { f.area }).collect()
        };
        let points = facets.list.iter().map(|facet| {
            let sequence = Sequence::new(seed, facet.side, 0, STREAM);
            let off = |s, t| enclosure.point_off(facet.side as usize, s, t);
            let ([s, t, u, v], [x, y, z, w]) = (sequence.point(0), sequence.point(1));
            [off(s, t), off(u, v), off(x, y), off(z, w)]
        });
        Self {
            middles: std::array::from_fn(coordinate),
            points: points.collect(),
            cones: facets.nodes.iter().map(|node| Cone::around(facets.list[node.range.clone()].iter().map(|f| f.normal))).collect(),
            facets,
        }
    }

    pub fn cone(&self, node: usize) -> Cone {
        self.cones[node]
    }
}

impl Cone {
    /// Around directions.
    fn around(directions: impl Iterator<Item = DVec3> + Clone) -> Self {
        let axis = directions.clone().sum::<DVec3>().normalize_or_zero();
        let cosine = if axis == DVec3::ZERO { -1.0 } else { directions.map(|d| axis.dot(d)).fold(1.0, f64::min) };
        Self { axis, cosine }
    }

    /// Whether all directions are one but for rounding.
    pub fn is_one(&self) -> bool {
        self.cosine > 1.0 - 1e-12
    }
}
