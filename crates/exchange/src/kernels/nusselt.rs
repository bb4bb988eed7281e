//! The form factor by Nusselt's analog.
//!
//! What it computes: a polygon is projected onto the unit hemisphere above a point, and from there straight down onto
//! its base; the form factor from the point is the share of the base that is covered (Nusselt 1928, *Graphische
//! Bestimmung des Winkelverhaeltnisses bei der Waermestrahlung*). Each edge becomes an arc of a great circle, and the
//! sector between the arc and the centre, of area angle / 2, shrinks by the cosine of its plane with the base when it
//! is projected. The form factor from a patch is the mean over points of it: Gauss's rule, `points^2` of them.
//!
//! Error: none at a point. The mean converges geometrically where the patches are apart (unit squares at gap 1: by a
//! factor of 20 a point). Where they share an edge, what a point sees depends near the ends of the edge on the direction
//! to them alone, and the mean converges like `1 / points^4`. Where an edge of one ends within an edge of the other it
//! does so like `1 / points^2`, erratically, because rows of points near the edge see a step where it ends.
//!
//! When to choose it: to see and to teach what a form factor is, and for a first estimate.

use crate::kernels::point_to_polygon::{above_horizon, solid_cosine};
use crate::quadrature::PlaneRule;
use glam::DVec3;
use radiosity_geometry::sampling::Frame;

/// The share of the unit disk that a polygon covers, its corners relative to the point and none below its horizon.
///
/// The projected sectors of all edges, each `angle / 2` times the cosine between its plane and the base, over pi: which
/// is Lambert's formula, term by term.
pub fn covered(normal: DVec3, corners: &[DVec3]) -> f64 {
    solid_cosine(normal, corners)
}

/// The exchange, m2, from every point of a rule on the first polygon: the areas around the points, summed.
pub fn nusselt(first: &[DVec3], rule: &PlaneRule, mut covered_at: impl FnMut(DVec3) -> f64) -> f64 {
    let mut sum = 0.0;
    rule.on(first, |x, area| sum += area * covered_at(x));
    sum
}

/// The part of a convex polygon above the horizon of `x`, its corners relative to `x`, as [`covered`] takes them.
pub fn seen_from(x: DVec3, normal: DVec3, polygon: &[DVec3]) -> Vec<DVec3> {
    let mut corners = Vec::with_capacity(polygon.len() + 1);
    above_horizon(x, normal, polygon, |corner| corners.push(corner));
    corners
}

/// The outline of a polygon as projected onto the unit hemisphere, for pictures: points in the frame of the normal,
/// whose first two coordinates are those of the projection onto the base.
///
/// Corners as [`covered`] takes them. `steps` points an edge, evenly along the great circle that it becomes.
pub fn outline(normal: DVec3, corners: &[DVec3], steps: usize) -> Vec<DVec3> {
    let frame = Frame::new(normal);
    let mut points = Vec::with_capacity(steps * corners.len());
    for k in 0..corners.len() {
        let (a, b) = (corners[k].normalize_or_zero(), corners[(k + 1) % corners.len()].normalize_or_zero());
        let angle = a.cross(b).length().atan2(a.dot(b));
        for step in 0..steps {
            let t = step as f64 / steps as f64;
            let on = (a * ((1.0 - t) * angle).sin() + b * (t * angle).sin()).normalize_or(a);
            points.push(DVec3::new(on.dot(frame.tangent), on.dot(frame.bitangent), on.dot(frame.normal)));
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn square(z: f64) -> [DVec3; 4] {
        [(0., 0.), (1., 0.), (1., 1.), (0., 1.)].map(|(x, y)| DVec3::new(x, y, z))
    }

    #[test]
    fn a_square_above_its_corner() {
        assert!((covered(DVec3::Z, &square(1.0)) - 0.138_531_606_0).abs() < 1e-10);
    }

    #[test]
    fn the_outline_covers_the_same_share_of_the_base() {
        let points = outline(DVec3::Z, &square(1.0), 2000);
        let n = points.len();
        let twice: f64 = (0..n).map(|k| points[k].truncate().perp_dot(points[(k + 1) % n].truncate())).sum();
        assert!((0.5 * twice.abs() / PI - 0.138_531_606_0).abs() < 1e-6);
        assert!(points.iter().all(|p| (p.length() - 1.0).abs() < 1e-12 && p.z > 0.0));
    }

    #[test]
    fn what_is_below_the_horizon_is_cut_off() {
        // Howell B-8: the part above the horizon is the unit square that stands on the plane of the point.
        let tall = [(0., -3.), (1., -3.), (1., 1.), (0., 1.)].map(|(y, z)| DVec3::new(1.0, y, z));
        let corners = seen_from(DVec3::ZERO, DVec3::Z, &tall);
        assert!((covered(DVec3::Z, &corners) - 0.055_734_197_0).abs() < 1e-10);
        assert!(outline(DVec3::Z, &corners, 7).iter().all(|p| p.z >= 0.0));
        assert!(seen_from(DVec3::ZERO, DVec3::Z, &square(-1.0)).is_empty());
    }

    #[test]
    fn the_mean_over_a_patch_converges() {
        let error = |n: usize| {
            let f = nusselt(&square(0.0), &PlaneRule::new(n), |x| covered(DVec3::Z, &square(1.0).map(|c| c - x)));
            (f - 0.199_824_895_698_387_46).abs()
        };
        assert!(error(2) < 1e-2 && error(4) < 1e-4 && error(8) < 1e-8, "{} {} {}", error(2), error(4), error(8));
    }
}
