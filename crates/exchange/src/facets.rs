//! The sides of an enclosure as kernels see them, in the order of a tree.
//!
//! A facet is one side: its corners in counter-clockwise order seen from where it looks. Facets that lie and face
//! alike are neighbours in the order, so that a run of facets, a [`Node`], can be judged as one.

use crate::enclosure::Enclosure;
use glam::DVec3;

/// One side.
#[derive(Clone, Debug)]
pub struct Facet {
    /// The side's number in the enclosure.
    pub side: u32,
    /// The patch it is a side of.
    pub patch: u32,
    /// Corners, counter-clockwise seen from where it looks; a triangle repeats its last.
    corners: [DVec3; 4],
    count: u8,
    /// Unit normal, toward where it looks.
    pub normal: DVec3,
    /// Centroid.
    pub centre: DVec3,
    /// m2.
    pub area: f64,
    /// The greatest distance of a corner from the centroid.
    pub radius: f64,
}

impl Facet {
    /// The corners: three or four.
    #[inline]
    pub fn corners(&self) -> &[DVec3] {
        &self.corners[..self.count as usize]
    }

    /// The signed distance of a point from the facet's plane, positive in front.
    #[inline]
    pub fn height(&self, point: DVec3) -> f64 {
        (point - self.centre).dot(self.normal)
    }

    fn new(enclosure: &Enclosure, side: usize) -> Self {
        let patch = enclosure.patch_of(side);
        let patches = enclosure.patches();
        let mut ring = patches.corners(patch).to_vec();
        if !enclosure.is_front(side) {
            ring.reverse();
        }
        let centre = patches.centre[patch];
        let mut corners = [ring[ring.len() - 1]; 4];
        corners[..ring.len()].copy_from_slice(&ring);
        Self {
            side: side as u32,
            patch: patch as u32,
            corners,
            count: ring.len() as u8,
            normal: enclosure.normal(side),
            centre,
            area: patches.area[patch],
            radius: ring.iter().map(|c| c.distance(centre)).fold(0.0, f64::max),
        }
    }
}

/// An axis-aligned box.
#[derive(Clone, Copy, Debug)]
pub struct Bounds {
    /// Lower corner.
    pub low: DVec3,
    /// Upper corner.
    pub high: DVec3,
}

impl Bounds {
    /// Around nothing.
    pub const EMPTY: Self = Self { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY };

    /// Around points.
    pub fn of(points: impl IntoIterator<Item = DVec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |b, p| Self { low: b.low.min(p), high: b.high.max(p) })
    }

    /// Around both.
    pub fn union(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// Whether the boxes have a point in common.
    #[inline]
    pub fn meets(&self, other: &Self) -> bool {
        self.low.cmple(other.high).all() && other.low.cmple(self.high).all()
    }

    /// The squares of the least and the greatest distance of points of two boxes.
    pub fn distances_squared(&self, other: &Self) -> (f64, f64) {
        let gap = (other.low - self.high).max(self.low - other.high).max(DVec3::ZERO);
        let span = (other.high - self.low).max(self.high - other.low);
        (gap.length_squared(), span.length_squared())
    }

    /// The least and the greatest of `normal . point` over the box.
    #[inline]
    pub fn extent_along(&self, normal: DVec3) -> (f64, f64) {
        let (a, b) = (self.low * normal, self.high * normal);
        (a.min(b).element_sum(), a.max(b).element_sum())
    }
}

/// A run of facets.
#[derive(Clone, Debug)]
pub struct Node {
    /// The first facet and the one after the last.
    pub range: std::ops::Range<usize>,
    /// Around all their corners.
    pub bounds: Bounds,
    /// The least and the greatest radius among them.
    pub radii: (f64, f64),
    /// Where the two halves are; none of a leaf.
    pub children: Option<[usize; 2]>,
}

/// All sides with area, in the order of a tree over them.
pub struct Facets {
    /// In tree order.
    pub list: Vec<Facet>,
    /// Nodes; the first is the root.
    pub nodes: Vec<Node>,
    /// The size of the scene, m: rounding of coordinates is relative to it.
    pub extent: f64,
}

/// Facets in a leaf: a run this long is worth one judgement.
pub(crate) const LEAF: usize = 16;

/// How much of the scene's size a turn of the normal by a right angle counts when facets are grouped.
const NORMAL_WEIGHT: f64 = 1.0;

impl Facets {
    /// Takes the sides of an enclosure.
    pub fn new(enclosure: &Enclosure) -> Self {
        let sides = (0..enclosure.sides()).filter(|&side| enclosure.area(side) > 0.0);
        let mut list: Vec<Facet> = sides.map(|side| Facet::new(enclosure, side)).collect();
        let patches = enclosure.patches();
        let all = Bounds::of(patches.polygons.iter().chain(&patches.obstructions).flatten().copied());
        let extent = if list.is_empty() { 0.0 } else { (all.high - all.low).max_element() };
        let mut nodes = Vec::new();
        if !list.is_empty() {
            divide(&mut list, 0, NORMAL_WEIGHT * extent, &mut nodes);
        }
        Self { list, nodes, extent }
    }

    /// The numbers of the nodes without children, in the order of their facets.
    pub fn leaves(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.nodes.len()).filter(|&n| self.nodes[n].children.is_none())
    }
}

/// Adds the node over a run that starts at `first`, and all below it; returns its number.
fn divide(run: &mut [Facet], first: usize, turn: f64, nodes: &mut Vec<Node>) -> usize {
    let number = nodes.len();
    let bounds = Bounds::of(run.iter().flat_map(|f| f.corners().to_vec()));
    let radii = run.iter().fold((f64::INFINITY, 0.0f64), |(l, h), f| (l.min(f.radius), h.max(f.radius)));
    nodes.push(Node { range: first..first + run.len(), bounds, radii, children: None });
    if run.len() > LEAF {
        // Along whichever of six coordinates, three of place and three of direction, the run is longest.
        let coordinate = |f: &Facet, k: usize| if k < 3 { f.centre[k] } else { turn * f.normal[k - 3] };
        let spread = |k: usize| {
            let (low, high) = run.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), f| {
                (low.min(coordinate(f, k)), high.max(coordinate(f, k)))
            });
            high - low
        };
        let widths: Vec<f64> = (0..6).map(spread).collect();
        let axis = (0..6).fold(0, |best, k| if widths[k] > widths[best] { k } else { best });
        let order =
            |a: &Facet, b: &Facet| coordinate(a, axis).total_cmp(&coordinate(b, axis)).then(a.side.cmp(&b.side));
        // A multiple of the leaf's size on the left leaves full leaves.
        let middle = (run.len() / 2).next_multiple_of(LEAF).min(run.len() - 1);
        run.select_nth_unstable_by(middle, order);
        let (left, right) = run.split_at_mut(middle);
        let left_number = divide(left, first, turn, nodes);
        let right_number = divide(right, first + middle, turn, nodes);
        nodes[number].children = Some([left_number, right_number]);
    }
    number
}

#[cfg(test)]
mod tests {
    use super::*;
    use radiosity_geometry::Patches;

    #[test]
    fn every_side_is_in_one_leaf() {
        let square = |z: f64| [(0., 0.), (1., 0.), (1., 1.), (0., 1.)].map(|(x, y)| DVec3::new(x, y, z));
        let n = 100;
        let patches = Patches::new((0..n).map(|k| square(k as f64)).collect(), vec![0; n], vec![0; n], vec![true; n]);
        let facets = Facets::new(&Enclosure::new(patches));
        let mut next = 0;
        for leaf in facets.leaves() {
            assert_eq!(facets.nodes[leaf].range.start, next);
            next = facets.nodes[leaf].range.end;
        }
        assert_eq!(next, 200);
        let mut sides: Vec<u32> = facets.list.iter().map(|f| f.side).collect();
        sides.sort_unstable();
        assert!(sides.into_iter().eq(0..200));
        for f in &facets.list {
            let c = f.corners();
            assert!((c[1] - c[0]).cross(c[2] - c[1]).dot(f.normal) > 0.0);
        }
    }
}
