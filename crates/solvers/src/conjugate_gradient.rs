//! Conjugate gradient on the symmetric form, all bands at once.
//!
//! With `z = sqrt(rho) H` the equation becomes `(A - sqrt(rho) G sqrt(rho)) z = sqrt(rho) (G E + A H0)`, symmetric
//! positive definite for rho < 1 when no row of G sums above A (Hestenes and Stiefel 1952; for radiosity Neumann 1994,
//! *Iterative solution methods*). Preconditioned by A. The iterations share each product; every band has its own step
//! lengths.

use crate::problem::{Problem, SolveOptions, SolveReport};
use radiosity_operator::{Cancelled, Control};

/// Solves for the radiosity of every element and band.
pub fn conjugate_gradient(
    problem: &Problem,
    options: &SolveOptions,
    control: &Control,
) -> Result<(Vec<f64>, SolveReport), Cancelled> {
    let bands = problem.bands;
    let root: Vec<f64> = problem.reflectance.iter().map(|r| r.sqrt()).collect();
    let inverse_area: Vec<f64> = problem.area.iter().map(|&a| if a > 0.0 { 1.0 / a } else { 0.0 }).collect();
    // An element without area takes no part: its row of the right-hand side is zero, and so stays its unknown.
    let takes_part = |k: usize| problem.area_at(k) > 0.0;

    let mut z = vec![0.0; root.len()];
    let mut residual = problem.product(problem.emission);
    for (k, r) in residual.iter_mut().enumerate() {
        *r = if takes_part(k) { root[k] * (*r + problem.area_at(k) * problem.incident[k]) } else { 0.0 };
    }
    let mut direction = vec![0.0; root.len()];
    let mut energy = weighted_norms(&residual, &inverse_area, bands);
    let scale = energy.clone();
    let mut previous: Option<Vec<f64>> = None;
    let mut report = SolveReport::start();
    while !report.note(worst_ratio(&energy, &scale), options, control)? {
        for (k, d) in direction.iter_mut().enumerate() {
            let beta = previous.as_ref().map_or(0.0, |p| ratio(energy[k % bands], p[k % bands]));
            *d = inverse_area[k / bands] * residual[k] + beta * *d;
        }
        let spread: Vec<f64> = direction.iter().zip(&root).map(|(d, r)| d * r).collect();
        let mut image = problem.product(&spread);
        for (k, v) in image.iter_mut().enumerate() {
            *v = if takes_part(k) { problem.area_at(k) * direction[k] - root[k] * *v } else { 0.0 };
        }
        let curvature = dots(&direction, &image, bands);
        for k in 0..z.len() {
            let step = ratio(energy[k % bands], curvature[k % bands]);
            z[k] += step * direction[k];
            residual[k] -= step * image[k];
        }
        let next = weighted_norms(&residual, &inverse_area, bands);
        previous = Some(std::mem::replace(&mut energy, next));
    }
    let radiosity = problem.emission.iter().zip(&root).zip(&z).map(|((e, r), z)| e + r * z).collect();
    Ok((radiosity, report))
}

/// Zero over zero is a band that is already solved.
fn ratio(a: f64, b: f64) -> f64 {
    if b > 0.0 { a / b } else { 0.0 }
}

fn worst_ratio(energy: &[f64], scale: &[f64]) -> f64 {
    energy.iter().zip(scale).map(|(e, s)| ratio(*e, *s).sqrt()).fold(0.0, f64::max)
}

fn dots(a: &[f64], b: &[f64], bands: usize) -> Vec<f64> {
    let mut sums = vec![0.0; bands];
    for (a, b) in a.chunks_exact(bands).zip(b.chunks_exact(bands)) {
        for c in 0..bands {
            sums[c] += a[c] * b[c];
        }
    }
    sums
}

fn weighted_norms(r: &[f64], weight: &[f64], bands: usize) -> Vec<f64> {
    let mut sums = vec![0.0; bands];
    for (r, w) in r.chunks_exact(bands).zip(weight) {
        for c in 0..bands {
            sums[c] += w * r[c] * r[c];
        }
    }
    sums
}
