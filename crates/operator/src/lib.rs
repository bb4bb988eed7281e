//! The one trait that carries the weight: exchanges implement it, solvers consume it.

pub mod conformance;
pub mod control;
pub mod csr;
pub mod dense;
pub mod hierarchical;
pub mod rows;
pub mod sweep;
pub mod symmetric;

pub use control::{Cancelled, Control};
pub use csr::Csr;
pub use dense::Dense;
pub use hierarchical::{Hierarchical, Part, PartBuilder};
pub use radiosity_store::Numbers;
pub use rows::Rows;
pub use sweep::Update;
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

    /// Replaces `row` by the entries `(column, value)` of row `i`, each column once; zeros may be left out.
    ///
    /// By a product with a unit vector, which is also a column, where an operator knows nothing better.
    fn read_row(&self, i: usize, row: &mut Vec<(u32, f64)>) {
        let (mut unit, mut image) = (vec![0.0; self.len()], vec![0.0; self.len()]);
        unit[i] = 1.0;
        self.apply(&unit, &mut image, 1);
        row.clear();
        row.extend(image.iter().enumerate().filter(|(_, v)| **v != 0.0).map(|(j, v)| (j as u32, *v)));
    }

    /// Says that many rows will be read one by one: an operator that finds rows slowly may spend memory on them now.
    fn expect_rows(&self) {}

    /// Visits every row once, in an order of the operator's own: `update(i, sums, x_i)` is given row `i` of `G x` with
    /// all updates so far, and may change `x_i`. What stands on the diagonal counts with `x_i` as it was.
    ///
    /// Row by row where an operator knows nothing better.
    fn sweep(&self, x: &mut [f64], columns: usize, update: &mut Update) {
        sweep::row_by_row(self, x, columns, update);
    }
}

/// A product with a block by products with its columns.
pub(crate) fn column_by_column(x: &[f64], y: &mut [f64], columns: usize, product: impl Fn(&[f64], &mut [f64])) {
    let mut column = vec![0.0; x.len() / columns.max(1)];
    for c in 0..columns {
        let one: Vec<f64> = x.iter().skip(c).step_by(columns).copied().collect();
        product(&one, &mut column);
        y.iter_mut().skip(c).step_by(columns).zip(&column).for_each(|(y, v)| *y = *v);
    }
}
