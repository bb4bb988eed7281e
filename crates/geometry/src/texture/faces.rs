//! Faces and the places of an image on them.

use std::sync::Arc;

use glam::DVec3;

use super::raster::Raster;
use crate::sampling::Sequence;

/// The affine map from the points of a triangle to texture coordinates.
#[derive(Clone, Copy, Debug)]
struct Affine {
    origin: DVec3,
    at_origin: [f64; 2],
    /// How u and v change a metre.
    gradients: [DVec3; 2],
}

impl Affine {
    /// Of a triangle without area, the coordinates of its first corner.
    fn new([a, b, c]: [DVec3; 3], coordinates: [[f64; 2]; 3]) -> Self {
        let (e1, e2) = (b - a, c - a);
        let normal = e1.cross(e2);
        let square = normal.length_squared();
        let dual = |side: DVec3| if square > 0.0 { side / square } else { DVec3::ZERO };
        let (d1, d2) = (dual(e2.cross(normal)), dual(normal.cross(e1)));
        let [at, at_b, at_c] = coordinates;
        let gradients = [0, 1].map(|k| (at_b[k] - at[k]) * d1 + (at_c[k] - at[k]) * d2);
        Self { origin: a, at_origin: at, gradients }
    }

    #[inline]
    fn coordinates(&self, point: DVec3) -> [f64; 2] {
        [0, 1].map(|k| self.at_origin[k] + self.gradients[k].dot(point - self.origin))
    }
}

/// A triangle, or a quad as the two triangles on both sides of its first diagonal.
#[derive(Clone, Copy, Debug)]
struct Unwrapped {
    first: Affine,
    /// If another map holds on the last corner's side of the diagonal: that, and the vector across to that side.
    second: Option<(Affine, DVec3)>,
}

/// How far off the coordinates of a quad's last corner may be for one map to serve all of it.
const SAME: f64 = 1e-9;

impl Unwrapped {
    /// Corners as faces have them: a triangle repeats its last.
    fn new([a, b, c, d]: [DVec3; 4], coordinates: [[f64; 2]; 4]) -> Self {
        let [at_a, at_b, at_c, at_d] = coordinates;
        let first = Affine::new([a, b, c], [at_a, at_b, at_c]);
        let second = Affine::new([a, c, d], [at_a, at_c, at_d]);
        let across = (c - a).cross(d - b).cross(c - a);
        let found = first.coordinates(d);
        let is_one = c == d || (0..2).all(|k| (found[k] - at_d[k]).abs() <= SAME);
        Self { first, second: (!is_one).then_some((second, across)) }
    }

    #[inline]
    fn coordinates(&self, point: DVec3) -> [f64; 2] {
        match &self.second {
            Some((second, across)) if across.dot(point - second.origin) > 0.0 => second.coordinates(point),
            _ => self.first.coordinates(point),
        }
    }

    /// The parts of a convex polygon on both triangles, each with its map.
    fn parts(&self, polygon: &[DVec3]) -> Vec<(Affine, Vec<DVec3>)> {
        match self.second {
            None => vec![(self.first, polygon.to_vec())],
            Some((second, across)) => {
                vec![
                    (self.first, clipped(polygon, second.origin, -across)),
                    (second, clipped(polygon, second.origin, across)),
                ]
            }
        }
    }
}

/// What of a convex polygon lies on the side of a plane that `toward` points to (Sutherland and Hodgman 1974).
fn clipped(polygon: &[DVec3], on: DVec3, toward: DVec3) -> Vec<DVec3> {
    let height = |p: DVec3| toward.dot(p - on);
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (&p, &q) in polygon.iter().zip(polygon.iter().cycle().skip(1)) {
        let (here, next) = (height(p), height(q));
        if here >= 0.0 {
            kept.push(p);
        }
        if (here > 0.0 && next < 0.0) || (here < 0.0 && next > 0.0) {
            kept.push(p + here / (here - next) * (q - p));
        }
    }
    kept
}

fn area(polygon: &[DVec3]) -> f64 {
    let Some(&origin) = polygon.first() else { return 0.0 };
    let fan = polygon.windows(2).map(|edge| (edge[0] - origin).cross(edge[1] - origin));
    0.5 * fan.sum::<DVec3>().length()
}

/// An image laid over the faces of a surface, times a factor a band.
#[derive(Clone, Debug)]
pub struct TexturedFaces {
    image: Arc<Raster>,
    faces: Vec<Unwrapped>,
    factor: Vec<f32>,
}

/// What a texture has at a point.
#[derive(Clone, Copy, Debug)]
pub struct Values<'a> {
    texel: [f32; 3],
    is_grey: bool,
    factor: &'a [f32],
}

impl Values<'_> {
    /// The value of a band.
    #[inline]
    pub fn band(&self, band: usize) -> f32 {
        self.factor[band] * self.texel[if self.is_grey { 0 } else { band }]
    }
}

/// The faces of a surface, corners and their texture coordinates.
pub fn unwrapped(vertices: &[DVec3], faces: &[[u32; 4]], coordinates: &[[f64; 2]]) -> Vec<([DVec3; 4], [[f64; 2]; 4])> {
    let of = |face: &[u32; 4]| (face.map(|i| vertices[i as usize]), face.map(|i| coordinates[i as usize]));
    faces.iter().map(of).collect()
}

/// Points for what cannot be found along outlines.
const POINTS: u32 = 4096;

impl TexturedFaces {
    /// Faces as four corners with their texture coordinates; a triangle repeats its last. Of a factor of 1 a ten-millionth
    /// is taken off, so that values stay below 1.
    ///
    /// # Panics
    /// If an image of three channels meets a factor of another number of bands.
    pub fn new(
        image: Arc<Raster>,
        faces: impl IntoIterator<Item = ([DVec3; 4], [[f64; 2]; 4])>,
        factor: &[f64],
    ) -> Self {
        assert!(image.channels() == 1 || factor.len() == image.channels(), "one channel, or one per band");
        let faces = faces.into_iter().map(|(corners, coordinates)| Unwrapped::new(corners, coordinates)).collect();
        Self { image, faces, factor: factor.iter().map(|&f| (f as f32).min(1.0 - f32::EPSILON)).collect() }
    }

    /// How many faces there are.
    pub fn len(&self) -> usize {
        self.faces.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.faces.is_empty()
    }

    /// The values at a point of a face.
    #[inline]
    pub fn at(&self, face: usize, point: DVec3) -> Values<'_> {
        let texel = self.image.at(self.faces[face].coordinates(point));
        Values { texel, is_grey: self.image.channels() == 1, factor: &self.factor }
    }

    /// The mean of each band over a convex polygon on a face.
    pub fn mean(&self, face: usize, polygon: &[DVec3], values: &mut [f64]) {
        let parts = self.faces[face].parts(polygon);
        let whole: f64 = parts.iter().map(|(_, part)| area(part)).sum();
        let mut means = [0.0; 3];
        for (map, part) in parts.iter().filter(|(_, part)| part.len() > 2) {
            let share = if whole > 0.0 { area(part) / whole } else { 1.0 / parts.len() as f64 };
            let of_part = self.mean_of_part(map, part);
            means.iter_mut().zip(of_part).for_each(|(mean, value)| *mean += share * value);
        }
        let is_grey = self.image.channels() == 1;
        for (band, (value, &factor)) in values.iter_mut().zip(&self.factor).enumerate() {
            *value = f64::from(factor) * means[if is_grey { 0 } else { band }];
        }
    }

    fn mean_of_part(&self, map: &Affine, part: &[DVec3]) -> [f64; 3] {
        let corners: Vec<_> = part.iter().map(|&p| map.coordinates(p)).collect();
        self.image.mean_over(&corners).unwrap_or_else(|| self.sampled_mean(&corners, part))
    }

    /// The mean by points that are spread evenly over a polygon, corners of which have these coordinates.
    fn sampled_mean(&self, corners: &[[f64; 2]], part: &[DVec3]) -> [f64; 3] {
        let areas: Vec<f64> = (2..part.len()).map(|k| area(&[part[0], part[k - 1], part[k]])).collect();
        let (whole, sequence) = (areas.iter().sum::<f64>(), Sequence::new(0, 0, 0, 0));
        let mut sum = [0.0; 3];
        for index in 0..POINTS {
            let [mut choice, s, t, _] = sequence.point(index);
            choice *= whole;
            let mut k = 0;
            while k + 1 < areas.len() && choice >= areas[k] {
                choice -= areas[k];
                k += 1;
            }
            // Osada et al. 2002, *Shape distributions*: even over a triangle.
            let (root, t) = (s.sqrt(), t);
            let weights = [1.0 - root, root * (1.0 - t), root * t];
            let ends = [corners[0], corners[k + 1], corners[k + 2]];
            let at = [0, 1].map(|axis| (0..3).map(|i| weights[i] * ends[i][axis]).sum());
            sum.iter_mut().zip(self.image.at(at)).for_each(|(sum, value)| *sum += f64::from(value));
        }
        sum.map(|sum| sum / f64::from(POINTS))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texture::Wrap;

    fn image() -> Arc<Raster> {
        let values = (0..64).map(|i| ((i * 37) % 64) as f32 / 64.0).collect();
        Arc::new(Raster::of_values([8, 8], 1, values).with_wrap([Wrap::Clamp; 2]))
    }

    const TILTED: [DVec3; 4] =
        [DVec3::new(1., 0., 0.), DVec3::new(3., 0., 1.), DVec3::new(3., 2., 1.), DVec3::new(1., 2., 0.)];
    const WHOLE: [[f64; 2]; 4] = [[0., 0.], [1., 0.], [1., 1.], [0., 1.]];

    #[test]
    fn corners_have_their_coordinates_and_points_between_those_between() {
        let bent = [[0.1, 0.2], [0.9, 0.1], [1.0, 1.3], [-0.4, 0.7]];
        let face = Unwrapped::new(TILTED, bent);
        for (point, expected) in TILTED.iter().zip(bent).chain([(&(0.5 * (TILTED[2] + TILTED[3])), [0.3, 1.0])]) {
            let found = face.coordinates(*point);
            assert!((0..2).all(|k| (found[k] - expected[k]).abs() < 1e-12), "{found:?} {expected:?}");
        }
        assert!(Unwrapped::new(TILTED, WHOLE).second.is_none() && face.second.is_some());
    }

    #[test]
    fn means_of_the_parts_of_a_face_add_up_to_its_own() {
        for coordinates in [WHOLE, [[0.1, 0.2], [2.9, 0.1], [1.0, 1.3], [-0.4, 0.7]]] {
            let faces = TexturedFaces::new(image(), [(TILTED, coordinates)], &[0.5, 0.25]);
            let (mut whole, mut sum, mut part) = ([0.0; 2], 0.0, [0.0; 2]);
            faces.mean(0, &TILTED, &mut whole);
            for (x0, x1) in [(0.0, 0.3), (0.3, 1.0)] {
                let across = |x: f64, p: DVec3, q: DVec3| p + x * (q - p);
                let strip = [
                    across(x0, TILTED[0], TILTED[1]),
                    across(x1, TILTED[0], TILTED[1]),
                    across(x1, TILTED[3], TILTED[2]),
                    across(x0, TILTED[3], TILTED[2]),
                ];
                faces.mean(0, &strip, &mut part);
                sum += (x1 - x0) * part[0];
            }
            assert!((sum - whole[0]).abs() < 1e-12 && (whole[0] - 2.0 * whole[1]).abs() < 1e-12);
        }
    }

    #[test]
    fn a_face_whose_coordinates_are_a_line_or_a_point_has_a_mean() {
        let line = [[0.0, 0.3], [1.0, 0.3], [1.0, 0.3], [0.0, 0.3]];
        let mut value = [0.0];
        let faces = TexturedFaces::new(image(), [(TILTED, line), (TILTED, [[0.4, 0.6]; 4])], &[1.0]);
        faces.mean(0, &TILTED, &mut value);
        let n = 4096;
        let exact = (0..n).map(|i| f64::from(image().at([(f64::from(i) + 0.5) / f64::from(n), 0.3])[0])).sum::<f64>();
        // So many points of a sequence of low discrepancy on a function with kinks.
        assert!((value[0] - exact / f64::from(n)).abs() < 2e-3);
        faces.mean(1, &TILTED, &mut value);
        assert!((value[0] - f64::from(faces.at(1, TILTED[2]).band(0))).abs() < 1e-6);
    }
}
