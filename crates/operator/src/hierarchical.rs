//! A symmetric matrix in patches of two kinds: far ones of rank one, near ones entry by entry.

use crate::Operator;
use rayon::prelude::*;
use std::ops::Range;

/// A symmetric matrix whose blocks far from the diagonal are products of two vectors.
///
/// Rows stand in an order of the builder's choice, such that what is alike is adjacent; vectors are numbered as the
/// caller numbers them.
#[derive(Clone, Debug, Default)]
pub struct Hierarchical {
    len: usize,
    /// Position in the matrix -> number. Numbers that are missing have empty rows.
    order: Vec<u32>,
    parts: Vec<Part>,
}

/// Some blocks above the diagonal: what one piece of work builds.
#[derive(Clone, Debug, Default)]
pub struct Part {
    /// First and last but one position of rows and of columns of each far block.
    links: Vec<[u32; 4]>,
    /// For each far block a weight for each row, then one for each column: an entry is the product of both.
    weights: Vec<f32>,
    /// Positions of rows with near entries.
    rows: Vec<u32>,
    /// Where the entries of each of these rows start, and where the last end.
    offsets: Vec<u32>,
    /// Positions, above their row's.
    columns: Vec<u32>,
    values: Vec<f32>,
}

impl Part {
    /// Adds the block of `rows` and `columns`, ranges of positions that have none in common, with entries `u_i w_j`.
    ///
    /// # Panics
    /// If there is not one weight for each row and column.
    pub fn link(&mut self, rows: Range<usize>, columns: Range<usize>, u: &[f32], w: &[f32]) {
        assert_eq!((u.len(), w.len()), (rows.len(), columns.len()), "a weight for each row and column");
        self.links.push([rows.start as u32, rows.end as u32, columns.start as u32, columns.end as u32]);
        self.weights.extend_from_slice(u);
        self.weights.extend_from_slice(w);
    }

    /// Adds near entries of a row: positions above the row's, with values.
    pub fn near(&mut self, row: usize, entries: impl IntoIterator<Item = (u32, f32)>) {
        if self.offsets.is_empty() {
            self.offsets.push(0);
        }
        let before = self.columns.len();
        for (column, value) in entries {
            self.columns.push(column);
            self.values.push(value);
        }
        if self.columns.len() > before {
            self.rows.push(row as u32);
            self.offsets.push(self.columns.len() as u32);
        }
    }

    /// The number of far blocks.
    pub fn links(&self) -> usize {
        self.links.len()
    }

    /// The number of near pairs.
    pub fn pairs(&self) -> usize {
        self.columns.len()
    }

    /// Numbers that a product reads.
    fn size(&self) -> usize {
        self.weights.len() + self.columns.len()
    }

    /// Bytes held.
    pub fn memory_bytes(&self) -> usize {
        16 * self.links.len()
            + 4 * self.weights.len()
            + 4 * (self.rows.len() + self.offsets.len())
            + 8 * self.columns.len()
    }

    /// Calls `visit(rows, columns, u, w)` for each far block.
    fn for_each_link(&self, mut visit: impl FnMut(Range<usize>, Range<usize>, &[f32], &[f32])) {
        let mut rest = self.weights.as_slice();
        for &[a, b, c, d] in &self.links {
            let (rows, columns) = (a as usize..b as usize, c as usize..d as usize);
            let (u, after) = rest.split_at(rows.len());
            let (w, after) = after.split_at(columns.len());
            rest = after;
            visit(rows, columns, u, w);
        }
    }

    /// Near entries by row: position, columns, values.
    fn near_rows(&self) -> impl Iterator<Item = (usize, &[u32], &[f32])> {
        self.rows.iter().enumerate().map(|(k, &row)| {
            let range = self.offsets[k] as usize..self.offsets[k + 1] as usize;
            (row as usize, &self.columns[range.clone()], &self.values[range])
        })
    }

    fn add_product<const C: usize>(&self, x: &[[f64; C]], y: &mut [[f64; C]]) {
        self.for_each_link(|rows, columns, u, w| {
            let (from_rows, from_columns) = (dot(u, &x[rows.clone()]), dot(w, &x[columns.clone()]));
            add(u, &from_columns, &mut y[rows]);
            add(w, &from_rows, &mut y[columns]);
        });
        for (row, columns, values) in self.near_rows() {
            let (xi, mut sum) = (x[row], [0.0; C]);
            for (&column, &value) in columns.iter().zip(values) {
                let (v, j) = (f64::from(value), column as usize);
                for c in 0..C {
                    sum[c] += v * x[j][c];
                    y[j][c] += v * xi[c];
                }
            }
            (0..C).for_each(|c| y[row][c] += sum[c]);
        }
    }
}

fn dot<const C: usize>(weights: &[f32], x: &[[f64; C]]) -> [f64; C] {
    // Two sums at a time: a chain of additions waits for each.
    let mut sums = [[0.0; C]; 2];
    let mut pairs = weights.chunks_exact(2).zip(x.chunks_exact(2));
    for (w, x) in &mut pairs {
        for k in 0..2 {
            for c in 0..C {
                sums[k][c] += f64::from(w[k]) * x[k][c];
            }
        }
    }
    if weights.len() % 2 == 1 {
        let last = weights.len() - 1;
        (0..C).for_each(|c| sums[0][c] += f64::from(weights[last]) * x[last][c]);
    }
    std::array::from_fn(|c| sums[0][c] + sums[1][c])
}

fn add<const C: usize>(weights: &[f32], times: &[f64; C], y: &mut [[f64; C]]) {
    for (w, y) in weights.iter().zip(y) {
        (0..C).for_each(|c| y[c] += f64::from(*w) * times[c]);
    }
}

/// Runs of parts whose products are summed one after the other, so that sums do not depend on the number of threads.
/// Each holds a vector, so few where vectors are long.
fn most_groups(len: usize) -> usize {
    if len > 1 << 18 { 8 } else { 16 }
}

impl Hierarchical {
    /// Joins parts. Their blocks must not overlap and lie above the diagonal, in positions of `order`.
    pub fn new(len: usize, order: Vec<u32>, parts: Vec<Part>) -> Self {
        Self { len, order, parts }
    }

    /// The number of far blocks.
    pub fn links(&self) -> usize {
        self.parts.iter().map(Part::links).sum()
    }

    /// The number of near pairs.
    pub fn pairs(&self) -> usize {
        self.parts.iter().map(Part::pairs).sum()
    }

    /// Bytes held.
    pub fn memory_bytes(&self) -> usize {
        4 * self.order.len() + self.parts.iter().map(Part::memory_bytes).sum::<usize>()
    }

    /// The entries of row `i` that are not zero, columns ascending.
    pub fn row(&self, i: usize) -> Vec<(u32, f64)> {
        let Some(position) = self.order.iter().position(|&k| k as usize == i) else { return Vec::new() };
        let mut row = Vec::new();
        for part in &self.parts {
            part.for_each_link(|rows, columns, u, w| {
                let (own, range, other) = if rows.contains(&position) {
                    (u[position - rows.start], columns, w)
                } else if columns.contains(&position) {
                    (w[position - columns.start], rows, u)
                } else {
                    return;
                };
                row.extend(range.zip(other).map(|(q, &v)| (self.order[q], f64::from(own) * f64::from(v))));
            });
            for (p, columns, values) in part.near_rows() {
                if p == position {
                    row.extend(columns.iter().zip(values).map(|(&q, &v)| (self.order[q as usize], f64::from(v))));
                } else if let Some(k) = columns.iter().position(|&q| q as usize == position) {
                    row.push((self.order[p], f64::from(values[k])));
                }
            }
        }
        row.retain(|e| e.1 != 0.0);
        row.sort_unstable_by_key(|e| e.0);
        row
    }

    fn product<const C: usize>(&self, x: &[f64], y: &mut [f64]) {
        let n = self.order.len();
        let (x, _) = x.as_chunks::<C>();
        let (y, _) = y.as_chunks_mut::<C>();
        let x: Vec<[f64; C]> = self.order.iter().map(|&k| x[k as usize]).collect();
        let sums: Vec<Vec<[f64; C]>> = self
            .groups()
            .into_par_iter()
            .map(|group| {
                let mut sum = vec![[0.0; C]; n];
                self.parts[group].iter().for_each(|part| part.add_product(&x, &mut sum));
                sum
            })
            .collect();
        y.fill([0.0; C]);
        for (p, &k) in self.order.iter().enumerate() {
            for sum in &sums {
                (0..C).for_each(|c| y[k as usize][c] += sum[p][c]);
            }
        }
    }

    /// Runs of parts of about the same size.
    fn groups(&self) -> Vec<Range<usize>> {
        let all: usize = self.parts.iter().map(Part::size).sum();
        let share = all.div_ceil(most_groups(self.len)).max(1);
        let (mut groups, mut start, mut held) = (Vec::new(), 0, 0);
        for (k, part) in self.parts.iter().enumerate() {
            held += part.size();
            if held >= share || k + 1 == self.parts.len() {
                groups.push(start..k + 1);
                (start, held) = (k + 1, 0);
            }
        }
        groups
    }
}

impl Operator for Hierarchical {
    fn len(&self) -> usize {
        self.len
    }

    fn apply(&self, x: &[f64], y: &mut [f64], columns: usize) {
        match columns {
            1 => self.product::<1>(x, y),
            3 => self.product::<3>(x, y),
            4 => self.product::<4>(x, y),
            // Column by column: other numbers of bands are rare.
            _ => {
                let mut column = vec![0.0; self.len];
                for c in 0..columns {
                    let one: Vec<f64> = x.iter().skip(c).step_by(columns).copied().collect();
                    self.product::<1>(&one, &mut column);
                    column.iter().enumerate().for_each(|(i, v)| y[i * columns + c] = *v);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::conformance::check;

    /// Eight positions of ten numbers: a far block, near entries, and two numbers without rows.
    fn sample() -> Hierarchical {
        let mut first = Part::default();
        first.link(0..3, 4..8, &[0.5, 0.0, 0.25], &[1.0, 2.0, 0.0, 4.0]);
        first.near(0, [(1, 0.5), (3, 0.125)]);
        first.near(2, []);
        let mut second = Part::default();
        second.near(4, [(5, 1.5)]);
        second.near(6, [(7, 0.75)]);
        Hierarchical::new(10, vec![9, 8, 7, 6, 3, 2, 1, 0], vec![first, second])
    }

    #[test]
    fn conforms() {
        check(&sample());
    }

    #[test]
    fn rows_are_products_with_unit_vectors() {
        let operator = sample();
        for i in 0..10 {
            let mut unit = [0.0; 10];
            unit[i] = 1.0;
            let mut product = [0.0; 10];
            operator.apply(&unit, &mut product, 1);
            let mut row = [0.0; 10];
            operator.row(i).iter().for_each(|&(j, v)| row[j as usize] = v);
            assert_eq!(row, product, "row {i}");
        }
        assert_eq!(operator.row(9), vec![(0, 2.0), (2, 1.0), (3, 0.5), (6, 0.125), (8, 0.5)]);
        assert!(operator.row(4).is_empty());
        assert_eq!((operator.links(), operator.pairs()), (1, 4));
    }
}
