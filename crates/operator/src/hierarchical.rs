//! A symmetric matrix in patches of two kinds: far ones of rank one, near ones entry by entry.

mod rows;
mod sweep;

use crate::sweep::Update;
use crate::symmetric::check_order;
use crate::{Operator, column_by_column};
use radiosity_store::{Numbers, Section, Sections, StoreError, Stored};
use rayon::prelude::*;
use rows::Index;
use std::ops::Range;
use std::sync::OnceLock;

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
    /// Whether parts that are mapped are let go of after each product.
    is_frugal: bool,
    /// Who is in which block, once somebody wants many rows one by one.
    index: OnceLock<Index>,
}

/// A far block: entries `u_i w_j`.
struct Link<'a> {
    rows: Range<usize>,
    columns: Range<usize>,
    u: &'a [f32],
    w: &'a [f32],
}

/// Some blocks above the diagonal: what one piece of work builds.
#[derive(Clone, Debug, Default)]
pub struct Part {
    /// Four numbers a far block: where its rows start and end, where its columns do, by position.
    links: Numbers<u32>,
    /// For each far block a weight for each row, then one for each column: an entry is the product of both.
    weights: Numbers<f32>,
    /// Positions of rows with near entries.
    rows: Numbers<u32>,
    /// Where the entries of each of these rows start, and where the last end.
    offsets: Numbers<u32>,
    /// Positions, above their row's.
    columns: Numbers<u32>,
    values: Numbers<f32>,
}

/// A part in the making.
#[derive(Clone, Debug, Default)]
pub struct PartBuilder {
    links: Vec<u32>,
    weights: Vec<f32>,
    rows: Vec<u32>,
    offsets: Vec<u32>,
    columns: Vec<u32>,
    values: Vec<f32>,
}

impl PartBuilder {
    /// Adds the block of `rows` and `columns`, ranges of positions that have none in common, with entries `u_i w_j`.
    ///
    /// # Panics
    /// If there is not one weight for each row and column.
    pub fn link(&mut self, rows: Range<usize>, columns: Range<usize>, u: &[f32], w: &[f32]) {
        assert_eq!((u.len(), w.len()), (rows.len(), columns.len()), "a weight for each row and column");
        self.links.extend([rows.start, rows.end, columns.start, columns.end].map(|p| p as u32));
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

    /// The part.
    pub fn build(self) -> Part {
        Part {
            links: self.links.into(),
            weights: self.weights.into(),
            rows: self.rows.into(),
            offsets: self.offsets.into(),
            columns: self.columns.into(),
            values: self.values.into(),
        }
    }
}

impl Part {
    /// From its arrays, in which anything may be, as [`Stored::sections`] has them: of a matrix of `n`.
    ///
    /// # Errors
    /// If they do not fit each other, in words.
    pub fn from_arrays(
        n: usize,
        links: Vec<u32>,
        weights: Vec<f32>,
        rows: Vec<u32>,
        offsets: Vec<u32>,
        (columns, values): (Vec<u32>, Vec<f32>),
    ) -> Result<Self, String> {
        let part = PartBuilder { links, weights, rows, offsets, columns, values }.build();
        part.check(n)?;
        Ok(part)
    }

    /// Adds the part's product with `x` to `y`, both by position.
    pub fn add_to(&self, x: &[f64], y: &mut [f64]) {
        self.add_product(x.as_chunks::<1>().0, y.as_chunks_mut::<1>().0);
    }

    /// The number of far blocks.
    pub fn links(&self) -> usize {
        self.links.len() / 4
    }

    /// The number of near pairs.
    pub fn pairs(&self) -> usize {
        self.columns.len()
    }

    fn release(&self) {
        self.links.release();
        self.weights.release();
        self.rows.release();
        self.offsets.release();
        self.columns.release();
        self.values.release();
    }

    /// Numbers that a product reads.
    fn size(&self) -> usize {
        self.weights.len() + self.columns.len()
    }

    /// Bytes held.
    pub fn memory_bytes(&self) -> usize {
        let words = [self.links.len(), self.weights.len(), self.rows.len(), self.offsets.len(), 2 * self.columns.len()];
        4 * words.iter().sum::<usize>()
    }

    /// Checks that all blocks and entries are above the diagonal of a matrix of `n` and have their numbers.
    fn check(&self, n: usize) -> Result<(), String> {
        let (links, rest) = self.links.as_chunks::<4>();
        let mut weights = 0;
        for &[a, b, c, d] in links {
            if !(a <= b && b <= c && c <= d && d as usize <= n) {
                return Err(format!(
                    "rows {a} to {b} and columns {c} to {d} are no block above the diagonal of {n} rows"
                ));
            }
            weights += (b - a) as usize + (d - c) as usize;
        }
        if !rest.is_empty() || weights != self.weights.len() {
            return Err("there is not one weight for each row and column".into());
        }
        let (rows, offsets, columns): (&[u32], &[u32], &[u32]) = (&self.rows, &self.offsets, &self.columns);
        let spans = if rows.is_empty() { columns.is_empty() } else { offsets.len() == rows.len() + 1 };
        if !spans || columns.len() != self.values.len() {
            return Err("near rows do not have one start and end, or entries not one value".into());
        }
        for (&row, bounds) in rows.iter().zip(offsets.windows(2)) {
            let entries = columns.get(bounds[0] as usize..bounds[1] as usize);
            if !entries.is_some_and(|q| q.iter().all(|&q| q > row && (q as usize) < n)) {
                return Err(format!("the near columns of row {row} are out of bounds"));
            }
        }
        Ok(())
    }

    /// Calls `visit` for each far block.
    fn for_each_link<'a>(&'a self, mut visit: impl FnMut(Link<'a>)) {
        let mut start = 0;
        for number in 0..self.links() {
            let link = self.link_at(number, start);
            start += link.rows.len() + link.columns.len();
            visit(link);
        }
    }

    /// The far block of a number, whose weights start where they do.
    fn link_at(&self, number: usize, start: usize) -> Link<'_> {
        let links: &[u32] = &self.links;
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| links[4 * number + k] as usize);
        let (u, rest) = self.weights[start..].split_at(b - a);
        Link { rows: a..b, columns: c..d, u, w: &rest[..d - c] }
    }

    /// Near entries by row: position, columns, values.
    fn near_rows(&self) -> impl Iterator<Item = (usize, &[u32], &[f32])> {
        let (columns, values): (&[u32], &[f32]) = (&self.columns, &self.values);
        self.rows.iter().zip(self.offsets.windows(2)).map(move |(&row, bounds)| {
            let range = bounds[0] as usize..bounds[1] as usize;
            (row as usize, &columns[range.clone()], &values[range])
        })
    }

    fn add_product<const C: usize>(&self, x: &[[f64; C]], y: &mut [[f64; C]]) {
        self.for_each_link(|Link { rows, columns, u, w }| {
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
    if len > 1 << 14 { 8 } else { 16 }
}

impl Hierarchical {
    /// Joins parts. Their blocks must not overlap and lie above the diagonal, in positions of `order`.
    pub fn new(len: usize, order: Vec<u32>, parts: Vec<Part>) -> Self {
        Self { len, order, parts, is_frugal: false, index: OnceLock::new() }
    }

    /// The same of parts out of a file, in which anything may be.
    ///
    /// # Errors
    /// If the order is none, in words. Parts are left to [`Hierarchical::check_indices`], as that reads them.
    pub fn from_stored(len: usize, order: Vec<u32>, parts: Vec<Part>) -> Result<Self, String> {
        check_order(&order, len)?;
        Ok(Self::new(len, order, parts))
    }

    /// The same, of which no more stays in memory than is at work, where it is in a mapped file: each product finds its
    /// pages anew.
    pub fn frugal(self) -> Self {
        Self { is_frugal: true, ..self }
    }

    /// After a use of a part.
    fn done_with(&self, part: &Part) {
        if self.is_frugal {
            part.release();
        }
    }

    /// Checks that all blocks lie within the matrix and have their numbers.
    ///
    /// # Errors
    /// If one does not, in words. What is read of such a matrix panics or is wrong.
    pub fn check_indices(&self) -> Result<(), String> {
        self.parts.par_iter().try_for_each(|part| {
            let checked = part.check(self.order.len());
            self.done_with(part);
            checked
        })
    }

    /// The parts, in order.
    pub fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// Position in the matrix -> number.
    pub fn order(&self) -> &[u32] {
        &self.order
    }

    /// The number of far blocks.
    pub fn links(&self) -> usize {
        self.parts.iter().map(Part::links).sum()
    }

    /// The number of entries that may not be zero, both triangles.
    pub fn count(&self) -> usize {
        let mut count = self.pairs();
        self.parts.iter().for_each(|part| part.for_each_link(|link| count += link.rows.len() * link.columns.len()));
        2 * count
    }

    /// The number of near pairs.
    pub fn pairs(&self) -> usize {
        self.parts.iter().map(Part::pairs).sum()
    }

    /// Bytes held.
    pub fn memory_bytes(&self) -> usize {
        let index = self.index.get().map_or(0, Index::memory_bytes);
        4 * self.order.len() + index + self.parts.iter().map(Part::memory_bytes).sum::<usize>()
    }

    /// The entries of row `i` that are not zero, columns ascending.
    pub fn row(&self, i: usize) -> Vec<(u32, f64)> {
        let mut row = Vec::new();
        self.read_row_of(i, &mut row);
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
                self.parts[group].iter().for_each(|part| {
                    part.add_product(&x, &mut sum);
                    self.done_with(part);
                });
                sum
            })
            .collect();
        let total = |p: usize| {
            let mut total = [0.0; C];
            sums.iter().for_each(|sum| (0..C).for_each(|c| total[c] += sum[p][c]));
            total
        };
        let totals: Vec<[f64; C]> = (0..n).into_par_iter().with_min_len(1024).map(total).collect();
        y.fill([0.0; C]);
        self.order.iter().zip(totals).for_each(|(&k, total)| y[k as usize] = total);
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

impl Stored for Part {
    fn sections(&self) -> Vec<Section<'_>> {
        vec![
            Section::of(&self.links),
            Section::of(&self.weights),
            Section::of(&self.rows),
            Section::of(&self.offsets),
            Section::of(&self.columns),
            Section::of(&self.values),
        ]
    }

    fn from_sections(sections: &mut Sections<'_>) -> Result<Self, StoreError> {
        Ok(Self {
            links: sections.take()?,
            weights: sections.take()?,
            rows: sections.take()?,
            offsets: sections.take()?,
            columns: sections.take()?,
            values: sections.take()?,
        })
    }
}

impl Operator for Hierarchical {
    fn len(&self) -> usize {
        self.len
    }

    fn read_row(&self, i: usize, row: &mut Vec<(u32, f64)>) {
        self.read_row_of(i, row);
    }

    fn expect_rows(&self) {
        self.index.get_or_init(|| self.indexed());
    }

    fn sweep(&self, x: &mut [f64], columns: usize, update: &mut Update) {
        self.sweep_any(x, columns, update);
    }

    fn apply(&self, x: &[f64], y: &mut [f64], columns: usize) {
        match columns {
            1 => self.product::<1>(x, y),
            3 => self.product::<3>(x, y),
            4 => self.product::<4>(x, y),
            // Other numbers of bands are rare.
            _ => column_by_column(x, y, columns, |x, y| self.product::<1>(x, y)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::conformance::check;

    /// Eight positions of ten numbers: a far block, near entries, and two numbers without rows.
    fn sample() -> Hierarchical {
        let mut first = PartBuilder::default();
        first.link(0..3, 4..8, &[0.5, 0.0, 0.25], &[1.0, 2.0, 0.0, 4.0]);
        first.near(0, [(1, 0.5), (3, 0.125)]);
        first.near(2, []);
        let mut second = PartBuilder::default();
        second.near(4, [(5, 1.5)]);
        second.near(6, [(7, 0.75)]);
        Hierarchical::new(10, vec![9, 8, 7, 6, 3, 2, 1, 0], vec![first.build(), second.build()])
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
            let before = operator.row(i);
            let indexed = operator.clone();
            indexed.expect_rows();
            assert_eq!(indexed.row(i), before);
        }
        assert_eq!(operator.row(9), vec![(0, 2.0), (2, 1.0), (3, 0.5), (6, 0.125), (8, 0.5)]);
        assert!(operator.row(4).is_empty());
        assert_eq!((operator.links(), operator.pairs()), (1, 4));
    }

    #[test]
    fn what_does_not_fit_is_found() {
        let sound = || {
            let mut part = PartBuilder::default();
            part.link(0..2, 2..4, &[1.0, 2.0], &[3.0, 4.0]);
            part.near(0, [(1, 0.5)]);
            part
        };
        let checked = |change: &dyn Fn(&mut PartBuilder)| {
            let mut part = sound();
            change(&mut part);
            Hierarchical::from_stored(4, vec![3, 2, 1, 0], vec![part.build()]).unwrap().check_indices()
        };
        assert_eq!(checked(&|_| {}), Ok(()));
        let broken: [&dyn Fn(&mut PartBuilder); 8] = [
            &|p| p.links[3] = 5,
            &|p| p.links[0] = 3,
            &|p| p.links.push(0),
            &|p| p.weights.push(0.0),
            &|p| p.columns[0] = 0,
            &|p| p.columns[0] = 4,
            &|p| p.offsets[1] = 2,
            &|p| p.values.push(0.0),
        ];
        for (k, change) in broken.iter().enumerate() {
            assert!(checked(change).is_err(), "{k}");
        }
        assert!(Hierarchical::from_stored(3, vec![0, 0], Vec::new()).is_err());
    }
}
