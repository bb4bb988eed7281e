//! A sweep over a matrix of which only the triangle above the diagonal is stored, in one pass over it.
//!
//! A row pulls from the columns above the diagonal, whose values are still old, and has been sent what the rows before
//! it have become; then it pushes its own new value to the columns above the diagonal. The row is read twice, the
//! second time from a cache.

use super::{Block, Symmetric};
use crate::sweep::{Update, row_by_row};

impl Symmetric {
    pub(super) fn sweep_any(&self, x: &mut [f64], columns: usize, update: &mut Update) {
        match columns {
            1 => self.sweep_with::<1>(x, update),
            3 => self.sweep_with::<3>(x, update),
            4 => self.sweep_with::<4>(x, update),
            // Other numbers of bands are rare.
            _ => row_by_row(self, x, columns, update),
        }
    }

    fn sweep_with<const C: usize>(&self, x: &mut [f64], update: &mut Update) {
        let (x, _) = x.as_chunks_mut::<C>();
        let mut ordered: Vec<[f64; C]> = self.order.iter().map(|&k| x[k as usize]).collect();
        let mut sent = vec![[0.0; C]; ordered.len()];
        let mut is_missing = vec![true; x.len()];
        for block in &self.blocks {
            for p in block.rows.clone() {
                let i = self.order[p] as usize;
                is_missing[i] = false;
                block.pull(p, &ordered, &mut sent);
                update(i, &sent[p], &mut ordered[p]);
                block.push(p, &ordered, &mut sent);
                x[i] = ordered[p];
            }
        }
        for i in (0..x.len()).filter(|&i| is_missing[i]) {
            update(i, &[0.0; C], &mut x[i]);
        }
    }
}

impl Block {
    /// Adds to row `p` what is to its right.
    fn pull<const C: usize>(&self, p: usize, x: &[[f64; C]], sums: &mut [[f64; C]]) {
        let mut sum = sums[p];
        self.for_row(x.len(), p, |q, v| (0..C).for_each(|c| sum[c] += v * x[q][c]));
        sums[p] = sum;
    }

    /// Adds what row `p` sends to those to its right.
    fn push<const C: usize>(&self, p: usize, x: &[[f64; C]], sums: &mut [[f64; C]]) {
        let from = x[p];
        self.for_row(x.len(), p, |q, v| (0..C).for_each(|c| sums[q][c] += v * from[c]));
    }
}
