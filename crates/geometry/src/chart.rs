//! Area-preserving coordinates on a patch.

use crate::DVec3;

/// An area-preserving, piecewise affine map from the unit square onto a patch.
///
/// Equal cells of the square are equal areas of the patch, so that a stratified point set on the square is one on
/// the patch, and a `k x k` grid on the square cuts the patch into `k * k` elements of one size. The map is affine
/// on a parallelogram, folds the square along its diagonal onto a triangle (Heitz 2019, *A low-distortion map
/// between triangle and square*), and does so twice, side by side, for any other convex quadrilateral.
#[derive(Clone, Copy, Debug)]
pub enum Chart {
    /// `origin + s * e1 + t * e2`.
    Parallelogram {
        /// The first corner.
        origin: DVec3,
        /// From the first to the second corner.
        e1: DVec3,
        /// From the first to the last corner.
        e2: DVec3,
    },
    /// `origin + b1 * e1 + b2 * e2` with barycentric `b1`, `b2` from the fold.
    Triangle {
        /// The first corner.
        origin: DVec3,
        /// From the first to the second corner.
        e1: DVec3,
        /// From the first to the third corner.
        e2: DVec3,
    },
    /// Triangles `abc` over `s < split` and `acd` over the rest.
    Quad {
        /// The first corner.
        origin: DVec3,
        /// Corners two to four relative to the first.
        edges: [DVec3; 3],
        /// The first triangle's share of the area.
        split: f64,
    },
}

/// Heitz's fold of the unit square onto barycentric coordinates `(b1, b2)`.
fn fold(s: f64, t: f64) -> (f64, f64) {
    if t > s { (0.5 * s, t - 0.5 * s) } else { (s - 0.5 * t, 0.5 * t) }
}

/// The inverse of [`fold`].
fn unfold(b1: f64, b2: f64) -> (f64, f64) {
    if b2 > b1 { (2.0 * b1, b1 + b2) } else { (b1 + b2, 2.0 * b2) }
}

impl Chart {
    /// The chart of a polygon of three corners (the last repeated) or four.
    pub fn new(polygon: &[DVec3; 4]) -> Self {
        let [a, b, c, d] = *polygon;
        let (e1, e2, e3) = (b - a, c - a, d - a);
        if c == d {
            return Chart::Triangle { origin: a, e1, e2 };
        }
        // Rounding of the file's coordinates may leave a rectangle's far corner off by a few units in the last place.
        let defect = (e1 + e3 - e2).length();
        if defect <= 1e-7 * (e1.length() + e3.length()) {
            return Chart::Parallelogram { origin: a, e1, e2: e3 };
        }
        let (first, second) = (e1.cross(e2).length(), e2.cross(e3).length());
        Chart::Quad { origin: a, edges: [e1, e2, e3], split: first / (first + second) }
    }

    /// The barycentric coordinates of a point on its triangle with the second and third corner of that: of the whole, or
    /// of `abc` for `s < split` and `acd` beyond. Those of a parallelogram are its chart coordinates.
    #[inline]
    pub fn barycentric(&self, s: f64, t: f64) -> (f64, f64) {
        match *self {
            Chart::Parallelogram { .. } => (s, t),
            Chart::Triangle { .. } => fold(s, t),
            Chart::Quad { split, .. } if s < split => fold(s / split, t),
            Chart::Quad { split, .. } => fold((s - split) / (1.0 - split), t),
        }
    }

    /// The point at chart coordinates `(s, t)` in the unit square.
    #[inline]
    pub fn point(&self, s: f64, t: f64) -> DVec3 {
        match *self {
            Chart::Parallelogram { origin, e1, e2 } => origin + s * e1 + t * e2,
            Chart::Triangle { origin, e1, e2 } => {
                let (b1, b2) = self.barycentric(s, t);
                origin + b1 * e1 + b2 * e2
            }
            Chart::Quad { origin, edges: [e1, e2, e3], split } => {
                let (b1, b2) = self.barycentric(s, t);
                if s < split { origin + b1 * e1 + b2 * e2 } else { origin + b1 * e2 + b2 * e3 }
            }
        }
    }

    /// Chart coordinates of the point with barycentric coordinates `(u, v)` on triangle `abc` (`half` 0) or `acd`
    /// (`half` 1) of the polygon, as a ray reports its hit.
    #[inline]
    pub fn coordinates(&self, half: usize, u: f64, v: f64) -> (f64, f64) {
        match *self {
            Chart::Parallelogram { .. } => {
                if half == 0 {
                    (u + v, v)
                } else {
                    (u, u + v)
                }
            }
            Chart::Triangle { .. } => unfold(u, v),
            Chart::Quad { split, .. } => {
                let (s, t) = unfold(u, v);
                if half == 0 { (s * split, t) } else { (split + s * (1.0 - split), t) }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn polygons() -> [[DVec3; 4]; 3] {
        let p = |x: f64, y: f64| DVec3::new(x, y, 0.5 * x - y);
        [
            [p(0., 0.), p(2., 0.), p(3., 1.), p(1., 1.)],
            [p(0., 0.), p(2., 0.), p(3., 1.), p(3., 1.)],
            [p(0., 0.), p(2., 0.), p(3., 1.), p(0., 2.)],
        ]
    }

    proptest! {
        #[test]
        fn coordinates_invert_point(which in 0usize..3, half in 0usize..2, a in 0.001..0.999f64, b in 0.001..0.999f64) {
            let polygon = polygons()[which];
            let half = if which == 1 { 0 } else { half };
            let (u, v) = if a + b < 1.0 { (a, b) } else { (1.0 - a, 1.0 - b) };
            let (p, q) = if half == 0 { (polygon[1], polygon[2]) } else { (polygon[2], polygon[3]) };
            let point = polygon[0] + u * (p - polygon[0]) + v * (q - polygon[0]);
            let chart = Chart::new(&polygon);
            let (s, t) = chart.coordinates(half, u, v);
            prop_assert!((chart.point(s, t) - point).length() < 1e-12);
        }
    }

    #[test]
    fn equal_cells_are_equal_areas() {
        // The mean of the points of a fine grid is the centroid only if the map preserves area.
        for polygon in polygons() {
            let chart = Chart::new(&polygon);
            let patches = crate::Patches::new(vec![polygon], vec![0], vec![0], vec![false]);
            let n = 1000;
            let mean = (0..n * n)
                .map(|i| chart.point(((i % n) as f64 + 0.5) / n as f64, ((i / n) as f64 + 0.5) / n as f64))
                .sum::<DVec3>()
                / (n * n) as f64;
            assert!((mean - patches.centre[0]).length() < 2e-3, "{mean} {}", patches.centre[0]);
        }
    }
}
