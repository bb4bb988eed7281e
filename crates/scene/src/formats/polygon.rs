//! Polygons of any number of corners, cut into the triangles and planar, convex quads that surfaces are made of.

use glam::DVec3;

use crate::model::Face;
use crate::quad::{self, Shape};

/// What became of a polygon.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Cut {
    /// Triangles and quads; none for a polygon without area.
    pub faces: Vec<Face>,
    /// Its corners leave its plane, so that the triangles follow one of several surfaces through them.
    pub bent: bool,
    /// Its edges cross, so that the triangles do not cover it.
    pub tangled: bool,
}

/// Cuts the polygon with these corners, which are indices into `positions`.
pub(super) fn cut(corners: &[u32], positions: &[DVec3]) -> Cut {
    let corners = without_repeats(corners, positions);
    match corners[..] {
        [] | [_] | [_, _] => Cut::default(),
        [a, b, c] => Cut { faces: vec![[a, b, c, c]], ..Cut::default() },
        [a, b, c, d] => match quad::classify([a, b, c, d].map(|corner| positions[corner as usize])) {
            Shape::Sound => Cut { faces: vec![[a, b, c, d]], ..Cut::default() },
            Shape::ZeroArea => Cut::default(),
            Shape::NonPlanar(_) | Shape::NotConvex => triangulated(&corners, positions),
        },
        _ => triangulated(&corners, positions),
    }
}

/// The corners without neighbours in the same place.
fn without_repeats(corners: &[u32], positions: &[DVec3]) -> Vec<u32> {
    let same = |a: u32, b: u32| positions[a as usize] == positions[b as usize];
    let mut kept: Vec<u32> = Vec::with_capacity(corners.len());
    for &corner in corners {
        if kept.last().is_none_or(|&last| !same(last, corner)) {
            kept.push(corner);
        }
    }
    while kept.len() > 1 && same(kept[0], kept[kept.len() - 1]) {
        kept.pop();
    }
    kept
}

/// Ear clipping in the plane of the polygon.
fn triangulated(corners: &[u32], positions: &[DVec3]) -> Cut {
    let points: Vec<_> = corners.iter().map(|&corner| positions[corner as usize]).collect();
    let vector_area = vector_area(&points);
    let Some(normal) = vector_area.try_normalize() else {
        return Cut { tangled: extent(&points) > 0.0, ..Cut::default() };
    };
    let (x, y) = normal.any_orthonormal_pair();
    let flat: Vec<f64> = points.iter().flat_map(|p| [(*p - points[0]).dot(x), (*p - points[0]).dot(y)]).collect();
    let Ok(clipped) = earcutr::earcut(&flat, &[], 2) else {
        return Cut { tangled: true, ..Cut::default() };
    };
    let mut cut = Cut { bent: off_plane(&points, normal) > quad::PLANARITY * extent(&points), ..Cut::default() };
    let mut covered = 0.0;
    for triangle in clipped.chunks_exact(3) {
        let [a, b, c] = [triangle[0], triangle[1], triangle[2]];
        let twice_area = (points[b] - points[a]).cross(points[c] - points[a]).dot(normal);
        covered += 0.5 * twice_area.abs();
        let [a, b, c] = [a, b, c].map(|i| corners[i]);
        cut.faces.push(if twice_area < 0.0 { [a, c, b, b] } else { [a, b, c, c] });
    }
    cut.tangled = (covered - vector_area.length()).abs() > 1e-6 * vector_area.length();
    cut
}

/// Newell's vector area: the normal times the area, for bent polygons that of their best plane.
fn vector_area(points: &[DVec3]) -> DVec3 {
    let origin = points[0];
    let fan = points.windows(2).map(|edge| (edge[0] - origin).cross(edge[1] - origin));
    0.5 * fan.sum::<DVec3>()
}

fn off_plane(points: &[DVec3], normal: DVec3) -> f64 {
    let centre = points.iter().sum::<DVec3>() / points.len() as f64;
    points.iter().map(|p| (*p - centre).dot(normal).abs()).fold(0.0, f64::max)
}

fn extent(points: &[DVec3]) -> f64 {
    points.iter().map(|p| p.distance(points[0])).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn points(flat: &[[f64; 2]]) -> Vec<DVec3> {
        flat.iter().map(|&[x, y]| DVec3::new(x, y, 0.0)).collect()
    }

    fn cut_all(positions: &[DVec3]) -> Cut {
        cut(&(0..positions.len() as u32).collect::<Vec<_>>(), positions)
    }

    /// The vector area of the faces.
    fn area(cut: &Cut, positions: &[DVec3]) -> DVec3 {
        let corner = |i: u32| positions[i as usize];
        let half = |&[a, b, c, d]: &Face| (corner(c) - corner(a)).cross(corner(d) - corner(b)) / 2.0;
        cut.faces.iter().map(half).sum()
    }

    #[test]
    fn convex_quads_stay_quads() {
        let square = points(&[[0., 0.], [1., 0.], [1., 1.], [0., 1.]]);
        assert_eq!(cut_all(&square).faces, [[0, 1, 2, 3]]);
    }

    #[test]
    fn arrowheads_become_two_triangles_of_their_area() {
        let arrow = points(&[[0., 0.], [2., 0.], [0.5, 0.5], [0., 2.]]);
        let cut = cut_all(&arrow);
        assert_eq!((cut.faces.len(), cut.bent, cut.tangled), (2, false, false));
        assert!((area(&cut, &arrow) - DVec3::Z).length() < 1e-12);
    }

    #[test]
    fn letter_l_is_covered_whichever_way_it_turns() {
        let mut letter = points(&[[0., 0.], [3., 0.], [3., 1.], [1., 1.], [1., 4.], [0., 4.]]);
        assert!((area(&cut_all(&letter), &letter) - 6.0 * DVec3::Z).length() < 1e-12);
        letter.reverse();
        assert!((area(&cut_all(&letter), &letter) + 6.0 * DVec3::Z).length() < 1e-12);
    }

    #[test]
    fn bent_quads_are_split_and_noticed() {
        let mut bent = points(&[[0., 0.], [1., 0.], [1., 1.], [0., 1.]]);
        bent[2].z = 0.2;
        let cut = cut_all(&bent);
        assert_eq!((cut.faces.len(), cut.bent), (2, true));
    }

    #[test]
    fn crossing_edges_are_noticed() {
        assert!(cut_all(&points(&[[0., 0.], [1., 1.], [1., 0.], [0., 1.]])).tangled);
        assert!(cut_all(&points(&[[0., 2.], [1., -1.], [-2., 1.], [2., 1.], [-1., -1.]])).tangled);
    }

    #[test]
    fn repeated_corners_are_dropped() {
        let positions = points(&[[0., 0.], [1., 0.], [1., 1.]]);
        assert_eq!(cut(&[0, 1, 2, 2], &positions).faces, [[0, 1, 2, 2]]);
        assert_eq!(cut(&[0, 1, 1, 2, 0], &positions).faces, [[0, 1, 2, 2]]);
        assert!(cut(&[0, 1, 0, 0], &positions).faces.len() <= 1);
        assert!(cut(&[0, 0, 0], &positions).faces.is_empty());
    }

    proptest! {
        /// Star-shaped polygons are simple, so that their triangles cover them.
        #[test]
        fn star_shaped_polygons_are_covered(radii in prop::collection::vec(0.1_f64..2.0, 5..40)) {
            let step = std::f64::consts::TAU / radii.len() as f64;
            let star: Vec<_> = radii.iter().enumerate().map(|(i, r)| {
                let (sin, cos) = (i as f64 * step).sin_cos();
                DVec3::new(r * cos, r * sin, 3.0)
            }).collect();
            let cut = cut_all(&star);
            prop_assert!(!cut.tangled && !cut.bent);
            prop_assert!((area(&cut, &star) - vector_area(&star)).length() < 1e-9);
        }

        #[test]
        fn nothing_panics(flat in prop::collection::vec((-2_i8..3, -2_i8..3, -1_i8..2), 0..12)) {
            let any: Vec<_> =
                flat.iter().map(|&(x, y, z)| DVec3::new(f64::from(x), f64::from(y), f64::from(z))).collect();
            cut_all(&any);
        }
    }
}
