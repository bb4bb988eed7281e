//! One row after the other: what a solver that shoots needs, and no product.

use crate::Operator;

/// Rows of G that are read one at a time, in an order that the reader chooses as it goes.
///
/// Every operator has them. A source that finds a row only when it is asked for need not be an operator, nor symmetric:
/// row i is what leaves i, wherever it was measured.
pub trait Rows: Sync {
    /// The number of rows.
    fn count(&self) -> usize;

    /// Says that many rows will be asked for.
    fn begin(&self) {}

    /// Replaces `row` by the entries `(j, G_ij)` of row `i`, each column once, and those that are zero perhaps left out.
    fn find_row(&self, i: usize, row: &mut Vec<(u32, f64)>);

    /// How many rows are best found together now that row `i` is wanted: 1 where there is nothing to gain.
    fn batch(&self, i: usize) -> usize {
        let _ = i;
        1
    }

    /// Says that these rows will probably be asked for. What [`Rows::find_row`] gives does not depend on it.
    fn prepare(&self, rows: &[usize]) {
        let _ = rows;
    }
}

impl<O: Operator + ?Sized> Rows for O {
    fn count(&self) -> usize {
        self.len()
    }

    fn begin(&self) {
        self.expect_rows();
    }

    fn find_row(&self, i: usize, row: &mut Vec<(u32, f64)>) {
        self.read_row(i, row);
    }
}
