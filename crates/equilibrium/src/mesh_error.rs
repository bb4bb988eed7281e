//! How far the piecewise linear field through the values of patches is from the light on them.
//!
//! Samples remember in which cell of their side they were taken. So for each cell and replicate there is what arrives
//! there, and what the field through the same replicate's patch values says. The mean product of the differences of
//! two replicates is the square of the error of the mesh without bias, because the noise of two replicates is
//! independent; it may come out negative where there is little. What varies within a cell is allowed for by a factor.

use crate::answer::{CELL_LEVEL, CELLS};
use radiosity_exchange::Enclosure;
use radiosity_geometry::corners::{CREASE_ANGLE, corner_weights};
use radiosity_geometry::{Chart, Corners, Patches};
use rayon::prelude::*;

/// The field against the samples, per side.
#[derive(Default)]
pub(crate) struct MeshError {
    /// Mean square over the side of the light less the field, sides x bands. Negative by noise.
    pub square: Vec<f64>,
    /// Variance of that, mean over bands, per side.
    pub noise: Vec<f64>,
    /// Variance of the field by sampling, mean over the side, sides x bands.
    pub variance: Vec<f64>,
    /// As `square`, half of it that of the sides around: less noise side by side.
    pub smooth_square: Vec<f64>,
    /// The variance of that, mean over bands.
    pub smooth_noise: Vec<f64>,
}

/// Four by four cells see about this share of the variation: .70 of a parabola's about its mean, .75 of a step's, all of a
/// slope's that is off and nearly all of a mean's.
const SEEN: f64 = 0.8;

impl MeshError {
    /// `values` are sides x replicates x bands, `by_cell` sides x replicates x [`CELLS`] x bands.
    pub fn of(enclosure: &Enclosure, values: &[f64], by_cell: &[f32], replicates: usize, bands: usize) -> Self {
        let width = replicates * bands;
        let fronts = enclosure.patches();
        let n = fronts.len();
        let backs = backs(enclosure);
        let of_fronts = Corners::new(fronts, CREASE_ANGLE);
        let of_backs = Corners::new(&backs, CREASE_ANGLE);
        let mut corners = of_fronts.field(&values[..n * width], width);
        corners.extend(of_backs.field(&values[n * width..], width));
        let per_side: Vec<(Vec<f64>, f64, Vec<f64>)> = (0..enclosure.sides())
            .into_par_iter()
            .with_min_len(64)
            .map(|side| {
                let corners = &corners[side * 4 * width..][..4 * width];
                let cells = &by_cell[side * width * CELLS..][..width * CELLS];
                let weights = cell_weights(&Chart::new(&fronts.polygons[enclosure.patch_of(side)]));
                compare(corners, cells, &weights, replicates, bands)
            })
            .collect();
        let mut error = Self::default();
        for (square, noise, variance) in per_side {
            error.square.extend(square);
            error.noise.push(noise);
            error.variance.extend(variance);
        }
        error.smooth(&of_fronts, fronts, 0, bands);
        error.smooth(&of_backs, &backs, n, bands);
        error
    }

    /// Forgets sides on which light is not looked at.
    pub fn clear_where(&mut self, bands: usize, is_idle: impl Fn(usize) -> bool) {
        for side in (0..self.noise.len()).filter(|&side| is_idle(side)) {
            self.square[side * bands..][..bands].fill(0.0);
            self.smooth_square[side * bands..][..bands].fill(0.0);
            (self.noise[side], self.smooth_noise[side]) = (0.0, 0.0);
        }
    }

    /// Mixes half of the sides from `first` on with those around them, by area.
    fn smooth(&mut self, corners: &Corners<&Patches>, patches: &Patches, first: usize, bands: usize) {
        for patch in 0..patches.len() {
            let around = || corners.around(patch).filter(|&other| other != patch);
            let area: f64 = around().map(|other| patches.area[other]).sum();
            let own = if area > 0.0 { 0.5 } else { 1.0 };
            let share = |other: usize| 0.5 * patches.area[other] / area;
            let mut square: Vec<f64> =
                self.square[(first + patch) * bands..][..bands].iter().map(|s| own * s).collect();
            let mut noise = own * own * self.noise[first + patch];
            for other in around() {
                let of = &self.square[(first + other) * bands..][..bands];
                square.iter_mut().zip(of).for_each(|(s, o)| *s += share(other) * o);
                // Most come twice.
                noise += 2.0 * share(other).powi(2) * self.noise[first + other];
            }
            self.smooth_square.extend(square);
            self.smooth_noise.push(noise);
        }
    }
}

/// The patches that have backs, in the order of those.
fn backs(enclosure: &Enclosure) -> Patches {
    let fronts = enclosure.patches();
    let of: Vec<usize> = (fronts.len()..enclosure.sides()).map(|side| enclosure.patch_of(side)).collect();
    Patches::new(
        of.iter().map(|&p| fronts.polygons[p]).collect(),
        of.iter().map(|&p| fronts.surface[p]).collect(),
        of.iter().map(|&p| fronts.face[p]).collect(),
        vec![true; of.len()],
    )
}

/// What each corner counts in the mean over each cell: by four points, since triangles are folded along a diagonal.
fn cell_weights(chart: &Chart) -> [[f64; 4]; CELLS] {
    let n = 1 << CELL_LEVEL;
    std::array::from_fn(|cell| {
        let (i, j) = (cell >> CELL_LEVEL, cell & (n - 1));
        let mut mean = [0.0; 4];
        for (x, y) in [(0.25, 0.25), (0.25, 0.75), (0.75, 0.25), (0.75, 0.75)] {
            let weights = corner_weights(chart, (i as f64 + x) / n as f64, (j as f64 + y) / n as f64);
            (0..4).for_each(|k| mean[k] += 0.25 * weights[k]);
        }
        mean
    })
}

/// Square of the error, its variance, and the variance of the field of one side.
fn compare(
    corners: &[f64],
    by_cell: &[f32],
    weights: &[[f64; 4]; CELLS],
    replicates: usize,
    bands: usize,
) -> (Vec<f64>, f64, Vec<f64>) {
    let pairs = (replicates * (replicates - 1)) as f64;
    let (mut square, mut variance, mut noise) = (vec![0.0; bands], vec![0.0; bands], 0.0);
    for (cell, weights) in weights.iter().enumerate() {
        for band in 0..bands {
            let (mut sum, mut squares, mut level, mut levels) = (0.0, 0.0, 0.0, 0.0);
            for r in 0..replicates {
                let column = r * bands + band;
                let field: f64 = (0..4).map(|k| weights[k] * corners[k * replicates * bands + column]).sum();
                let off = f64::from(by_cell[(r * CELLS + cell) * bands + band]) - field;
                (sum, squares) = (sum + off, squares + off * off);
                (level, levels) = (level + field, levels + field * field);
            }
            let n = replicates as f64;
            square[band] += (sum * sum - squares) / pairs / (SEEN * CELLS as f64);
            variance[band] += (levels - level * level / n).max(0.0) / pairs / CELLS as f64;
            // The product of two deviations of variance v has variance v^2, and there are half as many pairs.
            let each = (squares - sum * sum / n).max(0.0) / (n - 1.0);
            noise += 2.0 * each * each / pairs / (SEEN * CELLS as f64).powi(2) / bands as f64;
        }
    }
    (square, noise, variance)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// A strip of `n` squares with the light `h(x)` and no noise.
    fn error_of(n: usize, h: impl Fn(f64) -> f64) -> f64 {
        let p = |i: usize, j: usize| DVec3::new(i as f64 / n as f64, j as f64 / n as f64, 0.0);
        let polygons: Vec<[DVec3; 4]> = (0..n).map(|i| [p(i, 0), p(i + 1, 0), p(i + 1, 1), p(i, 1)]).collect();
        let patches = Patches::new(polygons, vec![0; n], vec![0; n], vec![false; n]);
        let enclosure = Enclosure::new(patches);
        let mean = |a: f64, b: f64| (0..100).map(|k| h(a + (b - a) * (k as f64 + 0.5) / 100.0)).sum::<f64>() / 100.0;
        let at = |i: usize, x: f64| (i as f64 + x) / n as f64;
        let values: Vec<f64> = (0..n).flat_map(|i| [mean(at(i, 0.0), at(i, 1.0)); 2]).collect();
        let cell = |i: usize, c: usize| mean(at(i, (c / 4) as f64 / 4.0), at(i, (c / 4 + 1) as f64 / 4.0)) as f32;
        let by_cell: Vec<f32> =
            (0..n).flat_map(|i| (0..2).flat_map(move |_| (0..16).map(move |c| cell(i, c)))).collect();
        let error = MeshError::of(&enclosure, &values, &by_cell, 2, 1);
        assert!(error.variance.iter().all(|v| v.abs() < 1e-12) && error.noise.iter().all(|v| v.abs() < 1e-12));
        (error.square.iter().sum::<f64>() / n as f64).sqrt()
    }

    #[test]
    fn linear_light_leaves_no_error_and_smooth_light_little() {
        assert!(error_of(4, |x| 1.0 + 2.0 * x) < 1e-6);
        let (coarse, fine) = (error_of(8, |x| (3.0 * x).cos()), error_of(16, |x| (3.0 * x).cos()));
        assert!(coarse / fine > 3.5 && coarse < 0.02, "{coarse} {fine}");
    }

    #[test]
    fn a_step_is_an_error_of_half_its_height_over_its_patch() {
        // The field rises over three patches, of which the step cuts one in the middle.
        let step = error_of(9, |x| if x < 0.5 { 0.0 } else { 1.0 });
        assert!((0.08..0.2).contains(&step), "{step}");
    }
}
