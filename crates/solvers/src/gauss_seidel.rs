//! Gauss-Seidel iteration: elements gather one after the other, each with what those before it have become.
//!
//! Solves each row for its own unknown (for radiosity Cohen and Greenberg 1985). Half the sweeps of Jacobi or fewer, each
//! as much work as a product but one row after the other, on one thread. The residual is what rows were off by when
//! they were visited, relative to the first bounce as with Jacobi. No residual of what is returned is greater: as the
//! exchange has no negative entries, its part to one side of the diagonal has no greater norm than all of it.
//!
//! A symmetric sweep, down and up again, was measured to take three quarters as many sweeps of twice the work.

use crate::problem::{Problem, worst_ratio};
use crate::report::{SolveOptions, SolveReport, Track};
use radiosity_operator::{Cancelled, Control};

/// Solves for the radiosity of every element and band.
pub fn gauss_seidel(
    problem: &Problem,
    options: &SolveOptions,
    control: &Control,
) -> Result<(Vec<f64>, SolveReport), Cancelled> {
    relaxed(problem, &vec![1.0; problem.bands], options, control)
}

/// Sweeps that move every unknown by so many times what its row asks for, a factor in (0, 2) for each band.
pub(crate) fn relaxed(
    problem: &Problem,
    relaxation: &[f64],
    options: &SolveOptions,
    control: &Control,
) -> Result<(Vec<f64>, SolveReport), Cancelled> {
    let bands = problem.bands;
    let state = |radiosity: &[f64]| (radiosity.to_vec(), vec![0.0; bands]);
    let mut track = Track::new(options, control);
    let mut radiosity = problem.bounce(problem.emission);
    track.work(1.0);
    let change: Vec<f64> = radiosity.iter().zip(problem.emission).map(|(a, b)| a - b).collect();
    let scale = problem.squares(&change);
    let mut residual = worst_ratio(&scale, &scale);
    while !track.note(residual, None, || state(&radiosity))? {
        let squares = sweep(problem, relaxation, &mut radiosity);
        track.work(1.0);
        residual = worst_ratio(&squares, &scale);
    }
    Ok((radiosity, track.finish(None)))
}

/// One sweep; per band a bound of the square of the residual that it leaves.
fn sweep(problem: &Problem, relaxation: &[f64], radiosity: &mut [f64]) -> Vec<f64> {
    let bands = problem.bands;
    let mut squares = vec![0.0; bands];
    problem.exchange.sweep(radiosity, bands, &mut |i, sums, b| {
        let area = problem.area[i];
        for c in 0..bands {
            let k = i * bands + c;
            let irradiance = if area > 0.0 { sums[c] / area + problem.incident[k] } else { 0.0 };
            let residual = problem.emission[k] + problem.reflectance[k] * irradiance - b[c];
            b[c] += relaxation[c] * residual;
            squares[c] += area * residual * residual;
        }
    });
    // A row leaves 1 - w of its own residual, and w of those after it.
    squares.iter_mut().zip(relaxation).for_each(|(s, w)| *s *= ((1.0 - w).abs() + w).powi(2));
    squares
}
