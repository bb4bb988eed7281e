//! Jacobi iteration: light bounces once more everywhere at a time. The plain solver others are checked against.
//!
//! `B <- E + rho (G B / A + H0)`; converges at the rate of the largest reflectance. The residual is what a bounce
//! changes, in the norm weighted by area, relative to what the first bounce adds. What it adds is also the unshot power.

use crate::problem::{Problem, ratio, worst_ratio};
use crate::report::{SolveOptions, SolveReport, Track};
use radiosity_operator::{Cancelled, Control};

/// Solves for the radiosity of every element and band.
pub fn jacobi(
    problem: &Problem,
    options: &SolveOptions,
    control: &Control,
) -> Result<(Vec<f64>, SolveReport), Cancelled> {
    let emitted: f64 = problem.power(&problem.source()).iter().sum();
    let mut radiosity = problem.emission.to_vec();
    let mut scale: Option<Vec<f64>> = None;
    let mut track = Track::new(options, control);
    loop {
        let next = problem.bounce(&radiosity);
        track.work(1.0);
        let change: Vec<f64> = next.iter().zip(&radiosity).map(|(a, b)| a - b).collect();
        let squares = problem.squares(&change);
        let scale = scale.get_or_insert_with(|| squares.clone());
        let residual = worst_ratio(&squares, scale);
        let unshot = ratio(problem.power(&change).iter().sum(), emitted);
        radiosity = next;
        if track.note(residual, Some(unshot), || (radiosity.clone(), vec![0.0; problem.bands]))? {
            return Ok((radiosity, track.finish(None)));
        }
    }
}
