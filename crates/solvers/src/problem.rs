//! What is solved.

use radiosity_operator::{Operator, Rows};

/// One equation per band on one exchange. Blocks are row-major, an element's bands side by side.
///
/// The exchange is an operator, or for a solver that needs no more than rows, a source of them.
pub struct Problem<'a, X: ?Sized = dyn Operator + 'a> {
    /// G, m2.
    pub exchange: &'a X,
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

impl<X: Rows + ?Sized> Problem<'_, X> {
    /// The number of elements.
    pub fn len(&self) -> usize {
        self.exchange.count()
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

    /// The area of the element that entry `k` of a block belongs to.
    pub(crate) fn area_at(&self, k: usize) -> f64 {
        self.area[k / self.bands]
    }

    /// What leaves before any light has gone from element to element: `E + rho H0`, W/m2.
    pub(crate) fn source(&self) -> Vec<f64> {
        let reflected = |k: usize| if self.area_at(k) > 0.0 { self.reflectance[k] * self.incident[k] } else { 0.0 };
        (0..self.emission.len()).map(|k| self.emission[k] + reflected(k)).collect()
    }

    /// Per band the sum over elements of the area times `values`.
    pub(crate) fn power(&self, values: &[f64]) -> Vec<f64> {
        self.sums(values, |v| v)
    }

    /// Per band the sum over elements of the area times the square of `values`.
    pub(crate) fn squares(&self, values: &[f64]) -> Vec<f64> {
        self.sums(values, |v| v * v)
    }

    fn sums(&self, values: &[f64], of: impl Fn(f64) -> f64) -> Vec<f64> {
        let mut sums = vec![0.0; self.bands];
        for (values, area) in values.chunks_exact(self.bands).zip(self.area) {
            sums.iter_mut().zip(values).for_each(|(sum, v)| *sum += area * of(*v));
        }
        sums
    }
}

impl Problem<'_> {
    /// `y = G x` for a block of bands.
    pub(crate) fn product(&self, x: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; x.len()];
        self.exchange.apply(x, &mut y, self.bands);
        y
    }

    /// One bounce: `E + rho (G x / A + H0)`.
    pub(crate) fn bounce(&self, x: &[f64]) -> Vec<f64> {
        let mut next = self.product(x);
        for (k, v) in next.iter_mut().enumerate() {
            let area = self.area_at(k);
            let irradiance = if area > 0.0 { *v / area + self.incident[k] } else { 0.0 };
            *v = self.emission[k] + self.reflectance[k] * irradiance;
        }
        next
    }
}

/// The worst band's norm relative to its scale, from squares of both; zero over zero is a band that is solved.
pub(crate) fn worst_ratio(squares: &[f64], scale: &[f64]) -> f64 {
    squares.iter().zip(scale).map(|(e, s)| ratio(*e, *s).sqrt()).fold(0.0, |a, b| if a > b { a } else { b })
}

/// Nothing out of nothing is nothing.
pub(crate) fn ratio(a: f64, b: f64) -> f64 {
    if b > 0.0 { a / b } else { 0.0 }
}
