//! The faces of a scene as polygons to cut: degenerate ones left out, pairs of triangles merged, bad quads split.

use std::collections::HashMap;

use glam::DVec3;

use super::cut::{Piece, Side};
use crate::{Face, Scene, Surface};

/// Corners this far off their common plane, relative to the diagonal, still count as planar.
const PLANAR: f64 = 1e-6;

/// The same relative to the largest coordinate: files carry 32-bit floats.
const PLANAR_ABSOLUTE: f64 = 2.0 * f32::EPSILON as f64;

/// The flattest corner of a quad that two triangles may merge into: 45 to 135 degrees.
const MERGED_COSINE: f64 = 0.71;

/// The flattest corner of a quad that two pieces of one face may merge into: 15 to 165 degrees.
const PIECE_COSINE: f64 = 0.966;

/// The flattest corner of a quad face that is cut as it is: 8 to 172 degrees.
const KEPT_COSINE: f64 = 0.99;

/// A face, or two triangles merged, on its way to patches.
#[derive(Clone, Copy, Debug)]
pub(super) struct Polygon {
    pub(super) surface: u32,
    pub(super) face: u32,
    /// A triangle repeats its last corner.
    pub(super) corners: [DVec3; 4],
    pub(super) is_quad: bool,
}

/// Whether a face has no area to speak of: its height vanishes to rounding against its longest edge.
pub fn is_degenerate(corners: &[DVec3; 4]) -> bool {
    let [a, b, c, d] = *corners;
    let longest = [a - b, b - c, c - d, d - a, c - a, d - b].iter().map(|e| e.length_squared()).fold(0.0, f64::max);
    let area = 0.5 * ((b - a).cross(c - a).length() + (c - a).cross(d - a).length());
    area <= 1e-12 * longest
}

impl Polygon {
    pub(super) fn triangle(surface: u32, face: u32, [a, b, c]: [DVec3; 3]) -> Self {
        Self { surface, face, corners: [a, b, c, c], is_quad: false }
    }

    fn n_corners(&self) -> usize {
        if self.is_quad { 4 } else { 3 }
    }

    /// Its corners, none of them twice.
    pub(super) fn own_corners(&self) -> &[DVec3] {
        &self.corners[..self.n_corners()]
    }

    /// Its edges, each from its start to its end.
    fn edges(&self) -> impl Iterator<Item = (DVec3, DVec3)> + '_ {
        let n = self.n_corners();
        (0..n).map(move |i| (self.corners[i], self.corners[(i + 1) % n]))
    }

    pub(super) fn longest_edge(&self) -> f64 {
        self.edges().map(|(a, b)| a.distance(b)).fold(0.0, f64::max)
    }

    pub(super) fn shortest_edge(&self) -> f64 {
        self.edges().map(|(a, b)| a.distance(b)).fold(f64::INFINITY, f64::min)
    }

    pub(super) fn area(&self) -> f64 {
        self.vector_area().length()
    }

    pub(super) fn unit_normal(&self) -> DVec3 {
        self.vector_area().normalize_or_zero()
    }

    fn vector_area(&self) -> DVec3 {
        let [a, b, c, d] = self.corners;
        0.5 * (c - a).cross(d - b)
    }

    /// The polygon with edge `i` from `a` to `b` in `segments(i, a, b)` segments.
    pub(super) fn piece(&self, segments: impl Fn(usize, DVec3, DVec3) -> u32) -> Piece {
        let sides = self.edges().enumerate().map(|(i, (a, b))| Side::new(a, b, segments(i, a, b)));
        Piece::new(sides)
    }

    /// The quality of its shape: 1 for a square, less for a triangle.
    fn quality(&self) -> f64 {
        self.piece(|_, _, _| 1).area_and_quality().1
    }

    /// The name of the face for messages.
    pub(super) fn describe(&self, scene: &Scene) -> String {
        format!("surface '{}', face {}", scene.surfaces[self.surface as usize].name, self.face)
    }

    /// The two triangles of a quad on the diagonal whose worse triangle is the better one.
    fn split(&self) -> [Polygon; 2] {
        let [a, b, c, d] = self.corners;
        let normal = self.vector_area();
        // The height on the longest edge, signed: a diagonal outside the quad turns one triangle around.
        let worse = |pair: &[[DVec3; 3]; 2]| {
            let height = |&[p, q, r]: &[DVec3; 3]| {
                let longest = p.distance_squared(q).max(q.distance_squared(r)).max(r.distance_squared(p));
                (q - p).cross(r - p).dot(normal) / longest.sqrt()
            };
            height(&pair[0]).min(height(&pair[1]))
        };
        let (first, second) = ([[a, b, c], [a, c, d]], [[b, c, d], [b, d, a]]);
        let pair = if worse(&second) > worse(&first) { second } else { first };
        pair.map(|corners| Polygon::triangle(self.surface, self.face, corners))
    }

    /// The largest cosine of a corner's angle.
    pub(super) fn sharpest_cosine(&self) -> f64 {
        let (corners, n) = (self.own_corners(), self.n_corners());
        let cosine = |i: usize| {
            let [before, here, after] = [n - 1, 0, 1].map(|k| corners[(i + k) % n]);
            (before - here).normalize_or_zero().dot((after - here).normalize_or_zero())
        };
        (0..n).map(cosine).fold(-1.0, f64::max)
    }

    /// The largest cosine of a corner's angle, without its sign; infinite unless planar and strictly convex.
    fn flattest_cosine(&self) -> f64 {
        let normal = self.vector_area().normalize_or_zero();
        let mut flattest = 0.0f64;
        for i in 0..4 {
            let [before, here, after] = [3, 0, 1].map(|k| self.corners[(i + k) % 4]);
            let (p, q) = ((before - here).normalize_or_zero(), (after - here).normalize_or_zero());
            if q.cross(p).dot(normal) <= 0.0 {
                return f64::INFINITY;
            }
            flattest = flattest.max(p.dot(q).abs());
        }
        let [a, b, c, d] = self.corners;
        let height = (b - a).dot(normal).abs().max((d - a).dot(normal).abs()).max((c - a).dot(normal).abs());
        let largest = self.corners.iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
        let tolerance = PLANAR * a.distance(c).max(b.distance(d)) + PLANAR_ABSOLUTE * largest;
        if height <= tolerance { flattest } else { f64::INFINITY }
    }
}

/// All faces of a scene in order, as the scene has them.
pub(super) fn raw_polygons(scene: &Scene) -> impl Iterator<Item = Polygon> + '_ {
    polygons_of(&scene.surfaces)
}

fn polygons_of(surfaces: &[Surface]) -> impl Iterator<Item = Polygon> + '_ {
    (0u32..).zip(surfaces).flat_map(|(s, surface)| {
        (0u32..).zip(&surface.faces).map(move |(f, face)| {
            let corners = corners(surface, face);
            Polygon { surface: s, face: f, corners, is_quad: face[2] != face[3] }
        })
    })
}

/// All faces that only block, in order, as the scene has them.
pub(super) fn obstructions(scene: &Scene) -> Vec<[DVec3; 4]> {
    scene.obstructions.iter().flat_map(|surface| surface.faces.iter().map(|face| corners(surface, face))).collect()
}

fn corners(surface: &Surface, face: &Face) -> [DVec3; 4] {
    // Adding zero makes a negative zero positive, so that equal coordinates have equal bits.
    face.map(|v| surface.vertices[v as usize] + DVec3::ZERO)
}

/// The polygons to cut, in order of surfaces and faces.
pub(super) fn polygons(scene: &Scene) -> Vec<Polygon> {
    convex(&scene.surfaces)
}

/// What only blocks, in convex polygons.
pub(super) fn blockers(scene: &Scene) -> Vec<Polygon> {
    convex(&scene.obstructions)
}

fn convex(surfaces: &[Surface]) -> Vec<Polygon> {
    let mut polygons: Vec<Polygon> = Vec::new();
    for polygon in polygons_of(surfaces).filter(|polygon| !is_degenerate(&polygon.corners)) {
        match without_repeats(polygon) {
            quad if quad.is_quad && quad.flattest_cosine() > KEPT_COSINE => polygons.extend(quad.split()),
            other => polygons.push(other),
        }
    }
    polygons.retain(|polygon| !is_degenerate(&polygon.corners));
    merge_triangles(&mut polygons);
    polygons
}

/// A quad with two equal neighbouring corners as the triangle that it is.
fn without_repeats(polygon: Polygon) -> Polygon {
    let [a, b, c, d] = polygon.corners;
    if !polygon.is_quad || !(a == b || b == c || c == d || d == a) {
        return polygon;
    }
    let three = if a == b || d == a { [b, c, d] } else { [a, b, if b == c { d } else { c }] };
    Polygon::triangle(polygon.surface, polygon.face, three)
}

/// Merges pairs of coplanar triangles of one surface into well-shaped quads, the most rectangular first.
fn merge_triangles(polygons: &mut Vec<Polygon>) {
    let candidates = merge_candidates(polygons);
    merge_best(polygons, candidates);
}

/// Merges pairs of triangles into quads, the most rectangular first, each triangle once.
pub(super) fn merge_best(polygons: &mut Vec<Polygon>, mut candidates: Vec<Candidate>) {
    candidates.sort_by(|a, b| a.cosine.total_cmp(&b.cosine).then(a.pair.cmp(&b.pair)));
    let mut is_merged = vec![false; polygons.len()];
    let mut is_gone = vec![false; polygons.len()];
    for Candidate { pair: [first, second], corners, .. } in candidates {
        if is_merged[first] || is_merged[second] {
            continue;
        }
        (is_merged[first], is_merged[second], is_gone[second]) = (true, true, true);
        (polygons[first].corners, polygons[first].is_quad) = (corners, true);
    }
    let mut gone = is_gone.into_iter();
    polygons.retain(|_| gone.next() == Some(false));
}

/// Two triangles that may become one quad.
pub(super) struct Candidate {
    /// Indices of the polygons, the lower one first.
    pair: [usize; 2],
    corners: [DVec3; 4],
    /// Zero for a rectangle. Rounded, so that equal shapes rank equal whatever their rounding errors are.
    cosine: f64,
}

/// The quad of two triangles on the edge that starts at the given corner of either, if it is no worse than they are.
pub(super) fn piece_candidate(
    polygons: &[Polygon],
    (first, edge): (usize, usize),
    (second, back): (usize, usize),
) -> Option<Candidate> {
    let third = |polygon: usize, k: usize| polygons[polygon].corners[k % 3];
    let corners = [third(first, edge + 1), third(first, edge + 2), third(first, edge), third(second, back + 2)];
    let quad = Polygon { corners, is_quad: true, ..polygons[first] };
    let cosine = quad.flattest_cosine();
    let is_good = cosine <= MERGED_COSINE
        || cosine <= PIECE_COSINE && quad.quality() >= polygons[first].quality().min(polygons[second].quality());
    is_good.then_some(Candidate { pair: [first, second], corners, cosine: (cosine * 1e6).round() })
}

/// The edges on which a flush face of the same surface goes on: polygon and edge.
pub(super) fn flush_edges(polygons: &[Polygon]) -> Vec<(usize, usize)> {
    let uses = edge_uses(polygons);
    let mut flush = Vec::new();
    for shared in uses.chunk_by(|a, b| a.points == b.points) {
        for a in shared {
            let (one, normal) = (&polygons[a.polygon], polygons[a.polygon].unit_normal());
            let goes_on = |b: &&EdgeUse| {
                let other = &polygons[b.polygon];
                b.is_upward != a.is_upward
                    && other.surface == one.surface
                    && other.unit_normal().dot(normal) > 1.0 - 1e-9
            };
            if shared.iter().any(|b| goes_on(&b)) {
                flush.push((a.polygon, a.edge as usize));
            }
        }
    }
    flush
}

/// One use of an edge by a triangle or a quad.
#[derive(Clone, Copy)]
struct EdgeUse {
    /// Ids of the end points, the lower one first.
    points: [u32; 2],
    polygon: usize,
    /// Which edge of the polygon.
    edge: u8,
    /// Whether the polygon runs along the edge from the lower point to the higher one.
    is_upward: bool,
}

/// All pairs of triangles that would make a good quad.
fn merge_candidates(polygons: &[Polygon]) -> Vec<Candidate> {
    let uses = edge_uses(polygons);
    let mut candidates = Vec::new();
    for shared in uses.chunk_by(|a, b| a.points == b.points) {
        for (k, a) in shared.iter().enumerate() {
            let partners = shared[k + 1..].iter().filter(|b| b.is_upward != a.is_upward);
            candidates.extend(partners.filter_map(|b| merged(polygons, a, b, shared)));
        }
    }
    candidates
}

/// The uses of all edges, sorted by edge and polygon.
fn edge_uses(polygons: &[Polygon]) -> Vec<EdgeUse> {
    let mut ids = HashMap::new();
    let mut id_of = |point: DVec3| {
        let next = ids.len() as u32;
        *ids.entry(point.to_array().map(f64::to_bits)).or_insert(next)
    };
    let mut uses = Vec::with_capacity(3 * polygons.len());
    for (polygon, shape) in polygons.iter().enumerate() {
        for (edge, (a, b)) in (0u8..).zip(shape.edges()) {
            let (a, b) = (id_of(a), id_of(b));
            uses.push(EdgeUse { points: [a.min(b), a.max(b)], polygon, edge, is_upward: a < b });
        }
    }
    uses.sort_unstable_by_key(|u| (u.points, u.polygon, u.edge));
    uses
}

/// The quad of two triangles on an edge if it is good and no face outside its plane stands on that edge.
fn merged(polygons: &[Polygon], a: &EdgeUse, b: &EdgeUse, shared: &[EdgeUse]) -> Option<Candidate> {
    let (first, second) = (&polygons[a.polygon], &polygons[b.polygon]);
    if first.is_quad || second.is_quad || first.surface != second.surface {
        return None;
    }
    let third = |u: &EdgeUse, k: usize| polygons[u.polygon].corners[(u.edge as usize + k) % 3];
    let corners = [third(a, 1), third(a, 2), third(a, 0), third(b, 2)];
    let quad = Polygon { corners, is_quad: true, ..*first };
    // The corners of two triangles folded onto each other are no convex quad, so this compares the normals too.
    let cosine = quad.flattest_cosine();
    if cosine > MERGED_COSINE {
        return None;
    }
    let normal = quad.vector_area().normalize_or_zero();
    let is_flush = |u: &EdgeUse| polygons[u.polygon].vector_area().normalize_or_zero().cross(normal).length() < 1e-3;
    if !shared.iter().all(is_flush) {
        return None;
    }
    Some(Candidate { pair: [a.polygon, b.polygon], corners, cosine: (cosine * 1e6).round() })
}
