//! The polygons that could block anything.

use super::shaft::Shaft;
use crate::convex::range;
use crate::enclosure::Enclosure;
use crate::facets::Bounds;
use glam::DVec3;
use radiosity_geometry::Patches;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::ops::Range;

/// An opaque convex polygon.
#[derive(Clone, Debug)]
pub struct Blocker {
    /// Corners in order around the outline; which way round does not matter.
    pub corners: Vec<DVec3>,
    /// Unit normal by the right-hand rule.
    pub normal: DVec3,
    /// `normal . x` of the points of its plane.
    pub offset: f64,
    /// Around the corners.
    pub bounds: Bounds,
}

impl Blocker {
    /// A polygon with area; none without.
    pub fn new(corners: Vec<DVec3>) -> Option<Self> {
        let normal = vector_area(&corners).normalize_or_zero();
        if normal == DVec3::ZERO {
            return None;
        }
        let offset = normal.dot(corners.iter().sum::<DVec3>() / corners.len() as f64);
        Some(Self { bounds: Bounds::of(corners.iter().copied()), corners, normal, offset })
    }

    /// The signed distance of a point from its plane.
    #[inline]
    pub fn height(&self, point: DVec3) -> f64 {
        self.normal.dot(point) - self.offset
    }
}

/// Half the sum of cross products around the outline.
pub fn vector_area(corners: &[DVec3]) -> DVec3 {
    let o = corners[0];
    corners.windows(2).map(|w| (w[0] - o).cross(w[1] - o)).sum::<DVec3>() * 0.5
}

/// How far single-precision files may leave a corner off the plane it is meant to lie in, relative to the scene.
pub const CONTACT: f64 = 2e-7;

/// All that could block.
pub struct Blockers {
    /// In the order of a tree.
    pub list: Vec<Blocker>,
    /// Runs of the list and boxes around them.
    nodes: Vec<Run>,
    /// What rises less than this above a plane lies in it, metres.
    pub contact: f64,
}

/// Blockers that lie together.
struct Run {
    range: Range<usize>,
    bounds: Bounds,
    /// Where the second half is, the first being the next; none of a leaf.
    second: Option<usize>,
}

/// Blockers in a leaf.
const LEAF: usize = 4;

impl Blockers {
    /// Patches that tile a flat convex face count as that face: a wall of a thousand patches is one blocker. What has
    /// all of the scene on one side of its plane, like the walls of a convex room, blocks nothing and is left out.
    pub fn new(enclosure: &Enclosure, extent: f64) -> Self {
        let patches = enclosure.patches();
        let mut all = faces(patches);
        all.extend(patches.obstructions.iter().filter_map(|polygon| Blocker::new(ring(polygon))));
        let whole = Self::of(all, CONTACT * extent);
        let splits = |b: &Blocker| whole.reaches(b, 1.0) && whole.reaches(b, -1.0);
        let dividing = whole.list.par_iter().filter(|b| splits(b)).cloned().collect();
        Self::of(dividing, whole.contact)
    }

    fn of(mut list: Vec<Blocker>, contact: f64) -> Self {
        let mut nodes = Vec::new();
        if !list.is_empty() {
            divide(&mut list, 0, &mut nodes);
        }
        Self { list, nodes, contact }
    }

    /// Whether any corner rises in front of a blocker's plane, or behind it where `sign` is -1.
    fn reaches(&self, blocker: &Blocker, sign: f64) -> bool {
        let (normal, least) = (sign * blocker.normal, sign * blocker.offset + self.contact);
        !self.walk(
            |bounds| bounds.extent_along(normal).1 > least,
            |other| !other.corners.iter().any(|&c| normal.dot(c) > least),
        )
    }

    /// Whether nothing may stand between two boxes.
    pub fn leave_free(&self, shaft: &Shaft) -> bool {
        self.walk(|bounds| shaft.meets(bounds), |blocker| !shaft.admits(blocker))
    }

    /// Adds the numbers of what may stand between two boxes.
    pub fn find(&self, shaft: &Shaft, found: &mut Vec<u32>) {
        let mut visit = |run: &Run| {
            found.extend(run.range.clone().filter(|&k| shaft.admits(&self.list[k])).map(|k| k as u32));
            true
        };
        self.walk_runs(|bounds| shaft.meets(bounds), &mut visit);
    }

    /// Visits blockers where `enter` lets it, as long as `go_on` does; whether it came to the end.
    fn walk(&self, enter: impl Fn(&Bounds) -> bool, go_on: impl Fn(&Blocker) -> bool) -> bool {
        self.walk_runs(enter, &mut |run| self.list[run.range.clone()].iter().all(&go_on))
    }

    fn walk_runs(&self, enter: impl Fn(&Bounds) -> bool, go_on: &mut impl FnMut(&Run) -> bool) -> bool {
        let mut stack = [0usize; 64];
        let mut open = usize::from(!self.nodes.is_empty());
        while open > 0 {
            open -= 1;
            let number = stack[open];
            let run = &self.nodes[number];
            if !enter(&run.bounds) {
                continue;
            }
            match run.second {
                Some(second) => {
                    stack[open] = second;
                    stack[open + 1] = number + 1;
                    open += 2;
                }
                None if !go_on(run) => return false,
                None => {}
            }
        }
        true
    }
}

/// Adds the node over a run that starts at `first`, and all below it: halves by the middles of boxes.
fn divide(run: &mut [Blocker], first: usize, nodes: &mut Vec<Run>) {
    let number = nodes.len();
    let bounds = run.iter().fold(Bounds::EMPTY, |all, b| all.union(b.bounds));
    nodes.push(Run { range: first..first + run.len(), bounds, second: None });
    if run.len() > LEAF {
        let middle = |b: &Blocker, k: usize| b.bounds.low[k] + b.bounds.high[k];
        let spread = |k: usize| {
            let (low, high) = range(run.iter().map(|b| middle(b, k)));
            high - low
        };
        let axis = (0..3).max_by(|&a, &b| spread(a).total_cmp(&spread(b))).expect("three axes");
        let half = run.len() / 2;
        run.select_nth_unstable_by(half, |a, b| middle(a, axis).total_cmp(&middle(b, axis)));
        let (left, right) = run.split_at_mut(half);
        divide(left, first, nodes);
        nodes[number].second = Some(nodes.len());
        divide(right, first + half, nodes);
    }
}

/// The corners of a polygon whose last may be repeated.
fn ring(polygon: &[DVec3; 4]) -> Vec<DVec3> {
    if polygon[2] == polygon[3] { polygon[..3].to_vec() } else { polygon.to_vec() }
}

/// The faces that the patches were cut from, where they tile a convex polygon; else the patches themselves.
fn faces(patches: &Patches) -> Vec<Blocker> {
    let mut groups: BTreeMap<(u32, u32), Vec<usize>> = BTreeMap::new();
    for i in (0..patches.len()).filter(|&i| patches.area[i] > 0.0) {
        groups.entry((patches.surface[i], patches.face[i])).or_default().push(i);
    }
    let mut found = Vec::with_capacity(groups.len());
    for members in groups.into_values() {
        match merged(patches, &members) {
            Some(face) => found.push(face),
            None => found.extend(members.iter().filter_map(|&i| Blocker::new(patches.corners(i).to_vec()))),
        }
    }
    found
}

/// The convex polygon that patches of one plane tile; none if they tile something else.
fn merged(patches: &Patches, members: &[usize]) -> Option<Blocker> {
    if members.len() == 1 {
        return Blocker::new(patches.corners(members[0]).to_vec());
    }
    let normal = patches.normal[members[0]];
    let origin = patches.centre[members[0]];
    let corners: Vec<DVec3> = members.iter().flat_map(|&i| patches.corners(i).iter().copied()).collect();
    let size = corners.iter().map(|c| c.distance(origin)).fold(0.0, f64::max);
    let is_flat = corners.iter().all(|c| (*c - origin).dot(normal).abs() <= 1e-9 * size);
    let alike = members.iter().all(|&i| patches.normal[i].dot(normal) > 1.0 - 1e-9);
    if !(is_flat && alike) {
        return None;
    }
    let face = Blocker::new(convex_hull(&corners, normal))?;
    let tiled: f64 = members.iter().map(|&i| patches.area[i]).sum();
    let hull = vector_area(&face.corners).length();
    ((hull - tiled).abs() <= 1e-9 * hull).then_some(face)
}

/// The corners of the convex hull of points of a plane, counter-clockwise about its normal (Andrew 1979).
fn convex_hull(points: &[DVec3], normal: DVec3) -> Vec<DVec3> {
    let frame = radiosity_geometry::sampling::Frame::new(normal);
    let mut flat: Vec<(f64, f64, DVec3)> =
        points.iter().map(|&p| (p.dot(frame.tangent), p.dot(frame.bitangent), p)).collect();
    flat.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let size = flat[flat.len() - 1].0 - flat[0].0 + f64::MIN_POSITIVE;
    let turn = |a: &(f64, f64, DVec3), b: &(f64, f64, DVec3), c: &(f64, f64, DVec3)| {
        (b.0 - a.0) * (c.1 - a.1) - (b.1 - a.1) * (c.0 - a.0)
    };
    let half = |flat: &mut dyn Iterator<Item = &(f64, f64, DVec3)>| {
        let mut hull: Vec<(f64, f64, DVec3)> = Vec::new();
        for p in flat {
            while hull.len() >= 2 && turn(&hull[hull.len() - 2], &hull[hull.len() - 1], p) <= 1e-12 * size * size {
                hull.pop();
            }
            hull.push(*p);
        }
        hull.pop();
        hull
    };
    let mut hull = half(&mut flat.iter());
    hull.extend(half(&mut flat.iter().rev()));
    hull.into_iter().map(|p| p.2).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A grid of `n x n` squares over the unit square at height `z`.
    fn grid(n: usize, z: f64, face: u32) -> Patches {
        let at = |i: usize, j: usize| DVec3::new(i as f64 / n as f64, j as f64 / n as f64, z);
        let cells = (0..n * n).map(|k| (k % n, k / n));
        let polygons: Vec<_> = cells.map(|(i, j)| [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]).collect();
        let count = polygons.len();
        Patches::new(polygons, vec![0; count], vec![face; count], vec![false; count])
    }

    #[test]
    fn patches_of_a_face_count_as_the_face() {
        let faces = faces(&grid(5, 0.0, 3));
        assert_eq!(faces.len(), 1);
        assert_eq!(faces[0].corners.len(), 4);
    }

    #[test]
    fn a_face_with_a_hole_stays_in_pieces() {
        let mut patches = grid(3, 0.0, 0);
        let keep = |v: &[[DVec3; 4]]| v.iter().enumerate().filter(|(i, _)| *i != 4).map(|(_, p)| *p).collect();
        let polygons: Vec<_> = keep(&patches.polygons);
        patches = Patches::new(polygons, vec![0; 8], vec![0; 8], vec![false; 8]);
        assert_eq!(faces(&patches).len(), 8);
    }

    #[test]
    fn only_what_divides_the_scene_can_block() {
        let square = |z: f64| grid(1, z, 0).polygons[0];
        let patches = Patches::new(vec![square(0.0), square(1.0)], vec![0, 1], vec![0, 0], vec![false; 2]);
        let enclosure = Enclosure::new(patches.clone());
        assert!(Blockers::new(&enclosure, 1.0).list.is_empty());
        let enclosure = Enclosure::new(patches.with_obstructions(vec![square(0.5)]));
        assert_eq!(Blockers::new(&enclosure, 1.0).list.len(), 1);
    }
}
