//! From a request for accuracy to an answer that meets it.
//!
//! ```text
//! sample -> solve on patches -> sweep to elements -> gather per replicate -> estimate the error -> sample more
//! ```
//!
//! 1. **Sample** the exchange: rays from every side, area samples of the lamps, in independent replicates.
//! 2. **Solve** `B = E + rho F B` on whole sides with the symmetric operator (conjugate gradient).
//! 3. **Sweep** twice: every element (a quarter or sixteenth of a side) gathers through its own rays, so that light
//!    which varies within a patch is seen by others as it varies.
//! 4. **Gather** once more for the answer, through each side's own rays, replicate by replicate.
//! 5. **Estimate** the error from the spread of the replicates, carried through the interreflections, and from what
//!    the elements changed. While it is too large, spend rays where they reduce it most.

pub mod adjoint;
pub mod answer;
pub mod energy;
pub mod error;
pub mod given;
pub mod incident;
pub mod lighting;
pub mod linked;
mod mesh_error;
pub mod method;
pub mod on_demand;
pub mod plan;
pub mod report;
pub mod shooting;
pub mod solve;
mod translucency;
pub mod transport;

pub use adjoint::{Gradient, gradients};
pub use energy::Energy;
pub use given::solve_given;
pub use incident::Incident;
pub use lighting::{Lamp, Lighting};
pub use linked::solve_linked;
pub use method::Method;
pub use on_demand::solve_on_demand;
pub use report::{Cause, Limit, Report, SolverReport};
pub use shooting::{Shooting, ShootingSettings, ShotSolution, shoot};
pub use solve::{Closure, Failure, Measurement, Settings, Solution, Source, irradiance_on_sides, relight, solve};
pub use transport::Transport;
