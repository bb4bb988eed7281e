//! The form factor from polygon to polygon by a double contour integral.
//!
//! What it computes: the unoccluded exchange between two planar polygons each of which lies in front of the other's
//! plane. Stokes's theorem, twice, turns the integral over both areas into one along both outlines
//! (Sparrow 1963, *A new and simpler formulation for radiative angle factors*, eq. 10):
//!
//! `A1 F12 = 1/(2 pi) sum_edges sum_edges' (u . u') integral integral ln r dt' dt`
//!
//! The inner integral is closed. So is the outer one between parallel edges, and perpendicular edges do not count:
//! polygons whose edges are all parallel or perpendicular, such as the rectangles of Howell's C-11 to C-14, cost no
//! quadrature. For others the outer integral is one Gauss rule where the edges are well apart, and bisected adaptively
//! where they come near, touch or coincide. A fixed rule fails there: Zatz (1993, *Galerkin radiosity*) finds 33 %
//! on touching squares; the integrand is as weakly singular as `s ln s`, which bisection meets.
//!
//! Error: the tolerance given. What cancels between edges costs about `1e-16 (r / L)^2` of the result beside rounding,
//! so polygons of size L very far apart are better served by [`super::areas`].
//!
//! When to choose it: near and touching polygons, to any accuracy.

use crate::quadrature::{Rule, adaptive, gauss};
use glam::DVec3;
use std::f64::consts::PI;
use std::sync::OnceLock;

/// The exchange `A1 F12`, m2, between polygons of any shape that are wholly in front of each other, without anything
/// between them, to within about `tolerance` m2.
///
/// Corners are in counter-clockwise order seen from the front.
pub fn contour(first: &[DVec3], second: &[DVec3], tolerance: f64) -> f64 {
    // Logarithms of lengths near 1 cancel least: a common factor of all lengths adds nothing around closed outlines.
    let unit = scale(first, second);
    let per_pair = 2.0 * PI * tolerance / ((first.len() * second.len()) as f64 * unit * unit);
    let mut sum = 0.0;
    for edge in edges(first, unit) {
        for other in edges(second, unit) {
            sum += edge_pair(&edge, &other, per_pair);
        }
    }
    sum * unit * unit / (2.0 * PI)
}

/// Whether all edges of two polygons are parallel or perpendicular to each other, so that no quadrature is needed.
pub fn is_closed_form(first: &[DVec3], second: &[DVec3]) -> bool {
    edges(first, 1.0).all(|e| {
        edges(second, 1.0).all(|f| {
            let cosine = e.direction.dot(f.direction).abs();
            cosine < PARALLEL || e.direction.cross(f.direction).length() < PARALLEL
        })
    })
}

/// Sines and cosines below this are zero: it is what coordinates rounded to double precision leave.
const PARALLEL: f64 = 1e-12;

/// One edge: where it starts, its unit direction, its length, in units of the pair's size.
#[derive(Clone, Copy)]
struct Edge {
    start: DVec3,
    direction: DVec3,
    length: f64,
}

/// The distance across both polygons, roughly.
fn scale(first: &[DVec3], second: &[DVec3]) -> f64 {
    let origin = first[0];
    let reach = first.iter().chain(second).map(|p| p.distance_squared(origin)).fold(0.0, f64::max);
    reach.sqrt().max(f64::MIN_POSITIVE)
}

fn edges(polygon: &[DVec3], unit: f64) -> impl Iterator<Item = Edge> + '_ {
    (0..polygon.len()).filter_map(move |k| {
        let (a, b) = (polygon[k], polygon[if k + 1 == polygon.len() { 0 } else { k + 1 }]);
        let length = a.distance(b);
        (length > 0.0).then(|| Edge { start: a / unit, direction: (b - a) / length, length: length / unit })
    })
}

/// `(u . u')` times the integral of ln r along both edges.
fn edge_pair(edge: &Edge, other: &Edge, tolerance: f64) -> f64 {
    let cosine = edge.direction.dot(other.direction);
    if cosine.abs() < PARALLEL {
        return 0.0;
    }
    if edge.direction.cross(other.direction).length() < PARALLEL {
        return cosine * parallel(edge, other);
    }
    let tolerance = tolerance / cosine.abs();
    let mut inner = |s: f64| log_distance(edge.start + s * edge.direction, other);
    let Some(points) = enough_points(edge, other, tolerance) else {
        return cosine * adaptive(0.0, edge.length, tolerance, &mut inner);
    };
    let rule = rule(points);
    let sum: f64 = rule.nodes.iter().zip(&rule.weights).map(|(x, w)| w * inner(x * edge.length)).sum();
    cosine * edge.length * sum
}

/// The most points of a plain Gauss rule; beyond, bisection.
const MOST_POINTS: usize = 16;

fn rule(points: usize) -> &'static Rule {
    static RULES: OnceLock<Vec<Rule>> = OnceLock::new();
    &RULES.get_or_init(|| (1..=MOST_POINTS).map(|n| gauss(n, 0)).collect())[points - 1]
}

/// How many Gauss points along the first edge meet the tolerance; none if the edges are too near.
///
/// The inner integral is analytic within the ellipse about the edge that keeps off the other edge: n points err by
/// about `rho^(-2 n)` where rho is the sum of its half axes (Trefethen 2008, *Is Gauss quadrature better than
/// Clenshaw-Curtis?*, theorem 4.5).
fn enough_points(edge: &Edge, other: &Edge, tolerance: f64) -> Option<usize> {
    let half = 0.5 * edge.length;
    let x = segment_distance(edge, other) / half;
    if x < 0.1 {
        return None;
    }
    let rho = x + (x * x + 1.0).sqrt();
    let magnitude = 4.0 * edge.length * other.length;
    let points = ((magnitude / tolerance).ln() / (2.0 * rho.ln())).ceil().max(1.0);
    (points <= MOST_POINTS as f64).then_some(points as usize)
}

/// The least distance of two segments (Ericson 2005, *Real-Time Collision Detection*, 5.1.9).
fn segment_distance(first: &Edge, second: &Edge) -> f64 {
    let r = first.start - second.start;
    let b = first.direction.dot(second.direction);
    let (c, f) = (first.direction.dot(r), second.direction.dot(r));
    let sine_squared = (1.0 - b * b).max(0.0);
    let mut s = if sine_squared > 1e-14 { ((b * f - c) / sine_squared).clamp(0.0, first.length) } else { 0.0 };
    let t = (b * s + f).clamp(0.0, second.length);
    s = (b * t - c).clamp(0.0, first.length);
    (r + s * first.direction - t * second.direction).length()
}

/// The integral of ln r from a point along an edge: elementary.
fn log_distance(point: DVec3, edge: &Edge) -> f64 {
    let r = edge.start - point;
    let a = r.dot(edge.direction);
    let b = a + edge.length;
    let height = r.cross(edge.direction).length();
    let h2 = height * height;
    let half_log = |t: f64| {
        let d = t * t + h2;
        if d > 0.0 { 0.5 * t * d.ln() } else { 0.0 }
    };
    // The two arcus tangents as one angle, which is exact also where each is near a right angle.
    half_log(b) - half_log(a) - edge.length + height * (height * edge.length).atan2(h2 + a * b)
}

/// The integral of ln r along two parallel edges: elementary.
fn parallel(edge: &Edge, other: &Edge) -> f64 {
    let r = other.start - edge.start;
    let along = r.dot(edge.direction);
    let height = r.cross(edge.direction).length();
    let far = along + other.length * edge.direction.dot(other.direction).signum();
    let (low, high) = (along.min(far), along.max(far));
    let p = |t: f64| twice_integrated_log(t, height);
    p(high) - p(low) - p(high - edge.length) + p(low - edge.length)
}

/// A function of t whose second derivative is `ln sqrt(t^2 + h^2)`.
fn twice_integrated_log(t: f64, h: f64) -> f64 {
    let (t2, h2) = (t * t, h * h);
    let d = t2 + h2;
    if d == 0.0 {
        return 0.0;
    }
    0.25 * (t2 - h2) * d.ln() - 0.75 * t2 + h * t * t.atan2(h)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn p(x: f64, y: f64, z: f64) -> DVec3 {
        DVec3::new(x, y, z)
    }

    /// A unit square that faces up, and one at height 1 that faces down.
    fn facing() -> ([DVec3; 4], [DVec3; 4]) {
        (
            [p(0., 0., 0.), p(1., 0., 0.), p(1., 1., 0.), p(0., 1., 0.)],
            [p(0., 0., 1.), p(0., 1., 1.), p(1., 1., 1.), p(1., 0., 1.)],
        )
    }

    fn turned(polygon: &[DVec3]) -> Vec<DVec3> {
        let turn = glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.4, 1.1, -0.7);
        polygon.iter().map(|&x| 3.0 * (turn * x) + p(5., -2., 1.)).collect()
    }

    #[test]
    fn facing_squares() {
        let (a, b) = facing();
        assert!((contour(&a, &b, 1e-12) - 0.199_824_895_698_387_46).abs() < 1e-14);
        assert!(is_closed_form(&a, &b));
    }

    #[test]
    fn squares_that_share_an_edge() {
        let (a, _) = facing();
        let b = [p(0., 0., 0.), p(0., 1., 0.), p(0., 1., 1.), p(0., 0., 1.)];
        assert!((contour(&a, &b, 1e-12) - 0.200_043_776_075_403_16).abs() < 1e-14);
    }

    #[test]
    fn a_square_cut_in_triangles_sees_as_much() {
        // The diagonals are neither parallel nor perpendicular to anything: this is the adaptive path, touching edges,
        // touching corners and all.
        let (a, facing) = facing();
        let touching = [p(0., 0., 0.), p(0., 1., 0.), p(0., 1., 1.), p(0., 0., 1.)];
        for (b, exact) in [(facing, 0.199_824_895_698_387_46), (touching, 0.200_043_776_075_403_16)] {
            let (a, b) = (turned(&a), turned(&b));
            let mut sum = 0.0;
            for k in 0..2 {
                for l in 0..2 {
                    sum += contour(&[a[0], a[k + 1], a[k + 2]], &[b[0], b[l + 1], b[l + 2]], 1e-11);
                }
            }
            assert!((sum / 9.0 - exact).abs() < 1e-11, "{sum} {exact}");
        }
    }

    #[test]
    fn wedges_of_strips() {
        // Long strips at an angle approach 1 - sin(angle / 2) (Howell C-3) from below.
        let angle = std::f64::consts::FRAC_PI_3;
        let l = 1e4;
        let a = [p(0., 0., 0.), p(1., 0., 0.), p(1., l, 0.), p(0., l, 0.)];
        let (c, s) = (angle.cos(), angle.sin());
        let b = [p(0., 0., 0.), p(0., l, 0.), p(c, l, s), p(c, 0., s)];
        let f = contour(&a, &b, 1e-8) / l;
        assert!((f - 0.5).abs() < 2e-4 && f < 0.5, "{f}");
    }

    #[test]
    fn polygons_with_any_number_of_corners() {
        // A regular polygon of many corners is nearly a disk: coaxial disks r1 = r2 = h = 1 (Howell C-41).
        let n = 400;
        let ring = |z: f64, turn: f64| -> Vec<DVec3> {
            let angle = |k: usize| turn * 2.0 * PI * k as f64 / n as f64;
            (0..n).map(|k| p(angle(k).cos(), angle(k).sin(), z)).collect()
        };
        let f = contour(&ring(0.0, 1.0), &ring(1.0, -1.0), 1e-9) / PI;
        assert!((f - 0.381_966_011_3).abs() < 1e-4, "{f}");
    }

    #[test]
    fn edges_may_coincide_in_part() {
        // A wall whose foot covers the middle third of the floor's edge only.
        let floor = [p(0., 0., 0.), p(3., 0., 0.), p(3., 2., 0.), p(0., 2., 0.)];
        let wall = |x0: f64, x1: f64| [p(x0, 0., 0.), p(x0, 0., 1.), p(x1, 0., 1.), p(x1, 0., 0.)];
        let all = contour(&floor, &wall(0., 3.), 1e-12);
        let parts = contour(&floor, &wall(0., 1.), 1e-12)
            + contour(&floor, &wall(1., 2.), 1e-12)
            + contour(&floor, &wall(2., 3.), 1e-12);
        assert!((all - parts).abs() < 1e-13, "{all} {parts}");
        assert!(all > 0.0);
    }
}
