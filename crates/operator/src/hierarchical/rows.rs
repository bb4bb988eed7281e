//! Rows of a hierarchical matrix: all blocks that a position is in.
//!
//! To look through all blocks takes a product's time, so that an index by position is kept for who reads many rows.

use super::{Hierarchical, Link};

/// No position: what stands for numbers without a row.
const NOWHERE: u32 = u32::MAX;

/// Positions that share a list of blocks.
const BUCKET: usize = 32;

/// Which blocks and near entries a position is in.
#[derive(Clone, Debug, Default)]
pub(super) struct Index {
    /// Number -> position.
    position: Vec<u32>,
    /// Of each bucket of positions the links, by their part and their number in it.
    links: Vec<Vec<(u32, u32)>>,
    /// Of each part where the weights of each link start.
    weights: Vec<Vec<u32>>,
    /// Of each position where its near entries start, and where the last end.
    starts: Vec<usize>,
    near: Vec<(u32, f32)>,
}

impl Index {
    pub fn memory_bytes(&self) -> usize {
        let links: usize = self.links.iter().map(Vec::len).sum();
        let weights: usize = self.weights.iter().map(Vec::len).sum();
        4 * (self.position.len() + weights) + 8 * (links + self.starts.len() + self.near.len())
    }
}

impl Hierarchical {
    pub(super) fn indexed(&self) -> Index {
        let n = self.order.len();
        let mut index = Index {
            position: vec![NOWHERE; self.len],
            links: vec![Vec::new(); n.div_ceil(BUCKET)],
            starts: vec![0; n + 1],
            ..Index::default()
        };
        self.order.iter().enumerate().for_each(|(p, &k)| index.position[k as usize] = p as u32);
        for (number, part) in self.parts.iter().enumerate() {
            let (mut weights, mut next) = (Vec::with_capacity(part.links()), 0);
            part.for_each_link(|link| {
                for range in [&link.rows, &link.columns].into_iter().filter(|r| !r.is_empty()) {
                    for bucket in range.start / BUCKET..=(range.end - 1) / BUCKET {
                        let (list, entry) = (&mut index.links[bucket], (number as u32, weights.len() as u32));
                        // Rows and columns may share a bucket.
                        if list.last() != Some(&entry) {
                            list.push(entry);
                        }
                    }
                }
                weights.push(next);
                next += (link.rows.len() + link.columns.len()) as u32;
            });
            index.weights.push(weights);
            for (p, columns, _) in part.near_rows() {
                index.starts[p + 1] += columns.len();
                columns.iter().for_each(|&q| index.starts[q as usize + 1] += 1);
            }
        }
        for p in 0..n {
            index.starts[p + 1] += index.starts[p];
        }
        let mut next = index.starts.clone();
        index.near = vec![(0, 0.0); index.starts[n]];
        for part in &self.parts {
            for (p, columns, values) in part.near_rows() {
                for (&q, &v) in columns.iter().zip(values) {
                    index.near[next[p]] = (q, v);
                    index.near[next[q as usize]] = (p as u32, v);
                    next[p] += 1;
                    next[q as usize] += 1;
                }
            }
        }
        index
    }

    /// The entries of row `i` that are not zero, each column once, in no order.
    pub(super) fn read_row_of(&self, i: usize, row: &mut Vec<(u32, f64)>) {
        row.clear();
        match self.index.get() {
            Some(index) => self.read_indexed(index, i, row),
            None => self.read_all(i, row),
        }
        row.retain(|e| e.1 != 0.0);
    }

    fn read_indexed(&self, index: &Index, i: usize, row: &mut Vec<(u32, f64)>) {
        let position = index.position[i];
        if position == NOWHERE {
            return;
        }
        let p = position as usize;
        for &(part, number) in &index.links[p / BUCKET] {
            let start = index.weights[part as usize][number as usize] as usize;
            self.add_link(&self.parts[part as usize].link_at(number as usize, start), p, row);
        }
        let near = &index.near[index.starts[p]..index.starts[p + 1]];
        row.extend(near.iter().map(|&(q, v)| (self.order[q as usize], f64::from(v))));
    }

    fn read_all(&self, i: usize, row: &mut Vec<(u32, f64)>) {
        let Some(position) = self.order.iter().position(|&k| k as usize == i) else { return };
        for part in &self.parts {
            part.for_each_link(|link| self.add_link(&link, position, row));
            for (p, columns, values) in part.near_rows() {
                if p == position {
                    row.extend(columns.iter().zip(values).map(|(&q, &v)| (self.order[q as usize], f64::from(v))));
                } else if let Some(k) = columns.iter().position(|&q| q as usize == position) {
                    row.push((self.order[p], f64::from(values[k])));
                }
            }
        }
    }

    /// What a block has in the row at a position.
    fn add_link(&self, link: &Link, position: usize, row: &mut Vec<(u32, f64)>) {
        let (own, range, other) = if link.rows.contains(&position) {
            (link.u[position - link.rows.start], &link.columns, link.w)
        } else if link.columns.contains(&position) {
            (link.w[position - link.columns.start], &link.rows, link.u)
        } else {
            return;
        };
        row.extend(range.clone().zip(other).map(|(q, &v)| (self.order[q], f64::from(own) * f64::from(v))));
    }
}
