//! Jacobi iteration: light bounces once more everywhere at a time. The plain solver others are checked against.
//!
//! `B <- E + rho (G B / A + H0)`; converges at the rate of the largest reflectance.

use crate::problem::{Problem, SolveOptions, SolveReport};
use radiosity_operator::{Cancelled, Control};

/// Solves for the radiosity of every element and band.
pub fn jacobi(
    problem: &Problem,
    options: &SolveOptions,
    control: &Control,
) -> Result<(Vec<f64>, SolveReport), Cancelled> {
    let bands = problem.bands;
    let mut radiosity = problem.emission.to_vec();
    let mut scale: Option<Vec<f64>> = None;
    let mut report = SolveReport::start();
    loop {
        let arriving = problem.product(&radiosity);
        let next: Vec<f64> = (0..radiosity.len())
            .map(|k| {
                let area = problem.area_at(k);
                let irradiance = if area > 0.0 { arriving[k] / area + problem.incident[k] } else { 0.0 };
                problem.emission[k] + problem.reflectance[k] * irradiance
            })
            .collect();
        let change = norms(&next, &radiosity, problem.area, bands);
        // The first change is what the first bounce adds: the right-hand side that residuals are relative to.
        let scale = scale.get_or_insert_with(|| change.clone());
        let worst = change.iter().zip(scale.iter()).map(|(c, s)| if *s > 0.0 { (c / s).sqrt() } else { 0.0 });
        let residual = worst.fold(0.0, f64::max);
        radiosity = next;
        if report.note(residual, options, control)? {
            return Ok((radiosity, report));
        }
    }
}

fn norms(a: &[f64], b: &[f64], area: &[f64], bands: usize) -> Vec<f64> {
    let mut sums = vec![0.0; bands];
    for (k, (a, b)) in a.iter().zip(b).enumerate() {
        sums[k % bands] += area[k / bands] * (a - b) * (a - b);
    }
    sums
}
