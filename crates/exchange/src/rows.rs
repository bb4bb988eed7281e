//! Form factors row by row, as a method measured them from one end.

/// Compressed rows of F: `(side, F)` from each side, sides in ascending order and none twice.
///
/// Nothing is symmetrised: the row of one end and the row of the other may disagree by the method's error.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rows {
    /// Where the entries of each side start; one more than sides.
    pub offsets: Vec<usize>,
    /// To which side, and the fraction that arrives there.
    pub entries: Vec<(u32, f64)>,
}

impl Rows {
    /// Joins rows in order.
    pub fn from_rows(rows: Vec<Vec<(u32, f64)>>) -> Self {
        let mut offsets = Vec::with_capacity(rows.len() + 1);
        offsets.push(0);
        for row in &rows {
            offsets.push(offsets.last().unwrap() + row.len());
        }
        Self { offsets, entries: rows.concat() }
    }

    /// The number of rows.
    pub fn len(&self) -> usize {
        self.offsets.len().saturating_sub(1)
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The entries of a row.
    pub fn row(&self, side: usize) -> &[(u32, f64)] {
        &self.entries[self.offsets[side]..self.offsets[side + 1]]
    }
}
