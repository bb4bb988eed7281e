//! Conjugate gradient on the symmetric form, all bands at once.
//!
//! With `z = sqrt(rho) H` the equation becomes `(A - sqrt(rho) G sqrt(rho)) z = sqrt(rho) (G E + A H0)`, symmetric
//! positive definite for rho < 1 when no row of G sums above A (Hestenes and Stiefel 1952; for radiosity Neumann 1994,
//! *Iterative solution methods*). Preconditioned by A. The iterations share each product; every band has its own step
//! lengths. The residual is that of the symmetric form in the norm weighted by 1/area, relative to its right-hand side:
//! in that norm the first bounce.
//!
//! What was measured and left out: the diagonal is A already, as no plane sees itself, and A (1 - rho^2 sum_j F_ij^2)
//! takes no fewer iterations; symmetric Gauss-Seidel as preconditioner halves them at two more sweeps each, on one
//! thread; a coarse space of one vector saves one or two.

use crate::problem::{Problem, ratio, worst_ratio};
use crate::report::{SolveOptions, SolveReport, Track};
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
    let radiosity = |z: &[f64]| problem.emission.iter().zip(&root).zip(z).map(|((e, r), z)| e + r * z).collect();
    let mut track = Track::new(options, control);
    track.work(1.0);
    while !track.note(worst_ratio(&energy, &scale), None, || (radiosity(&z), vec![0.0; bands]))? {
        for (k, d) in direction.iter_mut().enumerate() {
            let beta = previous.as_ref().map_or(0.0, |p| ratio(energy[k % bands], p[k % bands]));
            *d = inverse_area[k / bands] * residual[k] + beta * *d;
        }
        let spread: Vec<f64> = direction.iter().zip(&root).map(|(d, r)| d * r).collect();
        let mut image = problem.product(&spread);
        for (k, v) in image.iter_mut().enumerate() {
            *v = if takes_part(k) { problem.area_at(k) * direction[k] - root[k] * *v } else { 0.0 };
        }
        track.work(1.0);
        let curvature = dots(&direction, &image, bands);
        let unsolved = |c: usize| ratio(energy[c], scale[c]).sqrt() > options.tolerance;
        if (0..bands).any(|c| unsolved(c) && (curvature[c] <= 0.0 || curvature[c].is_nan())) {
            return Ok((radiosity(&z), track.diverged()));
        }
        for k in 0..z.len() {
            let step = ratio(energy[k % bands], curvature[k % bands]);
            z[k] += step * direction[k];
            residual[k] -= step * image[k];
        }
        let next = weighted_norms(&residual, &inverse_area, bands);
        previous = Some(std::mem::replace(&mut energy, next));
    }
    Ok((radiosity(&z), track.finish(None)))
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
