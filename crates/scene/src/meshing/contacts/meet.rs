//! Where two flat faces touch or cross.

use glam::DVec3;

use super::boxes::Extent;
use crate::meshing::faces::Polygon;

/// Faces smaller than so many tolerances take no part.
const LEAST_FACE: f64 = 16.0;

/// A contact is longer than so many times what its place is uncertain by.
const LEAST_CONTACT: f64 = 8.0;

/// Planes that meet at a smaller angle than the inverse of this are not told from parallel ones.
const FLATTEST: f64 = 64.0;

/// A face with its plane.
#[derive(Clone, Debug)]
pub(super) struct Sheet {
    corners: [DVec3; 4],
    n: usize,
    centre: DVec3,
    normal: DVec3,
    /// Which of its edges end what it covers, by bits; the others run on into a flush face of the same surface.
    outline: u8,
}

impl Sheet {
    /// The sheet of a polygon; `None` for one that is too small to tell its corners apart.
    pub(super) fn new(polygon: &Polygon, tolerance: f64) -> Option<Self> {
        let (corners, n) = (polygon.corners, if polygon.is_quad { 4 } else { 3 });
        let longest = polygon.longest_edge();
        let normal = polygon.unit_normal();
        let is_large = polygon.shortest_edge() > LEAST_FACE * tolerance
            && polygon.area() > LEAST_FACE * tolerance * longest
            && normal.is_normalized();
        let centre = corners[..n].iter().sum::<DVec3>() / n as f64;
        (is_large && centre.is_finite()).then_some(Self { corners, n, centre, normal, outline: u8::MAX })
    }

    pub(super) fn without_edge(&mut self, edge: usize) {
        self.outline &= !(1 << edge);
    }

    pub(super) fn extent(&self) -> Extent {
        Extent::around(self.corners)
    }

    pub(super) fn corners(&self) -> &[DVec3] {
        &self.corners[..self.n]
    }

    fn edge(&self, i: usize) -> [DVec3; 2] {
        [self.corners[i], self.corners[(i + 1) % self.n]]
    }

    /// How far the corners of another lie above this plane; nothing where that is less than the tolerance.
    fn heights(&self, other: &Sheet, tolerance: f64) -> [f64; 4] {
        other.corners.map(|p| {
            let height = (p - self.centre).dot(self.normal);
            if height.abs() <= tolerance { 0.0 } else { height }
        })
    }

    /// How far inside its edge `i` a point lies.
    fn depth(&self, i: usize, p: DVec3) -> f64 {
        let [a, b] = self.edge(i);
        self.normal.cross(b - a).normalize_or_zero().dot(p - a)
    }

    /// Whether a point belongs to the face, within `slack`.
    fn holds(&self, p: DVec3, slack: f64) -> bool {
        (p - self.centre).dot(self.normal).abs() <= slack && (0..self.n).all(|i| self.depth(i, p) >= -slack)
    }

    /// Where its own outline crosses a plane above which its corners have `heights`: the ends of the crossing.
    fn trace(&self, heights: &[f64; 4]) -> Option<[DVec3; 2]> {
        let mut ends: Option<[DVec3; 2]> = None;
        for i in 0..self.n {
            let j = (i + 1) % self.n;
            let (h, k) = (heights[i], heights[j]);
            let here = if h == 0.0 {
                self.corners[i]
            } else if h * k < 0.0 {
                // From the lower end, so that both faces on an edge find the same point.
                let (low, high, h, k) = if h < 0.0 { (i, j, h, k) } else { (j, i, k, h) };
                self.corners[low].lerp(self.corners[high], h / (h - k))
            } else {
                continue;
            };
            ends = Some(match ends {
                None => [here, here],
                Some([a, b]) if here.distance_squared(a) > b.distance_squared(a) => [a, here],
                Some([a, b]) if here.distance_squared(b) > b.distance_squared(a) => [here, b],
                Some(both) => both,
            });
        }
        ends
    }

    /// The part of a segment in the plane of this face that lies on it.
    fn clip(&self, [mut a, mut b]: [DVec3; 2], tolerance: f64) -> Option<[DVec3; 2]> {
        for i in 0..self.n {
            let snapped = |p: DVec3| {
                let depth = self.depth(i, p);
                if depth.abs() <= tolerance { 0.0 } else { depth }
            };
            let (h, k) = (snapped(a), snapped(b));
            if h < 0.0 && k <= 0.0 || h <= 0.0 && k < 0.0 {
                return None;
            } else if h < 0.0 {
                a = a.lerp(b, h / (h - k));
            } else if k < 0.0 {
                b = a.lerp(b, h / (h - k));
            }
        }
        Some([a, b])
    }
}

/// Collects the segments that two faces have in common: one for faces at an angle; for faces in one plane those
/// parts of the outline of either that lie on the other.
pub(super) fn meet(a: &Sheet, b: &Sheet, tolerance: f64, found: &mut Vec<[DVec3; 2]>) {
    found.clear();
    let (over_a, over_b) = (a.heights(b, tolerance), b.heights(a, tolerance));
    let is_aside =
        |heights: &[f64; 4], n: usize| heights[..n].iter().all(|&h| h > 0.0) || heights[..n].iter().all(|&h| h < 0.0);
    if is_aside(&over_a, b.n) || is_aside(&over_b, a.n) {
        return;
    }
    let is_flush = |heights: &[f64; 4]| heights.iter().all(|&h| h == 0.0);
    let shared = shared_edge(a, b);
    if is_flush(&over_a) || is_flush(&over_b) {
        if shared.is_none_or(|[i, j]| !lie_apart(a, i, b, j)) {
            flush(a, b, tolerance, found);
        }
    } else if shared.is_none() {
        found.extend(crossing(a, b, &over_a, &over_b, tolerance));
    }
}

/// The edge that two faces have in common to the bit, by its number in either.
fn shared_edge(a: &Sheet, b: &Sheet) -> Option<[usize; 2]> {
    (0..a.n).find_map(|i| {
        let [p, q] = a.edge(i);
        (0..b.n).find(|&j| b.edge(j) == [q, p] || b.edge(j) == [p, q]).map(|j| [i, j])
    })
}

/// Whether two faces of one plane lie on either side of an edge that they share.
fn lie_apart(a: &Sheet, i: usize, b: &Sheet, j: usize) -> bool {
    let [start, end] = b.edge(j);
    let farthest = b.corners().iter().filter(|&&p| p != start && p != end).map(|&p| a.depth(i, p));
    farthest.fold(f64::NEG_INFINITY, f64::max) < 0.0
}

/// The parts of both outlines that lie on the other face.
fn flush(a: &Sheet, b: &Sheet, tolerance: f64, found: &mut Vec<[DVec3; 2]>) {
    for (one, other) in [(a, b), (b, a)] {
        let outline = (0..one.n).filter(|i| one.outline & (1 << i) != 0).map(|i| one.edge(i));
        let parts = outline.filter_map(|edge| other.clip(edge, tolerance));
        found.extend(parts.filter(|[p, q]| p.distance(*q) > LEAST_CONTACT * 2.0 * tolerance));
    }
}

/// What two faces at an angle have in common.
fn crossing(a: &Sheet, b: &Sheet, over_a: &[f64; 4], over_b: &[f64; 4], tolerance: f64) -> Option<[DVec3; 2]> {
    let angle = a.normal.cross(b.normal).length();
    let slack = tolerance * (2.0 + (1.0 / angle).min(FLATTEST));
    let (first, second) = (a.trace(over_b)?, b.trace(over_a)?);
    let length = |[p, q]: [DVec3; 2]| p.distance_squared(q);
    let [from, to] = if length(first) >= length(second) { first } else { second };
    let direction = (to - from).try_normalize()?;
    let along = |p: DVec3| direction.dot(p - from);
    let ordered = |[p, q]: [DVec3; 2]| if along(p) <= along(q) { [p, q] } else { [q, p] };
    let ([a0, a1], [b0, b1]) = (ordered(first), ordered(second));
    let start = if along(a0) >= along(b0) { a0 } else { b0 };
    let end = if along(a1) <= along(b1) { a1 } else { b1 };
    let is_long = along(end) - along(start) > LEAST_CONTACT * slack;
    let is_on = |p: DVec3| a.holds(p, slack) && b.holds(p, slack);
    (is_long && is_on(start) && is_on(end)).then_some([start, end])
}
