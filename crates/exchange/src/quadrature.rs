//! Rules for integrals over intervals and polygons.

use glam::DVec3;

/// A one-dimensional rule on [0, 1]: nodes with weights that sum to 1.
#[derive(Clone, Debug)]
pub struct Rule {
    /// Where.
    pub nodes: Vec<f64>,
    /// How much each counts.
    pub weights: Vec<f64>,
}

/// Legendre and Jacobi polynomials of every order by the three-term recurrence, by weight `(1 - x)^alpha`.
///
/// Returns the polynomial and its derivative at `x`. Abramowitz and Stegun 1964, 22.7.1 and 22.8.1, with beta = 0.
fn jacobi(n: usize, alpha: f64, x: f64) -> (f64, f64) {
    let (mut before, mut p) = (1.0, 0.5 * (alpha + (alpha + 2.0) * x));
    if n == 0 {
        return (1.0, 0.0);
    }
    for k in 1..n {
        let k = k as f64;
        let c = 2.0 * k + alpha;
        let a = 2.0 * (k + 1.0) * (k + 1.0 + alpha) * c;
        let b = (c + 1.0) * (alpha * alpha + x * (c + 2.0) * c);
        let d = 2.0 * (k + alpha) * k * (c + 2.0);
        (before, p) = (p, (b * p - d * before) / a);
    }
    let m = n as f64;
    let c = 2.0 * m + alpha;
    let slope = (m * (alpha - c * x) * p + 2.0 * (m + alpha) * m * before) / (c * (1.0 - x * x));
    (p, slope)
}

/// The Gauss rule of `n` nodes for the weight `(1 - x)^alpha` on [0, 1], alpha 0 (Legendre) or 1: exact for
/// polynomials of degree `2 n - 1` times the weight.
pub fn gauss(n: usize, alpha: u32) -> Rule {
    let a = f64::from(alpha);
    let (mut nodes, mut weights) = (vec![0.0; n], vec![0.0; n]);
    for k in 0..n {
        // The guess of Stroud and Secrest for Legendre serves for alpha = 1 too: deflation keeps roots apart.
        let mut x = -(std::f64::consts::PI * (k as f64 + 0.75) / (n as f64 + 0.5 * (1.0 + a))).cos();
        for _ in 0..100 {
            let (p, slope) = jacobi(n, a, x);
            let crowd: f64 = nodes[..k].iter().map(|y| 1.0 / (x - (2.0 * y - 1.0))).sum();
            let step = p / (slope - p * crowd);
            x -= step;
            if step.abs() < 1e-15 {
                break;
            }
        }
        let (_, slope) = jacobi(n, a, x);
        nodes[k] = 0.5 * (x + 1.0);
        weights[k] = 1.0 / ((1.0 - x * x) * slope * slope);
    }
    // The constant in front follows from the sum: the weights add up to the integral of the weight, here made 1.
    let sum: f64 = weights.iter().sum();
    weights.iter_mut().for_each(|w| *w /= sum);
    Rule { nodes, weights }
}

/// A rule on the unit square and, folded, on a triangle: `(u, v, weight)` with weights that sum to 1.
#[derive(Clone, Debug)]
pub struct PlaneRule {
    /// Of the unit square, for convex quadrilaterals by the bilinear map.
    pub square: Vec<(f64, f64, f64)>,
    /// Barycentric coordinates of the second and third corner: the conical product rule (Stroud 1971).
    pub triangle: Vec<(f64, f64, f64)>,
}

impl PlaneRule {
    /// `n * n` nodes, exact to degree `2 n - 1`.
    pub fn new(n: usize) -> Self {
        let (legendre, conical) = (gauss(n, 0), gauss(n, 1));
        let (mut square, mut triangle) = (Vec::with_capacity(n * n), Vec::with_capacity(n * n));
        for (u, wu) in legendre.nodes.iter().zip(&legendre.weights) {
            for (v, wv) in legendre.nodes.iter().zip(&legendre.weights) {
                square.push((*u, *v, wu * wv));
            }
            for (v, wv) in conical.nodes.iter().zip(&conical.weights) {
                triangle.push((u * (1.0 - v), *v, wu * wv));
            }
        }
        Self { square, triangle }
    }

    /// Calls `visit(point, area)` at the nodes of a convex polygon: the areas sum to the polygon's.
    ///
    /// Triangles and quadrilaterals take `n * n` nodes, more corners a fan of triangles.
    pub fn on(&self, polygon: &[DVec3], mut visit: impl FnMut(DVec3, f64)) {
        match polygon {
            [a, b, c, d] => self.on_quad([*a, *b, *c, *d], visit),
            [a, rest @ ..] => {
                for pair in rest.windows(2) {
                    self.on_triangle([*a, pair[0], pair[1]], &mut visit);
                }
            }
            [] => {}
        }
    }

    fn on_triangle(&self, [a, b, c]: [DVec3; 3], visit: &mut impl FnMut(DVec3, f64)) {
        let (e1, e2) = (b - a, c - a);
        let area = 0.5 * e1.cross(e2).length();
        for &(u, v, w) in &self.triangle {
            visit(a + u * e1 + v * e2, w * area);
        }
    }

    fn on_quad(&self, [a, b, c, d]: [DVec3; 4], mut visit: impl FnMut(DVec3, f64)) {
        let (e1, e2, twist) = (b - a, d - a, a - b + c - d);
        for &(u, v, w) in &self.square {
            let area = (e1 + v * twist).cross(e2 + u * twist).length();
            visit(a + u * e1 + v * e2 + u * v * twist, w * area);
        }
    }
}

/// Gauss and Kronrod nodes and weights on [-1, 1] (Kronrod 1965; QUADPACK 1983, qk15): positive nodes, then zero.
const KRONROD: [(f64, f64, f64); 8] = [
    (0.991_455_371_120_812_6, 0.022_935_322_010_529_224, 0.0),
    (0.949_107_912_342_758_5, 0.063_092_092_629_978_55, 0.129_484_966_168_869_7),
    (0.864_864_423_359_769_1, 0.104_790_010_322_250_18, 0.0),
    (0.741_531_185_599_394_4, 0.140_653_259_715_525_92, 0.279_705_391_489_276_67),
    (0.586_087_235_467_691_1, 0.169_004_726_639_267_9, 0.0),
    (0.405_845_151_377_397_2, 0.190_350_578_064_785_4, 0.381_830_050_505_118_9),
    (0.207_784_955_007_898_47, 0.204_432_940_075_298_9, 0.0),
    (0.0, 0.209_482_141_084_727_83, 0.417_959_183_673_469_4),
];

/// The integral of `f` over [a, b] by bisection until 7 Gauss and 15 Kronrod points agree to `tolerance`.
///
/// Singularities as weak as `s ln s` at the ends or inside cost some twenty bisections.
pub fn adaptive(a: f64, b: f64, tolerance: f64, f: &mut impl FnMut(f64) -> f64) -> f64 {
    bisect(a, b, tolerance, 48, f)
}

fn bisect(a: f64, b: f64, tolerance: f64, depth: u32, f: &mut impl FnMut(f64) -> f64) -> f64 {
    let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
    let (mut fine, mut coarse) = (0.0, 0.0);
    for (x, kronrod, gauss) in KRONROD {
        let value = if x == 0.0 { f(middle) } else { f(middle - half * x) + f(middle + half * x) };
        fine += kronrod * value;
        coarse += gauss * value;
    }
    if (fine - coarse).abs() * half.abs() <= tolerance || depth == 0 {
        return fine * half;
    }
    // What is asked of the whole is not asked of each half again: where a singularity is, one of them is all but done.
    bisect(a, middle, 0.7 * tolerance, depth - 1, f) + bisect(middle, b, 0.7 * tolerance, depth - 1, f)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gauss_is_exact_to_its_degree() {
        for n in 1..=12 {
            for alpha in 0..=1 {
                let rule = gauss(n, alpha);
                for degree in 0..2 * n {
                    let d = degree as f64;
                    // The mean of x^d by the weight (1 - x)^alpha on [0, 1].
                    let exact = if alpha == 0 { 1.0 / (d + 1.0) } else { 2.0 / ((d + 1.0) * (d + 2.0)) };
                    let sum: f64 = rule.nodes.iter().zip(&rule.weights).map(|(x, w)| w * x.powi(degree as i32)).sum();
                    assert!((sum - exact).abs() < 1e-14, "{n} {alpha} {degree}: {sum} {exact}");
                }
            }
        }
    }

    #[test]
    fn plane_rules_integrate_polynomials() {
        let rule = PlaneRule::new(3);
        let p = |x: f64, y: f64| DVec3::new(x, y, 0.0);
        let integral = |polygon: &[DVec3]| {
            let (mut area, mut fifth) = (0.0, 0.0);
            rule.on(polygon, |x, w| {
                area += w;
                fifth += w * x.x.powi(3) * x.y.powi(2);
            });
            (area, fifth)
        };
        // x^3 y^2 over the unit triangle: 3! 2! / 7!; over the unit square: 1 / 12.
        let (area, fifth) = integral(&[p(0., 0.), p(1., 0.), p(0., 1.)]);
        assert!((area - 0.5).abs() < 1e-15 && (fifth - 12.0 / 5040.0).abs() < 1e-16);
        let (area, fifth) = integral(&[p(0., 0.), p(1., 0.), p(1., 1.), p(0., 1.)]);
        assert!((area - 1.0).abs() < 1e-15 && (fifth - 1.0 / 12.0).abs() < 1e-15);
        let (area, _) = integral(&[p(0., 0.), p(2., 0.), p(3., 1.), p(1., 2.), p(0., 1.)]);
        assert!((area - 4.0).abs() < 1e-14, "{area}");
    }

    #[test]
    fn weak_singularities_are_met() {
        let integral = adaptive(0.0, 1.0, 1e-13, &mut |s| if s > 0.0 { s * s.ln() } else { 0.0 });
        assert!((integral + 0.25).abs() < 1e-13, "{integral}");
        let inside = adaptive(0.0, 1.0, 1e-13, &mut |s: f64| (s - 0.3).abs());
        assert!((inside - (0.045 + 0.245)).abs() < 1e-12, "{inside}");
    }
}
