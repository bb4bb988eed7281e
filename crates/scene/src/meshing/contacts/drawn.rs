//! A polygon with lines drawn on it, in pieces that end at them.

use glam::DVec3;

use super::boxes::{BoxTree, Extent};
use super::frame;
use super::lines::Line;
use super::points::Points;
use super::triangulate::{Triangle, triangulate};
use crate::meshing::cut::{Collector, Side, segments};
use crate::meshing::faces::{self, Polygon};

/// The sharpest corner of pieces that are cut as they are: 40 degrees.
const GOOD_COSINE: f64 = 0.766;

/// How far from a line the regular mesh begins, in longest edges.
const CLEARANCE: f64 = 0.4;

/// The lines on a polygon, between places of its own.
pub(super) struct Drawn {
    places: Vec<DVec3>,
    /// Anticlockwise, with every point on it.
    outline: Vec<u32>,
    lines: Vec<Line>,
    /// The fewest pieces.
    coarse: Vec<Polygon>,
    is_good: bool,
}

impl Drawn {
    /// The polygon with an outline and lines between numbered points; `None` if they make no sense.
    pub(super) fn new(polygon: &Polygon, outline: &[u32], lines: &[Line], points: &Points) -> Option<Self> {
        let mut ids: Vec<u32> = outline.iter().chain(lines.iter().flatten()).copied().collect();
        ids.sort_unstable();
        ids.dedup();
        let own = |id: &u32| ids.binary_search(id).expect("every point is listed") as u32;
        let places: Vec<DVec3> = ids.iter().map(|&id| points.place(id)).collect();
        let outline: Vec<u32> = outline.iter().map(own).collect();
        let lines: Vec<Line> = lines.iter().map(|line| [own(&line[0]), own(&line[1])]).collect();
        let coarse = merged(polygon, &triangulate(&outline, &lines, &places, &frame(polygon))?, &places);
        let is_good = coarse.iter().all(|piece| piece.sharpest_cosine() <= GOOD_COSINE);
        Some(Self { places, outline, lines, coarse, is_good })
    }

    /// The pieces to cut to `max_edge`.
    pub(super) fn pieces(&self, polygon: &Polygon, max_edge: f64) -> Vec<Polygon> {
        if self.is_good {
            return self.coarse.clone();
        }
        self.between_lines(polygon, max_edge).unwrap_or_else(|| self.coarse.clone())
    }

    /// Pieces of the mesh that the polygon would have without lines, where these are far, and others that join it to
    /// them. Outline and lines are divided as all edges are.
    fn between_lines(&self, polygon: &Polygon, max_edge: f64) -> Option<Vec<Polygon>> {
        let mut places = self.places.clone();
        let mut divided = |[a, b]: Line| {
            let [p, q] = [a, b].map(|id| places[id as usize]);
            let n = segments(p.distance(q), max_edge);
            let side = Side::new(p, q, n);
            let mut ends = vec![a];
            for i in 1..n {
                ends.push(places.len() as u32);
                places.push(side.point(i));
            }
            ends.push(b);
            ends
        };
        let n = self.outline.len();
        let mut outline = Vec::new();
        for i in 0..n {
            let mut points = divided([self.outline[i], self.outline[(i + 1) % n]]);
            points.pop();
            outline.extend(points);
        }
        let mut lines: Vec<Line> = Vec::new();
        for &line in &self.lines {
            lines.extend(divided(line).windows(2).map(|ends| [ends[0], ends[1]]));
        }

        let mut edges: Vec<Line> = (0..outline.len()).map(|i| [outline[i], outline[(i + 1) % outline.len()]]).collect();
        edges.extend(&lines);
        let nodes = free_nodes(polygon, max_edge, &edges, &places);
        places.extend(nodes);
        let triangles = triangulate(&outline, &lines, &places, &frame(polygon))?;
        Some(merged(polygon, &triangles, &places))
    }
}

/// The corners of the mesh of the whole polygon that keep clear of all edges.
fn free_nodes(polygon: &Polygon, max_edge: f64, edges: &[Line], places: &[DVec3]) -> Vec<DVec3> {
    let mut regular = Collector::default();
    let whole = polygon.piece(|_, a, b| segments(a.distance(b), max_edge));
    let _ = whole.cut(max_edge, &mut regular);
    let mut nodes: Vec<[f64; 3]> = regular.polygons.iter().flatten().map(|p| p.to_array()).collect();
    nodes.sort_unstable_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
    nodes.dedup();

    let clearance = CLEARANCE * max_edge;
    let ends = |edge: &Line| edge.map(|id| places[id as usize]);
    let extents: Vec<_> = edges.iter().map(|edge| Extent::around(ends(edge)).grown(clearance)).collect();
    let tree = BoxTree::new(&extents);
    let mut near = Vec::new();
    let is_free = |&p: &DVec3| {
        tree.meeting(&Extent { low: p, high: p }, &mut near);
        near.iter().all(|&i| distance(p, ends(&edges[i as usize])) > clearance)
    };
    nodes.into_iter().map(DVec3::from_array).filter(is_free).collect()
}

/// How far a point is from a segment.
fn distance(p: DVec3, [a, b]: [DVec3; 2]) -> f64 {
    let along = b - a;
    let t = ((p - a).dot(along) / along.length_squared()).clamp(0.0, 1.0);
    p.distance(a + t * along)
}

/// The triangles of a polygon as polygons, good pairs of them merged.
fn merged(polygon: &Polygon, triangles: &[Triangle], places: &[DVec3]) -> Vec<Polygon> {
    let shape = |t: &Triangle| Polygon::triangle(polygon.surface, polygon.face, t.points.map(|id| places[id as usize]));
    let mut pieces: Vec<Polygon> = triangles.iter().map(shape).collect();
    let neighbours = triangles.iter().enumerate().flat_map(|(i, triangle)| {
        let across = (0..3).filter_map(move |edge| Some((edge, triangle.across[edge]?)));
        across.filter(move |&(_, j)| i < j).map(move |(edge, j)| (i, edge, j))
    });
    let candidates = neighbours.filter_map(|(i, edge, j)| {
        let back = triangles[j].across.iter().position(|&k| k == Some(i))?;
        faces::piece_candidate(&pieces, (i, edge), (j, back))
    });
    let candidates = candidates.collect();
    faces::merge_best(&mut pieces, candidates);
    pieces
}
