//! Lines in the plane of a face: where they cross, and which points lie on them.

use std::collections::HashMap;

use glam::{DVec2, DVec3};

use super::boxes::{BoxTree, Extent};
use super::points::Points;

/// A line by the numbers of its ends, the lower one first.
pub(super) type Line = [u32; 2];

/// Lines that run into each other deeper than this are given up.
const DEEPEST: usize = 64;

/// The line between two points, whichever way it runs.
pub(super) fn line(a: u32, b: u32) -> Line {
    [a.min(b), a.max(b)]
}

/// Coordinates in the plane of a face.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    origin: DVec3,
    across: DVec3,
    up: DVec3,
}

impl Frame {
    /// A frame whose first axis runs from `origin` to `towards`, anticlockwise about `normal`.
    pub(super) fn new(origin: DVec3, towards: DVec3, normal: DVec3) -> Self {
        let across = (towards - origin).normalize_or_zero();
        Self { origin, across, up: normal.cross(across) }
    }

    pub(super) fn flat(&self, p: DVec3) -> DVec2 {
        DVec2::new((p - self.origin).dot(self.across), (p - self.origin).dot(self.up))
    }
}

/// The points on each line, from its first end to its second. A line is divided alike wherever it occurs.
#[derive(Default)]
pub(super) struct Divisions(HashMap<Line, Vec<u32>>);

impl Divisions {
    fn add(&mut self, line: Line, point: u32) {
        if !line.contains(&point) {
            self.0.entry(line).or_default().push(point);
        }
    }

    /// Puts the points of every line in order.
    pub(super) fn sort(&mut self, points: &Points) {
        for (&[a, b], on) in &mut self.0 {
            let (start, along) = (points.place(a), points.place(b) - points.place(a));
            let position = |id: u32| (points.place(id) - start).dot(along);
            on.sort_unstable_by(|&p, &q| position(p).total_cmp(&position(q)).then(p.cmp(&q)));
            on.dedup();
        }
    }

    /// Pushes the points from behind `from` up to and with `to`, those on parts of the line among them.
    pub(super) fn walk(&self, from: u32, to: u32, visit: &mut impl FnMut(u32)) {
        self.walk_at(from, to, 0, visit);
    }

    fn walk_at(&self, from: u32, to: u32, depth: usize, visit: &mut impl FnMut(u32)) {
        let Some(on) = self.0.get(&line(from, to)).filter(|_| depth < DEEPEST) else {
            return visit(to);
        };
        let mut here = from;
        let mut step = |next: u32| {
            self.walk_at(here, next, depth + 1, visit);
            here = next;
        };
        if from < to {
            on.iter().for_each(|&p| step(p));
        } else {
            on.iter().rev().for_each(|&p| step(p));
        }
        step(to);
    }
}

/// Notes which points of one plane lie on which of its lines, and makes points where lines cross.
pub(super) fn divide(lines: &[Line], frame: &Frame, tolerance: f64, points: &mut Points, divisions: &mut Divisions) {
    let extent = |points: &Points, &[a, b]: &Line| Extent::around([points.place(a), points.place(b)]).grown(tolerance);
    let extents: Vec<_> = lines.iter().map(|line| extent(points, line)).collect();
    let tree = BoxTree::new(&extents);
    let mut near = Vec::new();

    let mut ends: Vec<u32> = lines.iter().flatten().copied().collect();
    ends.sort_unstable();
    ends.dedup();
    for id in ends {
        let p = points.place(id);
        tree.meeting(&Extent { low: p, high: p }, &mut near);
        for &i in &near {
            let [a, b] = lines[i as usize];
            if is_on(p, points.place(a), points.place(b), tolerance) {
                divisions.add([a, b], id);
            }
        }
    }

    for (i, &first) in lines.iter().enumerate() {
        tree.meeting(&extents[i], &mut near);
        for &j in near.iter().filter(|&&j| j as usize > i) {
            let second = lines[j as usize];
            let [p, q] = first.map(|id| points.place(id));
            let [r, s] = second.map(|id| points.place(id));
            let Some(t) = crossing([p, q].map(|p| frame.flat(p)), [r, s].map(|p| frame.flat(p)), tolerance) else {
                continue;
            };
            let id = points.id(p.lerp(q, t));
            divisions.add(first, id);
            divisions.add(second, id);
        }
    }
}

/// Whether a point lies on a segment and on neither end.
fn is_on(p: DVec3, a: DVec3, b: DVec3, tolerance: f64) -> bool {
    let length = a.distance(b);
    let along = (b - a) / length;
    let position = along.dot(p - a);
    position > tolerance && position < length - tolerance && (p - a - position * along).length() <= tolerance
}

/// Where along the first segment the second crosses it; `None` if they only touch.
fn crossing([p, q]: [DVec2; 2], [r, s]: [DVec2; 2], tolerance: f64) -> Option<f64> {
    let side = |a: DVec2, b: DVec2, c: DVec2| {
        let height = (b - a).normalize_or_zero().perp_dot(c - a);
        if height.abs() <= tolerance { 0.0 } else { height }
    };
    let (h, k) = (side(r, s, p), side(r, s, q));
    (h * k < 0.0 && side(p, q, r) * side(p, q, s) < 0.0).then(|| h / (h - k))
}
