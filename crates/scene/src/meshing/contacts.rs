//! Lines along which faces touch or cross each other, put into the polygons to cut.
//!
//! Where a wall stands on a floor, light ends at a line (a discontinuity of order zero: Campbell and Fussell 1990;
//! Heckbert 1992; Lischinski, Tampieri and Greenberg 1992). A patch on both sides of it would carry light into the
//! dark. So every polygon is cut along the segments that others have in common with it, and the mesh conforms to what
//! stands on it. No polygon without such a line changes, unless a neighbour put a point on its outline.

mod boxes;
mod drawn;
mod lines;
mod meet;
mod points;
#[cfg(test)]
mod tests;
mod triangulate;

use std::borrow::Cow;
use std::collections::HashMap;

use glam::DVec3;

use super::faces::{self, Polygon};
use boxes::{BoxTree, Extent};
use drawn::Drawn;
use lines::{Divisions, Frame, Line, line};
use meet::{Sheet, meet};
use points::Points;

/// What is closer together than this part of the longest extent of the scene touches: files carry 32-bit floats, and
/// a plane through three rounded corners is off by a little more than one of them.
const TOUCHING: f64 = 4.0 * f32::EPSILON as f64;

/// How far off a line a point may be that lies on it, in tolerances: both were moved to where others are.
const ON_LINE: f64 = 2.0;

/// Polygons, and the lines that are drawn on some of them.
pub(super) struct Drawing {
    polygons: Vec<Polygon>,
    /// Those with lines, by the number of the polygon, in order.
    drawn: Vec<(usize, Drawn)>,
}

impl Drawing {
    /// Polygons without lines.
    pub(super) fn blank(polygons: Vec<Polygon>) -> Self {
        Self { polygons, drawn: Vec::new() }
    }

    /// Draws the lines along which polygons touch or cross each other or what only blocks.
    ///
    /// Where polygons meet they share points to the bit: those that differ by less than the tolerance become the one
    /// that comes first.
    pub(super) fn new(mut polygons: Vec<Polygon>, blockers: &[Polygon]) -> Self {
        let tolerance = tolerance(&polygons, blockers);
        let contacts = contacts(&polygons, blockers, tolerance);
        if contacts.is_empty() {
            return Self::blank(polygons);
        }
        let layout = Layout::new(&polygons, &contacts, tolerance);
        polygons.iter_mut().for_each(|polygon| layout.move_corners(polygon));
        let drawn = polygons.iter().enumerate().filter_map(|(i, polygon)| Some((i, layout.drawn(i, polygon)?)));
        let drawn = drawn.collect();
        Self { polygons, drawn }
    }

    pub(super) fn has_lines(&self) -> bool {
        !self.drawn.is_empty()
    }

    /// Triangles and convex quads that end at the lines, in the order of the polygons they are of, to be cut to
    /// `max_edge`: as few as there can be, or, where these would be needles, such as let a regular mesh run on between
    /// the lines.
    pub(super) fn pieces(&self, max_edge: f64) -> Cow<'_, [Polygon]> {
        if self.drawn.is_empty() {
            return Cow::Borrowed(&self.polygons);
        }
        let mut pieces = Vec::with_capacity(self.polygons.len());
        let mut next = 0;
        for (i, drawn) in &self.drawn {
            pieces.extend_from_slice(&self.polygons[next..*i]);
            pieces.extend(drawn.pieces(&self.polygons[*i], max_edge));
            next = i + 1;
        }
        pieces.extend_from_slice(&self.polygons[next..]);
        Cow::Owned(pieces)
    }
}

fn tolerance(polygons: &[Polygon], blockers: &[Polygon]) -> f64 {
    let extent = Extent::around(polygons.iter().chain(blockers).flat_map(|polygon| polygon.corners));
    TOUCHING * (extent.high - extent.low).max_element()
}

/// A segment that two faces have in common; the blockers are numbered after all polygons.
struct Contact {
    faces: [u32; 2],
    ends: [DVec3; 2],
}

/// All contacts, in order of the faces.
fn contacts(polygons: &[Polygon], blockers: &[Polygon], tolerance: f64) -> Vec<Contact> {
    let all = || (0u32..).zip(polygons.iter().chain(blockers));
    let mut index = Vec::new();
    let mut sheets = Vec::new();
    for (i, sheet) in all().filter_map(|(i, polygon)| Some((i, Sheet::new(polygon, tolerance)?))) {
        index.push(i);
        sheets.push(sheet);
    }
    let n_own = index.partition_point(|&i| (i as usize) < polygons.len());
    for (offset, part) in [(0, polygons), (polygons.len() as u32, blockers)] {
        for (polygon, edge) in faces::flush_edges(part) {
            if let Ok(k) = index.binary_search(&(polygon as u32 + offset)) {
                sheets[k].without_edge(edge);
            }
        }
    }

    let extents: Vec<_> = sheets.iter().map(|sheet| sheet.extent().grown(tolerance)).collect();
    let tree = BoxTree::new(&extents);
    let (mut near, mut segments, mut contacts) = (Vec::new(), Vec::new(), Vec::new());
    for i in 0..n_own {
        tree.meeting(&extents[i], &mut near);
        for &j in near.iter().filter(|&&j| j as usize > i) {
            meet(&sheets[i], &sheets[j as usize], tolerance, &mut segments);
            let faces = [index[i], index[j as usize]];
            contacts.extend(segments.iter().map(|&ends| Contact { faces, ends }));
        }
    }
    contacts
}

/// The lines on all polygons.
struct Layout {
    points: Points,
    /// The number of each corner that lines may run to, by its bits.
    corners: HashMap<[u64; 3], u32>,
    /// Polygon and line, in order.
    lines: Vec<(u32, Line)>,
    divisions: Divisions,
}

impl Layout {
    fn new(polygons: &[Polygon], contacts: &[Contact], tolerance: f64) -> Self {
        let mut layout = Self {
            points: Points::new(tolerance),
            corners: HashMap::new(),
            lines: Vec::new(),
            divisions: Divisions::default(),
        };
        let mut involved: Vec<u32> = contacts.iter().flat_map(|contact| contact.faces).collect();
        involved.sort_unstable();
        involved.dedup();
        involved.retain(|&i| (i as usize) < polygons.len());
        // Corners come first, so that other points move to them and not they to others.
        for &i in &involved {
            polygons[i as usize].own_corners().iter().for_each(|&corner| layout.number_corner(corner));
        }
        for Contact { faces, ends } in contacts {
            let [a, b] = ends.map(|end| layout.points.id(end));
            let own = faces.iter().filter(|&&i| a != b && (i as usize) < polygons.len());
            layout.lines.extend(own.map(|&i| (i, line(a, b))));
        }
        for &i in &involved {
            let outline = layout.outline(&polygons[i as usize]).expect("the corners of involved polygons are numbered");
            let edges = (0..outline.len()).map(|k| (i, line(outline[k], outline[(k + 1) % outline.len()])));
            layout.lines.extend(edges);
        }
        layout.lines.sort_unstable();
        layout.lines.dedup();
        for own in layout.lines.chunk_by(|a, b| a.0 == b.0) {
            let frame = frame(&polygons[own[0].0 as usize]);
            let lines: Vec<Line> = own.iter().map(|&(_, line)| line).collect();
            lines::divide(&lines, &frame, ON_LINE * tolerance, &mut layout.points, &mut layout.divisions);
        }
        layout.divisions.sort(&layout.points);
        layout
    }

    fn number_corner(&mut self, corner: DVec3) {
        let id = self.points.id(corner);
        self.corners.insert(bits(corner), id);
    }

    /// The numbers of the corners of a polygon, if all have one.
    fn outline(&self, polygon: &Polygon) -> Option<Vec<u32>> {
        polygon.own_corners().iter().map(|&corner| self.corners.get(&bits(corner)).copied()).collect()
    }

    /// Puts the corners of a polygon where others have theirs.
    fn move_corners(&self, polygon: &mut Polygon) {
        for corner in &mut polygon.corners {
            if let Some(&id) = self.corners.get(&bits(*corner)) {
                *corner = self.points.place(id);
            }
        }
    }

    /// What is drawn on a polygon; `None` if it stays whole.
    fn drawn(&self, index: usize, polygon: &Polygon) -> Option<Drawn> {
        let outline = self.divided_outline(polygon)?;
        let n = outline.len();
        let mut edges: Vec<Line> = (0..n).map(|i| line(outline[i], outline[(i + 1) % n])).collect();
        edges.sort_unstable();
        let first = self.lines.partition_point(|&(i, _)| (i as usize) < index);
        let own = self.lines[first..].iter().take_while(|&&(i, _)| i as usize == index);
        let mut lines = Vec::new();
        for &(_, [mut from, to]) in own {
            self.divisions.walk(from, to, &mut |next| {
                lines.push(line(from, next));
                from = next;
            });
        }
        lines.sort_unstable();
        lines.dedup();
        lines.retain(|line| edges.binary_search(line).is_err());
        if lines.is_empty() && n == polygon.own_corners().len() {
            return None;
        }
        Drawn::new(polygon, &outline, &lines, &self.points)
    }

    /// The outline with all points on it; `None` if corners have no numbers or a point occurs twice.
    fn divided_outline(&self, polygon: &Polygon) -> Option<Vec<u32>> {
        let corner = |p: &DVec3| self.corners.get(&bits(*p)).copied();
        let corners: Vec<_> = polygon.own_corners().iter().map(corner).collect();
        let n = corners.len();
        let mut outline = Vec::new();
        for i in 0..n {
            match (corners[i], corners[(i + 1) % n]) {
                (Some(a), Some(b)) => self.divisions.walk(a, b, &mut |p| outline.push(p)),
                _ => return None,
            }
        }
        let mut sorted = outline.clone();
        sorted.sort_unstable();
        sorted.dedup();
        (sorted.len() == outline.len()).then_some(outline)
    }
}

/// Coordinates in the plane of a polygon, along its first edge.
fn frame(polygon: &Polygon) -> Frame {
    Frame::new(polygon.corners[0], polygon.corners[1], polygon.unit_normal())
}

fn bits(p: DVec3) -> [u64; 3] {
    p.to_array().map(f64::to_bits)
}
