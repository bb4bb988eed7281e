//! A dense symmetric matrix: the plain operator others are checked against.

use crate::Operator;
use rayon::prelude::*;

/// Row-major `n x n` values.
#[derive(Clone, Debug, Default)]
pub struct Dense {
    len: usize,
    values: Vec<f64>,
}

impl Dense {
    /// Wraps row-major values.
    ///
    /// # Panics
    /// If there are not `len * len` values.
    pub fn new(len: usize, values: Vec<f64>) -> Self {
        assert_eq!(values.len(), len * len, "a dense operator of {len} rows needs {} values", len * len);
        Self { len, values }
    }

    /// Row `i`.
    pub fn row(&self, i: usize) -> &[f64] {
        &self.values[i * self.len..(i + 1) * self.len]
    }
}

impl Operator for Dense {
    fn len(&self) -> usize {
        self.len
    }

    fn apply(&self, x: &[f64], y: &mut [f64], columns: usize) {
        y.par_chunks_mut(columns).enumerate().for_each(|(i, out)| {
            out.fill(0.0);
            for (g, x) in self.row(i).iter().zip(x.chunks_exact(columns)) {
                for (o, x) in out.iter_mut().zip(x) {
                    *o += g * x;
                }
            }
        });
    }

    fn read_row(&self, i: usize, row: &mut Vec<(u32, f64)>) {
        row.clear();
        row.extend(self.row(i).iter().enumerate().filter(|(_, v)| **v != 0.0).map(|(j, v)| (j as u32, *v)));
    }
}
