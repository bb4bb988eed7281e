//! Rules about edges: which way neighbours wind, and whether surfaces enclose a space.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use glam::DVec3;

use super::{Tally, corner_key, named};
use crate::model::{Finding, Scene};
use crate::quad::{self, Shape};

/// Distances below this part of the scene's size count as none: files carry 32-bit floats.
const ROUNDING: f64 = 1e-6;

/// With more edges than this of one face only, those that meet the middle of another edge are not looked for.
const MOST_COMPARED: usize = 4000;

/// So many holes are told apart.
const MOST_HOLES: usize = 10;

/// So many surfaces at an edge or a hole are named.
const MOST_NAMED: usize = 6;

/// One use of an edge by a face.
#[derive(Clone, Copy)]
pub(super) struct EdgeUse {
    /// Ids of the end points, the lower one first.
    pub(super) points: [u32; 2],
    pub(super) surface: u32,
    pub(super) face: u32,
    /// Whether the face runs along the edge from the lower point to the higher one.
    is_upward: bool,
}

/// All edges of faces with an area.
pub(super) struct Edges {
    positions: Vec<DVec3>,
    /// Sorted by edge, surface and face.
    uses: Vec<EdgeUse>,
}

impl Edges {
    /// The edges of a scene whose indices are in range.
    pub(super) fn of(scene: &Scene) -> Self {
        let (mut ids, mut edges) = (HashMap::new(), Self { positions: Vec::new(), uses: Vec::new() });
        for (s, surface) in (0u32..).zip(&scene.surfaces) {
            for (f, &face) in (0u32..).zip(&surface.faces) {
                let corners = surface.corners(face);
                if quad::classify(corners) == Shape::ZeroArea {
                    continue;
                }
                let points = corners.map(|corner| {
                    // Adding zero turns -0.0 into 0.0, which is the same place.
                    let corner = corner + DVec3::ZERO;
                    *ids.entry(corner.to_array().map(f64::to_bits)).or_insert_with(|| {
                        edges.positions.push(corner);
                        edges.positions.len() as u32 - 1
                    })
                });
                for (a, b) in (0..4).map(|i| (points[i], points[(i + 1) % 4])).filter(|(a, b)| a != b) {
                    let points = [a.min(b), a.max(b)];
                    edges.uses.push(EdgeUse { points, surface: s, face: f, is_upward: a < b });
                }
            }
        }
        edges.uses.sort_unstable_by_key(|edge| (edge.points, edge.surface, edge.face));
        edges
    }

    /// The uses of each edge.
    fn each(&self) -> impl Iterator<Item = &[EdgeUse]> {
        self.uses.chunk_by(|a, b| a.points == b.points)
    }

    /// The edges of one face along which no others run. An edge that meets the middle of another is covered by it.
    fn open(&self, scene: &Scene) -> Vec<EdgeUse> {
        let single = self.single();
        if single.len() > MOST_COMPARED {
            return single;
        }
        let size = scene.bounds().map_or(0.0, |(low, high)| (high - low).length());
        let ends: Vec<_> = single.iter().map(|edge| self.ends(edge)).collect();
        let leaks = |i: usize| uncovered(&ends, i, ROUNDING * size) > 2.0 * ROUNDING * size;
        (0..single.len()).filter(|&i| leaks(i)).map(|i| single[i]).collect()
    }

    /// The edges of one face only.
    pub(super) fn single(&self) -> Vec<EdgeUse> {
        self.each().filter(|uses| uses.len() == 1).map(|uses| uses[0]).collect()
    }

    pub(super) fn ends(&self, edge: &EdgeUse) -> [DVec3; 2] {
        edge.points.map(|point| self.positions[point as usize])
    }
}

/// Two faces of a one-sided surface that wind differently: one of them shows its back where the other shows its front.
pub(super) fn mixed_winding(scene: &Scene, found: &mut Vec<Finding>) {
    let edges = Edges::of(scene);
    for (s, turned) in Winding::within_surfaces(scene, &edges).minority() {
        let mut tally = Tally::NONE;
        turned.faces.iter().for_each(|&face| tally.add(face, 0.0));
        let element = tally.element(&named(&scene.surfaces[s as usize])).unwrap_or_default();
        let message = format!(
            "it winds against its neighbour, face {}, so that one shows its front where the other shows its back; reverse \
             the order of its corners",
            turned.neighbour.face
        );
        let finding = Finding::warning("mixed-winding", element, message);
        found.push(finding.on(s as usize, turned.faces).along(turned.edges));
    }
}

/// Edges where a space leaks, those where more than two faces meet, and surfaces that look out of the space.
pub(super) fn enclosure(scene: &Scene, found: &mut Vec<Finding>) {
    let edges = Edges::of(scene);
    turned_surfaces(scene, &edges, found);
    let is_closed = holes(scene, &edges, found);
    if is_closed {
        looking_outward(scene, found);
    }
    crowded_edges(scene, &edges, found);
}

/// The rims of holes, one by one; whether there are none.
fn holes(scene: &Scene, edges: &Edges, found: &mut Vec<Finding>) -> bool {
    let open = edges.open(scene);
    let rims = rims(scene, edges, &open);
    for rim in rims.iter().take(MOST_HOLES) {
        found.push(hole(scene, edges, rim));
    }
    if rims.len() > MOST_HOLES {
        let rest: Vec<_> = rims[MOST_HOLES..].iter().flatten().map(|edge| edges.ends(edge)).collect();
        let more = rims.len() - MOST_HOLES;
        let message = format!("{more} more holes or open rims, of {} edges, first at {}", rest.len(), middle(&rest[0]));
        found.push(Finding::note("open-edges", "", message).along(rest));
    }
    open.is_empty()
}

fn hole(scene: &Scene, edges: &Edges, rim: &[EdgeUse]) -> Finding {
    let (first, count) = (rim[0], rim.len());
    let edges_belong = if count == 1 { "edge belongs" } else { "edges belong" };
    let message = format!(
        "{count} {edges_belong} to one face only, first the one at {}; where a space should be enclosed, there is a hole: \
         close it between {}",
        middle(&edges.ends(&first)),
        surfaces_at(scene, rim),
    );
    let element = format!("{}, face {}", named(&scene.surfaces[first.surface as usize]), first.face);
    let own = rim.iter().filter(|edge| edge.surface == first.surface).map(|edge| edge.face);
    let finding = Finding::note("open-edges", element, message).on(first.surface as usize, own);
    finding.along(rim.iter().map(|edge| edges.ends(edge)))
}

/// Edges without a second face that hang together where one ends, largest groups first.
fn rims(scene: &Scene, edges: &Edges, open: &[EdgeUse]) -> Vec<Vec<EdgeUse>> {
    let mut groups = Groups::new(open.len());
    let mut first_at = HashMap::new();
    for (i, edge) in open.iter().enumerate() {
        for point in edge.points {
            groups.join(i, *first_at.entry(point).or_insert(i), false);
        }
    }
    // One may also end in the middle of another.
    if open.len() <= MOST_COMPARED {
        let size = scene.bounds().map_or(0.0, |(low, high)| (high - low).length());
        let ends: Vec<_> = open.iter().map(|edge| edges.ends(edge)).collect();
        for i in 0..open.len() {
            let meets = |j: &usize| ends[*j].iter().any(|&end| distance(&ends[i], end) <= ROUNDING * size);
            (0..open.len()).filter(meets).for_each(|j| groups.join(i, j, false));
        }
    }
    let mut members: BTreeMap<usize, Vec<EdgeUse>> = BTreeMap::new();
    for (i, &edge) in open.iter().enumerate() {
        members.entry(groups.find(i).0).or_default().push(edge);
    }
    let mut rims: Vec<_> = members.into_values().collect();
    rims.iter_mut().for_each(|rim| rim.sort_by_key(|edge| (edge.surface, edge.face)));
    rims.sort_by_key(|rim| std::cmp::Reverse(rim.len()));
    rims
}

/// How far a point is from an edge, metres.
fn distance([a, b]: &[DVec3; 2], p: DVec3) -> f64 {
    let along = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
    p.distance(a.lerp(*b, along))
}

/// The names of the surfaces that edges belong to.
fn surfaces_at(scene: &Scene, edges: &[EdgeUse]) -> String {
    let surfaces: BTreeSet<_> = edges.iter().map(|edge| edge.surface).collect();
    let names: Vec<_> =
        surfaces.iter().take(MOST_NAMED).map(|&s| format!("'{}'", scene.surfaces[s as usize].name)).collect();
    match (surfaces.len(), names.len()) {
        (1, _) => format!("faces of {}", names[0]),
        (all, listed) if all > listed => format!("{} and {} others", names.join(", "), all - listed),
        (_, listed) => format!("{} and {}", names[..listed - 1].join(", "), names[listed - 1]),
    }
}

/// Edges where more than two faces meet.
fn crowded_edges(scene: &Scene, edges: &Edges, found: &mut Vec<Finding>) {
    let crowded: Vec<_> = edges.each().filter(|uses| uses.len() > 2).collect();
    let Some(&first) = crowded.first() else { return };
    let mut tally = Tally::NONE;
    let mut faces: Vec<_> =
        crowded.iter().copied().flatten().filter(|edge| edge.surface == first[0].surface).map(|e| e.face).collect();
    faces.sort_unstable();
    faces.dedup();
    faces.iter().for_each(|&face| tally.add(face, 0.0));
    let message = format!(
        "more than two faces meet at {} edges, first at {}, between {}; walls inside an enclosure do so too, but if none is \
         meant there, remove the face too many",
        crowded.len(),
        middle(&edges.ends(&first[0])),
        surfaces_at(scene, first),
    );
    let element = tally.element(&named(&scene.surfaces[first[0].surface as usize])).unwrap_or_default();
    let finding = Finding::note("non-manifold-edges", element, message).on(first[0].surface as usize, faces);
    found.push(finding.along(crowded.iter().map(|uses| edges.ends(&uses[0]))));
}

/// Neighbours of two one-sided surfaces that wind differently; those of one surface are found without asking.
fn turned_surfaces(scene: &Scene, edges: &Edges, found: &mut Vec<Finding>) {
    let known: BTreeSet<_> = Winding::within_surfaces(scene, edges)
        .minority()
        .into_iter()
        .flat_map(|(s, turned)| turned.faces.into_iter().map(move |face| (s, face)))
        .collect();
    for (s, mut turned) in Winding::across_surfaces(scene, edges).minority() {
        turned.faces.retain(|&face| !known.contains(&(s, face)));
        if turned.faces.is_empty() {
            continue;
        }
        let surface = &scene.surfaces[s as usize];
        let mut tally = Tally::NONE;
        turned.faces.iter().for_each(|&face| tally.add(face, 0.0));
        let is_whole = tally.count == surface.faces.len();
        let element = if is_whole { named(surface) } else { tally.element(&named(surface)).unwrap_or_default() };
        let EdgeUse { surface: other, face, .. } = turned.neighbour;
        let message = format!(
            "it winds against '{}', face {face}, so that one shows its front where the other shows its back; reverse the \
             order of its corners",
            scene.surfaces[other as usize].name,
        );
        let finding = Finding::warning("mixed-winding", element, message);
        found.push(finding.on(s as usize, turned.faces).along(turned.edges));
    }
}

/// Which faces wind alike with their neighbours, as far as neighbours reach.
struct Winding<'a> {
    scene: &'a Scene,
    edges: &'a Edges,
    /// The two faces of each edge that counts.
    joints: Vec<[EdgeUse; 2]>,
}

/// The faces of a surface that wind against most of what they hang together with.
struct Turned {
    faces: Vec<u32>,
    /// Where they meet those that they wind against.
    edges: Vec<[DVec3; 2]>,
    /// A face that the first of them winds against.
    neighbour: EdgeUse,
}

impl<'a> Winding<'a> {
    /// Counting edges where two faces of one surface meet, and no third of it.
    fn within_surfaces(scene: &'a Scene, edges: &'a Edges) -> Self {
        let runs = edges.each().flat_map(|uses| uses.chunk_by(|a, b| a.surface == b.surface));
        Self::new(scene, edges, runs)
    }

    /// Counting all edges where two faces meet, and no third.
    fn across_surfaces(scene: &'a Scene, edges: &'a Edges) -> Self {
        Self::new(scene, edges, edges.each())
    }

    fn new(scene: &'a Scene, edges: &'a Edges, runs: impl Iterator<Item = &'a [EdgeUse]>) -> Self {
        let surface = |edge: &EdgeUse| &scene.surfaces[edge.surface as usize];
        let key = |edge: &EdgeUse| corner_key(surface(edge).corners(surface(edge).faces[edge.face as usize]));
        let joint = |uses: &[EdgeUse]| match *uses {
            [a, b] if ![&a, &b].iter().any(|edge| surface(edge).material.two_sided) => Some([a, b]),
            _ => None,
        };
        let joints = runs.filter_map(joint).filter(|[a, b]| key(a) != key(b)).collect();
        Self { scene, edges, joints }
    }

    /// Per surface, the faces that wind against the larger area of what they hang together with.
    fn minority(&self) -> BTreeMap<u32, Turned> {
        let mut turned = BTreeMap::new();
        if self.joints.iter().all(|[a, b]| a.is_upward != b.is_upward) {
            return turned;
        }
        let mut offsets = vec![0];
        for surface in &self.scene.surfaces {
            offsets.push(offsets.last().unwrap_or(&0) + surface.faces.len());
        }
        let id = |edge: &EdgeUse| offsets[edge.surface as usize] + edge.face as usize;
        let mut groups = Groups::new(*offsets.last().unwrap_or(&0));
        for [a, b] in &self.joints {
            groups.join(id(a), id(b), a.is_upward == b.is_upward);
        }
        let outvoted = self.outvoted(&mut groups);
        let mut is_against = |edge: &EdgeUse| {
            let (root, parity) = groups.find(id(edge));
            outvoted[root] == parity
        };
        for pair in &self.joints {
            for (a, b) in [(pair[0], pair[1]), (pair[1], pair[0])] {
                if is_against(&a) {
                    let turned = turned.entry(a.surface).or_insert(Turned {
                        faces: Vec::new(),
                        edges: Vec::new(),
                        neighbour: b,
                    });
                    turned.faces.push(a.face);
                    if a.is_upward == b.is_upward && !is_against(&b) {
                        if turned.edges.is_empty() {
                            turned.neighbour = b;
                        }
                        turned.edges.push(self.edges.ends(&a));
                    }
                }
            }
        }
        for turned in turned.values_mut() {
            turned.faces.sort_unstable();
            turned.faces.dedup();
        }
        turned
    }

    /// Per root of a group, which of its two parts is the smaller by area; of equal ones, that without the first face.
    fn outvoted(&self, groups: &mut Groups) -> Vec<bool> {
        let faces = self.scene.surfaces.iter().flat_map(|s| s.faces.iter().map(|&face| s.corners(face)));
        let (n, mut weight) = (groups.len(), Vec::new());
        weight.resize(n, 0.0);
        let mut leading = vec![None; n];
        for (i, [a, b, c, d]) in faces.enumerate() {
            let (root, parity) = groups.find(i);
            let area = 0.5 * (c - a).cross(d - b).length();
            weight[root] += if parity { area } else { -area };
            leading[root].get_or_insert((parity, area));
        }
        let choose = |(weight, leading): (f64, Option<(bool, f64)>)| {
            let (first, area) = leading.unwrap_or((false, 0.0));
            if weight.abs() > ROUNDING * area { weight < 0.0 } else { !first }
        };
        weight.into_iter().zip(leading).map(choose).collect()
    }
}

/// Things that hang together, each the same way round as its group or the other way.
struct Groups {
    /// The parent of each, and whether it is the other way round.
    parent: Vec<(usize, bool)>,
}

impl Groups {
    fn new(n: usize) -> Self {
        Self { parent: (0..n).map(|i| (i, false)).collect() }
    }

    fn len(&self) -> usize {
        self.parent.len()
    }

    /// The root of a group, and which way round an element is to it.
    fn find(&mut self, i: usize) -> (usize, bool) {
        let (mut root, mut parity) = (i, false);
        while self.parent[root].0 != root {
            parity ^= self.parent[root].1;
            root = self.parent[root].0;
        }
        let (mut at, mut rest) = (i, parity);
        while self.parent[at].0 != root && at != root {
            let (next, flipped) = self.parent[at];
            self.parent[at] = (root, rest);
            rest ^= flipped;
            at = next;
        }
        (root, parity)
    }

    /// Joins two groups; what contradicts an earlier joint is let be.
    fn join(&mut self, a: usize, b: usize, is_opposite: bool) {
        let ((r, p), (s, q)) = (self.find(a), self.find(b));
        if r != s {
            let (low, high) = (r.min(s), r.max(s));
            self.parent[high] = (low, p ^ q ^ is_opposite);
        }
    }
}

/// A closed space whose surfaces show it their backs: the volume that they enclose is positive.
fn looking_outward(scene: &Scene, found: &mut Vec<Finding>) {
    if scene.surfaces.iter().any(|surface| surface.material.two_sided) {
        return;
    }
    let Some((low, high)) = scene.bounds() else { return };
    let faces = scene.surfaces.iter().flat_map(|surface| surface.faces.iter().map(|&face| surface.corners(face)));
    let volume: f64 = faces
        .map(|corners| {
            let [a, b, c, d] = corners.map(|corner| corner - 0.5 * (low + high));
            (a.dot(b.cross(c)) + a.dot(c.cross(d))) / 6.0
        })
        .sum();
    if volume > ROUNDING * (high - low).length().powi(3) {
        let message = "the surfaces look out of the space that they enclose, so that none sees another; reverse the order \
                       of corners where the inside is meant";
        found.push(Finding::warning("looking-outward", "", message));
    }
}

fn middle(edge: &[DVec3; 2]) -> String {
    let DVec3 { x, y, z } = 0.5 * (edge[0] + edge[1]);
    format!("({x:.4}, {y:.4}, {z:.4})")
}

/// How much of an edge no other covers, metres.
fn uncovered(edges: &[[DVec3; 2]], i: usize, tolerance: f64) -> f64 {
    let [start, end] = edges[i];
    let (direction, length) = ((end - start).normalize_or_zero(), start.distance(end));
    let along = |p: DVec3| direction.dot(p - start);
    let is_near = |p: DVec3| (p - start - along(p) * direction).length() <= tolerance;
    let others = edges.iter().enumerate().filter(|&(j, [a, b])| j != i && is_near(*a) && is_near(*b));
    let mut spans: Vec<_> = others.map(|(_, &[a, b])| [along(a).min(along(b)), along(a).max(along(b))]).collect();
    spans.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]));
    let (mut reached, mut bare) = (0.0_f64, 0.0);
    for [from, to] in spans {
        bare += (from.min(length) - reached).max(0.0);
        reached = reached.max(to);
    }
    bare + (length - reached).max(0.0)
}
