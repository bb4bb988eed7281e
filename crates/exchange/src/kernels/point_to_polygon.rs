//! The form factor from a differential area to a polygon, in closed form.
//!
//! Lambert 1760; Hottel and Sarofim 1967, *Radiative Transfer*, eq. 2-35; Baum, Rushmeier and Winget 1989, eq. 10:
//! `F = 1/(2 pi) sum_k angle_k n . (r_k x r_k+1) / |r_k x r_k+1|` over the edges of the part above the horizon,
//! with `angle_k = atan2(|r_k x r_k+1|, r_k . r_k+1)`, which is accurate for small and for nearly straight angles.
//! Exact up to rounding; no occlusion.

use glam::DVec3;

/// The fraction of what leaves a differential area at `x` with unit `normal` that reaches a convex polygon of three
/// or four corners, whichever side of the polygon faces `x`. Parts below the horizon of `x` do not count.
pub fn point_to_polygon(x: DVec3, normal: DVec3, polygon: &[DVec3]) -> f64 {
    debug_assert!(polygon.len() <= 4, "a convex polygon of {} corners does not fit the buffer", polygon.len());
    let mut above = [DVec3::ZERO; 5];
    let mut count = 0;
    above_horizon(x, normal, polygon, |corner| {
        above[count] = corner;
        count += 1;
    });
    solid_cosine(normal, &above[..count])
}

/// The same for corners relative to the point, none below its horizon.
pub fn solid_cosine(normal: DVec3, corners: &[DVec3]) -> f64 {
    let mut sum = 0.0;
    for (k, &a) in corners.iter().enumerate() {
        let b = corners[if k + 1 == corners.len() { 0 } else { k + 1 }];
        let cross = a.cross(b);
        let sine = cross.length();
        if sine > 0.0 {
            sum += sine.atan2(a.dot(b)) / sine * normal.dot(cross);
        }
    }
    sum.abs() * (0.5 * std::f64::consts::FRAC_1_PI)
}

/// Hands the corners of the part of a convex polygon above the horizon of `x` to `keep`, relative to `x` and in order.
pub fn above_horizon(x: DVec3, normal: DVec3, polygon: &[DVec3], mut keep: impl FnMut(DVec3)) {
    let Some(&last) = polygon.last() else { return };
    let mut previous = last - x;
    let mut previous_height = normal.dot(previous);
    for &corner in polygon {
        let current = corner - x;
        let height = normal.dot(current);
        if (height > 0.0) != (previous_height > 0.0) {
            let t = previous_height / (previous_height - height);
            keep(previous + t * (current - previous));
        }
        if height > 0.0 {
            keep(current);
        }
        (previous, previous_height) = (current, height);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(z: f64) -> [DVec3; 4] {
        [DVec3::new(0., 0., z), DVec3::new(1., 0., z), DVec3::new(1., 1., z), DVec3::new(0., 1., z)]
    }

    #[test]
    fn point_below_a_corner_of_a_parallel_unit_square() {
        let f = point_to_polygon(DVec3::ZERO, DVec3::Z, &square(1.0));
        assert!((f - 0.138_531_606_0).abs() < 1e-10, "{f}");
    }

    #[test]
    fn point_facing_a_perpendicular_unit_square() {
        // The square stands on the plane of the point, one edge on that plane, one corner straight ahead at 1.
        let polygon = [DVec3::new(1., 0., 0.), DVec3::new(1., 1., 0.), DVec3::new(1., 1., 1.), DVec3::new(1., 0., 1.)];
        let f = point_to_polygon(DVec3::ZERO, DVec3::Z, &polygon);
        assert!((f - 0.055_734_197_0).abs() < 1e-10, "{f}");
    }

    #[test]
    fn what_lies_below_the_horizon_does_not_count() {
        let tall = [DVec3::new(1., 0., -5.), DVec3::new(1., 1., -5.), DVec3::new(1., 1., 1.), DVec3::new(1., 0., 1.)];
        let f = point_to_polygon(DVec3::ZERO, DVec3::Z, &tall);
        assert!((f - 0.055_734_197_0).abs() < 1e-10, "{f}");
        assert_eq!(point_to_polygon(DVec3::ZERO, -DVec3::Z, &square(1.0)), 0.0);
    }

    #[test]
    fn an_immense_polygon_overhead_fills_the_hemisphere() {
        let s = 1e6;
        let polygon = [DVec3::new(-s, -s, 1.), DVec3::new(s, -s, 1.), DVec3::new(s, s, 1.), DVec3::new(-s, s, 1.)];
        assert!((point_to_polygon(DVec3::ZERO, DVec3::Z, &polygon) - 1.0).abs() < 1e-5);
    }
}
