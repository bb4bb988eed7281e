//! Sweeps: every row once, each with what the rows before it have become.

use crate::Operator;

/// What a sweep does in a row: its number, the columns of `(G x)_i`, and those of `x_i` to be changed.
pub type Update<'a> = dyn FnMut(usize, &[f64], &mut [f64]) + 'a;

/// A sweep by rows that are read one at a time.
pub(crate) fn row_by_row<O: Operator + ?Sized>(operator: &O, x: &mut [f64], columns: usize, update: &mut Update) {
    let (mut row, mut sums) = (Vec::new(), vec![0.0; columns]);
    for i in 0..operator.len() {
        operator.read_row(i, &mut row);
        sums.fill(0.0);
        for &(j, v) in &row {
            let x = &x[j as usize * columns..][..columns];
            sums.iter_mut().zip(x).for_each(|(s, x)| *s += v * x);
        }
        update(i, &sums, &mut x[i * columns..][..columns]);
    }
}
