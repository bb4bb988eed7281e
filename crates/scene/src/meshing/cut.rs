//! Cutting of one polygon whose edges are divided already.
//!
//! A quad with as many segments on opposite sides becomes a bilinear grid, a triangle with as many on all sides a
//! regular subdivision. Any other piece is cut in two by a chord from the middle of its most divided side, and so on.

use std::ops::ControlFlow;

use glam::DVec3;

/// How much longer than asked for an edge may be: files carry 32-bit floats, and 0.3 m in them is no reason to cut
/// an edge into four pieces of 0.075 m where three of 0.1 m were meant.
const TOLERANCE: f64 = 1e-6;

/// What a triangle is worth against a quad of as good a shape: a mesh of quads has half the patches.
const TRIANGLE_WORTH: f64 = 0.8;

/// The number of segments of an edge, none longer than `max_edge`.
pub(super) fn segments(length: f64, max_edge: f64) -> u32 {
    // Not `clamp`, which keeps what is no number, such as an infinite length over an infinite edge.
    (length / max_edge * (1.0 - TOLERANCE)).ceil().max(1.0).min(f64::from(u32::MAX)) as u32
}

/// A run along the division points of an edge.
#[derive(Clone, Copy, Debug)]
pub(super) struct Side {
    /// The ends of the whole edge in sorted order, so that its division points are the same from both sides.
    low: DVec3,
    high: DVec3,
    /// The segments of the whole edge.
    segments: u32,
    /// Where this side starts and ends among the division points; downwards if it runs against the order.
    from: u32,
    to: u32,
}

impl Side {
    /// The whole edge from `a` to `b`.
    pub(super) fn new(a: DVec3, b: DVec3, segments: u32) -> Self {
        let is_sorted = a.to_array() <= b.to_array();
        let (low, high) = if is_sorted { (a, b) } else { (b, a) };
        let (from, to) = if is_sorted { (0, segments) } else { (segments, 0) };
        Self { low, high, segments, from, to }
    }

    fn count(&self) -> u32 {
        self.from.abs_diff(self.to)
    }

    /// Division point `i` from the start.
    pub(super) fn point(&self, i: u32) -> DVec3 {
        let k = if self.from <= self.to { self.from + i } else { self.from - i };
        match k {
            0 => self.low,
            k if k == self.segments => self.high,
            k => self.low + (self.high - self.low) * (f64::from(k) / f64::from(self.segments)),
        }
    }

    fn start(&self) -> DVec3 {
        self.point(0)
    }

    fn length(&self) -> f64 {
        self.low.distance(self.high) * f64::from(self.count()) / f64::from(self.segments)
    }

    /// The parts before and after division point `i`.
    fn split(&self, i: u32) -> [Side; 2] {
        let middle = if self.from <= self.to { self.from + i } else { self.from - i };
        [Side { to: middle, ..*self }, Side { from: middle, ..*self }]
    }
}

/// What takes the patches of a piece; it may break off.
pub(super) trait Sink {
    /// Takes a quad with as many segments on opposite sides.
    fn quad(&mut self, sides: &[Side; 4]) -> ControlFlow<()>;
    /// Takes a triangle with as many segments on all sides.
    fn triangle(&mut self, sides: &[Side; 3]) -> ControlFlow<()>;
}

/// Counts patches and breaks off when there are more than enough.
pub(super) struct Counter {
    pub(super) count: usize,
    pub(super) enough: usize,
}

impl Counter {
    fn add(&mut self, nu: u32, nv: u32) -> ControlFlow<()> {
        self.count = self.count.saturating_add((nu as usize).saturating_mul(nv as usize));
        if self.count > self.enough { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

impl Sink for Counter {
    fn quad(&mut self, sides: &[Side; 4]) -> ControlFlow<()> {
        self.add(sides[0].count(), sides[1].count())
    }

    fn triangle(&mut self, sides: &[Side; 3]) -> ControlFlow<()> {
        self.add(sides[0].count(), sides[0].count())
    }
}

/// Collects the corners of patches; a triangle repeats its last.
#[derive(Default)]
pub(super) struct Collector {
    pub(super) polygons: Vec<[DVec3; 4]>,
}

impl Sink for Collector {
    fn quad(&mut self, sides: &[Side; 4]) -> ControlFlow<()> {
        let (nu, nv) = (sides[0].count(), sides[1].count());
        for j in 0..nv {
            for i in 0..nu {
                let corner = |i, j| grid_point(sides, i, j);
                self.polygons.push([corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)]);
            }
        }
        ControlFlow::Continue(())
    }

    fn triangle(&mut self, sides: &[Side; 3]) -> ControlFlow<()> {
        let n = sides[0].count();
        let corner = |i, j| barycentric_point(sides, i, j);
        for j in 0..n {
            for i in 0..n - j {
                let (right, top) = (corner(i + 1, j), corner(i, j + 1));
                self.polygons.push([corner(i, j), right, top, top]);
                if i + j + 1 < n {
                    let across = corner(i + 1, j + 1);
                    self.polygons.push([right, across, top, top]);
                }
            }
        }
        ControlFlow::Continue(())
    }
}

/// Point `(i, j)` of the bilinear grid over a quad; on its sides exactly their division points.
fn grid_point(sides: &[Side; 4], i: u32, j: u32) -> DVec3 {
    let (nu, nv) = (sides[0].count(), sides[1].count());
    if j == 0 {
        return sides[0].point(i);
    } else if i == nu {
        return sides[1].point(j);
    } else if j == nv {
        return sides[2].point(nu - i);
    } else if i == 0 {
        return sides[3].point(nv - j);
    }
    let (u, v) = (f64::from(i) / f64::from(nu), f64::from(j) / f64::from(nv));
    let [a, b, c, d] = [0, 1, 2, 3].map(|k: usize| sides[k].start());
    // Differences first: what is flat along an axis stays exactly flat.
    a + (b - a) * (u * (1.0 - v)) + (c - a) * (u * v) + (d - a) * ((1.0 - u) * v)
}

/// Point `(i, j)` of the regular subdivision of a triangle; on its sides exactly their division points.
fn barycentric_point(sides: &[Side; 3], i: u32, j: u32) -> DVec3 {
    let n = sides[0].count();
    if j == 0 {
        return sides[0].point(i);
    } else if i + j == n {
        return sides[1].point(j);
    } else if i == 0 {
        return sides[2].point(n - j);
    }
    let [a, b, c] = [0, 1, 2].map(|k: usize| sides[k].start());
    a + (b - a) * (f64::from(i) / f64::from(n)) + (c - a) * (f64::from(j) / f64::from(n))
}

/// A triangle or a convex quad with divided sides.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    sides: [Side; 4],
    n: usize,
}

impl Piece {
    /// A piece of three or four sides, each of which starts where the one before it ends.
    pub(super) fn new(sides: impl IntoIterator<Item = Side>) -> Self {
        let mut sides = sides.into_iter();
        let first = sides.next().expect("a piece has sides");
        let mut piece = Self { sides: [first; 4], n: 1 };
        for side in sides {
            piece.sides[piece.n] = side;
            piece.n += 1;
        }
        piece
    }

    /// Cuts the piece into patches with no edge longer than `max_edge`.
    pub(super) fn cut(&self, max_edge: f64, sink: &mut impl Sink) -> ControlFlow<()> {
        if self.is_regular() {
            return self.emit(sink);
        }
        let [first, second] = self.halves(max_edge);
        first.cut(max_edge, sink)?;
        second.cut(max_edge, sink)
    }

    /// Hands over a piece that needs no cutting.
    pub(super) fn emit(&self, sink: &mut impl Sink) -> ControlFlow<()> {
        let [a, b, c, _] = self.sides;
        if self.n == 4 { sink.quad(&self.sides) } else { sink.triangle(&[a, b, c]) }
    }

    fn is_regular(&self) -> bool {
        let [a, b, c, d] = self.sides.map(|side| side.count());
        if self.n == 4 { a == c && b == d } else { a == b && b == c }
    }

    /// The two pieces of the best chord from the middle of the most divided side.
    fn halves(&self, max_edge: f64) -> [Piece; 2] {
        let piece = self.most_divided_first();
        let mut best = (f64::NEG_INFINITY, None);
        for m in middles(piece.sides[0].count()) {
            for (side, position) in piece.chord_ends() {
                let halves = piece.along_chord(m, side, position, max_edge);
                let score = score(&halves);
                // A clear improvement is needed, so that ties do not hang on rounding.
                if score > best.0 + 1e-9 {
                    best = (score, Some(halves));
                }
            }
        }
        best.1.expect("a side of several segments has a middle, and a piece has an opposite corner")
    }

    /// The same piece, turned so that its most divided side, the longest of these, comes first.
    fn most_divided_first(&self) -> Piece {
        let mut first = 0;
        for i in 1..self.n {
            let (a, b) = (&self.sides[i], &self.sides[first]);
            let is_longer = a.count() == b.count() && a.length() > b.length() * (1.0 + 1e-9);
            if a.count() > b.count() || is_longer {
                first = i;
            }
        }
        Piece::new((0..self.n).map(|i| self.sides[(first + i) % self.n]))
    }

    /// Where a chord from the first side may end, so that both pieces have three or four sides: side and position.
    fn chord_ends(&self) -> impl Iterator<Item = (usize, u32)> + '_ {
        let corners = (2..self.n).map(|side| (side, 0));
        let sides = if self.n == 4 { 2..=2 } else { 1..=2 };
        let middles = sides.flat_map(|side| middles(self.sides[side].count()).map(move |m| (side, m)));
        corners.chain(middles)
    }

    /// The two pieces along the chord from position `m` of the first side to `position` of `side`.
    fn along_chord(&self, m: u32, side: usize, position: u32, max_edge: f64) -> [Piece; 2] {
        let [before, after] = self.sides[0].split(m);
        let (a, b) = (after.start(), self.sides[side].point(position));
        let n = segments(a.distance(b), max_edge);
        let [first, rest] = self.sides[side].split(position);
        let part = (position > 0).then_some(first);
        let one = [after].into_iter().chain(self.sides[1..side].iter().copied()).chain(part);
        let other = [rest].into_iter().chain(self.sides[side + 1..self.n].iter().copied()).chain([before]);
        // Begin the second piece with the chord turned around; both take the same division points.
        [Piece::new(one.chain([Side::new(b, a, n)])), Piece::new([Side::new(a, b, n)].into_iter().chain(other))]
    }

    /// Its area and the quality of its shape: 1 for a square, [`TRIANGLE_WORTH`] for an equilateral triangle.
    pub(super) fn area_and_quality(&self) -> (f64, f64) {
        let p = |i: usize| self.sides[i].start();
        let squares: f64 = self.sides[..self.n].iter().map(|side| side.length().powi(2)).sum();
        if self.n == 4 {
            let area = 0.5 * (p(2) - p(0)).cross(p(3) - p(1)).length();
            (area, 4.0 * area / squares)
        } else {
            let area = 0.5 * (p(1) - p(0)).cross(p(2) - p(0)).length();
            (area, TRIANGLE_WORTH * 4.0 * 3f64.sqrt() * area / squares)
        }
    }
}

/// The one or two inner positions in the middle of so many segments.
fn middles(count: u32) -> impl Iterator<Item = u32> {
    let (low, high) = (count / 2, count.div_ceil(2));
    (low..=high).filter(move |&m| m > 0 && m < count)
}

/// How good two pieces are: the worse of them, and what they are on average.
fn score(halves: &[Piece; 2]) -> f64 {
    let [(a0, q0), (a1, q1)] = [halves[0].area_and_quality(), halves[1].area_and_quality()];
    q0.min(q1) + (a0 * q0 + a1 * q1) / (a0 + a1)
}
