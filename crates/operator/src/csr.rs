//! A symmetric sparse matrix in compressed rows.

use crate::Operator;
use rayon::prelude::*;

/// Rows of `(column, value)` entries; a column may occur more than once in a row and then counts as the sum.
///
/// Values are single precision: they are Monte Carlo estimates with far larger errors, and half the memory is twice
/// the speed of a product.
#[derive(Clone, Debug, Default)]
pub struct Csr {
    offsets: Vec<usize>,
    entries: Vec<(u32, f32)>,
    /// Symmetric diagonal scaling: the operator is `scale_i * value_ij * scale_j`.
    scale: Option<Vec<f64>>,
}

/// Rows per parallel task: enough work to be worth a steal.
const ROWS_PER_TASK: usize = 256;

impl Csr {
    /// Takes compressed rows: the entries of row `i` are `entries[offsets[i]..offsets[i + 1]]`.
    pub fn new(offsets: Vec<usize>, entries: Vec<(u32, f32)>) -> Self {
        debug_assert_eq!(offsets.last().copied(), Some(entries.len()));
        Self { offsets, entries, scale: None }
    }

    /// The entries of row `i`, unscaled.
    pub fn row(&self, i: usize) -> &[(u32, f32)] {
        &self.entries[self.offsets[i]..self.offsets[i + 1]]
    }

    /// The number of stored entries.
    pub fn stored(&self) -> usize {
        self.entries.len()
    }

    /// Bytes held.
    pub fn memory_bytes(&self) -> usize {
        self.entries.len() * size_of::<(u32, f32)>() + self.offsets.len() * size_of::<usize>()
    }

    /// The diagonal scaling, if any.
    pub fn scale(&self) -> Option<&[f64]> {
        self.scale.as_deref()
    }

    /// Scales rows and columns alike so that row sums approach `targets`, and never exceed `limits`.
    ///
    /// Symmetric Sinkhorn scaling (Knight, Ruiz and Ucar 2014): `d <- sqrt(d * target / (G d))` until every row is
    /// within `tolerance` of its target, relative to the largest, or `iterations` are spent. Monte Carlo rows do not
    /// sum to what is known exactly (1 in a closed enclosure); left alone, noise above 1 destroys positive
    /// definiteness and drifts the energy balance at high reflectance. Returns the worst remaining relative deviation.
    pub fn balance(&mut self, targets: &[f64], limits: &[f64], tolerance: f64, iterations: usize) -> f64 {
        let n = self.len();
        let mut scale = vec![1.0; n];
        let mut sums = vec![0.0; n];
        let mut worst = f64::INFINITY;
        self.scale = None;
        for round in 0..=iterations {
            self.apply_unscaled(&scale, &mut sums, 1);
            worst = (0..n)
                .filter(|&i| targets[i] > 0.0 && sums[i] > 0.0)
                .map(|i| (scale[i] * sums[i] / targets[i] - 1.0).abs())
                .fold(0.0, f64::max);
            if worst <= tolerance || round == iterations {
                break;
            }
            for i in 0..n {
                scale[i] =
                    if targets[i] > 0.0 && sums[i] > 0.0 { (scale[i] * targets[i] / sums[i]).sqrt() } else { 0.0 };
            }
        }
        // Scaling rows that are too long by their excess, on both sides, leaves none too long.
        for i in 0..n {
            let sum = scale[i] * sums[i];
            if sum > limits[i] {
                scale[i] *= limits[i] / sum;
            }
        }
        self.scale = Some(scale);
        worst
    }

    fn apply_unscaled(&self, x: &[f64], y: &mut [f64], columns: usize) {
        match columns {
            1 => self.product::<1>(x, y),
            3 => self.product::<3>(x, y),
            4 => self.product::<4>(x, y),
            _ => self.product_any(x, y, columns),
        }
    }

    fn product<const C: usize>(&self, x: &[f64], y: &mut [f64]) {
        let (x, _) = x.as_chunks::<C>();
        let (y, _) = y.as_chunks_mut::<C>();
        y.par_chunks_mut(ROWS_PER_TASK).enumerate().for_each(|(task, rows)| {
            for (k, out) in rows.iter_mut().enumerate() {
                let mut sum = [0.0; C];
                for &(column, value) in self.row(task * ROWS_PER_TASK + k) {
                    let x = &x[column as usize];
                    for c in 0..C {
                        sum[c] += f64::from(value) * x[c];
                    }
                }
                *out = sum;
            }
        });
    }

    fn product_any(&self, x: &[f64], y: &mut [f64], columns: usize) {
        y.par_chunks_mut(ROWS_PER_TASK * columns).enumerate().for_each(|(task, rows)| {
            for (k, out) in rows.chunks_exact_mut(columns).enumerate() {
                out.fill(0.0);
                for &(column, value) in self.row(task * ROWS_PER_TASK + k) {
                    let x = &x[column as usize * columns..][..columns];
                    for (o, x) in out.iter_mut().zip(x) {
                        *o += f64::from(value) * x;
                    }
                }
            }
        });
    }
}

/// Multiplies row `i` of a block by `scale[i]`.
fn scaled(x: &[f64], scale: &[f64], columns: usize) -> Vec<f64> {
    x.chunks_exact(columns).zip(scale).flat_map(|(row, s)| row.iter().map(move |v| v * s)).collect()
}

impl Operator for Csr {
    fn len(&self) -> usize {
        self.offsets.len().saturating_sub(1)
    }

    fn apply(&self, x: &[f64], y: &mut [f64], columns: usize) {
        match &self.scale {
            None => self.apply_unscaled(x, y, columns),
            Some(scale) => {
                self.apply_unscaled(&scaled(x, scale, columns), y, columns);
                for (row, s) in y.chunks_exact_mut(columns).zip(scale) {
                    row.iter_mut().for_each(|v| *v *= s);
                }
            }
        }
    }

    fn read_row(&self, i: usize, row: &mut Vec<(u32, f64)>) {
        row.clear();
        let scaled = |(j, v): (u32, f32)| match &self.scale {
            None => (j, f64::from(v)),
            Some(scale) => (j, scale[i] * f64::from(v) * scale[j as usize]),
        };
        row.extend(self.row(i).iter().copied().map(scaled));
        // A column that is stored in several entries is one.
        row.sort_unstable_by_key(|e| e.0);
        row.dedup_by(|next, kept| {
            let same = next.0 == kept.0;
            kept.1 += if same { next.1 } else { 0.0 };
            same
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::conformance;

    /// A symmetric matrix with a few entries per row, some of them split in two.
    fn example(n: usize) -> Csr {
        let mut rows = vec![Vec::new(); n];
        for i in 0..n {
            for step in [1, 7, 12] {
                let (j, value) = ((i + step) % n, 0.1 + ((i * 31 + step) % 17) as f32 * 0.01);
                rows[i].push((j as u32, value));
                rows[j].push((i as u32, value));
            }
        }
        let mut offsets = vec![0];
        let mut entries = Vec::new();
        for row in rows {
            entries.extend(row);
            offsets.push(entries.len());
        }
        Csr::new(offsets, entries)
    }

    #[test]
    fn conforms() {
        conformance::check(&example(601));
    }

    #[test]
    fn balanced_rows_meet_their_targets() {
        let mut csr = example(300);
        let targets: Vec<f64> = (0..300).map(|i| 1.0 + (i % 5) as f64 * 0.1).collect();
        let worst = csr.balance(&targets, &targets, 1e-12, 2000);
        assert!(worst < 1e-12, "{worst}");
        for (sum, target) in csr.row_sums().iter().zip(&targets) {
            assert!((sum - target).abs() < 1e-9);
        }
        conformance::check(&csr);
    }

    #[test]
    fn limits_hold_even_when_balancing_is_cut_short() {
        let mut csr = example(300);
        let targets = vec![1.0; 300];
        csr.balance(&targets, &targets, 0.0, 1);
        assert!(csr.row_sums().iter().all(|&s| s <= 1.0 + 1e-12));
    }
}
