//! Which blockers could stand between two sets of points (Haines and Wallace 1994, *Shaft culling for efficient
//! ray-cast radiosity*).

use super::blockers::Blocker;
use crate::convex::range;
use crate::facets::{Bounds, Facet};
use glam::DVec3;

/// The convex hull of two boxes, by planes that both lie behind.
pub struct Shaft {
    ends: [Bounds; 2],
    bounds: Bounds,
    /// Outward normals and the greatest `normal . x` of the hull.
    planes: Vec<(DVec3, f64)>,
    contact: f64,
}

impl Shaft {
    /// The hull of two boxes. Its planes are parallel to a coordinate axis.
    ///
    /// `contact`: what reaches no further than this beyond a blocker's plane lies in it.
    pub fn new(a: Bounds, b: Bounds, contact: f64) -> Self {
        let mut planes = Vec::with_capacity(8);
        for (u, v) in [(0, 1), (1, 2), (2, 0)] {
            for (su, sv) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
                let corner = |b: &Bounds, k: usize, s: f64| if s > 0.0 { b.high[k] } else { b.low[k] };
                let (pu, pv) = (corner(&a, u, su), corner(&a, v, sv));
                let (du, dv) = (corner(&b, u, su) - pu, corner(&b, v, sv) - pv);
                // The bridge between these corners is on the hull if its outward normal points into their quadrant.
                if du * su * dv * sv < 0.0 {
                    let mut normal = DVec3::ZERO;
                    normal[u] = su * dv.abs();
                    normal[v] = sv * du.abs();
                    planes.push((normal, normal[u] * pu + normal[v] * pv));
                }
            }
        }
        Self { ends: [a, b], bounds: a.union(b), planes, contact }
    }

    /// Whether a box has a point between the boxes, or may have.
    pub fn meets(&self, bounds: &Bounds) -> bool {
        self.bounds.meets(bounds) && !self.planes.iter().any(|(normal, most)| bounds.extent_along(*normal).0 >= *most)
    }

    /// Whether a blocker may stand between the boxes.
    pub fn admits(&self, blocker: &Blocker) -> bool {
        self.bounds.meets(&blocker.bounds)
            && !self.is_beside(blocker)
            && !self.planes.iter().any(|(normal, most)| blocker.corners.iter().all(|c| normal.dot(*c) >= *most))
    }

    /// Whether both boxes lie on one side of the blocker's plane.
    fn is_beside(&self, blocker: &Blocker) -> bool {
        let [a, b] = self.ends.map(|end| end.extent_along(blocker.normal));
        a.0.min(b.0) >= blocker.offset - self.contact || a.1.max(b.1) <= blocker.offset + self.contact
    }
}

/// What blockers do to a pair of facets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sight {
    /// Nothing is between them.
    Full,
    /// One blocker hides them from each other.
    None,
    /// Something may be.
    Partial,
}

/// Keeps of `candidates` those that may stand between two polygons, in `kept`.
///
/// `contact`: what rises no further than this above the plane of either does not block what that plane sends.
pub fn between(
    blockers: &[Blocker],
    candidates: &[u32],
    first: (&Facet, &[DVec3]),
    second: (&Facet, &[DVec3]),
    contact: f64,
    kept: &mut Vec<u32>,
) -> Sight {
    kept.clear();
    let bounds = Bounds::of(first.1.iter().chain(second.1).copied());
    let mut sides = None;
    for &candidate in candidates {
        let blocker = &blockers[candidate as usize];
        if !bounds.meets(&blocker.bounds) || !crosses(blocker, first, second, contact) {
            continue;
        }
        let sides = sides.get_or_insert_with(|| side_planes(first.1, second.1));
        if sides.iter().any(|(normal, most)| blocker.corners.iter().all(|c| normal.dot(*c) >= *most)) {
            continue;
        }
        if hides(blocker, first.1, second.1) {
            return Sight::None;
        }
        kept.push(candidate);
    }
    if kept.is_empty() { Sight::Full } else { Sight::Partial }
}

/// Whether the blocker rises above both planes, and the polygons are not both on one side of its own.
fn crosses(blocker: &Blocker, first: (&Facet, &[DVec3]), second: (&Facet, &[DVec3]), contact: f64) -> bool {
    let rises = |facet: &Facet| blocker.corners.iter().any(|&c| facet.height(c) > contact);
    let (mut front, mut back) = (false, false);
    for &p in first.1.iter().chain(second.1) {
        let h = blocker.height(p);
        front |= h > contact;
        back |= h < -contact;
    }
    front && back && rises(first.0) && rises(second.0)
}

/// Planes along an edge of one polygon and a corner of the other that both polygons lie behind: outward normals and
/// the greatest `normal . x`.
fn side_planes(first: &[DVec3], second: &[DVec3]) -> Vec<(DVec3, f64)> {
    let mut planes = Vec::with_capacity(8);
    for (polygon, other) in [(first, second), (second, first)] {
        for k in 0..polygon.len() {
            let (a, b) = (polygon[k], polygon[(k + 1) % polygon.len()]);
            planes.extend(other.iter().filter_map(|&c| supporting(a, b, c, polygon, other)).next());
        }
    }
    planes
}

/// The plane through an edge and a corner, if both polygons lie behind it.
fn supporting(a: DVec3, b: DVec3, c: DVec3, polygon: &[DVec3], other: &[DVec3]) -> Option<(DVec3, f64)> {
    let normal = (b - a).cross(c - a).normalize_or_zero();
    if normal == DVec3::ZERO {
        return None;
    }
    let slack = 1e-12 * (a.abs().max_element() + (c - a).length());
    let (mut low, mut high) = (0.0f64, 0.0f64);
    for &p in polygon.iter().chain(other) {
        let h = normal.dot(p - a);
        (low, high) = (low.min(h), high.max(h));
    }
    if high <= slack && low < -slack {
        Some((normal, normal.dot(a) - slack))
    } else if low >= -slack && high > slack {
        Some((-normal, -normal.dot(a) - slack))
    } else {
        None
    }
}

/// Whether every line from corner to corner passes through the blocker: then every line between the polygons does.
fn hides(blocker: &Blocker, first: &[DVec3], second: &[DVec3]) -> bool {
    let heights = |polygon: &[DVec3]| range(polygon.iter().map(|&p| blocker.height(p)));
    let (a, b) = (heights(first), heights(second));
    let apart = (a.0 > 0.0 && b.1 < 0.0) || (b.0 > 0.0 && a.1 < 0.0);
    apart && first.iter().all(|&x| second.iter().all(|&y| passes(blocker, x, y)))
}

/// Whether the line between two points on either side of the blocker's plane meets the plane within the blocker.
fn passes(blocker: &Blocker, x: DVec3, y: DVec3) -> bool {
    let (hx, hy) = (blocker.height(x), blocker.height(y));
    let at = x + hx / (hx - hy) * (y - x);
    let n = blocker.corners.len();
    (0..n).all(|k| {
        let (a, b) = (blocker.corners[k], blocker.corners[(k + 1) % n]);
        blocker.normal.dot((b - a).cross(at - a)) >= 0.0
    })
}
