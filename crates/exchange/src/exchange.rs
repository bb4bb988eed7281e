//! The exchange of an enclosure, however it is kept.

use radiosity_operator::{Hierarchical, Operator, Symmetric, Update};

/// G between all sides, m2.
#[derive(Clone, Debug)]
pub enum Exchange {
    /// Each pair by itself.
    Pairs(Symmetric),
    /// Near pairs by themselves, far ones in blocks of rank one.
    Links(Hierarchical),
}

impl Exchange {
    /// The pairs, where each is kept by itself.
    pub fn pairs(&self) -> Option<&Symmetric> {
        match self {
            Exchange::Pairs(pairs) => Some(pairs),
            Exchange::Links(_) => None,
        }
    }

    /// The entries of row `i` that are not zero, columns ascending.
    pub fn row(&self, i: usize) -> Vec<(u32, f64)> {
        match self {
            Exchange::Pairs(pairs) => pairs.row(i),
            Exchange::Links(links) => links.row(i),
        }
    }

    /// Entries that are not zero, both triangles; of rank one, those of their blocks.
    pub fn count(&self) -> usize {
        match self {
            Exchange::Pairs(pairs) => pairs.count(),
            Exchange::Links(links) => links.count(),
        }
    }

    /// All entries that are not zero as compressed rows, columns ascending: offsets, columns, values.
    pub fn to_csr(&self) -> (Vec<usize>, Vec<u32>, Vec<f64>) {
        let links = match self {
            Exchange::Pairs(pairs) => return pairs.to_csr(),
            Exchange::Links(links) => links,
        };
        links.expect_rows();
        let (mut offsets, mut columns, mut values) = (vec![0], Vec::new(), Vec::new());
        for i in 0..links.len() {
            for (j, v) in links.row(i) {
                columns.push(j);
                values.push(v);
            }
            offsets.push(columns.len());
        }
        (offsets, columns, values)
    }

    /// Position in the matrix -> number of the side.
    pub fn order(&self) -> &[u32] {
        match self {
            Exchange::Pairs(pairs) => pairs.order(),
            Exchange::Links(links) => links.order(),
        }
    }

    /// Checks what was read of a file, before the first use.
    ///
    /// # Errors
    /// If an index is out of bounds, in words.
    pub fn check_indices(&self) -> Result<(), String> {
        match self {
            Exchange::Pairs(pairs) => pairs.check_indices(),
            Exchange::Links(links) => links.check_indices(),
        }
    }

    /// Bytes held.
    pub fn memory_bytes(&self) -> usize {
        match self {
            Exchange::Pairs(pairs) => pairs.memory_bytes(),
            Exchange::Links(links) => links.memory_bytes(),
        }
    }

    fn operator(&self) -> &dyn Operator {
        match self {
            Exchange::Pairs(pairs) => pairs,
            Exchange::Links(links) => links,
        }
    }
}

impl Operator for Exchange {
    fn len(&self) -> usize {
        self.operator().len()
    }

    fn apply(&self, x: &[f64], y: &mut [f64], columns: usize) {
        self.operator().apply(x, y, columns);
    }

    fn read_row(&self, i: usize, row: &mut Vec<(u32, f64)>) {
        self.operator().read_row(i, row);
    }

    fn expect_rows(&self) {
        self.operator().expect_rows();
    }

    fn sweep(&self, x: &mut [f64], columns: usize, update: &mut Update) {
        self.operator().sweep(x, columns, update);
    }
}
