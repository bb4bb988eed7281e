//! The exchange that blockers hide between two polygons.
//!
//! The visible part of one polygon from a point of the other is exact ([`Fragments`]); what is left is an integral over
//! the other. Its integrand is continuous, with kinks where a corner passes behind an edge, and jumps only where a
//! blocker stands on the polygon: there it is cut first. The rest is adaptive: triangles with the seven points of
//! Radon (1948), halved where the estimate of the error is largest until its sum is small enough.
//!
//! Points can overlook what is small, and two measures are taken against it:
//!
//! - What is hidden by something small and near changes within that distance. So cells are halved until none is larger
//!   than a blocker beside it is narrow or far, unless all they could add is nothing that matters.
//! - Where all points of a cell see all of the other polygon, or nothing of it, the cell is looked at from the corners of
//!   the other: from there the whole of the cell is seen exactly, be the lit or hidden part ever so narrow. If they
//!   disagree, that cell's part is integrated over the other polygon instead.

use super::blockers::{Blocker, vector_area};
use super::fragments::Fragments;
use crate::convex::{quarters, range, split};
use crate::facets::{Bounds, Facet};
use glam::DVec3;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// A polygon of a facet that takes part in an exchange: in front of the other's plane.
#[derive(Clone, Copy)]
pub struct End<'a> {
    /// The facet.
    pub facet: &'a Facet,
    /// The part of it.
    pub polygon: &'a [DVec3],
}

/// An integral and how far off it may be.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate {
    /// m2.
    pub value: f64,
    /// m2.
    pub error: f64,
    /// Whether all is hidden, as far as anything looked: then nothing is left, whatever rounding makes of the value.
    pub is_all: bool,
}

impl Estimate {
    /// All of an exchange of so many m2.
    pub fn all(whole: f64) -> Self {
        Self { value: whole, error: 0.0, is_all: true }
    }
}

/// Cells in which the adaptive rule ends, whatever the error: some hundred thousand points.
const MOST_CELLS: usize = 20_000;

/// Buffers kept between pairs.
#[derive(Default)]
pub struct Hidden {
    fragments: Fragments,
    order: Vec<u32>,
}

impl Hidden {
    /// The part of `A1 F12`, m2, that blockers take from the unoccluded exchange, to about `tolerance` m2.
    pub fn exchange(
        &mut self,
        first: End,
        second: End,
        blockers: &[Blocker],
        candidates: &[u32],
        tolerance: f64,
        contact: f64,
    ) -> Estimate {
        let feet = |end: &End| feet(end, blockers, candidates, contact).len();
        // Integrate over the end that no blocker stands on, else over the smaller.
        let from_first = match feet(&first).cmp(&feet(&second)) {
            Ordering::Less => true,
            Ordering::Greater => false,
            Ordering::Equal => first.facet.area <= second.facet.area,
        };
        let (source, target) = if from_first { (first, second) } else { (second, first) };
        self.order_by_size(source, blockers, candidates);
        let Self { fragments, order } = self;
        let between = Between { blockers, order, contact };
        View { source, target, between, fragments }.integral(tolerance, true)
    }

    /// What looms largest comes first: it leaves fewest fragments to those after it.
    fn order_by_size(&mut self, source: End, blockers: &[Blocker], candidates: &[u32]) {
        let size = |k: &u32| {
            let blocker = &blockers[*k as usize];
            let r = 0.5 * (blocker.bounds.low + blocker.bounds.high) - source.facet.centre;
            let across = (blocker.bounds.high - blocker.bounds.low).length_squared();
            across * blocker.normal.dot(r).abs() / (r.length_squared() * r.length()).max(f64::MIN_POSITIVE)
        };
        self.order.clear();
        self.order.extend_from_slice(candidates);
        self.order.sort_by(|a, b| size(b).total_cmp(&size(a)).then(a.cmp(b)));
    }
}

/// What stands between two polygons.
#[derive(Clone, Copy)]
struct Between<'a> {
    blockers: &'a [Blocker],
    /// Which of them, and in which order they are looked at.
    order: &'a [u32],
    contact: f64,
}

/// One polygon as points of another see it.
struct View<'a> {
    source: End<'a>,
    target: End<'a>,
    between: Between<'a>,
    fragments: &'a mut Fragments,
}

/// Cells to begin with at most.
const MOST_FIRST_CELLS: usize = 4_000;

/// A share of what a point sees that is rounding.
const NOTHING: f64 = 1e-11;

impl View<'_> {
    /// The form factors from a point of the source to the target: all of it, and what of it is hidden.
    fn at(&mut self, x: DVec3) -> (f64, f64) {
        let (normal, Between { blockers, order, contact }) = (self.source.facet.normal, self.between);
        let whole = self.fragments.visible(x, normal, self.target.polygon, std::iter::empty(), contact);
        let list = order.iter().map(|&k| &blockers[k as usize]);
        (whole, whole - self.fragments.visible(x, normal, self.target.polygon, list, contact))
    }

    /// The integral over the source of what is hidden. `may_turn`: whether cells may be looked at from the target.
    fn integral(&mut self, tolerance: f64, may_turn: bool) -> Estimate {
        let Between { blockers, order, contact } = self.between;
        let near: Vec<Near> = order.iter().map(|&k| Near::new(&blockers[k as usize])).collect();
        let feet = feet(&self.source, blockers, order, contact);
        let mut waiting: Vec<[DVec3; 3]> = cut_at(self.source, &feet, contact)
            .iter()
            .flat_map(|cell| cell[1..].windows(2).map(|pair| [cell[0], pair[0], pair[1]]))
            .collect();
        let mut heap = BinaryHeap::new();
        while let Some(triangle) = waiting.pop() {
            let Some(cell) = self.cell(triangle) else { continue };
            let is_coarse = waiting.len() + heap.len() < MOST_FIRST_CELLS
                && cell.whole > 0.1 * tolerance
                && near.iter().any(|n| n.is_coarse(&triangle));
            if is_coarse {
                waiting.extend(quarters(&triangle));
            } else {
                heap.push(if may_turn { self.checked(cell, tolerance) } else { cell });
            }
        }
        self.refine(heap, tolerance, may_turn)
    }

    /// Splits the worst cell until the errors sum to no more than the tolerance.
    fn refine(&mut self, mut heap: BinaryHeap<Cell>, tolerance: f64, may_turn: bool) -> Estimate {
        let total = |heap: &BinaryHeap<Cell>| heap.iter().map(|c| c.error).sum::<f64>();
        let mut error = total(&heap);
        while error > tolerance && heap.len() < MOST_CELLS {
            let Some(worst) = heap.pop() else { break };
            error -= worst.error;
            for child in self.split(&worst) {
                let child = if may_turn { self.checked(child, tolerance) } else { child };
                error += child.error;
                heap.push(child);
            }
            if heap.len().is_multiple_of(256) {
                error = total(&heap);
            }
        }
        let is_all = !heap.is_empty() && heap.iter().all(|c| c.uniform == Uniform::Hidden);
        Estimate { value: heap.iter().map(|c| c.value).sum(), error: total(&heap), is_all }
    }

    /// A cell with its integral; none if the triangle has no area.
    fn cell(&mut self, corners: [DVec3; 3]) -> Option<Cell> {
        let [a, b, c] = corners;
        let area = area_of(&corners);
        if area == 0.0 {
            return None;
        }
        let (mut all_hidden, mut all_visible, mut most) = (true, true, 0.0f64);
        let mut f = |x: DVec3| {
            let (whole, hidden) = self.at(x);
            all_hidden &= hidden >= (1.0 - NOTHING) * whole;
            all_visible &= hidden <= NOTHING * whole;
            most = most.max(whole);
            hidden
        };
        let middle = f((a + b + c) / 3.0);
        let mut value = CENTRE * middle;
        let mut orbits = [0.0; 2];
        for (sum, (t, weight)) in orbits.iter_mut().zip(ORBITS) {
            for (p, q, r) in [(a, b, c), (b, c, a), (c, a, b)] {
                *sum += f((1.0 - 2.0 * t) * p + t * (q + r));
            }
            value += weight * *sum;
        }
        // With the centre, each orbit alone makes a rule of degree 2.
        let roughness = orbits
            .iter()
            .zip(ORBITS)
            .map(|(sum, (t, _))| {
                let spread = (1.0 - 2.0 * t) * (1.0 - 2.0 * t) + 2.0 * t * t - 1.0 / 3.0;
                let weight = 1.0 / (6.0 * spread);
                (value - ((1.0 - weight) * middle + weight / 3.0 * sum)).abs()
            })
            .fold(0.0, f64::max);
        // So do its corners. What is all but hidden comes into view at a corner first: from where a single convex
        // blocker hides all of the target is a convex set. Corners themselves may lie in a blocker's plane.
        let mut inset = |p: DVec3| f(p + CORNER_INSET * ((a + b + c) / 3.0 - p));
        let by_corners = 0.75 * middle + corners.map(&mut inset).iter().sum::<f64>() / 12.0;
        let roughness = area * roughness.max((value - by_corners).abs());
        let uniform = if all_hidden {
            Uniform::Hidden
        } else if all_visible {
            Uniform::Visible
        } else {
            Uniform::Not
        };
        Some(Cell { corners, whole: area * most, value: area * value, roughness, error: roughness, uniform })
    }

    /// The four halves of a cell.
    fn split(&mut self, cell: &Cell) -> Vec<Cell> {
        let mut children: Vec<Cell> = quarters(&cell.corners).into_iter().filter_map(|t| self.cell(t)).collect();
        // What the halves changed is the error the whole had. Smooth parts lose nearly all of it, kinks about half;
        // the halves share that by how rough they look themselves.
        let change = (cell.value - children.iter().map(|c| c.value).sum::<f64>()).abs();
        let rough: f64 = children.iter().map(|c| c.roughness).sum();
        let left = (0.5 * change).max(ROUGH_SHARE * rough);
        for child in &mut children {
            child.error = if rough > 0.0 { left * child.roughness / rough } else { 0.0 };
        }
        children
    }

    /// A cell that looks all hidden or all visible, looked at from the target: integrated over that if it is neither.
    fn checked(&mut self, cell: Cell, tolerance: f64) -> Cell {
        if cell.uniform == Uniform::Not || cell.whole <= 0.1 * tolerance || !self.is_mistaken(&cell) {
            return cell;
        }
        let (source, target, between) = (self.target, self.source, self.between);
        let target = End { polygon: &cell.corners, ..target };
        let turned = View { source, target, between, fragments: &mut *self.fragments }.integral(0.1 * tolerance, false);
        let uniform = if turned.is_all { Uniform::Hidden } else { Uniform::Not };
        Cell { value: turned.value, error: turned.error, uniform, ..cell }
    }

    /// Whether corners and middle of the target see the cell otherwise than its points see the target.
    fn is_mistaken(&mut self, cell: &Cell) -> bool {
        let (source, target, between) = (self.target, self.source, self.between);
        let target = End { polygon: &cell.corners, ..target };
        let mut turned = View { source, target, between, fragments: &mut *self.fragments };
        let corners = source.polygon;
        let middle = corners.iter().sum::<DVec3>() / corners.len() as f64;
        corners.iter().map(|&c| c + CORNER_INSET * (middle - c)).chain([middle]).any(|y| {
            let (whole, hidden) = turned.at(y);
            match cell.uniform {
                Uniform::Hidden => hidden < (1.0 - NOTHING) * whole,
                _ => hidden > NOTHING * whole,
            }
        })
    }
}

/// How finely what a blocker hides varies near it.
struct Near {
    bounds: Bounds,
    /// Its narrower extent.
    width: f64,
}

impl Near {
    fn new(blocker: &Blocker) -> Self {
        let corners = &blocker.corners;
        let longest = (0..corners.len()).map(|k| corners[k].distance(corners[(k + 1) % corners.len()]));
        let longest = longest.fold(0.0, f64::max);
        Self { bounds: blocker.bounds, width: vector_area(corners).length() / longest }
    }

    /// Whether what it hides may vary within a triangle more than a few points tell.
    fn is_coarse(&self, triangle: &[DVec3; 3]) -> bool {
        let [a, b, c] = *triangle;
        let size = a.distance(b).max(b.distance(c)).max(c.distance(a));
        let middle = (a + b + c) / 3.0;
        let apart = middle.clamp(self.bounds.low, self.bounds.high).distance(middle);
        size > 1.5 * apart.max(self.width)
    }
}

fn area_of([a, b, c]: &[DVec3; 3]) -> f64 {
    0.5 * (*b - *a).cross(*c - *a).length()
}

/// What all points of a cell say.
#[derive(Clone, Copy, PartialEq)]
enum Uniform {
    Hidden,
    Visible,
    Not,
}

/// A triangle with the integral over it.
struct Cell {
    corners: [DVec3; 3],
    /// The integral if all were hidden, at most.
    whole: f64,
    value: f64,
    /// How far rules of lower degree are from the value.
    roughness: f64,
    error: f64,
    uniform: Uniform,
}

impl PartialEq for Cell {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Cell {}
impl PartialOrd for Cell {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Cell {
    fn cmp(&self, other: &Self) -> Ordering {
        // Ties are broken by place, so that the order of the heap is the same every time.
        let place = |c: &Self| c.corners[0].to_array().map(f64::to_bits);
        self.error.total_cmp(&other.error).then_with(|| place(self).cmp(&place(other)))
    }
}

/// Radon's two orbits of three points: the barycentric coordinate that two corners have, and the weight.
const ORBITS: [(f64, f64); 2] =
    [(0.101_286_507_323_456_34, 0.125_939_180_544_827_15), (0.470_142_064_105_115_1, 0.132_394_152_788_506_2)];
const CENTRE: f64 = 0.225;

/// The least error left of a cell, as a share of how rough it looks: halves may agree by chance where a kink is.
const ROUGH_SHARE: f64 = 0.1;

/// How far corners are moved toward the middle.
const CORNER_INSET: f64 = 1e-3;

/// Where blockers stand on the plane of an end, or pass through it: segments.
fn feet(end: &End, blockers: &[Blocker], candidates: &[u32], contact: f64) -> Vec<[DVec3; 2]> {
    let on = |blocker: &Blocker| -> Option<[DVec3; 2]> {
        let heights: Vec<f64> = blocker.corners.iter().map(|&c| end.facet.height(c)).collect();
        if heights.iter().all(|&h| h > contact) {
            return None;
        }
        let mut points = Vec::new();
        for (k, (&c, &h)) in blocker.corners.iter().zip(&heights).enumerate() {
            let next = (k + 1) % heights.len();
            if h.abs() <= contact {
                points.push(c);
            } else if h * heights[next] < 0.0 && heights[next].abs() > contact {
                points.push(c + h / (h - heights[next]) * (blocker.corners[next] - c));
            }
        }
        let far = |p: &DVec3| points.iter().copied().max_by(|a, b| a.distance(*p).total_cmp(&b.distance(*p)));
        let (p, q) = (far(points.first()?)?, far(&far(points.first()?)?)?);
        (p.distance(q) > contact).then_some([p, q])
    };
    let divides = |segment: &[DVec3; 2]| splits(end.polygon, end.facet.normal, segment, contact);
    candidates.iter().filter_map(|&k| on(&blockers[k as usize])).filter(divides).collect()
}

/// Whether a segment in the plane of a convex polygon divides it, at least in part.
fn splits(polygon: &[DVec3], normal: DVec3, [p, q]: &[DVec3; 2], contact: f64) -> bool {
    let across = normal.cross(*q - *p).normalize_or_zero();
    let (low, high) = range(polygon.iter().map(|c| across.dot(*c - *p)));
    if low >= -contact || high <= contact {
        return false;
    }
    // The stretch of the segment inside all edges.
    let (mut from, mut to) = (0.0f64, 1.0f64);
    for k in 0..polygon.len() {
        let (a, b) = (polygon[k], polygon[(k + 1) % polygon.len()]);
        let inward = normal.cross(b - a);
        let (hp, hq) = (inward.dot(*p - a), inward.dot(*q - a));
        if hp < 0.0 && hq < 0.0 {
            return false;
        }
        if hp < 0.0 {
            from = from.max(hp / (hp - hq));
        } else if hq < 0.0 {
            to = to.min(hp / (hp - hq));
        }
    }
    (to - from) * p.distance(*q) > contact
}

/// Cells beyond which feet are left to the adaptive rule.
const MOST_FEET_CELLS: usize = 64;

/// Cuts an end along the lines of the segments that divide it.
fn cut_at(end: End, feet: &[[DVec3; 2]], contact: f64) -> Vec<Vec<DVec3>> {
    let normal = end.facet.normal;
    let mut cells = vec![end.polygon.to_vec()];
    for foot in feet {
        if cells.len() >= MOST_FEET_CELLS {
            break;
        }
        cells = cells
            .into_iter()
            .flat_map(
                |cell| {
                    if splits(&cell, normal, foot, contact) { halves(&cell, normal, foot) } else { vec![cell] }
                },
            )
            .collect();
    }
    cells
}

/// The two parts of a convex polygon on either side of a line in its plane.
fn halves(polygon: &[DVec3], normal: DVec3, [p, q]: &[DVec3; 2]) -> Vec<Vec<DVec3>> {
    let across = normal.cross(*q - *p);
    let heights: Vec<f64> = polygon.iter().map(|c| across.dot(*c - *p)).collect();
    let (mut left, mut right) = (Vec::new(), Vec::new());
    split(polygon, &heights, &mut left, &mut right);
    vec![left, right]
}
