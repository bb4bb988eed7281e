//! A symmetric matrix without diagonal, each pair stored once.

mod rows;
mod sweep;

use crate::sweep::Update;
use crate::{Operator, column_by_column};
use radiosity_store::{Numbers, Section, Sections, StoreError, Stored};
use rayon::prelude::*;
use rows::{Columns, positions};
use std::ops::Range;
use std::sync::OnceLock;

/// The upper triangle of a symmetric matrix in blocks of rows, dense or sparse as each block's filling suggests.
///
/// Rows stand in an order of the builder's choice; vectors and entries are numbered as the caller numbers them.
#[derive(Clone, Debug, Default)]
pub struct Symmetric {
    len: usize,
    /// Position in the matrix -> number. Numbers that are missing have empty rows.
    order: Vec<u32>,
    /// Number -> position in the matrix.
    position: Vec<u32>,
    blocks: Vec<Block>,
    /// Whether blocks that are mapped are let go of after each use.
    is_frugal: bool,
    /// Of sparse blocks a copy by columns, once somebody wants many rows one by one.
    columns: OnceLock<Columns>,
}

/// Consecutive rows: of row p the columns above p.
#[derive(Clone, Debug)]
pub struct Block {
    rows: Range<usize>,
    entries: Entries,
}

#[derive(Clone, Debug)]
enum Entries {
    /// Row after row, all columns above the diagonal.
    Dense(Numbers<f64>),
    /// The same in single precision.
    Single(Numbers<f32>),
    /// Compressed rows.
    Sparse { offsets: Numbers<u64>, columns: Numbers<u32>, values: Numbers<f64> },
}

/// How exactly dense blocks are kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// To 6e-8 of an entry, in half the memory, which is half the time of a product.
    Single,
    /// As they are.
    Double,
}

/// Checks that each position has a number of its own below `len`.
pub(crate) fn check_order(order: &[u32], len: usize) -> Result<(), String> {
    let mut seen = vec![false; len];
    for &number in order {
        match seen.get_mut(number as usize) {
            Some(seen) if !*seen => *seen = true,
            _ => return Err(format!("{number} is no number of a row, or stands twice in their order")),
        }
    }
    Ok(())
}

/// A sparse entry takes 12 bytes, and a dense one 8, or 4 in single precision.
fn sparse_below(precision: Precision) -> f64 {
    if precision == Precision::Single { 0.3 } else { 0.6 }
}

/// Groups of rows whose products are summed one after the other, so that sums do not depend on the number of threads.
const GROUPS: usize = 16;

impl Symmetric {
    /// Joins blocks of rows that follow each other, by position in `order`.
    ///
    /// # Panics
    /// If the blocks do not cover all positions.
    pub fn from_blocks(len: usize, order: Vec<u32>, blocks: Vec<Block>) -> Self {
        let joined = Self::joined(len, order, blocks);
        if let Err(what) = joined.check_shape() {
            panic!("{what}");
        }
        joined
    }

    /// The same of blocks out of a file, in which anything may be.
    ///
    /// # Errors
    /// If order and blocks do not fit each other, in words. Indices within sparse blocks are left to
    /// [`Symmetric::check_indices`], as that reads them all.
    pub fn from_stored(len: usize, order: Vec<u32>, blocks: Vec<Block>) -> Result<Self, String> {
        let joined = Self::joined(len, order, blocks);
        joined.check_shape()?;
        Ok(joined)
    }

    fn joined(len: usize, order: Vec<u32>, blocks: Vec<Block>) -> Self {
        let position = positions(len, &order);
        Self { len, order, position, blocks, is_frugal: false, columns: OnceLock::new() }
    }

    fn check_shape(&self) -> Result<(), String> {
        let n = self.order.len();
        check_order(&self.order, self.len)?;
        let mut next = 0;
        for block in &self.blocks {
            if block.rows.start != next || block.rows.end < next || block.rows.end > n {
                return Err("blocks do not cover all rows in order".into());
            }
            next = block.rows.end;
            block.check_shape(n)?;
        }
        if next == n { Ok(()) } else { Err("blocks do not cover all rows in order".into()) }
    }

    /// The same, of which no more stays in memory than is at work, where it is in a mapped file: each use of a block
    /// finds its pages anew.
    pub fn frugal(self) -> Self {
        Self { is_frugal: true, ..self }
    }

    /// After a use of a block.
    fn done_with(&self, block: &Block) {
        if self.is_frugal {
            block.entries.release();
        }
    }

    /// Checks that all columns of sparse blocks are within the matrix, above the diagonal and ascend. Reads them all.
    ///
    /// # Errors
    /// If one is not, in words. What is read of such a matrix panics or is wrong.
    pub fn check_indices(&self) -> Result<(), String> {
        self.blocks.par_iter().try_for_each(|block| {
            let checked = block.check_indices(self.order.len());
            self.done_with(block);
            checked
        })
    }

    /// The blocks, in order.
    pub fn blocks(&self) -> &[Block] {
        &self.blocks
    }

    /// Position in the matrix -> number.
    pub fn order(&self) -> &[u32] {
        &self.order
    }

    /// The number of entries that are not zero, both triangles.
    pub fn count(&self) -> usize {
        let count = |block: &Block| {
            let count = block.entries.not_zero();
            self.done_with(block);
            count
        };
        2 * self.blocks.par_iter().map(count).sum::<usize>()
    }

    /// As one block: for each position of `rows` its entries above the diagonal, columns ascending.
    pub fn from_sparse_rows(rows: &[Vec<(u32, f64)>]) -> Self {
        let mut offsets = vec![0u64];
        for row in rows {
            offsets.push(offsets.last().unwrap() + row.len() as u64);
        }
        let entries = Entries::Sparse {
            offsets: offsets.into(),
            columns: rows.iter().flatten().map(|e| e.0).collect(),
            values: rows.iter().flatten().map(|e| e.1).collect(),
        };
        // Several blocks let several threads work on a product.
        Self::from_blocks(rows.len(), (0..rows.len() as u32).collect(), entries.divided(rows.len()))
    }

    /// The number of pairs stored.
    pub fn stored(&self) -> usize {
        self.blocks.iter().map(|b| b.entries.len()).sum()
    }

    /// Bytes held.
    pub fn memory_bytes(&self) -> usize {
        let bytes = |e: &Entries| match e {
            Entries::Dense(values) => 8 * values.len(),
            Entries::Single(values) => 4 * values.len(),
            Entries::Sparse { offsets, columns, values } => 8 * offsets.len() + 4 * columns.len() + 8 * values.len(),
        };
        let columns = self.columns.get().map_or(0, Columns::memory_bytes);
        columns
            + 4 * (self.order.len() + self.position.len())
            + self.blocks.iter().map(|b| bytes(&b.entries)).sum::<usize>()
    }

    /// Calls `visit(i, j, value)` for every pair that is not zero, once, in a fixed order.
    pub fn for_each_pair(&self, mut visit: impl FnMut(usize, usize, f64)) {
        for block in &self.blocks {
            block.for_each(self.order.len(), |p, q, v| {
                if v != 0.0 {
                    visit(self.order[p] as usize, self.order[q] as usize, v);
                }
            });
            self.done_with(block);
        }
    }

    /// The same pairs with other values: `change(i, j, value)`.
    pub fn mapped(&self, change: impl Fn(usize, usize, f64) -> f64 + Sync) -> Self {
        let mut other = Self { columns: OnceLock::new(), ..self.clone() };
        let n = self.order.len();
        other.blocks.par_iter_mut().for_each(|block| {
            let mut values = Vec::with_capacity(block.entries.len());
            block.for_each(n, |p, q, v| {
                let (i, j) = (self.order[p] as usize, self.order[q] as usize);
                values.push(if v == 0.0 { 0.0 } else { change(i, j, v) });
            });
            block.entries.set_values(values);
        });
        other
    }

    /// The same pairs with values that depend on those of another matrix of the same pairs: `change(i, j, a, b)`.
    ///
    /// # Panics
    /// If the other was not made from this one by [`Symmetric::mapped`], or this from the other.
    pub fn plus(&self, other: &Self, change: impl Fn(usize, usize, f64, f64) -> f64 + Sync) -> Self {
        let mut result = Self { columns: OnceLock::new(), ..self.clone() };
        result.blocks.par_iter_mut().zip(&self.blocks).zip(&other.blocks).for_each(|((block, a), b)| {
            assert_eq!(a.entries.len(), b.entries.len(), "the same pairs");
            let mut seconds = Vec::with_capacity(b.entries.len());
            b.for_each(self.order.len(), |_, _, w| seconds.push(w));
            let mut seconds = seconds.into_iter();
            let mut values = Vec::with_capacity(a.entries.len());
            a.for_each(self.order.len(), |p, q, v| {
                let (i, j) = (self.order[p] as usize, self.order[q] as usize);
                let w = seconds.next().expect("as many as firsts");
                values.push(if v == 0.0 { 0.0 } else { change(i, j, v, w) });
            });
            block.entries.set_values(values);
        });
        result
    }

    /// The entries of row `i` that are not zero, columns ascending.
    pub fn row(&self, i: usize) -> Vec<(u32, f64)> {
        let mut row = Vec::new();
        self.read_row(i, &mut row);
        row.sort_unstable_by_key(|e| e.0);
        row
    }

    /// All entries that are not zero as compressed rows, columns ascending: offsets, columns, values.
    pub fn to_csr(&self) -> (Vec<usize>, Vec<u32>, Vec<f64>) {
        let mut offsets = vec![0usize; self.len + 1];
        self.for_each_pair(|i, j, _| {
            offsets[i + 1] += 1;
            offsets[j + 1] += 1;
        });
        for k in 0..self.len {
            offsets[k + 1] += offsets[k];
        }
        let mut next = offsets.clone();
        let mut entries = vec![(0u32, 0.0); offsets[self.len]];
        self.for_each_pair(|i, j, v| {
            entries[next[i]] = (j as u32, v);
            entries[next[j]] = (i as u32, v);
            next[i] += 1;
            next[j] += 1;
        });
        let mut rest = entries.as_mut_slice();
        let mut rows = Vec::with_capacity(self.len);
        for k in 0..self.len {
            let (row, tail) = rest.split_at_mut(offsets[k + 1] - offsets[k]);
            rows.push(row);
            rest = tail;
        }
        rows.into_par_iter().for_each(|row| row.sort_unstable_by_key(|e| e.0));
        (offsets, entries.iter().map(|e| e.0).collect(), entries.iter().map(|e| e.1).collect())
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
                for block in &self.blocks[group] {
                    block.add_product(n, &x, &mut sum);
                    self.done_with(block);
                }
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

    /// Runs of blocks with about the same number of entries.
    fn groups(&self) -> Vec<Range<usize>> {
        let share = self.stored().div_ceil(GROUPS).max(1);
        let (mut groups, mut start, mut held) = (Vec::new(), 0, 0);
        for (k, block) in self.blocks.iter().enumerate() {
            held += block.entries.len();
            if held >= share || k + 1 == self.blocks.len() {
                groups.push(start..k + 1);
                (start, held) = (k + 1, 0);
            }
        }
        groups
    }
}

impl Entries {
    fn len(&self) -> usize {
        match self {
            Entries::Dense(values) | Entries::Sparse { values, .. } => values.len(),
            Entries::Single(values) => values.len(),
        }
    }

    fn not_zero(&self) -> usize {
        match self {
            Entries::Dense(values) | Entries::Sparse { values, .. } => values.iter().filter(|v| **v != 0.0).count(),
            Entries::Single(values) => values.iter().filter(|v| **v != 0.0).count(),
        }
    }

    fn release(&self) {
        match self {
            Entries::Dense(values) => values.release(),
            Entries::Single(values) => values.release(),
            Entries::Sparse { offsets, columns, values } => {
                offsets.release();
                columns.release();
                values.release();
            }
        }
    }

    /// Replaces all values, in double precision.
    fn set_values(&mut self, new: Vec<f64>) {
        match self {
            Entries::Sparse { values, .. } => *values = new.into(),
            dense => *dense = Entries::Dense(new.into()),
        }
    }

    /// Compressed rows cut into blocks.
    fn divided(self, rows: usize) -> Vec<Block> {
        let Entries::Sparse { offsets, columns, values } = self else { unreachable!("only sparse rows are divided") };
        let step = rows.div_ceil(GROUPS).max(1);
        let part = |first: usize| {
            let rows = first..(first + step).min(rows);
            let base = offsets[rows.start];
            let range = base as usize..offsets[rows.end] as usize;
            let entries = Entries::Sparse {
                offsets: offsets[rows.start..=rows.end].iter().map(|o| o - base).collect(),
                columns: columns[range.clone()].to_vec().into(),
                values: values[range].to_vec().into(),
            };
            Block { rows, entries }
        };
        (0..rows).step_by(step).map(part).collect()
    }
}

impl Block {
    /// Upper rows of a matrix of `n`, one after the other, all columns above the diagonal.
    pub fn new(n: usize, rows: Range<usize>, values: &[f64], precision: Precision) -> Self {
        // A sum vectorises where a filter does not.
        let filled: u64 = values.iter().map(|v| u64::from(*v != 0.0)).sum();
        if filled as f64 >= sparse_below(precision) * values.len() as f64 {
            let entries = match precision {
                Precision::Single => Entries::Single(values.iter().map(|v| *v as f32).collect()),
                Precision::Double => Entries::Dense(values.to_vec().into()),
            };
            return Self { rows, entries };
        }
        let (mut offsets, mut columns, mut kept) =
            (vec![0u64], Vec::with_capacity(filled as usize), Vec::with_capacity(filled as usize));
        let mut rest = values;
        for p in rows.clone() {
            let (row, after) = rest.split_at(n - 1 - p);
            for (k, &v) in row.iter().enumerate().filter(|(_, v)| **v != 0.0) {
                columns.push((p + 1 + k) as u32);
                kept.push(v);
            }
            offsets.push(columns.len() as u64);
            rest = after;
        }
        let entries = Entries::Sparse { offsets: offsets.into(), columns: columns.into(), values: kept.into() };
        Self { rows, entries }
    }

    /// Checks the lengths of the arrays, for a matrix of `n` rows.
    fn check_shape(&self, n: usize) -> Result<(), String> {
        let Range { start, end } = self.rows;
        let fits = match &self.entries {
            Entries::Sparse { offsets, columns, values } => {
                offsets.len() == end - start + 1
                    && offsets.first() == Some(&0)
                    && offsets.last() == Some(&(values.len() as u64))
                    && columns.len() == values.len()
            }
            dense => dense.len() == self.rows.clone().map(|p| n - 1 - p).sum::<usize>(),
        };
        if fits { Ok(()) } else { Err(format!("the arrays of rows {start} to {end} do not fit each other")) }
    }

    fn check_indices(&self, n: usize) -> Result<(), String> {
        let Entries::Sparse { offsets, columns, .. } = &self.entries else { return Ok(()) };
        let (offsets, columns): (&[u64], &[u32]) = (offsets, columns);
        for (p, bounds) in self.rows.clone().zip(offsets.windows(2)) {
            // Rows that overlap or lie outside have no slice.
            let row = columns.get(bounds[0] as usize..bounds[1] as usize);
            let is_sound = row.is_some_and(|row| {
                row.first().is_none_or(|&q| q as usize > p)
                    && row.last().is_none_or(|&q| (q as usize) < n)
                    && row.windows(2).all(|pair| pair[0] < pair[1])
            });
            if !is_sound {
                return Err(format!("the columns of row {p} are out of bounds or order"));
            }
        }
        Ok(())
    }

    /// Where row `p` starts among dense values.
    fn start(&self, n: usize, p: usize) -> usize {
        let before = p - self.rows.start;
        // Row r has n - 1 - r entries.
        before * (n - 1) - (self.rows.start..p).sum::<usize>()
    }

    fn for_row(&self, n: usize, p: usize, mut visit: impl FnMut(usize, f64)) {
        match &self.entries {
            Entries::Dense(values) => {
                let start = self.start(n, p);
                for (k, &v) in values[start..start + n - 1 - p].iter().enumerate() {
                    visit(p + 1 + k, v);
                }
            }
            Entries::Single(values) => {
                let start = self.start(n, p);
                for (k, &v) in values[start..start + n - 1 - p].iter().enumerate() {
                    visit(p + 1 + k, f64::from(v));
                }
            }
            Entries::Sparse { offsets, columns, values } => {
                let row = p - self.rows.start;
                let range = offsets[row] as usize..offsets[row + 1] as usize;
                columns[range.clone()].iter().zip(&values[range]).for_each(|(&q, &v)| visit(q as usize, v));
            }
        }
    }

    fn for_each(&self, n: usize, mut visit: impl FnMut(usize, usize, f64)) {
        for p in self.rows.clone() {
            self.for_row(n, p, |q, v| visit(p, q, v));
        }
    }

    fn add_product<const C: usize>(&self, n: usize, x: &[[f64; C]], y: &mut [[f64; C]]) {
        for p in self.rows.clone() {
            let xp = x[p];
            let mut sum = [0.0; C];
            let mut add = |v: f64, x: &[f64; C], y: &mut [f64; C]| {
                for c in 0..C {
                    sum[c] += v * x[c];
                    y[c] += v * xp[c];
                }
            };
            let (start, count) = (self.start(n, p), n - 1 - p);
            let ends = x[p + 1..].iter().zip(&mut y[p + 1..]);
            match &self.entries {
                Entries::Dense(values) => {
                    values[start..start + count].iter().zip(ends).for_each(|(v, (x, y))| add(*v, x, y));
                }
                Entries::Single(values) => {
                    values[start..start + count].iter().zip(ends).for_each(|(v, (x, y))| add(f64::from(*v), x, y));
                }
                Entries::Sparse { .. } => self.for_row(n, p, |q, v| add(v, &x[q], &mut y[q])),
            }
            (0..C).for_each(|c| y[p][c] += sum[c]);
        }
    }
}

/// How files name the ways in which entries are kept.
const DENSE: u64 = 1;
const SINGLE: u64 = 2;
const SPARSE: u64 = 3;

/// First row, row after the last, way; then the arrays.
impl Stored for Block {
    fn sections(&self) -> Vec<Section<'_>> {
        let (way, arrays) = match &self.entries {
            Entries::Dense(values) => (DENSE, vec![Section::of(values)]),
            Entries::Single(values) => (SINGLE, vec![Section::of(values)]),
            Entries::Sparse { offsets, columns, values } => {
                (SPARSE, vec![Section::of(offsets), Section::of(columns), Section::of(values)])
            }
        };
        let mut sections = vec![Section::owned(&[self.rows.start as u64, self.rows.end as u64, way])];
        sections.extend(arrays);
        sections
    }

    fn from_sections(sections: &mut Sections<'_>) -> Result<Self, StoreError> {
        let [start, end, way] = sections.take_few::<u64, 3>()?;
        let entries = match way {
            DENSE => Entries::Dense(sections.take()?),
            SINGLE => Entries::Single(sections.take()?),
            SPARSE => {
                Entries::Sparse { offsets: sections.take()?, columns: sections.take()?, values: sections.take()? }
            }
            _ => return Err(sections.damaged(format!("entries are kept in an unknown way, {way}"))),
        };
        // Rows past u32 have no number, so that sums of lengths cannot overflow.
        if start > end || end > u64::from(u32::MAX) {
            return Err(sections.damaged(format!("rows {start} to {end}")));
        }
        Ok(Self { rows: start as usize..end as usize, entries })
    }
}

impl Operator for Symmetric {
    fn len(&self) -> usize {
        self.len
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

    fn read_row(&self, i: usize, row: &mut Vec<(u32, f64)>) {
        self.read_row_of(i, row);
    }

    fn expect_rows(&self) {
        self.columns.get_or_init(|| self.by_columns());
    }

    fn sweep(&self, x: &mut [f64], columns: usize, update: &mut Update) {
        self.sweep_any(x, columns, update);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Dense, conformance};

    /// Entry of a symmetric example; `fill` of a hundred pairs are not zero.
    fn entry(i: usize, j: usize, fill: usize) -> f64 {
        let (a, b) = (i.min(j), i.max(j));
        let hash = (a * 7919 + b * 104_729) % 100;
        if a != b && hash < fill { 0.1 + hash as f64 * 0.01 } else { 0.0 }
    }

    fn blocks(n: usize, order: &[u32], fill: usize) -> Symmetric {
        let step = 7;
        let row = |p: usize| (p + 1..n).map(move |q| entry(order[p] as usize, order[q] as usize, fill));
        let block = |first: usize| {
            let rows = first..(first + step).min(n);
            Block::new(n, rows.clone(), &rows.flat_map(row).collect::<Vec<f64>>(), Precision::Double)
        };
        Symmetric::from_blocks(n, order.to_vec(), (0..n).step_by(step).map(block).collect())
    }

    #[test]
    fn conforms_dense_and_sparse_in_any_order() {
        let n = 60;
        let order: Vec<u32> = (0..n as u32).map(|k| (k * 17) % n as u32).collect();
        for fill in [100, 70, 20, 0] {
            let operator = blocks(n, &order, fill);
            if fill > 0 {
                conformance::check(&operator);
            }
            let dense = Dense::new(n, (0..n * n).map(|k| entry(k / n, k % n, fill)).collect());
            let x: Vec<f64> = (0..n).map(|k| (k as f64).sin()).collect();
            let (mut y, mut z) = (vec![0.0; n], vec![0.0; n]);
            operator.apply(&x, &mut y, 1);
            dense.apply(&x, &mut z, 1);
            assert!(y.iter().zip(&z).all(|(a, b)| (a - b).abs() < 1e-12));
            let (offsets, columns, values) = operator.to_csr();
            let prepared = operator.clone();
            prepared.expect_rows();
            for i in 0..n {
                let row: Vec<(u32, f64)> =
                    (0..n as u32).map(|j| (j, entry(i, j as usize, fill))).filter(|e| e.1 != 0.0).collect();
                assert_eq!(operator.row(i), row);
                assert_eq!(prepared.row(i), row);
                let range = offsets[i]..offsets[i + 1];
                assert!(columns[range.clone()].iter().zip(&values[range]).map(|(c, v)| (*c, *v)).eq(row));
            }
        }
    }

    #[test]
    fn sparse_rows_conform_and_can_be_changed() {
        let n = 50;
        let rows: Vec<Vec<(u32, f64)>> =
            (0..n).map(|i| (i + 1..n).map(|j| (j as u32, entry(i, j, 30))).filter(|e| e.1 != 0.0).collect()).collect();
        let operator = Symmetric::from_sparse_rows(&rows);
        conformance::check(&operator);
        let doubled = operator.mapped(|_, _, v| 2.0 * v);
        assert_eq!(doubled.stored(), operator.stored());
        assert!(doubled.row_sums().iter().zip(operator.row_sums()).all(|(a, b)| (a - 2.0 * b).abs() < 1e-12));
    }

    #[test]
    fn single_precision_conforms() {
        let n = 30;
        let values: Vec<f64> = (0..n).flat_map(|p| (p + 1..n).map(move |q| entry(p, q, 100))).collect();
        let block = Block::new(n, 0..n, &values, Precision::Single);
        let operator = Symmetric::from_blocks(n, (0..n as u32).collect(), vec![block]);
        assert_eq!(operator.memory_bytes(), 4 * (2 * n + values.len()));
        conformance::check(&operator);
        for (j, v) in operator.row(7) {
            assert!((v / entry(7, j as usize, 100) - 1.0).abs() < 6e-8);
        }
        assert_eq!(operator.mapped(|_, _, v| v).row(7), operator.row(7));
    }

    #[test]
    fn numbers_without_a_row_have_none() {
        let operator = Symmetric::from_blocks(4, vec![3, 0], vec![Block::new(2, 0..2, &[0.5], Precision::Double)]);
        assert_eq!(operator.row_sums(), [0.5, 0.0, 0.0, 0.5]);
        assert_eq!(operator.row(1), []);
    }
}
