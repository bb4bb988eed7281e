//! Ways to solve the radiosity equation. Sees operators and vectors; knows no triangles.
//!
//! With G the symmetric exchange, A the areas, rho the reflectances, E the emission and H0 the irradiance from
//! lights outside the matrix, radiosity B and irradiance H satisfy `B = E + rho H`, `A H = G B + A H0`.

pub mod conjugate_gradient;
pub mod gauss_seidel;
pub mod jacobi;
pub mod over_relaxation;
pub mod problem;
pub mod report;
pub mod southwell;

pub use conjugate_gradient::conjugate_gradient;
pub use gauss_seidel::gauss_seidel;
pub use jacobi::jacobi;
pub use over_relaxation::over_relaxation;
pub use problem::{Problem, ProblemError};
pub use report::{Flow, History, Ledger, Observer, Snapshot, SolveOptions, SolveReport, Stop};
pub use southwell::{Light, Overshoot, shoot, southwell};
