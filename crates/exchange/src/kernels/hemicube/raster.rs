//! Scan conversion: which polygon is nearest in the direction of each pixel.
//!
//! Edges are planes through the source, `e = a x b` for an edge from a to b, and a pixel of direction d is inside when
//! `d . e` has one sign for all edges (Olano and Greer 1997, *Triangle scan conversion using 2D homogeneous
//! coordinates*). That is the result of clipping at the horizon and at the face without clipping: no new vertices
//! arise, and edges that reach behind the source or through it need no care.
//!
//! On every row of pixels an edge is a number: where it crosses. A polygon owns the pixels from its left to its right
//! crossing, the left one included. The two polygons at an edge compute its crossing from the same vertices by the same
//! operations; swapping the ends of the edge changes signs and no bits. So the right end of one is the left end of the
//! other: no pixel is left out and none is taken by both. Around a vertex spans follow on one another in the same way,
//! in whatever order rounding puts their ends.
//!
//! The lines of edges have no ends, so a row that passes a vertex by less than the rounding of double precision, some
//! 1e-13 of a pixel, may find the lines of two edges in the wrong order. Turned at random, no pixel comes that close.
//!
//! The inverse of depth is linear on a face. It is kept in single precision, evaluated in double precision every
//! eight pixels; of equals the one drawn first stays. What absorbs is drawn a little farther away than it is.

use super::face::{Grid, Window, mirrored, on_face};
use super::merge::{LANES, Merge, Pixels8};
use super::polygons::Polygons;
use super::view::{Item, View};

/// Depths and owners of the pixels of one face, rows padded by what a write of `LANES` pixels may reach over the end.
pub(super) struct Pixels {
    /// Pixels to a row, padding included.
    stride: usize,
    /// The inverse of the depth along the face's axis, in extents of the scene; 0 where there is nothing.
    nearness: Vec<f32>,
    /// What is seen; beyond the last column something that no owner equals.
    owner: Vec<u32>,
}

impl Pixels {
    /// Room for the largest face.
    pub fn new(resolution: usize) -> Self {
        let stride = resolution.next_multiple_of(LANES) + LANES;
        let count = stride * resolution;
        Self { stride, nearness: vec![0.0; count], owner: vec![u32::MAX; count] }
    }

    /// Forgets all that was drawn.
    #[inline(always)]
    fn clear(&mut self, grid: &Grid, nothing: u32) {
        let count = grid.rows * self.stride;
        self.nearness[..count].fill(0.0);
        for row in self.owner[..count].chunks_exact_mut(self.stride) {
            row[..grid.columns].fill(nothing);
        }
    }

    /// Owners along a row, with what follows the last column.
    #[inline(always)]
    pub fn owners(&self, row: usize) -> &[u32] {
        &self.owner[row * self.stride..(row + 1) * self.stride]
    }

    /// Nearness along a row.
    pub fn nearness(&self, row: usize) -> &[f32] {
        &self.nearness[row * self.stride..(row + 1) * self.stride]
    }

    /// Eight pixels from an index.
    #[inline(always)]
    fn eight(&mut self, at: usize) -> Pixels8<'_> {
        Pixels8 {
            nearness: (&mut self.nearness[at..at + LANES]).try_into().unwrap(),
            owner: (&mut self.owner[at..at + LANES]).try_into().unwrap(),
        }
    }
}

/// Draws what was chosen for a face.
#[inline(always)]
pub(super) fn draw<M: Merge>(face: usize, grid: &Grid, view: &View, polygons: &Polygons, pixels: &mut Pixels) {
    pixels.clear(grid, polygons.nothing());
    for item in &view.items[face] {
        if let Some(outline) = Outline::new(face, grid, view, polygons, item) {
            outline.fill::<M>(grid, &item.window, pixels);
        }
    }
}

/// Where a line of the grid crosses an edge: `at = slope * v + start`, in columns.
#[derive(Clone, Copy)]
struct Crossing {
    slope: f64,
    start: f64,
}

/// The lines that bound a polygon on a face, and its depth.
struct Outline {
    /// Pixels lie at these crossings or to the right of them.
    left: [Crossing; 4],
    /// Pixels lie to the left of these crossings.
    right: [Crossing; 4],
    /// How many of them count on either side; the rest exclude nothing.
    edges: usize,
    /// Rows that edges along rows leave, ends excluded.
    rows: [usize; 2],
    /// Nearness is `plane . (u, v, 1)`.
    plane: [f64; 3],
    owner: u32,
}

/// Nearness of backs and obstructions, relative to what it is: they lose where single precision cannot tell. At the
/// silhouette of a solid its faces from behind are as near as those from the front, and so are the two sides of a
/// sheet; there the one that can be seen counts. Rounding is a few units in the last place; this is eight.
const BLACK_NEARNESS: f64 = 1.0 - 8.0 * f32::EPSILON as f64;

/// An edge this level is taken to lie along the rows: its crossings move by more pixels a row than there are digits.
const LEVEL: f64 = 1e-13;

impl Outline {
    #[inline(always)]
    fn new(face: usize, grid: &Grid, view: &View, polygons: &Polygons, item: &Item) -> Option<Self> {
        let [a, b, c, d] = polygons.corners[item.polygon as usize];
        // Not by `map`: closures that stay outside are compiled without the entry point's instruction set.
        let (a, b) = (on_face(face, view.vertex(a)), on_face(face, view.vertex(b)));
        let (c, d) = (on_face(face, view.vertex(c)), on_face(face, view.vertex(d)));
        // By differences, which lose nothing to the distance of the polygon.
        let normal = cross(minus(c, a), minus(d, b));
        let height = dot(normal, a);
        let sign = if height > 0.0 { 1.0 } else { -1.0 };
        let owner = polygons.owners[item.polygon as usize][((height > 0.0) ^ mirrored(face)) as usize];
        let inverse = if owner == polygons.black() { BLACK_NEARNESS } else { 1.0 } / height;
        if !inverse.is_finite() {
            return None;
        }
        let none = |start: f64| [Crossing { slope: 0.0, start }; 4];
        let mut outline = Self {
            left: none(f64::NEG_INFINITY),
            right: none(f64::INFINITY),
            edges: 0,
            rows: item.window.rows.map(usize::from),
            plane: [normal[0] * inverse, normal[1] * inverse, normal[2] * inverse],
            owner,
        };
        outline.bound(grid, [a, b, c, d], sign);
        Some(outline)
    }

    /// Sorts the edges into left and right ones.
    #[inline(always)]
    fn bound(&mut self, grid: &Grid, p: [[f64; 3]; 4], sign: f64) {
        let edges = edge_planes(&p);
        let (mut slope, mut start, mut level) = ([0.0; 4], [0.0; 4], [false; 4]);
        for k in 0..4 {
            let (a, b, c) = (edges[0][k], edges[1][k], edges[2][k]);
            let along = -1.0 / a;
            slope[k] = b * along * grid.scale;
            start[k] = (c * along + 1.0) * grid.scale - 0.5;
            level[k] = a.abs() <= LEVEL * b.abs();
        }
        let (mut lefts, mut rights) = (0, 0);
        for k in 0..4 {
            let crossing = Crossing { slope: slope[k], start: start[k] };
            if level[k] {
                self.bound_rows(grid, sign * edges[1][k], sign * edges[2][k]);
            } else if sign * edges[0][k] > 0.0 {
                self.left[lefts & 3] = crossing;
                lefts += 1;
            } else {
                self.right[rights & 3] = crossing;
                rights += 1;
            }
        }
        self.edges = lefts.max(rights);
    }

    /// Keeps the rows on the inner side of an edge along the rows, where `b v + c > 0`.
    #[inline(always)]
    fn bound_rows(&mut self, grid: &Grid, b: f64, c: f64) {
        if b == 0.0 {
            // A line nowhere on the face; or, c = 0, an edge without length, as the last of a triangle.
            if c < 0.0 {
                self.rows[1] = 0;
            }
            return;
        }
        let crossing = grid.row(-c / b).clamp(-1.0, grid.rows as f64).ceil().max(0.0) as usize;
        if b > 0.0 {
            self.rows[0] = self.rows[0].max(crossing);
        } else {
            self.rows[1] = self.rows[1].min(crossing);
        }
    }

    /// Writes the pixels where the polygon is nearest.
    #[inline(always)]
    fn fill<M: Merge>(&self, grid: &Grid, window: &Window, pixels: &mut Pixels) {
        let step = self.plane[0] * grid.step;
        let mut ramp = [0f32; LANES];
        for (k, ramp) in ramp.iter_mut().enumerate() {
            *ramp = (step * k as f64) as f32;
        }
        for first in (self.rows[0]..self.rows[1]).step_by(BATCH) {
            let spans = self.spans(grid, window, first);
            for k in 0..BATCH.min(self.rows[1] - first) {
                let start = (first + k) * pixels.stride;
                let (mut column, end) = (spans.from[k] as usize, spans.to[k] as usize);
                while column < end {
                    let base = (spans.origin[k] + step * column as f64) as f32;
                    M::merge(pixels.eight(start + column), end - column, base, &ramp, self.owner);
                    column += LANES;
                }
            }
        }
    }

    /// The spans of `BATCH` rows.
    #[inline(always)]
    fn spans(&self, grid: &Grid, window: &Window, first: usize) -> Spans {
        let [low, high] = window.columns.map(f64::from);
        let (mut left, mut right, mut v, mut origin) = ([low; BATCH], [high; BATCH], [0.0; BATCH], [0.0; BATCH]);
        let [du, dv, d1] = self.plane;
        for k in 0..BATCH {
            v[k] = grid.v((first + k) as f64);
            origin[k] = (d1 + du * grid.u(0.0)) + dv * v[k];
        }
        for edge in 0..self.edges {
            let (l, r) = (self.left[edge], self.right[edge]);
            for k in 0..BATCH {
                let (l, r) = (l.slope * v[k] + l.start, r.slope * v[k] + r.start);
                left[k] = if l > left[k] { l } else { left[k] };
                right[k] = if r < right[k] { r } else { right[k] };
            }
        }
        Spans { from: round_up(left, low, high), to: round_up(right, low, high), origin }
    }
}

/// What a polygon covers of `BATCH` rows.
struct Spans {
    /// First columns.
    from: [u32; BATCH],
    /// Columns after the last.
    to: [u32; BATCH],
    /// Nearness at column 0.
    origin: [f64; BATCH],
}

/// Rows whose spans are found together.
const BATCH: usize = 8;

/// Rounds up to whole numbers from `low` to `high`.
#[inline(always)]
fn round_up(x: [f64; BATCH], low: f64, high: f64) -> [u32; BATCH] {
    // Doubles from 2^52 to 2^53 are the whole numbers: the sum rounds, and its low bits are the result.
    const SHIFT: f64 = (1u64 << 52) as f64;
    let mut up = [0; BATCH];
    for k in 0..BATCH {
        let x = if x[k] > low { x[k] } else { low };
        let x = if x < high { x } else { high };
        let nearest = x + SHIFT;
        let short = nearest - SHIFT < x;
        up[k] = nearest.to_bits() as u32 + short as u32;
    }
    up
}

/// The planes through the source and each edge, component by component. An edge taken the other way has the same
/// bits with other signs.
#[inline(always)]
fn edge_planes(p: &[[f64; 3]; 4]) -> [[f64; 4]; 3] {
    let mut planes = [[0.0; 4]; 3];
    for k in 0..4 {
        let n = cross(p[k], p[(k + 1) & 3]);
        for (plane, n) in planes.iter_mut().zip(n) {
            plane[k] = n;
        }
    }
    planes
}

#[inline(always)]
fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline(always)]
fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
