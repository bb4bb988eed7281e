//! What is left of a convex polygon when others that lie in it are taken away.
//!
//! Everything stays convex: taking a convex polygon from another leaves one convex piece along each of its edges.

use glam::DVec3;

/// Distances below this part of the polygon's extent count as none.
const ROUNDING: f64 = 1e-7;

/// How far corners may leave their base, relative to its extent, and how far parts may overlap. View3D has the same
/// tolerance; files carry few digits.
const SLACK: f64 = 1e-5;

/// Convex pieces of a polygon, in its plane.
pub(super) struct Cover {
    base: Vec<DVec3>,
    normal: DVec3,
    extent: f64,
    pieces: Vec<Vec<DVec3>>,
}

/// Why a polygon cannot be taken away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Misfit {
    OffPlane,
    Turned,
    Outside,
    Overlap,
}

impl Misfit {
    /// The sentence for it; `faces_base` for what should face its base.
    pub fn message(self, faces_base: bool) -> &'static str {
        match self {
            Self::OffPlane => "it does not lie in the plane of its base; move its vertices there",
            Self::Turned if faces_base => "a null surface must face its base; reverse the order of its vertices",
            Self::Turned => "it must face the same way as its base; reverse the order of its vertices",
            Self::Outside => "it reaches beyond its base; correct its vertices or its base",
            Self::Overlap => "it overlaps another surface of the same base; make one the base of the other",
        }
    }
}

impl Cover {
    /// The whole polygon, convex and counter-clockwise.
    pub fn new(base: &[DVec3]) -> Self {
        let normal = vector_area(base).normalize_or_zero();
        Self { base: base.to_vec(), normal, extent: extent(base), pieces: vec![base.to_vec()] }
    }

    /// Takes a convex polygon away that turns as the base does.
    pub fn remove(&mut self, hole: &[DVec3]) -> Result<(), Misfit> {
        self.check(hole)?;
        let before = self.area();
        let pieces = std::mem::take(&mut self.pieces);
        self.pieces = pieces.into_iter().flat_map(|piece| self.without(piece, hole)).collect();
        let taken = vector_area(hole).length();
        let missing = (before - self.area() - taken).abs();
        if missing > self.slack() * extent(hole) { Err(Misfit::Overlap) } else { Ok(()) }
    }

    fn slack(&self) -> f64 {
        SLACK * self.extent
    }

    fn check(&self, hole: &[DVec3]) -> Result<(), Misfit> {
        if hole.iter().any(|p| (*p - self.base[0]).dot(self.normal).abs() > self.slack()) {
            return Err(Misfit::OffPlane);
        }
        if vector_area(hole).dot(self.normal) <= 0.0 {
            return Err(Misfit::Turned);
        }
        let is_outside = |(a, b): (DVec3, DVec3)| hole.iter().any(|&p| self.height(a, b, p) < -self.slack());
        if edges(&self.base).any(is_outside) { Err(Misfit::Outside) } else { Ok(()) }
    }

    fn area(&self) -> f64 {
        self.pieces.iter().map(|piece| vector_area(piece).length()).sum()
    }

    /// How far a point lies within an edge.
    fn height(&self, a: DVec3, b: DVec3, point: DVec3) -> f64 {
        self.normal.cross(b - a).normalize_or_zero().dot(point - a)
    }

    /// The pieces of a piece without the hole.
    fn without(&self, piece: Vec<DVec3>, hole: &[DVec3]) -> Vec<Vec<DVec3>> {
        if self.is_apart(&piece, hole) || self.is_apart(hole, &piece) {
            return vec![piece];
        }
        let (mut pieces, mut rest) = (Vec::new(), piece.clone());
        for (a, b) in edges(hole) {
            let (within, beyond) = self.split(&rest, (a, b), hole);
            pieces.extend(beyond);
            match within {
                Some(within) => rest = within,
                None => return vec![piece],
            }
        }
        pieces
    }

    /// Whether all of one polygon lies beyond some edge of another.
    fn is_apart(&self, polygon: &[DVec3], other: &[DVec3]) -> bool {
        edges(other).any(|(a, b)| polygon.iter().all(|&p| self.height(a, b, p) <= self.tolerance()))
    }

    /// The parts of a convex polygon within an edge of a hole and beyond it.
    fn split(
        &self,
        polygon: &[DVec3],
        (a, b): (DVec3, DVec3),
        hole: &[DVec3],
    ) -> (Option<Vec<DVec3>>, Option<Vec<DVec3>>) {
        let height = |&p: &DVec3| Some(self.height(a, b, p)).filter(|h| h.abs() > self.tolerance()).unwrap_or(0.0);
        let heights: Vec<f64> = polygon.iter().map(height).collect();
        let (mut within, mut beyond) = (Vec::new(), Vec::new());
        for (i, (&p, &h)) in polygon.iter().zip(&heights).enumerate() {
            let next = (i + 1) % polygon.len();
            if h >= 0.0 {
                within.push(p);
            }
            if h <= 0.0 {
                beyond.push(p);
            }
            if h * heights[next] < 0.0 {
                let crossing = self.snapped(p.lerp(polygon[next], h / (h - heights[next])), hole);
                within.push(crossing);
                beyond.push(crossing);
            }
        }
        let reaches = |sign: f64| heights.iter().any(|h| sign * h > 0.0);
        (reaches(1.0).then_some(within), reaches(-1.0).then_some(beyond))
    }

    fn tolerance(&self) -> f64 {
        ROUNDING * self.extent
    }

    /// A corner of the hole in place of a point next to it, so that both have it in common.
    fn snapped(&self, point: DVec3, hole: &[DVec3]) -> DVec3 {
        let is_near = |corner: &&DVec3| corner.distance_squared(point) <= self.tolerance().powi(2);
        hole.iter().find(is_near).copied().unwrap_or(point)
    }

    /// The pieces as triangles and quads; a triangle repeats its last corner.
    pub fn into_faces(self) -> Vec<[DVec3; 4]> {
        self.pieces.iter().flat_map(|piece| fan(&self.straightened(piece))).collect()
    }

    /// The corners at which the outline turns.
    fn straightened(&self, piece: &[DVec3]) -> Vec<DVec3> {
        let mut kept = piece.to_vec();
        let mut i = 0;
        while i < kept.len() && kept.len() > 3 {
            let n = kept.len();
            let (before, after) = (kept[(i + n - 1) % n], kept[(i + 1) % n]);
            if self.height(before, after, kept[i]).abs() <= self.tolerance() {
                kept.remove(i);
            } else {
                i += 1;
            }
        }
        kept
    }
}

/// Quads from the first corner of a convex polygon, and a triangle where a corner is left.
fn fan(polygon: &[DVec3]) -> Vec<[DVec3; 4]> {
    let last = polygon.len() - 1;
    (1..last).step_by(2).map(|i| [polygon[0], polygon[i], polygon[i + 1], polygon[(i + 2).min(last)]]).collect()
}

fn edges(polygon: &[DVec3]) -> impl Iterator<Item = (DVec3, DVec3)> + '_ {
    (0..polygon.len()).map(|i| (polygon[i], polygon[(i + 1) % polygon.len()]))
}

/// The longest distance between corners.
fn extent(polygon: &[DVec3]) -> f64 {
    polygon.iter().flat_map(|p| polygon.iter().map(move |q| p.distance(*q))).fold(0.0, f64::max)
}

fn vector_area(polygon: &[DVec3]) -> DVec3 {
    let origin = polygon[0];
    0.5 * polygon.windows(2).map(|edge| (edge[0] - origin).cross(edge[1] - origin)).sum::<DVec3>()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::quad::{self, Shape};

    fn rectangle(low: [f64; 2], high: [f64; 2]) -> Vec<DVec3> {
        let at = |x: f64, y: f64| DVec3::new(x, y, 3.0 + 0.5 * x);
        vec![at(low[0], low[1]), at(high[0], low[1]), at(high[0], high[1]), at(low[0], high[1])]
    }

    fn remainder(base: &[DVec3], holes: &[Vec<DVec3>]) -> Result<Vec<[DVec3; 4]>, Misfit> {
        let mut cover = Cover::new(base);
        holes.iter().try_for_each(|hole| cover.remove(hole))?;
        Ok(cover.into_faces())
    }

    /// The vector area of faces, all of which must be sound.
    fn total(faces: &[[DVec3; 4]]) -> DVec3 {
        assert!(faces.iter().all(|&face| quad::classify(face) == Shape::Sound), "{faces:?}");
        faces.iter().map(|face| vector_area(face)).sum()
    }

    #[test]
    fn window_leaves_a_frame() {
        let (wall, window) = (rectangle([0., 0.], [4., 3.]), rectangle([1., 1.], [2., 2.]));
        let faces = remainder(&wall, std::slice::from_ref(&window)).unwrap();
        assert_eq!(faces.len(), 4);
        assert!((total(&faces) - vector_area(&wall) + vector_area(&window)).length() < 1e-12);
        // Corners of the window are those of the frame.
        assert!(window.iter().all(|corner| faces.iter().flatten().any(|p| p == corner)));
    }

    #[test]
    fn parts_may_touch_the_edge_and_one_another() {
        let wall = rectangle([0., 0.], [4., 3.]);
        let parts = [rectangle([0., 0.], [1., 2.]), rectangle([1., 0.], [2., 2.]), rectangle([3., 0.], [4., 3.])];
        let faces = remainder(&wall, &parts).unwrap();
        let expected = vector_area(&wall) * (12.0 - 2.0 - 2.0 - 3.0) / 12.0;
        assert!((total(&faces) - expected).length() < 1e-12);
        assert!(remainder(&wall, std::slice::from_ref(&wall)).unwrap().is_empty());
    }

    #[test]
    fn rounded_corners_fit() {
        let thirds = [rectangle([0., 0.], [1.333335, 3.]), rectangle([1.333333, 0.], [2.666667, 3.000001])];
        let faces = remainder(&rectangle([0., 0.], [4., 3.]), &thirds).unwrap();
        assert!((total(&faces).length() - vector_area(&thirds[0]).length()).abs() < 1e-4);
    }

    #[test]
    fn misfits_are_told_apart() {
        let wall = rectangle([0., 0.], [4., 3.]);
        let one = |hole: Vec<DVec3>| remainder(&wall, &[hole]).unwrap_err();
        let mut turned = rectangle([1., 1.], [2., 2.]);
        turned.reverse();
        assert_eq!(one(turned), Misfit::Turned);
        assert_eq!(one(rectangle([3., 1.], [5., 2.])), Misfit::Outside);
        let lifted = rectangle([1., 1.], [2., 2.]).into_iter().map(|p| p + 0.1 * DVec3::Z).collect();
        assert_eq!(one(lifted), Misfit::OffPlane);
        let both = [rectangle([1., 1.], [2., 2.]), rectangle([1.5, 1.5], [2.5, 2.5])];
        assert_eq!(remainder(&wall, &both).unwrap_err(), Misfit::Overlap);
    }

    proptest! {
        /// A triangle within a triangle, by barycentric weights.
        #[test]
        fn areas_add_up(weights in prop::array::uniform3(prop::array::uniform3(0.0_f64..1.0))) {
            let base = [DVec3::new(0., 0., 1.), DVec3::new(3., 0.5, 2.), DVec3::new(1., 2., 0.)];
            let place = |w: [f64; 3]| {
                let sum = w.iter().sum::<f64>().max(1e-3);
                (w[0] * base[0] + w[1] * base[1] + (sum - w[0] - w[1]) * base[2]) / sum
            };
            let mut hole = weights.map(place).to_vec();
            if vector_area(&hole).dot(vector_area(&base)) < 0.0 {
                hole.reverse();
            }
            prop_assume!(quad::classify([hole[0], hole[1], hole[2], hole[2]]) == Shape::Sound);
            prop_assume!(vector_area(&hole).length() > 1e-3);
            let faces = remainder(&base, &[hole.clone()]).unwrap();
            let sum: DVec3 = faces.iter().map(|face| vector_area(face)).sum();
            prop_assert!((sum + vector_area(&hole) - vector_area(&base)).length() < 1e-6);
        }
    }
}
