//! Delta form factors: what each pixel of a hemicube is worth, integrated in closed form.
//!
//! Cohen and Greenberg 1985 take the integrand at the centre of a pixel times its area: `1/(pi (u2 + v2 + 1)2) dA` on
//! the top and `v/(pi (u2 + v2 + 1)2) dA` on a side. Here both are integrated exactly over the pixel, by
//! differences of the form factor of a rectangle with one corner on the axis, so that all pixels together are 1 at
//! any resolution. The point formula is off by a relative `h2/24` times the integrand's relative Laplacian, with h
//! the width of a pixel. At its worst that is `h2/3` on the top, in the middle, and `2 h2/3` on a side, straight ahead
//! on the horizon: 0.0005 % and 0.001 % at a resolution of 512.

use super::Settings;
use std::f64::consts::FRAC_1_PI;

/// The form factors of the pixels of a hemicube of `resolution` pixels along an edge, `resolution` even:
/// `(top, side)`, row by row. The top has `resolution` rows of as many pixels; each of four sides has half as many
/// rows, from the horizon up. `top` and four times `side` sum to 1.
///
/// # Panics
/// If `resolution` is odd or not in 8..=4096.
pub fn delta_form_factors(resolution: usize) -> (Vec<f64>, Vec<f64>) {
    Settings { resolution, ..Settings::default() }.check();
    let strips = Strips::new(resolution);
    let differences = |sums: &[f64]| -> Vec<f64> {
        sums.chunks_exact(resolution + 1).flat_map(|row| row.windows(2).map(|w| w[1] - w[0])).collect()
    };
    (differences(&strips.top), differences(&strips.side))
}

/// Running sums of delta form factors along every row of pixels, so that a run of pixels costs one subtraction.
pub(super) struct Strips {
    /// Rows of `resolution + 1` sums, the first of each 0.
    pub top: Vec<f64>,
    /// As `top`, half as many rows, from the horizon up; the same for four sides.
    pub side: Vec<f64>,
}

impl Strips {
    pub fn new(resolution: usize) -> Self {
        Self {
            top: strips(resolution, resolution, -1.0, top_corner),
            side: strips(resolution, resolution / 2, 0.0, side_corner),
        }
    }

    /// A top that reaches `half_width` to either side at distance 1, and no sides.
    pub fn plane(resolution: usize, half_width: f64) -> Self {
        let corner = |u: f64, v: f64| top_corner(u * half_width, v * half_width);
        Self { top: strips(resolution, resolution, -1.0, corner), side: Vec::new() }
    }
}

/// Running sums of `rows` rows from `lowest` up, by differences of a form factor's value at corners.
fn strips(resolution: usize, rows: usize, lowest: f64, corner: impl Fn(f64, f64) -> f64) -> Vec<f64> {
    let step = 2.0 / resolution as f64;
    let edge = |row: usize| -> Vec<f64> {
        (0..=resolution).map(|k| corner(k as f64 * step - 1.0, lowest + row as f64 * step)).collect()
    };
    let mut low = edge(0);
    let mut sums = Vec::with_capacity(rows * (resolution + 1));
    for row in 1..=rows {
        let high = edge(row);
        let first = high[0] - low[0];
        sums.extend(high.iter().zip(&low).map(|(high, low)| (high - low) - first));
        low = high;
    }
    sums
}

/// The form factor of the rectangle from the axis to `(u, v)` in the plane that faces the source at distance 1, odd in
/// `u` and in `v`: the integral of `1/(pi (1 + u2 + v2)2)`.
pub(super) fn top_corner(u: f64, v: f64) -> f64 {
    let term = |a: f64, b: f64| {
        let c = (1.0 + a * a).sqrt();
        a / c * (b / c).atan()
    };
    0.5 * FRAC_1_PI * (term(u, v) + term(v, u))
}

/// The form factor of the rectangle from the foot of the axis to `(u, v)` in a plane at distance 1 that stands upright
/// on the source's, odd in `u`: the integral of `v/(pi (1 + u2 + v2)2)`.
fn side_corner(u: f64, v: f64) -> f64 {
    let c = (1.0 + v * v).sqrt();
    0.5 * FRAC_1_PI * (u.atan() - (u / c).atan() / c)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_sum_to_one_at_any_resolution() {
        for resolution in [8, 10, 50, 512, 1024] {
            let (top, side) = delta_form_factors(resolution);
            assert_eq!((top.len(), side.len()), (resolution * resolution, resolution * resolution / 2));
            let (top, side): (f64, f64) = (top.iter().sum(), side.iter().sum());
            // The square from -1 to 1 at distance 1: four times `top_corner(1, 1)`, written out.
            let c = std::f64::consts::FRAC_1_SQRT_2;
            assert!((top - 4.0 * FRAC_1_PI * c * c.atan()).abs() < 1e-12, "{resolution}: {top}");
            assert!((top + 4.0 * side - 1.0).abs() < 1e-12, "{resolution}: {}", top + 4.0 * side);
        }
    }

    /// Cohen and Greenberg's value at the centre of each pixel, times its area.
    fn point_formula(resolution: usize) -> (Vec<f64>, Vec<f64>) {
        let h = 2.0 / resolution as f64;
        let at = |k: usize, from: f64| (k as f64 + 0.5) * h + from;
        let value = |u: f64, v: f64| FRAC_1_PI / (u * u + v * v + 1.0).powi(2) * h * h;
        let pixels = |rows: usize| (0..rows * resolution).map(|p| (p % resolution, p / resolution));
        let top = pixels(resolution).map(|(i, j)| value(at(i, -1.0), at(j, -1.0))).collect();
        let side = pixels(resolution / 2).map(|(i, j)| at(j, 0.0) * value(at(i, -1.0), at(j, 0.0))).collect();
        (top, side)
    }

    #[test]
    fn the_point_formula_is_off_by_the_square_of_a_pixel() {
        for resolution in [32, 128, 512] {
            let ((top, side), (top_point, side_point)) = (delta_form_factors(resolution), point_formula(resolution));
            let relative = |exact: &[f64], point: &[f64]| {
                exact.iter().zip(point).map(|(e, p)| (p / e - 1.0).abs()).fold(0.0, f64::max)
            };
            // The relative Laplacian is -8 for 1/(1 + r2)2 in the middle, and -16 for v/(1 + r2)2 at u = v = 0.
            let h = 2.0 / resolution as f64;
            let (top_error, side_error) = (relative(&top, &top_point), relative(&side, &side_point));
            assert!((0.9..1.001).contains(&(top_error / (h * h / 3.0))), "{resolution}: {top_error}");
            assert!((0.9..1.001).contains(&(side_error / (h * h / 1.5))), "{resolution}: {side_error}");
        }
    }
}
