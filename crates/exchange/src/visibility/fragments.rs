//! What is visible of a polygon from a point: exactly, as convex fragments.
//!
//! Each blocker, seen from the point, is a cone. What lies outside the cone, or before the blocker, is visible; cutting
//! along the cone's faces leaves convex pieces (Weiler and Atherton 1977, *Hidden surface removal using polygon area
//! sorting*, in object space). All corners are kept relative to the point, so that cutting planes pass through zero.

use super::blockers::Blocker;
use crate::convex::split;
use crate::kernels::point_to_polygon::solid_cosine;
use glam::DVec3;

/// Convex polygons one after the other.
#[derive(Default)]
struct Pile {
    corners: Vec<DVec3>,
    ends: Vec<usize>,
}

impl Pile {
    fn clear(&mut self) {
        self.corners.clear();
        self.ends.clear();
    }

    fn start_of(&self, k: usize) -> usize {
        if k == 0 { 0 } else { self.ends[k - 1] }
    }

    fn polygon(&self, k: usize) -> &[DVec3] {
        &self.corners[self.start_of(k)..self.ends[k]]
    }

    fn push(&mut self, polygon: &[DVec3]) {
        if polygon.len() >= 3 {
            self.corners.extend_from_slice(polygon);
            self.ends.push(self.corners.len());
        }
    }
}

/// Buffers for [`Fragments::visible`], kept between points.
#[derive(Default)]
pub struct Fragments {
    visible: Pile,
    next: Pile,
    inside: Vec<DVec3>,
    part: Vec<DVec3>,
    rest: Vec<DVec3>,
    heights: Vec<f64>,
    /// The blocker at hand, from the eye: its corners, the inward normals through its edges, its plane.
    outline: Vec<DVec3>,
    faces: Vec<DVec3>,
    toward: (DVec3, f64),
}

/// Whether all points are on or outside a plane through the eye.
fn is_outside(inward: DVec3, points: &[DVec3]) -> bool {
    let on = ON_PLANE * inward.length();
    points.iter().all(|p| inward.dot(*p) <= on * p.abs().max_element())
}

/// A point this near to a cutting plane, relative to its distance from the eye, is on it.
const ON_PLANE: f64 = 1e-12;

impl Fragments {
    /// The form factor from a differential area at `x` to what `blockers` leave visible of a polygon above its horizon.
    ///
    /// `contact`: a blocker whose plane is nearer to `x` than this is seen edge on and hides nothing.
    pub fn visible<'b>(
        &mut self,
        x: DVec3,
        normal: DVec3,
        polygon: &[DVec3],
        blockers: impl Iterator<Item = &'b Blocker>,
        contact: f64,
    ) -> f64 {
        self.visible.clear();
        self.part.clear();
        self.part.extend(polygon.iter().map(|c| *c - x));
        self.visible.push(&self.part);
        for blocker in blockers {
            let depth = -blocker.height(x);
            if depth.abs() > contact {
                self.remove(blocker, x, depth);
            }
            if self.visible.ends.is_empty() {
                return 0.0;
            }
        }
        (0..self.visible.ends.len()).map(|k| solid_cosine(normal, self.visible.polygon(k))).sum::<f64>().max(0.0)
    }

    /// Takes away what one blocker hides. `depth`: along its normal, how far its plane is from the eye.
    fn remove(&mut self, blocker: &Blocker, x: DVec3, depth: f64) {
        self.look_at(blocker, x, depth);
        self.next.clear();
        for k in 0..self.visible.ends.len() {
            if self.misses(k) {
                self.next.push(self.visible.polygon(k));
                continue;
            }
            self.inside.clear();
            self.inside.extend_from_slice(self.visible.polygon(k));
            for e in 0..self.faces.len() {
                self.cut(self.faces[e], 0.0);
                self.next.push(&self.rest);
                std::mem::swap(&mut self.inside, &mut self.part);
                if self.inside.len() < 3 {
                    break;
                }
            }
            if self.inside.len() >= 3 {
                // Within the cone, what is before the blocker's plane stays visible.
                self.cut(blocker.normal * depth.signum(), depth.abs());
                self.next.push(&self.rest);
            }
        }
        std::mem::swap(&mut self.visible, &mut self.next);
    }

    /// The blocker as a cone: its corners from the eye, and the inward normals of the planes through its edges.
    fn look_at(&mut self, blocker: &Blocker, x: DVec3, depth: f64) {
        self.outline.clear();
        self.outline.extend(blocker.corners.iter().map(|c| *c - x));
        self.faces.clear();
        let n = self.outline.len();
        for e in 0..n {
            let (a, b) = (self.outline[e], self.outline[if e + 1 == n { 0 } else { e + 1 }]);
            // Counter-clockwise seen from its front, that is, where depth is negative.
            self.faces.push(if depth < 0.0 { b.cross(a) } else { a.cross(b) });
        }
        self.toward = (blocker.normal * depth.signum(), depth.abs());
    }

    /// Whether the cone and a fragment, both convex, have no inside in common: then a face of either parts them.
    fn misses(&self, k: usize) -> bool {
        let fragment = self.visible.polygon(k);
        let (toward, depth) = self.toward;
        let is_before = fragment.iter().all(|v| toward.dot(*v) <= depth);
        is_before || self.faces.iter().any(|face| is_outside(*face, fragment)) || self.is_beside(fragment)
    }

    /// Whether the blocker lies outside an edge of a fragment.
    fn is_beside(&self, fragment: &[DVec3]) -> bool {
        let n = fragment.len();
        // The sign of the first corner that is not on the plane of the first edges says which way round they go.
        let turn = fragment[0].cross(fragment[1]).dot(fragment[2]);
        (0..n).any(|e| {
            let (a, b) = (fragment[e], fragment[if e + 1 == n { 0 } else { e + 1 }]);
            let face = if turn > 0.0 { a.cross(b) } else { b.cross(a) };
            turn != 0.0 && is_outside(face, &self.outline)
        })
    }

    /// Splits `inside` by the plane `normal . v = offset` into `part`, where it is greater, and `rest`.
    fn cut(&mut self, normal: DVec3, offset: f64) {
        self.part.clear();
        self.rest.clear();
        self.heights.clear();
        let size = normal.length();
        let (mut above, mut below) = (false, false);
        for &v in &self.inside {
            let h = normal.dot(v) - offset;
            let on = ON_PLANE * size * v.abs().max_element();
            let h = if h.abs() <= on { 0.0 } else { h };
            above |= h > 0.0;
            below |= h < 0.0;
            self.heights.push(h);
        }
        if !below {
            std::mem::swap(&mut self.part, &mut self.inside);
        } else if !above {
            std::mem::swap(&mut self.rest, &mut self.inside);
        } else {
            split(&self.inside, &self.heights, &mut self.part, &mut self.rest);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::point_to_polygon::point_to_polygon;

    fn rectangle(x0: f64, x1: f64, y0: f64, y1: f64, z: f64) -> Vec<DVec3> {
        [(x0, y0), (x1, y0), (x1, y1), (x0, y1)].map(|(x, y)| DVec3::new(x, y, z)).to_vec()
    }

    fn visible(polygon: &[DVec3], blockers: &[Vec<DVec3>]) -> f64 {
        let blockers: Vec<Blocker> = blockers.iter().map(|b| Blocker::new(b.clone()).unwrap()).collect();
        Fragments::default().visible(DVec3::ZERO, DVec3::Z, polygon, blockers.iter(), 1e-9)
    }

    #[test]
    fn shadows_that_overlap_count_once() {
        let ceiling = rectangle(-4., 4., -4., 4., 2.0);
        let whole = point_to_polygon(DVec3::ZERO, DVec3::Z, &ceiling);
        // At half the height, shadows twice the size: [-1, 1]^2, and [0, 2] x [0, 2] beside and over it.
        let (a, b) = (rectangle(-0.5, 0.5, -0.5, 0.5, 1.0), rectangle(0.0, 1.0, 0.0, 1.0, 1.0));
        let shadow = |p: &[DVec3]| point_to_polygon(DVec3::ZERO, DVec3::Z, p);
        assert!((visible(&ceiling, std::slice::from_ref(&a)) - (whole - shadow(&a))).abs() < 1e-14);
        let overlap = rectangle(0.0, 0.5, 0.0, 0.5, 1.0);
        let expected = whole - shadow(&a) - shadow(&b) + shadow(&overlap);
        for pair in [[a.clone(), b.clone()], [b, a]] {
            assert!((visible(&ceiling, &pair) - expected).abs() < 1e-14);
        }
    }

    #[test]
    fn blockers_behind_hide_nothing_and_those_across_hide_what_is_beyond() {
        let ceiling = rectangle(-1., 1., -1., 1., 2.0);
        let whole = point_to_polygon(DVec3::ZERO, DVec3::Z, &ceiling);
        assert!((visible(&ceiling, &[rectangle(-1., 1., -1., 1., 3.0)]) - whole).abs() < 1e-15);
        assert!((visible(&ceiling, &[rectangle(-1., 1., -1., 1., -1.0)]) - whole).abs() < 1e-15);
        assert_eq!(visible(&ceiling, &[rectangle(-1., 1., -1., 1., 1.0)]), 0.0);
        // A tilted plate through the ceiling at x = 0: below it for x < 0, above it for x > 0.
        let tilted =
            [(-1., -1., 1.5), (1., -1., 2.5), (1., 1., 2.5), (-1., 1., 1.5)].map(|(x, y, z)| DVec3::new(x, y, z));
        let left = rectangle(-1., 0., -1., 1., 2.0);
        let seen = visible(&left, &[tilted.to_vec()]);
        let half = visible(&ceiling, &[tilted.to_vec()])
            - point_to_polygon(DVec3::ZERO, DVec3::Z, &rectangle(0., 1., -1., 1., 2.0));
        assert!((seen - half).abs() < 1e-14 && seen < 0.5 * whole, "{seen} {half}");
    }
}
