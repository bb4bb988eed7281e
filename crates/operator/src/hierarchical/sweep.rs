//! A sweep over a hierarchical matrix, in one pass over it.
//!
//! All rows of a far block come before all of its columns. So when the first of its rows is due, its columns are still
//! as they were, and what they send is the same for all its rows; when the last is done, what its rows send is the same
//! for all its columns. Near entries are pulled and pushed row by row.

use super::{Hierarchical, Link, add, dot};
use crate::sweep::{Update, row_by_row};

impl Hierarchical {
    pub(super) fn sweep_any(&self, x: &mut [f64], columns: usize, update: &mut Update) {
        match columns {
            1 => self.sweep_with::<1>(x, update),
            3 => self.sweep_with::<3>(x, update),
            4 => self.sweep_with::<4>(x, update),
            // Other numbers of bands are rare.
            _ => row_by_row(self, x, columns, update),
        }
    }

    fn sweep_with<const C: usize>(&self, x: &mut [f64], update: &mut Update) {
        let (x, _) = x.as_chunks_mut::<C>();
        let n = self.order.len();
        let mut ordered: Vec<[f64; C]> = self.order.iter().map(|&k| x[k as usize]).collect();
        let mut sent = vec![[0.0; C]; n];
        let mut is_missing = vec![true; x.len()];
        let links = self.all_links();
        let by = |key: fn(&Link) -> usize| {
            let mut numbers: Vec<u32> = (0..links.len() as u32).collect();
            numbers.sort_by_key(|&k| key(&links[k as usize]));
            numbers
        };
        let (starting, ending) = (by(|l| l.rows.start), by(|l| l.rows.end));
        let (mut starting, mut ending) = (starting.iter().peekable(), ending.iter().peekable());
        let mut near: Vec<(usize, &[u32], &[f32])> = self.parts.iter().flat_map(|part| part.near_rows()).collect();
        near.sort_by_key(|row| row.0);
        let mut near = near.chunk_by(|a, b| a.0 == b.0).peekable();
        for p in 0..n {
            while let Some(&k) = ending.next_if(|&&k| links[k as usize].rows.end <= p) {
                let link = &links[k as usize];
                add(link.w, &dot(link.u, &ordered[link.rows.clone()]), &mut sent[link.columns.clone()]);
            }
            while let Some(&k) = starting.next_if(|&&k| links[k as usize].rows.start <= p) {
                let link = &links[k as usize];
                add(link.u, &dot(link.w, &ordered[link.columns.clone()]), &mut sent[link.rows.clone()]);
            }
            let rows = near.next_if(|rows| rows[0].0 == p).unwrap_or(&[]);
            let entries = || rows.iter().flat_map(|(_, columns, values)| columns.iter().zip(*values));
            let mut sum = sent[p];
            for (&q, &v) in entries() {
                (0..C).for_each(|c| sum[c] += f64::from(v) * ordered[q as usize][c]);
            }
            let i = self.order[p] as usize;
            is_missing[i] = false;
            update(i, &sum, &mut ordered[p]);
            let from = ordered[p];
            for (&q, &v) in entries() {
                (0..C).for_each(|c| sent[q as usize][c] += f64::from(v) * from[c]);
            }
            x[i] = from;
        }
        for i in (0..x.len()).filter(|&i| is_missing[i]) {
            update(i, &[0.0; C], &mut x[i]);
        }
    }

    fn all_links(&self) -> Vec<Link<'_>> {
        let mut links = Vec::with_capacity(self.links());
        self.parts.iter().for_each(|part| part.for_each_link(|link| links.push(link)));
        links
    }
}
