//! The form factor from polygon to polygon by Gauss rules on both areas.
//!
//! What it computes: the unoccluded exchange `A1 F12 = integral integral cos cos' / (pi r^2) dA' dA` of two polygons
//! each wholly in front of the other, as a double sum over `n^2` nodes on either (Walton 2002, *Calculation of
//! obstructed view factors by adaptive integration*, NISTIR 6925, "2AI").
//!
//! Error: with eta = (R1 + R2) / d, the sum of the circumscribed radii over the distance of the centres, at most
//! [`CONSTANT`]`[n] eta^(2 n)` of the largest that pairs of such cosines exchange; measured on random pairs by the test
//! below. Useless for polygons that touch.
//!
//! When to choose it: polygons apart by more than about twice their size. Sixteen evaluations a pair at n = 2, four
//! at a time: far cheaper than the contour integral, and without its cancellation at a distance.

use crate::quadrature::PlaneRule;
use glam::DVec3;
use std::f64::consts::FRAC_1_PI;
use std::sync::OnceLock;

/// Orders n on offer, cheapest first.
pub const ORDERS: [usize; 6] = [1, 2, 3, 4, 6, 8];

/// The constant of the error bound of each order.
const CONSTANT: [f64; 6] = [1.5, 0.2, 0.03, 0.005, 0.001, 0.001];

/// Cosines that the middle of a pair shows are trusted down to this share of the largest that the pair may show.
const LEAST_SHARE: f64 = 1.0 / 64.0;

/// The rule of an order.
pub fn rule(order: usize) -> &'static PlaneRule {
    static RULES: OnceLock<Vec<PlaneRule>> = OnceLock::new();
    &RULES.get_or_init(|| ORDERS.iter().map(|&n| PlaneRule::new(n)).collect())[order]
}

/// Which order meets a relative tolerance, by separation and cosines.
#[derive(Clone, Debug)]
pub struct Orders {
    /// `most[order][k]`: the greatest eta^2 where the cosines are at least `2^-k` of what they may be.
    most: [[f64; BUCKETS]; ORDERS.len()],
}

const BUCKETS: usize = 7;

impl Orders {
    /// For an error of `tolerance` relative to the exchange of a pair.
    pub fn new(tolerance: f64) -> Self {
        let mut most = [[0.0; BUCKETS]; ORDERS.len()];
        for (order, row) in most.iter_mut().enumerate() {
            for (k, most) in row.iter_mut().enumerate() {
                let share = 0.5f64.powi(k as i32);
                *most = (tolerance * share / CONSTANT[order]).powf(1.0 / ORDERS[order] as f64).min(0.64);
            }
        }
        Self { most }
    }

    /// The cheapest order for a pair, or none.
    #[inline(always)]
    pub fn choose(&self, pair: &Separation) -> Option<usize> {
        let Separation { distance_squared, radii, heights: (height1, height2), little } = *pair;
        // What the heights may be anywhere on the pair, against what they are in the middle.
        let (most1, most2) = (height1.max(0.0) + radii, height2.max(0.0) + radii);
        let most = most1 * most2;
        let enough = (height1.max(0.0) * height2.max(0.0)).max(little * distance_squared * distance_squared);
        let share = (enough / most).clamp(LEAST_SHARE, 1.0);
        // 1, 1/2, 1/4 ...: the exponent of a float in (0, 1].
        let bucket = (1023 - (share.to_bits() >> 52)) as usize;
        let eta_squared = radii * radii / distance_squared;
        (0..ORDERS.len()).find(|&order| eta_squared <= self.most[order][bucket])
    }
}

/// How two polygons lie, as far as the error of a rule depends on it.
#[derive(Clone, Copy, Debug)]
pub struct Separation {
    /// Of the centres.
    pub distance_squared: f64,
    /// The sum of the radii about them.
    pub radii: f64,
    /// Of the other's centre above the plane of each.
    pub heights: (f64, f64),
    /// An exchange so little that the tolerance is meant relative to it even where there is less, as the product of
    /// cosines over the square of the distance that makes it: zero if there is none.
    pub little: f64,
}

/// The exchange, m2, between two convex polygons by the rule of an order.
pub fn areas(first: &[DVec3], normal1: DVec3, second: &[DVec3], normal2: DVec3, order: usize) -> f64 {
    let rule = rule(order);
    let mut sum = 0.0;
    rule.on(first, |x, w| {
        rule.on(second, |y, v| {
            let r = y - x;
            let r2 = r.length_squared();
            sum += w * v * (normal1.dot(r) * -normal2.dot(r)) / (r2 * r2);
        });
    });
    sum * FRAC_1_PI
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::contour::contour;
    use radiosity_geometry::sampling::Sequence;

    struct Pair {
        first: Vec<DVec3>,
        second: Vec<DVec3>,
        normals: [DVec3; 2],
        r: DVec3,
        radii: f64,
    }

    /// A random triangle or parallelogram about a point.
    fn shape(sequence: &Sequence, index: u32, centre: DVec3) -> (Vec<DVec3>, DVec3, f64) {
        let [a, b, c, d] = sequence.point(2 * index);
        let [e, f, g, _] = sequence.point(2 * index + 1);
        let turn = glam::DQuat::from_euler(glam::EulerRot::XYZ, 6.3 * a, 6.3 * b, 6.3 * c);
        let (x, y) = (turn * DVec3::X, turn * DVec3::Y);
        let (u, v) = ((0.3 + d) * x, (e - 0.5) * x + (0.3 + f) * y);
        let corners = if g < 0.5 {
            vec![-u - v, u - v, u + v, v - u]
        } else {
            vec![-(u + v) / 1.5, (2.0 * u - v) / 1.5, (2.0 * v - u) / 1.5]
        };
        let radius = corners.iter().map(|c| c.length()).fold(0.0, f64::max);
        (corners.iter().map(|c| centre + *c).collect(), turn * DVec3::Z, radius)
    }

    /// Random pairs wholly in front of each other at all separations.
    fn pairs(count: usize) -> Vec<Pair> {
        let (s1, s2) = (Sequence::new(1, 0, 0, 0), Sequence::new(2, 0, 0, 0));
        let mut pairs = Vec::new();
        for index in 0.. {
            let (first, n1, r1) = shape(&s1, index, DVec3::ZERO);
            let [x, y, z, t] = s2.point(3 * index + 60_000);
            let r = DVec3::new(x - 0.5, y - 0.5, z - 0.5).normalize() * (2.0 / (0.05 + 0.95 * t));
            let (second, n2, r2) = shape(&s2, index, r);
            let in_front = |polygon: &[DVec3], o: DVec3, n: DVec3| polygon.iter().all(|p| (*p - o).dot(n) > 0.0);
            if in_front(&second, DVec3::ZERO, n1) && in_front(&first, r, n2) {
                pairs.push(Pair { first, second, normals: [n1, n2], r, radii: r1 + r2 });
                if pairs.len() == count {
                    return pairs;
                }
            }
        }
        unreachable!()
    }

    #[test]
    fn the_error_bound_holds() {
        let mut worst = [0.0f64; ORDERS.len()];
        for pair in pairs(3000) {
            let [n1, n2] = pair.normals;
            let exact = contour(&pair.first, &pair.second, 1e-13);
            let d = pair.r.length();
            let eta = pair.radii / d;
            for (order, &n) in ORDERS.iter().enumerate() {
                let error = (areas(&pair.first, n1, &pair.second, n2, order) - exact).abs();
                let (h1, h2) = (n1.dot(pair.r), -n2.dot(pair.r));
                let share = (h1.max(0.0) * h2.max(0.0) / ((h1 + pair.radii) * (h2 + pair.radii))).max(LEAST_SHARE);
                let bound = eta.powi(2 * n as i32) / share * exact;
                if bound > 1e-12 && eta < 0.8 {
                    worst[order] = worst[order].max(error / bound);
                }
            }
        }
        println!("{worst:?}");
        for order in 0..ORDERS.len() {
            assert!(worst[order] < CONSTANT[order], "order {}: {}", ORDERS[order], worst[order]);
        }
    }

    #[test]
    fn little_exchange_needs_no_exact_rule() {
        let orders = Orders::new(1e-6);
        let grazing = Separation { distance_squared: 100.0, radii: 1.0, heights: (0.01, 0.01), little: 0.0 };
        assert!(orders.choose(&Separation { little: 1e-4, ..grazing }) < orders.choose(&grazing));
    }

    #[test]
    fn the_order_chosen_meets_the_tolerance() {
        for tolerance in [1e-2, 1e-4, 1e-6, 1e-8] {
            let orders = Orders::new(tolerance);
            let mut used = [0; ORDERS.len()];
            for pair in pairs(2000) {
                let [n1, n2] = pair.normals;
                let (h1, h2) = (n1.dot(pair.r), -n2.dot(pair.r));
                let (distance_squared, radii) = (pair.r.length_squared(), pair.radii);
                let separation = Separation { distance_squared, radii, heights: (h1, h2), little: 0.0 };
                let Some(order) = orders.choose(&separation) else { continue };
                used[order] += 1;
                let exact = contour(&pair.first, &pair.second, 1e-13);
                let found = areas(&pair.first, n1, &pair.second, n2, order);
                assert!((found - exact).abs() <= tolerance * exact + 1e-13, "{found} {exact} by {order}");
            }
            assert!(used.iter().sum::<i32>() > 100, "{used:?}");
        }
    }
}
