//! Chosen pairs of leaves, where not all pairs are wanted.

use super::{Scene, Scratch, Settings, Tally, Task};
use crate::enclosure::Enclosure;
use crate::facets::{Facets, Node};
use crate::visibility::Blockers;
use std::sync::Arc;

/// What pairs of leaves are measured in.
pub(crate) struct Selection<'a> {
    pub enclosure: &'a Enclosure,
    /// All facets, and the leaves they are in.
    pub facets: &'a Facets,
    pub blockers: &'a Arc<Blockers>,
    pub settings: &'a Settings,
    /// Per facet: how much more than the mean what it sends matters; empty where all matter alike.
    pub importance: &'a [f64],
}

impl Selection<'_> {
    /// Measures pairs of leaves `(a, b)`, by the numbers of their nodes, `a` before `b` in the tree or the same, sorted.
    ///
    /// `candidates` lists the blockers that may stand between two leaves; `visit(i, entries)` takes what facet `i`
    /// exchanges with facets after it, m2, zeros left out.
    pub fn measure(
        &self,
        pairs: &[(usize, usize)],
        scratch: &mut Scratch,
        mut candidates: impl FnMut(&Node, &Node, &mut Vec<u32>),
        mut visit: impl FnMut(usize, &mut dyn Iterator<Item = (u32, f32)>),
    ) -> Tally {
        let mut leaves: Vec<usize> = pairs.iter().flat_map(|&(a, b)| [a, b]).collect();
        leaves.sort_unstable();
        leaves.dedup();
        let (facets, numbers) = self.gathered(&leaves);
        let n = facets.list.len();
        let mut scene = Scene::new(self.enclosure, facets, self.blockers.clone(), self.settings);
        if !self.importance.is_empty() {
            scene.importance = numbers.iter().map(|&i| self.importance[i as usize]).collect();
        }
        let mut tally = Tally::default();
        for pairs in pairs.chunk_by(|p, q| p.0 == q.0) {
            let local = |leaf: usize| leaves.binary_search(&leaf).expect("a leaf of a pair");
            let leaf = local(pairs[0].0);
            let mut task = Task::new(&scene, leaf, scratch);
            let mut list = task.scratch.take_list();
            for &(a, b) in pairs {
                list.clear();
                candidates(&self.facets.nodes[a], &self.facets.nodes[b], &mut list);
                task.leaf(&scene.facets.nodes[local(b)], &list);
            }
            task.scratch.lists.push(list);
            task.tally.rays = std::mem::take(&mut task.scratch.rays.cast);
            tally = tally.plus(task.tally);
            let mut rest = task.values.as_slice();
            for i in task.node.range.clone() {
                let (row, after) = rest.split_at(n - 1 - i);
                rest = after;
                let entries = row.iter().zip(&numbers[i + 1..]).filter(|e| *e.0 != 0.0);
                visit(numbers[i] as usize, &mut entries.map(|(&v, &j)| (j, v as f32)));
            }
            let values = std::mem::take(&mut task.values);
            scratch.values = values;
        }
        tally
    }

    /// The facets of some leaves by themselves, and their numbers among all.
    fn gathered(&self, leaves: &[usize]) -> (Facets, Vec<u32>) {
        let (mut list, mut nodes, mut numbers) = (Vec::new(), Vec::new(), Vec::new());
        for &leaf in leaves {
            let node = &self.facets.nodes[leaf];
            let first = list.len();
            list.extend_from_slice(&self.facets.list[node.range.clone()]);
            numbers.extend(node.range.clone().map(|i| i as u32));
            nodes.push(Node { range: first..list.len(), ..node.clone() });
        }
        (Facets { list, nodes, extent: self.facets.extent }, numbers)
    }
}
