//! The one trait that carries the weight: exchanges implement it, solvers consume it.

pub mod conformance;
pub mod control;
pub mod csr;
pub mod dense;
pub mod hierarchical;
pub mod symmetric;

pub use control::{Cancelled, Control};
pub use csr::Csr;
pub use dense::Dense;
pub use hierarchical::{Hierarchical, Part, PartBuilder};
pub use radiosity_store::Numbers;
pub use symmetric::{Block, Precision, Symmetric};

/// A symmetric linear operator on vectors with one entry per element, applied to many columns at once.
///
/// Blocks of vectors are row-major: entry `i` of column `c` is `x[i * columns + c]`, so that the bands of one element
/// share a cache line.
pub trait Operator: Sync {
    /// The number of rows.
    fn len(&self) -> usize;

    /// Whether there are no rows.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Writes the product with the block `x` to `y`. The result does not depend on the number of threads.
    fn apply(&self, x: &[f64], y: &mut [f64], columns: usize);

    /// The row sums.
    fn row_sums(&self) -> Vec<f64> {
        let mut sums = vec![0.0; self.len()];
        self.apply(&vec![1.0; self.len()], &mut sums, 1);
        sums
    }
}
