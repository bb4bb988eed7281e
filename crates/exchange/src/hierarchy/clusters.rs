//! The tree over facets, and what is known of each cluster.

use super::parts::{NO_PART, parts};
use crate::enclosure::Enclosure;
use crate::facets::{Facets, Grouping, Node};
use glam::DVec3;

/// How much of a cluster's own size a turn of the normal by a right angle counts.
const TURN: f64 = 1.1;

/// Facets in the order of a tree, with what links read of them.
pub struct Clusters {
    pub facets: Facets,
    /// Per node.
    cones: Vec<Cone>,
    /// Per node: which part of the scene all its facets are in; none at the top, where they are in several.
    parts: Vec<Option<u32>>,
    /// Middles, normals and areas, coordinate by coordinate.
    pub middles: [Vec<f64>; 7],
    /// How much more than the mean what each facet sends matters; empty where all matter alike.
    pub importance: Vec<f64>,
}

/// Facets in a leaf: fewer make more blocks, more make more near pairs.
const LEAF: usize = 8;

/// The directions that a cluster faces: all within an angle of an axis.
#[derive(Clone, Copy, Debug)]
pub struct Cone {
    pub axis: DVec3,
    /// Of the angle.
    pub cosine: f64,
}

impl Clusters {
    pub fn new(enclosure: &Enclosure, importance: &[f64], seed: u64) -> Self {
        let parts = parts(enclosure, seed);
        let facets = Facets::apart(enclosure, Grouping::Compact(TURN), LEAF, &parts);
        // Parts follow each other in the tree.
        let part = |i: usize| parts[facets.list[i].side as usize];
        let part_of = |n: &Node| Some(part(n.range.start)).filter(|&p| p == part(n.range.end - 1));
        let coordinate = |k: usize| {
            facets
                .list
                .iter()
                .map(|f| {
                    if k < 3 {
                        f.centre[k]
                    } else if k < 6 {
                        f.normal[k - 3]
                    } else {
                        f.area
                    }
                })
                .collect()
        };
        Self {
            middles: std::array::from_fn(coordinate),
            parts: facets.nodes.iter().map(part_of).collect(),
            cones: facets
                .nodes
                .iter()
                .map(|node| Cone::around(facets.list[node.range.clone()].iter().map(|f| f.normal)))
                .collect(),
            importance: if importance.is_empty() {
                Vec::new()
            } else {
                facets.list.iter().map(|f| importance[f.side as usize]).collect()
            },
            facets,
        }
    }

    /// Whether two nodes are in parts of the scene that see nothing of each other.
    pub fn are_parted(&self, a: usize, b: usize) -> bool {
        let large = |n: usize| self.parts[n].filter(|&p| p != NO_PART);
        large(a).zip(large(b)).is_some_and(|(a, b)| a != b)
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
