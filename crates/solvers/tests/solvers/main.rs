//! The solvers, on random exchanges.

mod agreement;
mod random;
mod shooting;
