//! Successive over-relaxation: Gauss-Seidel that goes further than each row asks for.
//!
//! Young 1954, *Iterative methods for solving partial difference equations of elliptic type*: where Jacobi reduces the
//! error by mu an iteration, relax by w = 2 / (1 + sqrt(1 - mu^2)). His derivation needs a consistent order, which an
//! exchange has not, yet any w in (0, 2) converges as the form is symmetric and positive definite (Ostrowski 1954). In
//! a closed room mu is about the mean reflectance; that is taken for it, band by band. In closed rooms of reflectance 0.9
//! it takes half as many sweeps as Gauss-Seidel. Where much escapes mu is smaller and w too large, which costs some of
//! the gain.

use crate::gauss_seidel::relaxed;
use crate::problem::{Problem, ratio};
use crate::report::{SolveOptions, SolveReport};
use radiosity_operator::{Cancelled, Control};

/// Solves for the radiosity of every element and band.
pub fn over_relaxation(
    problem: &Problem,
    options: &SolveOptions,
    control: &Control,
) -> Result<(Vec<f64>, SolveReport), Cancelled> {
    let whole: f64 = problem.area.iter().sum();
    let factor = |reflected: &f64| {
        let mean = ratio(*reflected, whole);
        2.0 / (1.0 + (1.0 - mean * mean).sqrt())
    };
    let relaxation: Vec<f64> = problem.power(problem.reflectance).iter().map(factor).collect();
    relaxed(problem, &relaxation, options, control)
}
