//! The shape of a face: what a triangle or quad must be to serve as a patch.

use glam::DVec3;

/// How far a corner may leave the plane of its quad, relative to the longest diagonal.
///
/// Single-precision files round corners by some 1e-7 of their coordinates, which may be a hundred times the quad.
pub(crate) const PLANARITY: f64 = 1e-5;

/// Twice the area below which a face counts as having none, relative to its longest extent squared.
const FLATNESS: f64 = 1e-10;

/// What four corners make.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Shape {
    /// A triangle or a planar, convex quad.
    Sound,
    /// All corners on one line or in one point.
    ZeroArea,
    /// A corner lies this many metres off the plane through the others' mean.
    NonPlanar(f64),
    /// An inward corner, or edges that cross.
    NotConvex,
}

/// Classifies a face; a triangle repeats its last corner.
pub(crate) fn classify(corners: [DVec3; 4]) -> Shape {
    let [a, b, c, d] = corners;
    let extent = longest_extent(corners);
    let turns = turns(corners);
    let widest = turns.iter().copied().fold(DVec3::ZERO, longer);
    if widest.length() <= FLATNESS * extent * extent {
        return Shape::ZeroArea;
    }
    if c == d {
        return Shape::Sound;
    }
    let normal = (c - a).cross(d - b).try_normalize().unwrap_or(widest.normalize());
    let centre = 0.25 * (a + b + c + d);
    let off = corners.iter().map(|&p| (p - centre).dot(normal).abs()).fold(0.0, f64::max);
    if off > PLANARITY * extent {
        return Shape::NonPlanar(off);
    }
    let inward = |turn: &DVec3| turn.dot(normal) < -FLATNESS * extent * extent;
    if turns.iter().any(inward) { Shape::NotConvex } else { Shape::Sound }
}

/// The cross product of the two edges that meet at each corner.
fn turns(corners: [DVec3; 4]) -> [DVec3; 4] {
    std::array::from_fn(|i| {
        let (before, here, after) = (corners[(i + 3) % 4], corners[i], corners[(i + 1) % 4]);
        (here - before).cross(after - here)
    })
}

fn longest_extent([a, b, c, d]: [DVec3; 4]) -> f64 {
    [b - a, c - b, d - c, a - d, c - a, d - b].iter().map(|edge| edge.length()).fold(0.0, f64::max)
}

fn longer(a: DVec3, b: DVec3) -> DVec3 {
    if b.length_squared() > a.length_squared() { b } else { a }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quad(corners: [[f64; 3]; 4]) -> Shape {
        classify(corners.map(DVec3::from_array))
    }

    #[test]
    fn unit_square_is_sound() {
        let square = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];
        assert_eq!(quad(square), Shape::Sound);
    }

    #[test]
    fn triangle_with_a_repeated_corner_is_sound() {
        let triangle = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [1., 1., 0.]];
        assert_eq!(quad(triangle), Shape::Sound);
    }

    #[test]
    fn corner_on_an_edge_is_sound() {
        let flat = [[0., 0., 0.], [1., 0., 0.], [2., 0., 0.], [0., 1., 0.]];
        assert_eq!(quad(flat), Shape::Sound);
    }

    #[test]
    fn line_has_no_area() {
        let line = [[0., 0., 0.], [1., 0., 0.], [2., 0., 0.], [3., 0., 0.]];
        assert_eq!(quad(line), Shape::ZeroArea);
        assert_eq!(quad([[1., 2., 3.]; 4]), Shape::ZeroArea);
    }

    #[test]
    fn lifted_corner_is_not_planar() {
        let bent = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.1], [0., 1., 0.]];
        let Shape::NonPlanar(off) = quad(bent) else { panic!("{:?}", quad(bent)) };
        assert!((0.02..0.03).contains(&off), "{off}");
    }

    #[test]
    fn arrowhead_and_bow_tie_are_not_convex() {
        let arrow = [[0., 0., 0.], [2., 0., 0.], [0.5, 0.5, 0.], [0., 2., 0.]];
        let bow_tie = [[0., 0., 0.], [1., 1., 0.], [1., 0., 0.], [0., 1., 0.]];
        assert_eq!(quad(arrow), Shape::NotConvex);
        assert_eq!(quad(bow_tie), Shape::NotConvex);
    }
}
