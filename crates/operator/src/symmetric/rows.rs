//! A row of a matrix of which only the triangle above the diagonal is stored: a column of it, then a row.
//!
//! In a dense block a column is read in steps. In a sparse one every row has to be searched for it, which for all columns
//! takes many products' time; so a copy by columns is kept for who reads many.

use super::{Block, Entries, Symmetric};

/// No position: what stands for numbers without a row.
const NOWHERE: u32 = u32::MAX;

/// Where each of `len` numbers stands in an order.
pub(super) fn positions(len: usize, order: &[u32]) -> Vec<u32> {
    let mut position = vec![NOWHERE; len];
    for (p, &k) in order.iter().enumerate() {
        position[k as usize] = p as u32;
    }
    position
}

/// The entries of sparse blocks by columns: of column q the rows and values are `starts[q]..starts[q + 1]`.
#[derive(Clone, Debug, Default)]
pub(super) struct Columns {
    starts: Vec<usize>,
    rows: Vec<u32>,
    values: Vec<f64>,
}

impl Columns {
    pub fn memory_bytes(&self) -> usize {
        8 * self.starts.len() + 12 * self.rows.len()
    }

    fn for_column(&self, q: usize, mut visit: impl FnMut(usize, f64)) {
        let range = self.starts[q]..self.starts[q + 1];
        for (&p, &v) in self.rows[range.clone()].iter().zip(&self.values[range]) {
            visit(p as usize, v);
        }
    }
}

impl Symmetric {
    /// The sparse blocks once more, by columns.
    pub(super) fn by_columns(&self) -> Columns {
        let n = self.order.len();
        let sparse = || self.blocks.iter().filter(|b| b.is_sparse());
        let mut starts = vec![0usize; n + 1];
        sparse().for_each(|block| block.for_each(n, |_, q, _| starts[q + 1] += 1));
        for q in 0..n {
            starts[q + 1] += starts[q];
        }
        let mut next = starts.clone();
        let (mut rows, mut values) = (vec![0; starts[n]], vec![0.0; starts[n]]);
        sparse().for_each(|block| {
            block.for_each(n, |p, q, v| {
                (rows[next[q]], values[next[q]]) = (p as u32, v);
                next[q] += 1;
            });
        });
        Columns { starts, rows, values }
    }

    /// The entries of row `i` that are not zero, by position.
    pub(super) fn read_row_of(&self, i: usize, row: &mut Vec<(u32, f64)>) {
        row.clear();
        let position = self.position[i];
        if position == NOWHERE {
            return;
        }
        let (n, position) = (self.order.len(), position as usize);
        let mut add = |p: usize, v: f64| {
            if v != 0.0 {
                row.push((self.order[p], v));
            }
        };
        let columns = self.columns.get();
        if let Some(columns) = columns {
            columns.for_column(position, &mut add);
        }
        for block in self.blocks.iter().take_while(|b| b.rows.start <= position) {
            if columns.is_none() || !block.is_sparse() {
                block.for_column(n, position, &mut add);
            }
            if block.rows.contains(&position) {
                block.for_row(n, position, &mut add);
            }
            self.done_with(block);
        }
    }
}

impl Block {
    fn is_sparse(&self) -> bool {
        matches!(self.entries, Entries::Sparse { .. })
    }

    /// The entries of column `q` in the rows above the diagonal.
    fn for_column(&self, n: usize, q: usize, mut visit: impl FnMut(usize, f64)) {
        let rows = self.rows.start..self.rows.end.min(q);
        match &self.entries {
            Entries::Dense(values) => for_strided(n, rows, q, |p, k| visit(p, values[k])),
            Entries::Single(values) => for_strided(n, rows, q, |p, k| visit(p, f64::from(values[k]))),
            Entries::Sparse { offsets, columns, values } => {
                for p in rows {
                    let row = offsets[p - self.rows.start] as usize..offsets[p - self.rows.start + 1] as usize;
                    if let Ok(k) = columns[row.clone()].binary_search(&(q as u32)) {
                        visit(p, values[row.start + k]);
                    }
                }
            }
        }
    }
}

/// Row by row where column `q` is among dense values; row p of n has n - 1 - p of them.
#[inline(always)]
fn for_strided(n: usize, rows: std::ops::Range<usize>, q: usize, mut visit: impl FnMut(usize, usize)) {
    let mut row = 0;
    for p in rows {
        visit(p, row + q - p - 1);
        row += n - 1 - p;
    }
}
