//! Which pairs of clusters exchange, and how: the walk down the tree.

use super::clusters::{Clusters, Cone};
use crate::facets::Node;

/// Pairs of nodes, the first before the second in the tree or the same: one piece of work.
pub type Task = Vec<(usize, usize)>;

/// How two clusters are dealt with.
pub enum Relation {
    /// They lie behind each other, or in parts of the scene that see nothing of each other.
    None,
    /// They are well apart for their size.
    Far,
    /// They are apart enough if little goes between.
    Wide,
    /// Leaves that are not.
    Near,
    /// Their parts tell.
    Split([Option<(usize, usize)>; 3]),
}

/// Facets of the clusters whose pairs with all after them are one piece of work: so many that near pairs of neighbours
/// are found in the same piece, so few that an interrupted build loses little.
const MOST_IN_TASK: usize = 1024;

/// The sum of radii over the distance below which clusters may be linked through which little goes.
const WIDE: f64 = 1.2;

/// At least so many pieces of work, so that threads have enough.
const FEWEST_TASKS: usize = 64;

/// The pieces of work, in the order of the tree.
pub fn plan(clusters: &Clusters, separation: f64, contact: f64) -> Vec<Task> {
    let nodes = &clusters.facets.nodes;
    if nodes.is_empty() {
        return Vec::new();
    }
    let most = (clusters.facets.list.len() / FEWEST_TASKS).clamp(1, MOST_IN_TASK);
    let is_small = |n: usize| nodes[n].range.len() <= most || nodes[n].children.is_none();
    let firsts = firsts(nodes, is_small);
    let mut tasks = vec![Vec::new(); firsts.len()];
    let mut open = vec![(0, 0)];
    while let Some((a, b)) = open.pop() {
        let split = if is_small(a) { None } else { Some(clusters.relation(a, b, separation, contact)) };
        match split {
            Some(Relation::None) => {}
            Some(Relation::Split(pairs)) => open.extend(pairs.into_iter().flatten().rev()),
            _ => tasks[firsts.partition_point(|&f| f <= nodes[a].range.start) - 1].push((a, b)),
        }
    }
    tasks
}

/// Where the greatest clusters that are small start.
fn firsts(nodes: &[Node], is_small: impl Fn(usize) -> bool) -> Vec<usize> {
    let (mut firsts, mut open) = (Vec::new(), vec![0]);
    while let Some(n) = open.pop() {
        match nodes[n].children {
            Some([left, right]) if !is_small(n) => open.extend([right, left]),
            _ => firsts.push(nodes[n].range.start),
        }
    }
    firsts
}

impl Clusters {
    /// How two nodes are dealt with, `a` before `b` in the tree or the same.
    pub fn relation(&self, a: usize, b: usize, separation: f64, contact: f64) -> Relation {
        let (first, second) = (&self.facets.nodes[a], &self.facets.nodes[b]);
        if a == b {
            return match first.children {
                Some([l, r]) => Relation::Split([Some((l, l)), Some((l, r)), Some((r, r))]),
                None => Relation::Near,
            };
        }
        if self.are_parted(a, b) {
            return Relation::None;
        }
        if is_behind(first, self.cone(a), second, contact) || is_behind(second, self.cone(b), first, contact) {
            return Relation::None;
        }
        let (ra, rb) = (radius(first), radius(second));
        let distance = middle(first).distance(middle(second));
        if ra + rb <= separation * distance {
            return Relation::Far;
        }
        if ra + rb <= WIDE * distance {
            return Relation::Wide;
        }
        self.split(a, b)
    }

    /// The pairs of one of two nodes with the parts of the other, which is the larger.
    pub fn split(&self, a: usize, b: usize) -> Relation {
        let (first, second) = (&self.facets.nodes[a], &self.facets.nodes[b]);
        let (ra, rb) = (radius(first), radius(second));
        match (first.children, second.children) {
            (None, None) => Relation::Near,
            (Some([l, r]), None) => Relation::Split([Some((l, b)), Some((r, b)), None]),
            (Some([l, r]), Some(_)) if ra >= rb => Relation::Split([Some((l, b)), Some((r, b)), None]),
            (_, Some([l, r])) => Relation::Split([Some((a, l)), Some((a, r)), None]),
        }
    }
}

fn middle(node: &Node) -> glam::DVec3 {
    0.5 * (node.bounds.low + node.bounds.high)
}

fn radius(node: &Node) -> f64 {
    0.5 * (node.bounds.high - node.bounds.low).length()
}

/// Whether all of one cluster lies behind every facet of the other, by their boxes.
fn is_behind(other: &Node, cone: Cone, of: &Node, contact: f64) -> bool {
    // `cone` belongs to `other`: is `of` behind it?
    if cone.is_one() {
        let plane = other.bounds.extent_along(cone.axis).0;
        return of.bounds.extent_along(cone.axis).1 <= plane + contact;
    }
    let between = middle(of) - middle(other);
    let (distance, radii) = (between.length(), radius(of) + radius(other));
    if radii >= distance || cone.cosine <= 0.0 {
        return false;
    }
    // The angle from the axis is at least that of the middles less that of the balls; behind is a right angle off any
    // direction of the cone.
    let angle = (cone.axis.dot(between) / distance).clamp(-1.0, 1.0).acos() - (radii / distance).asin();
    angle - cone.cosine.acos() >= std::f64::consts::FRAC_PI_2
}
