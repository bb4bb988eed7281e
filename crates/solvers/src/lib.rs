//! Ways to solve the radiosity equation. Sees operators and vectors; knows no triangles.
//!
//! With G the symmetric exchange, A the areas, rho the reflectances, E the emission and H0 the irradiance from
//! lights outside the matrix, radiosity B and irradiance H satisfy `B = E + rho H`, `A H = G B + A H0`.

pub mod conjugate_gradient;
pub mod jacobi;
pub mod problem;

pub use conjugate_gradient::conjugate_gradient;
pub use jacobi::jacobi;
pub use problem::{Problem, ProblemError, SolveOptions, SolveReport, Stop};
