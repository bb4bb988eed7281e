//! Rows of the exchange that are found when they are asked for: no matrix, and no row that nobody needs.
//!
//! Cohen, Chen, Wallace and Greenberg 1988: the side that shoots is drawn on hemicubes, which tell what part of what
//! leaves it arrives at each other side. Several hemicubes stand on a side, each elsewhere and turned differently, in four
//! independent sets; their mean is the row and the spread of the sets its error. A row depends on the side and the seed alone, so it does not matter when
//! it is asked for, nor which were found beside it. G is as its sending ends measured it, so not quite symmetric.
//!
//! Rows are kept until they would take more memory than allowed; then all are forgotten, and found again when needed.

use crate::enclosure::Enclosure;
use crate::kernels::hemicube;
use radiosity_operator::Rows;
use std::collections::HashMap;
use std::sync::{Arc, Mutex};

/// How rows are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// Pixels along an edge of a hemicube.
    pub resolution: usize,
    /// Hemicubes a side, a multiple of four.
    pub positions: usize,
    /// Turns and places the hemicubes.
    pub seed: u64,
    /// Bytes that rows may take.
    pub memory_limit: u64,
}

/// A source of rows between the sides of an enclosure.
pub struct RowsOnDemand {
    enclosure: Arc<Enclosure>,
    settings: Settings,
    kept: Mutex<Kept>,
}

/// One row of the exchange.
#[derive(Clone, Debug, Default)]
pub struct Row {
    /// To which side, and G, m2.
    pub entries: Vec<(u32, f32)>,
    /// The standard error of each G, m2.
    pub error: Vec<f32>,
}

#[derive(Default)]
struct Kept {
    rows: HashMap<usize, Arc<Row>>,
    bytes: u64,
    /// Rows found, those found again included.
    found: u64,
}

/// Rows found together: enough for all cores, and few enough that not many of them are found for nothing.
const BATCH: usize = 16;

/// Independent sets of hemicubes on a side.
const REPLICATES: usize = 4;

/// An entry and its error.
const BYTES_PER_ENTRY: u64 = 12;

impl Row {
    fn bytes(&self) -> u64 {
        BYTES_PER_ENTRY * self.entries.len() as u64
    }

    /// The mean of what the sets of hemicubes of a side found, times its area.
    fn of(replicates: &[Vec<(u32, f64)>], area: f64) -> Self {
        let count = replicates.len() as f64;
        let mut all: Vec<(u32, f64)> = replicates.concat();
        all.sort_by_key(|e| e.0);
        let mut row = Self::default();
        for run in all.chunk_by(|a, b| a.0 == b.0) {
            let (sum, squares) = run.iter().fold((0.0, 0.0), |(s, q), (_, f)| (s + f, q + f * f));
            let mean = sum / count;
            // Sets that do not see it found zero.
            let variance = (squares - count * mean * mean).max(0.0) / (count * (count - 1.0));
            row.entries.push((run[0].0, (area * mean) as f32));
            row.error.push((area * variance.sqrt()) as f32);
        }
        row
    }
}

impl RowsOnDemand {
    /// Nothing is found yet.
    ///
    /// # Panics
    /// If the resolution is odd or not in 8..=4096, or the positions are no multiple of four.
    pub fn new(enclosure: Arc<Enclosure>, settings: Settings) -> Self {
        assert!(settings.positions.is_multiple_of(REPLICATES), "{} hemicubes are not four sets", settings.positions);
        let source = Self { enclosure, settings, kept: Mutex::default() };
        source.hemicube().check();
        source
    }

    /// The geometry.
    pub fn enclosure(&self) -> &Arc<Enclosure> {
        &self.enclosure
    }

    /// How rows are found.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Bytes that a solve needs at least: for rows that are found together.
    pub fn least_memory(sides: usize) -> u64 {
        BYTES_PER_ENTRY * (sides * BATCH.min(sides)) as u64
    }

    /// How many rows were found, those found again included.
    pub fn found(&self) -> u64 {
        self.kept().found
    }

    /// Bytes held.
    pub fn memory_bytes(&self) -> usize {
        self.kept().bytes as usize
    }

    /// Row `i`, found now if it is not kept.
    pub fn row(&self, i: usize) -> Arc<Row> {
        if let Some(row) = self.kept().rows.get(&i) {
            return row.clone();
        }
        self.find(&[i]).remove(0)
    }

    fn find(&self, sides: &[usize]) -> Vec<Arc<Row>> {
        let found: Vec<Arc<Row>> = hemicube::replicates_of(&self.enclosure, sides, &self.hemicube(), REPLICATES)
            .iter()
            .zip(sides)
            .map(|(rows, &side)| Arc::new(Row::of(rows, self.enclosure.area(side))))
            .collect();
        let mut kept = self.kept();
        let bytes: u64 = found.iter().map(|row| row.bytes()).sum();
        if kept.bytes + bytes > self.settings.memory_limit {
            kept.rows.clear();
            kept.bytes = 0;
        }
        kept.bytes += bytes;
        kept.found += sides.len() as u64;
        kept.rows.extend(sides.iter().copied().zip(found.iter().cloned()));
        found
    }

    fn hemicube(&self) -> hemicube::Settings {
        let Settings { resolution, positions, seed, .. } = self.settings;
        hemicube::Settings { resolution, positions, seed }
    }

    fn kept(&self) -> std::sync::MutexGuard<'_, Kept> {
        self.kept.lock().expect("nothing panics while it holds the rows")
    }
}

impl Rows for RowsOnDemand {
    fn count(&self) -> usize {
        self.enclosure.sides()
    }

    fn find_row(&self, i: usize, row: &mut Vec<(u32, f64)>) {
        row.clear();
        row.extend(self.row(i).entries.iter().map(|&(j, g)| (j, f64::from(g))));
    }

    fn batch(&self, i: usize) -> usize {
        if self.kept().rows.contains_key(&i) { 1 } else { BATCH }
    }

    fn prepare(&self, rows: &[usize]) {
        let missing: Vec<usize> = {
            let kept = self.kept();
            rows.iter().copied().filter(|i| !kept.rows.contains_key(i)).collect()
        };
        if !missing.is_empty() {
            self.find(&missing);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use radiosity_geometry::Patches;
    use radiosity_operator::Control;

    /// The inside of the unit cube, each face cut in four.
    fn cube() -> Arc<Enclosure> {
        let mut polygons = Vec::new();
        for (axis, high) in [(0, false), (0, true), (1, false), (1, true), (2, false), (2, true)] {
            for (s, t) in [(0.0, 0.0), (0.5, 0.0), (0.0, 0.5), (0.5, 0.5)] {
                let corner = |u: f64, v: f64| {
                    let mut p = [0.0; 3];
                    p[axis] = if high { 1.0 } else { 0.0 };
                    (p[(axis + 1) % 3], p[(axis + 2) % 3]) = (s + u, t + v);
                    DVec3::from_array(p)
                };
                let [a, b, c, d] = [corner(0.0, 0.0), corner(0.5, 0.0), corner(0.5, 0.5), corner(0.0, 0.5)];
                polygons.push(if high { [a, d, c, b] } else { [a, b, c, d] });
            }
        }
        let n = polygons.len();
        Arc::new(Enclosure::new(Patches::new(polygons, vec![0; n], (0..n as u32).collect(), vec![false; n])))
    }

    fn source(memory_limit: u64) -> RowsOnDemand {
        RowsOnDemand::new(cube(), Settings { resolution: 64, positions: 8, seed: 5, memory_limit })
    }

    #[test]
    fn a_row_is_the_same_whenever_it_is_asked_for() {
        let (rows, few) = (source(u64::MAX), source(800));
        rows.prepare(&[3, 17, 20]);
        assert_eq!((rows.found(), rows.batch(3), rows.batch(4)), (3, 1, BATCH));
        let (mut row, mut again) = (Vec::new(), Vec::new());
        for i in [17, 0, 3, 23, 0, 17] {
            rows.find_row(i, &mut row);
            few.find_row(i, &mut again);
            assert_eq!(row, again);
            let sets = hemicube::replicates_of(rows.enclosure(), &[i], &rows.hemicube(), 4).remove(0);
            for &(j, g) in &row {
                let of = |set: &Vec<(u32, f64)>| set.iter().filter(|e| e.0 == j).map(|e| e.1).sum::<f64>();
                let mean = sets.iter().map(of).sum::<f64>() / 4.0;
                assert!((g - 0.25 * mean).abs() < 1e-7 * mean);
            }
        }
        assert_eq!(rows.found(), 5);
        // Rows of 20 entries take 240 bytes, so three are kept: the fourth has all forgotten, and two are found again.
        assert_eq!((few.found(), few.memory_bytes()), (6, 3 * 240));
    }

    #[test]
    fn rows_close_and_their_error_is_of_the_size_of_their_error() {
        let (rows, fine) = (source(u64::MAX), 64);
        let settings = hemicube::Settings { resolution: 256, positions: fine, seed: 77 };
        let truth = hemicube::rows(rows.enclosure(), &settings, &Control::default()).unwrap();
        let (mut squares, mut estimate) = (0.0, 0.0);
        for i in 0..rows.count() {
            let row = rows.row(i);
            let sum: f64 = row.entries.iter().map(|e| f64::from(e.1)).sum();
            assert!((sum - 0.25).abs() < 1e-6);
            for ((entry, error), e) in row.entries.iter().zip(&row.error).zip(truth.row(i)) {
                squares += (f64::from(entry.1) - 0.25 * e.1).powi(2);
                estimate += f64::from(*error).powi(2);
            }
        }
        // Over some 480 entries of three degrees of freedom each, many of them alike.
        assert!(estimate > 0.5 * squares && estimate < 2.0 * squares, "{estimate} {squares}");
    }
}
