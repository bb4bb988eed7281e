//! A row of a matrix of which only the triangle above the diagonal is stored: a column of it, then a row.

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

impl Symmetric {
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
        for block in self.blocks.iter().take_while(|b| b.rows.start <= position) {
            block.for_column(n, position, &mut add);
            if block.rows.contains(&position) {
                block.for_row(n, position, &mut add);
            }
        }
    }
}

impl Block {
    /// The entries of column `q` in the rows above the diagonal.
    fn for_column(&self, n: usize, q: usize, mut visit: impl FnMut(usize, f64)) {
        let rows = self.rows.start..self.rows.end.min(q);
        match &self.entries {
            Entries::Dense(values) => for_strided(n, rows, q, |p, k| visit(p, values[k])),
            Entries::Single(values) => for_strided(n, rows, q, |p, k| visit(p, f64::from(values[k]))),
            Entries::Sparse { offsets, columns, values } => {
                for p in rows {
                    let row = offsets[p - self.rows.start]..offsets[p - self.rows.start + 1];
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
