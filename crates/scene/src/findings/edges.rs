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

/// One use of an edge by a face.
#[derive(Clone, Copy)]
struct EdgeUse {
    /// Ids of the end points, the lower one first.
    points: [u32; 2],
    surface: u32,
    face: u32,
    /// Whether the face runs along the edge from the lower point to the higher one.
    is_upward: bool,
}

/// All edges of faces with an area.
struct Edges {
    positions: Vec<DVec3>,
    /// Sorted by edge, surface and face.
    uses: Vec<EdgeUse>,
}

impl Edges {
    /// The edges of a scene whose indices are in range.
    fn of(scene: &Scene) -> Self {
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

    fn ends(&self, edge: &EdgeUse) -> [DVec3; 2] {
        edge.points.map(|point| self.positions[point as usize])
    }
}

/// Two faces of a one-sided surface that wind differently: one of them shows its back where the other shows its front.
pub(super) fn mixed_winding(scene: &Scene, found: &mut Vec<Finding>) {
    let mut against: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for uses in Edges::of(scene).each() {
        for own in uses.chunk_by(|a, b| a.surface == b.surface) {
            let surface = &scene.surfaces[own[0].surface as usize];
            let [a, b] = own else { continue };
            let key = |edge: &EdgeUse| corner_key(surface.corners(surface.faces[edge.face as usize]));
            if a.is_upward == b.is_upward && !surface.material.two_sided && key(a) != key(b) {
                against.entry(a.surface).or_default().push(b.face);
            }
        }
    }
    for (s, mut faces) in against {
        faces.sort_unstable();
        let mut tally = Tally::default();
        faces.iter().for_each(|&face| tally.add(face as usize, 0.0));
        found.push(Finding::warning(
            "mixed-winding",
            format!("{}, face {}{}", named(&scene.surfaces[s as usize]), faces[0], tally.and_more()),
            "it winds against a neighbour, so that one shows its front where the other shows its back; orient the \
             normals of the surface alike",
        ));
    }
}

/// Edges where a space leaks, those where more than two faces meet, and surfaces that look out of the space.
pub(super) fn enclosure(scene: &Scene, found: &mut Vec<Finding>) {
    let edges = Edges::of(scene);
    turned_surfaces(scene, &edges, found);
    let single: Vec<_> = edges.each().filter(|uses| uses.len() == 1).map(|uses| edges.ends(&uses[0])).collect();
    let open = leaking(scene, single);
    if let Some(first) = open.first() {
        let message = format!(
            "{} edges belong to one face only, first the one at {}; where a space should be enclosed, there is a hole",
            open.len(),
            middle(first)
        );
        found.push(Finding::note("open-edges", "", message));
    }
    if open.is_empty() {
        looking_outward(scene, found);
    }
    let crowded: Vec<_> = edges.each().filter(|uses| uses.len() > 2).map(|uses| edges.ends(&uses[0])).collect();
    if let Some(first) = crowded.first() {
        let message = format!(
            "more than two faces meet at {} edges, first at {}; walls inside an enclosure do so too",
            crowded.len(),
            middle(first)
        );
        found.push(Finding::note("non-manifold-edges", "", message));
    }
}

/// Neighbours of two one-sided surfaces that wind differently; those of one surface are found without asking.
fn turned_surfaces(scene: &Scene, edges: &Edges, found: &mut Vec<Finding>) {
    let surface = |edge: &EdgeUse| &scene.surfaces[edge.surface as usize];
    let one_sided = |uses: &[EdgeUse]| uses.iter().all(|edge| !surface(edge).material.two_sided);
    let mut pairs = BTreeSet::new();
    for uses in edges.each().filter(|uses| one_sided(uses)) {
        if let [a, b] = uses
            && a.surface != b.surface
            && a.is_upward == b.is_upward
        {
            pairs.insert((a.surface, b.surface));
        }
    }
    let Some(&(s, t)) = pairs.first() else { return };
    let message = format!(
        "it winds against '{}', so that one shows its front where the other shows its back; {} pairs of surfaces do so, \
         these first",
        scene.surfaces[s as usize].name,
        pairs.len()
    );
    found.push(Finding::warning("mixed-winding", named(&scene.surfaces[t as usize]), message));
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

/// The edges along which no others run. An edge that meets the middle of another is covered by it.
fn leaking(scene: &Scene, single: Vec<[DVec3; 2]>) -> Vec<[DVec3; 2]> {
    if single.len() > MOST_COMPARED {
        return single;
    }
    let size = scene.bounds().map_or(0.0, |(low, high)| (high - low).length());
    let leaks = |i: usize| uncovered(&single, i, ROUNDING * size) > 2.0 * ROUNDING * size;
    (0..single.len()).filter(|&i| leaks(i)).map(|i| single[i]).collect()
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
