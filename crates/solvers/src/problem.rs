//! What is solved and what a solver says about it.

use radiosity_operator::{Cancelled, Control, Operator};

/// One equation per band on one exchange. Blocks are row-major, an element's bands side by side.
#[derive(Clone, Copy)]
pub struct Problem<'a> {
    /// G, m2.
    pub exchange: &'a dyn Operator,
    /// Area per element, m2; zero for an element that takes no part.
    pub area: &'a [f64],
    /// Diffuse reflectance in [0, 1), elements x bands.
    pub reflectance: &'a [f64],
    /// Radiant exitance, W/m2, elements x bands.
    pub emission: &'a [f64],
    /// Irradiance from outside the matrix, W/m2, elements x bands.
    pub incident: &'a [f64],
    /// The number of bands.
    pub bands: usize,
}

/// A problem no solver can start on.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ProblemError {
    /// An array does not have one value per element and band.
    #[error("{name} has {found} values, {expected} are needed")]
    Length {
        /// Which array.
        name: &'static str,
        /// How long it is.
        found: usize,
        /// How long it should be.
        expected: usize,
    },
    /// A reflectance outside [0, 1).
    #[error("element {element}, band {band}: reflectance {value} is outside [0, 1)")]
    Reflectance {
        /// Which element.
        element: usize,
        /// Which band.
        band: usize,
        /// What it is.
        value: f64,
    },
    /// A value that is not finite.
    #[error("{name} of element {element} is not finite")]
    NotFinite {
        /// Which array.
        name: &'static str,
        /// Which element.
        element: usize,
    },
}

impl Problem<'_> {
    /// The number of elements.
    pub fn len(&self) -> usize {
        self.exchange.len()
    }

    /// Whether there are no elements.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Checks lengths and ranges.
    pub fn validate(&self) -> Result<(), ProblemError> {
        let (n, b) = (self.len(), self.bands);
        let arrays = [
            ("area", self.area, 1),
            ("reflectance", self.reflectance, b),
            ("emission", self.emission, b),
            ("incident", self.incident, b),
        ];
        for (name, values, columns) in arrays {
            if values.len() != n * columns {
                return Err(ProblemError::Length { name, found: values.len(), expected: n * columns });
            }
            if let Some(i) = values.iter().position(|v| !v.is_finite()) {
                return Err(ProblemError::NotFinite { name, element: i / columns });
            }
        }
        match self.reflectance.iter().position(|r| !(0.0..1.0).contains(r)) {
            Some(i) => Err(ProblemError::Reflectance { element: i / b, band: i % b, value: self.reflectance[i] }),
            None => Ok(()),
        }
    }

    /// `y = G x` for a block of bands.
    pub(crate) fn product(&self, x: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; x.len()];
        self.exchange.apply(x, &mut y, self.bands);
        y
    }

    /// The area of the element that entry `k` of a block belongs to.
    pub(crate) fn area_at(&self, k: usize) -> f64 {
        self.area[k / self.bands]
    }
}

/// When to stop.
#[derive(Clone, Copy, Debug)]
pub struct SolveOptions {
    /// Stop when every band's residual, relative to its right-hand side in the norm weighted by 1/area, is below this.
    pub tolerance: f64,
    /// Stop after this many products with the exchange.
    pub max_iterations: usize,
}

impl Default for SolveOptions {
    fn default() -> Self {
        Self { tolerance: 1e-8, max_iterations: 1000 }
    }
}

/// Why a solver stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// The tolerance is met.
    Converged,
    /// The iterations are spent; the answer has not converged.
    MaxIterations,
}

/// How a solve went.
#[derive(Clone, Debug)]
pub struct SolveReport {
    /// Products with the exchange.
    pub iterations: usize,
    /// The worst band's relative residual before each iteration and at the end.
    pub residuals: Vec<f64>,
    /// Why it stopped.
    pub stop: Stop,
}

impl SolveReport {
    pub(crate) fn start() -> Self {
        Self { iterations: 0, residuals: Vec::new(), stop: Stop::MaxIterations }
    }

    /// Notes a residual; true when the solver should stop.
    pub(crate) fn note(&mut self, residual: f64, options: &SolveOptions, control: &Control) -> Result<bool, Cancelled> {
        control.check()?;
        self.residuals.push(residual);
        if residual <= options.tolerance {
            self.stop = Stop::Converged;
            return Ok(true);
        }
        if self.iterations >= options.max_iterations {
            return Ok(true);
        }
        self.iterations += 1;
        Ok(false)
    }
}
