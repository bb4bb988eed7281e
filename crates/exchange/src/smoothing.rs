//! Row sums made what they are known to be, at least cost.
//!
//! Larsen and Howell (1986, *Least-squares smoothing of direct-exchange areas in zonal analysis*, J. Heat Transfer 108,
//! 239): among all symmetric exchanges X with the row sums wanted, the one that minimises `sum (X_ij - G_ij)^2 / W_ij`.
//! With a multiplier a row, `X_ij = G_ij + W_ij (m_i + m_j)` and `(diag(W 1) + W) m = wanted - G 1`: symmetric and
//! positive semidefinite, solved by conjugate gradients. Entries that would become negative are set to zero and the
//! rest is fitted again.
//!
//! W are the variances of the entries where they are known, which makes X the likeliest (Gauss and Markov); else G^2, as
//! in the article: all entries are trusted alike, relative to their size.

use radiosity_operator::{Cancelled, Control, Operator, Symmetric};

/// An exchange with the row sums wanted, and the greatest relative deviation from them that is left.
///
/// Rows without entries stay empty. What cannot be met, as in an enclosure of two patches of different area, is left as
/// it is or met as nearly as it can be.
pub fn with_row_sums(
    exchange: &Symmetric,
    variance: Option<&Symmetric>,
    wanted: &[f64],
    control: &Control,
) -> Result<(Symmetric, f64), Cancelled> {
    let sees: Vec<bool> = exchange.row_sums().iter().map(|s| *s > 0.0).collect();
    let worst = |exchange: &Symmetric| -> f64 {
        let sums = exchange.row_sums();
        let deviation = |i: usize| if wanted[i] > 0.0 { (sums[i] / wanted[i] - 1.0).abs() } else { sums[i] };
        (0..sums.len()).filter(|&i| sees[i]).map(deviation).fold(0.0, f64::max)
    };
    let mut fitted = exchange.clone();
    let mut deviation = worst(&fitted);
    for _ in 0..MOST_ROUNDS {
        let sums = fitted.row_sums();
        let missing: Vec<f64> = (0..sums.len()).map(|i| if sees[i] { wanted[i] - sums[i] } else { 0.0 }).collect();
        let weights = match variance {
            Some(variance) => variance.clone(),
            None => fitted.mapped(|_, _, g| g * g),
        };
        let multipliers = solve(&weights, &missing, control)?;
        let next = fitted.plus(&weights, |i, j, g, w| (g + w * (multipliers[i] + multipliers[j])).max(0.0));
        let left = worst(&next);
        if left >= deviation {
            break;
        }
        (fitted, deviation) = (next, left);
        if deviation < 1e-13 {
            break;
        }
    }
    Ok((fitted, deviation))
}

/// Fits after the first mend what rounding and entries cut off at zero left.
const MOST_ROUNDS: usize = 20;

/// `(diag(W 1) + W) m = b` by conjugate gradients, preconditioned by the diagonal.
fn solve(weights: &Symmetric, b: &[f64], control: &Control) -> Result<Vec<f64>, Cancelled> {
    let n = b.len();
    let diagonal = weights.row_sums();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let precondition =
        |r: &[f64]| -> Vec<f64> { r.iter().zip(&diagonal).map(|(r, d)| if *d > 0.0 { r / d } else { 0.0 }).collect() };
    let mut x = vec![0.0; n];
    let mut r = b.to_vec();
    let mut z = precondition(&r);
    let mut p = z.clone();
    let mut rz = dot(&r, &z);
    let enough = 1e-28 * rz;
    let mut q = vec![0.0; n];
    for _ in 0..1000 {
        control.check()?;
        if rz <= enough {
            break;
        }
        weights.apply(&p, &mut q, 1);
        (0..n).for_each(|k| q[k] += diagonal[k] * p[k]);
        let curvature = dot(&p, &q);
        if curvature <= 0.0 {
            break;
        }
        let step = rz / curvature;
        for k in 0..n {
            x[k] += step * p[k];
            r[k] -= step * q[k];
        }
        z = precondition(&r);
        let next = dot(&r, &z);
        (0..n).for_each(|k| p[k] = z[k] + next / rz * p[k]);
        rz = next;
    }
    Ok(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_sum_to_what_is_wanted_and_large_entries_take_most() {
        // A box of six faces of area 1 whose factors are off by a few per cent.
        let noise = |i: usize, j: usize| 1.0 + 0.03 * ((i * 7 + j * 13) as f64).sin();
        let rows: Vec<Vec<(u32, f64)>> =
            (0..6).map(|i| (i + 1..6).map(|j| (j as u32, 0.2 * noise(i, j))).collect()).collect();
        let exchange = Symmetric::from_sparse_rows(&rows);
        let (fitted, left) = with_row_sums(&exchange, None, &[1.0; 6], &Control::default()).unwrap();
        assert!(left < 1e-12, "{left}");
        let mut most = 0.0f64;
        fitted.for_each_pair(|_, _, g| most = most.max((g - 0.2).abs()));
        assert!(most < 0.2 * 0.05, "{most}");
    }

    #[test]
    fn what_is_known_exactly_stays() {
        let rows = vec![vec![(1, 0.5), (2, 0.6), (3, 0.1)], vec![(2, 0.1), (3, 0.5)], vec![(3, 0.2)], vec![]];
        let exchange = Symmetric::from_sparse_rows(&rows);
        // The pairs 0-1 and 2-3 are certain: the other four make up for what rows lack.
        let variance = exchange.mapped(|i, j, _| if (i, j) == (0, 1) || (i, j) == (2, 3) { 0.0 } else { 1.0 });
        let wanted = [1.0, 1.0, 0.7, 0.7];
        let (fitted, left) = with_row_sums(&exchange, Some(&variance), &wanted, &Control::default()).unwrap();
        assert!(left < 1e-9, "{left}");
        assert_eq!((fitted.row(0)[0], fitted.row(2).last()), ((1, 0.5), Some(&(3, 0.2))));
    }

    #[test]
    fn what_cannot_be_met_is_told() {
        let exchange = Symmetric::from_sparse_rows(&[vec![(1, 0.5)], vec![]]);
        let (_, left) = with_row_sums(&exchange, None, &[1.0, 4.0], &Control::default()).unwrap();
        assert!(left > 0.1, "{left}");
    }

    #[test]
    fn nothing_becomes_negative() {
        let rows = vec![vec![(1, 0.9), (2, 0.001)], vec![(2, 0.4)], vec![]];
        let (fitted, _) =
            with_row_sums(&Symmetric::from_sparse_rows(&rows), None, &[0.5, 0.8, 0.4], &Control::default()).unwrap();
        fitted.for_each_pair(|_, _, g| assert!(g >= 0.0));
    }
}
