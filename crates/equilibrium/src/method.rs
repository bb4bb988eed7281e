//! Which solver is used, by name.

use crate::answer::Solver;
use crate::solve::MOST_ITERATIONS;
use radiosity_solvers::{Overshoot, conjugate_gradient, gauss_seidel, jacobi, over_relaxation, southwell};

/// A solver of the crate `radiosity-solvers`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Fewest products that run on all threads.
    ConjugateGradient,
    /// Plainest.
    Jacobi,
    /// Half the sweeps of Jacobi.
    GaussSeidel,
    /// Fewer sweeps still.
    OverRelaxation,
    /// Progressive refinement: from the element with most unshot power, row by row.
    Southwell,
    /// The same, shooting more than there is for what will still arrive.
    Overshooting,
}

impl Method {
    /// All of them.
    pub const ALL: [Method; 6] = [
        Method::ConjugateGradient,
        Method::Jacobi,
        Method::GaussSeidel,
        Method::OverRelaxation,
        Method::Southwell,
        Method::Overshooting,
    ];

    /// What users call it.
    pub fn name(self) -> &'static str {
        match self {
            Method::ConjugateGradient => "conjugate_gradient",
            Method::Jacobi => "jacobi",
            Method::GaussSeidel => "gauss_seidel",
            Method::OverRelaxation => "over_relaxation",
            Method::Southwell => "southwell",
            Method::Overshooting => "overshooting",
        }
    }

    /// The one of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|m| m.name() == name)
    }

    /// How a method that shoots does it; none for methods that need products.
    pub fn overshoot(self) -> Option<Overshoot> {
        match self {
            Method::Southwell => Some(Overshoot::None),
            Method::Overshooting => Some(Overshoot::Ambient),
            _ => None,
        }
    }

    pub(crate) fn solver(self) -> Solver {
        match self {
            Method::ConjugateGradient => conjugate_gradient,
            Method::Jacobi => jacobi,
            Method::GaussSeidel => gauss_seidel,
            Method::OverRelaxation => over_relaxation,
            Method::Southwell => |p, o, c| southwell(p, Overshoot::None, o, c),
            Method::Overshooting => |p, o, c| southwell(p, Overshoot::Ambient, o, c),
        }
    }

    /// Far more than it needs on so many elements.
    pub(crate) fn most_iterations(self, elements: usize) -> usize {
        match self.overshoot() {
            None => MOST_ITERATIONS,
            Some(_) => MOST_ITERATIONS.saturating_mul(elements),
        }
    }
}
