//! A tree of boxes, for what is near what.

use glam::DVec3;

/// The most boxes that a leaf holds.
const LEAF: usize = 6;

/// A box by its two extreme corners.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    pub(super) low: DVec3,
    pub(super) high: DVec3,
}

impl Extent {
    /// The box around some points.
    pub(super) fn around(points: impl IntoIterator<Item = DVec3>) -> Self {
        let nothing = Self { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY };
        points.into_iter().fold(nothing, |all, p| Self { low: all.low.min(p), high: all.high.max(p) })
    }

    pub(super) fn grown(self, by: f64) -> Self {
        Self { low: self.low - by, high: self.high + by }
    }

    fn joined(self, other: &Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    fn meets(&self, other: &Self) -> bool {
        self.low.cmple(other.high).all() && other.low.cmple(self.high).all()
    }
}

/// A node: a leaf if it has boxes of its own, else two more nodes, the first of which follows it.
struct Node {
    extent: Extent,
    boxes: std::ops::Range<usize>,
    second: usize,
}

/// Boxes halved again and again at the median of their middles.
pub(super) struct BoxTree<'a> {
    boxes: &'a [Extent],
    order: Vec<u32>,
    nodes: Vec<Node>,
}

impl<'a> BoxTree<'a> {
    pub(super) fn new(boxes: &'a [Extent]) -> Self {
        let mut tree = Self { boxes, order: (0..boxes.len() as u32).collect(), nodes: Vec::new() };
        if !boxes.is_empty() {
            tree.build(0..boxes.len());
        }
        tree
    }

    fn build(&mut self, range: std::ops::Range<usize>) {
        let part = &mut self.order[range.clone()];
        let extent =
            part.iter().map(|&i| self.boxes[i as usize]).reduce(|a, b| a.joined(&b)).expect("no node is empty");
        let node = self.nodes.len();
        self.nodes.push(Node { extent, boxes: range.clone(), second: 0 });
        if part.len() <= LEAF {
            return;
        }
        let axis = (extent.high - extent.low).max_position();
        let middle = |i: u32| self.boxes[i as usize].low[axis] + self.boxes[i as usize].high[axis];
        let half = part.len() / 2;
        part.select_nth_unstable_by(half, |&a, &b| middle(a).total_cmp(&middle(b)).then(a.cmp(&b)));
        self.nodes[node].boxes = 0..0;
        self.build(range.start..range.start + half);
        self.nodes[node].second = self.nodes.len();
        self.build(range.start + half..range.end);
    }

    /// Collects the boxes that meet `query`, in ascending order.
    pub(super) fn meeting(&self, query: &Extent, found: &mut Vec<u32>) {
        found.clear();
        if !self.nodes.is_empty() {
            self.collect(0, query, found);
            found.sort_unstable();
        }
    }

    fn collect(&self, node: usize, query: &Extent, found: &mut Vec<u32>) {
        let Node { extent, boxes, second } = &self.nodes[node];
        if !extent.meets(query) {
            return;
        }
        if *second == 0 {
            let near = |&&i: &&u32| self.boxes[i as usize].meets(query);
            found.extend(self.order[boxes.clone()].iter().filter(near));
        } else {
            self.collect(node + 1, query, found);
            self.collect(*second, query, found);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_what_a_search_of_all_finds() {
        let at = |i: u32| DVec3::new(f64::from(i * 7 % 31), f64::from(i * 5 % 17), f64::from(i % 3));
        let boxes: Vec<_> = (0..200).map(|i| Extent::around([at(i), at(i) + f64::from(i % 4)])).collect();
        let tree = BoxTree::new(&boxes);
        let mut found = Vec::new();
        for query in &boxes {
            tree.meeting(query, &mut found);
            let expected: Vec<u32> = (0..200).filter(|&i| boxes[i as usize].meets(query)).collect();
            assert_eq!(found, expected);
        }
        BoxTree::new(&[]).meeting(&boxes[0], &mut found);
        assert!(found.is_empty());
    }
}
