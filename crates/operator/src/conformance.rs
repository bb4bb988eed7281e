//! What every exchange operator must satisfy. Tests of each operator call [`check`] in one line.

use crate::Operator;

/// A reproducible vector without structure.
fn noise(n: usize, seed: u64) -> Vec<f64> {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    (0..n)
        .map(|_| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64
        })
        .collect()
}

/// Asserts symmetry, linearity, agreement of blocks with single columns, row sums, rows, sweeps and repeatability.
///
/// # Panics
/// If the operator breaks one of them.
pub fn check(operator: &dyn Operator) {
    let n = operator.len();
    let product = |x: &[f64], columns| {
        let mut y = vec![f64::NAN; n * columns];
        operator.apply(x, &mut y, columns);
        y
    };
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let (x, z) = (noise(n, 1), noise(n, 2));
    let (gx, gz) = (product(&x, 1), product(&z, 1));
    let scale = dot(&z, &gx).abs().max(f64::MIN_POSITIVE);
    assert!((dot(&z, &gx) - dot(&x, &gz)).abs() <= 1e-9 * scale, "not symmetric");
    assert!(gx.iter().all(|&v| v.is_finite() && v >= 0.0), "an exchange maps nonnegative vectors to nonnegative ones");

    let sum: Vec<f64> = x.iter().zip(&z).map(|(x, z)| 2.0 * x - z).collect();
    for (i, v) in product(&sum, 1).iter().enumerate() {
        let expected = 2.0 * gx[i] - gz[i];
        assert!((v - expected).abs() <= 1e-9 * (gx[i] + gz[i] + f64::MIN_POSITIVE), "not linear in row {i}");
    }
    for columns in [2, 3, 4, 5] {
        let block = noise(n * columns, 3);
        let y = product(&block, columns);
        for c in 0..columns {
            let column: Vec<f64> = (0..n).map(|i| block[i * columns + c]).collect();
            for (i, v) in product(&column, 1).iter().enumerate() {
                assert!(
                    (y[i * columns + c] - v).abs() <= 1e-12 * v.abs(),
                    "column {c} of {columns} differs in row {i}"
                );
            }
        }
    }
    for (sum, product) in operator.row_sums().iter().zip(product(&vec![1.0; n], 1)) {
        assert!((sum - product).abs() <= 1e-12 * product.abs(), "row sums are not the product with ones");
    }
    assert_eq!(product(&x, 1), gx, "two products of one vector differ");
    check_rows(operator, &x, &gx);
    for columns in [1, 2, 3, 4] {
        check_sweep(operator, &noise(n * columns, 4), columns);
    }
}

/// Rows are those of the product, each column once.
fn check_rows(operator: &dyn Operator, x: &[f64], gx: &[f64]) {
    let mut row = vec![(u32::MAX, f64::NAN)];
    for (i, gx) in gx.iter().enumerate().take(MOST_ROWS) {
        operator.read_row(i, &mut row);
        let sum: f64 = row.iter().map(|&(j, v)| v * x[j as usize]).sum();
        assert!((sum - gx).abs() <= 1e-9 * gx.abs(), "row {i} is not that of the product");
        let mut columns: Vec<u32> = row.iter().map(|e| e.0).collect();
        columns.sort_unstable();
        assert!(columns.windows(2).all(|w| w[0] < w[1]), "row {i} has a column twice");
    }
}

/// A sweep visits every row once, with what the rows before it have become.
fn check_sweep(operator: &dyn Operator, start: &[f64], columns: usize) {
    let (mut x, mut order, mut given) = (start.to_vec(), Vec::new(), Vec::new());
    operator.sweep(&mut x, columns, &mut |i, sums, x| {
        order.push(i);
        given.push(sums.to_vec());
        x.iter_mut().zip(sums).for_each(|(x, s)| *x = 0.5 * *x + s);
    });
    let mut expected = start.to_vec();
    let mut row = Vec::new();
    for (&i, sums) in order.iter().zip(&given) {
        operator.read_row(i, &mut row);
        for c in 0..columns {
            let sum: f64 = row.iter().map(|&(j, v)| v * expected[j as usize * columns + c]).sum();
            assert!((sums[c] - sum).abs() <= 1e-9 * sum.abs(), "row {i}, column {c} of a sweep");
            expected[i * columns + c] = 0.5 * expected[i * columns + c] + sums[c];
        }
    }
    assert_eq!(x, expected, "a sweep keeps what its updates leave");
    order.sort_unstable();
    assert!(order.iter().copied().eq(0..operator.len()), "a sweep visits every row once");
}

/// Rows looked at one by one: an operator that knows nothing better takes a product for each.
const MOST_ROWS: usize = 200;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Dense;

    #[test]
    fn dense_conforms() {
        let n = 40;
        let mut values = noise(n * n, 9);
        for i in 0..n {
            for j in 0..i {
                values[i * n + j] = values[j * n + i];
            }
        }
        check(&Dense::new(n, values));
    }

    #[test]
    #[should_panic(expected = "not symmetric")]
    fn an_asymmetric_operator_is_caught() {
        check(&Dense::new(2, vec![0.0, 1.0, 0.5, 0.0]));
    }
}
