//! Rules about faces in one place: equal ones, and such as cover each other in part.

use std::collections::{BTreeMap, HashMap};

use glam::DVec3;

use super::{Tally, named, outline};
use crate::model::{Finding, MOST_PLACES, Scene};
use crate::quad::{self, Shape};

/// Faces are in one plane if they are no further apart than this, relative to the size of the scene.
const ROUNDING: f64 = 1e-6;

/// The part of the smaller face that must be covered before an overlap counts.
const LEAST_OVERLAP: f64 = 1e-3;

/// After so many comparisons no more overlaps are looked for: some meshes would take too long.
const MOST_COMPARISONS: usize = 20_000_000;

/// Faces with the same corners in any order, counted per pair of surfaces and by whether they look the same way.
pub(super) fn duplicate_faces(scene: &Scene, found: &mut Vec<Finding>) {
    let mut first_with = HashMap::new();
    let mut pairs: BTreeMap<(usize, usize, bool), (u32, Tally)> = BTreeMap::new();
    for (s, surface) in scene.surfaces.iter().enumerate() {
        for (f, &face) in (0u32..).zip(&surface.faces) {
            let corners = surface.corners(face);
            let normal = vector_area(&corners);
            let (t, g, other) = *first_with.entry(corner_key(corners)).or_insert((s, f, normal));
            if (t, g) != (s, f) {
                pairs.entry((t, s, normal.dot(other) < 0.0)).or_insert((g, Tally::NONE)).1.add(f, 0.0);
            }
        }
    }
    for ((s, t, is_opposite), (g, tally)) in pairs {
        let (other, surface) = (&scene.surfaces[s].name, &scene.surfaces[t]);
        let element = tally.element(&named(surface)).unwrap_or_default();
        let finding = if is_opposite {
            let message = format!(
                "it coincides with face {g} of '{other}', which looks the other way, and which of them is hit first is \
                 undefined; keep one and make it two-sided, or move them apart"
            );
            Finding::warning("coincident-opposite", element, message)
        } else {
            let message = format!(
                "it coincides with face {g} of '{other}'; remove one, or light will leak or be lost between them"
            );
            Finding::warning("duplicate-faces", element, message)
        };
        let edges = tally.faces.iter().flat_map(|&f| outline(surface.corners(surface.faces[f as usize])));
        found.push(finding.on(t, tally.faces.iter().copied()).along(edges));
    }
}

/// The corner positions in a fixed order; the repeated corner of a triangle counts once.
pub(super) fn corner_key(corners: [DVec3; 4]) -> [[u64; 3]; 4] {
    // Adding zero turns -0.0 into 0.0, which is the same place.
    let mut key = corners.map(|corner| corner.to_array().map(|x| (x + 0.0).to_bits()));
    key.sort_unstable();
    if let Some(repeat) = (1..4).find(|&i| key[i] == key[i - 1]) {
        key[repeat..].rotate_left(1);
        key[3] = [u64::MAX; 3];
    }
    key
}

/// A face on its way to be compared.
struct Placed {
    surface: usize,
    face: usize,
    corners: [DVec3; 4],
    normal: DVec3,
    area: f64,
    low: DVec3,
    high: DVec3,
}

/// Faces in one plane that look the same way and cover each other in part, counted per pair of surfaces. Faces that
/// look opposite ways stand on each other, as furniture does on a floor.
pub(super) fn overlapping_faces(scene: &Scene, found: &mut Vec<Finding>) {
    let size = scene.bounds().map_or(0.0, |(low, high)| (high - low).length());
    let faces = placed(scene);
    let mut pairs: BTreeMap<(usize, usize), Overlaps> = BTreeMap::new();
    for_each_close_pair(&faces, ROUNDING * size, |a, b| {
        let (first, second) = if (a.surface, a.face) < (b.surface, b.face) { (a, b) } else { (b, a) };
        let common = common_part(a, b);
        if vector_area_of(&common) > LEAST_OVERLAP * a.area.min(b.area)
            && corner_key(a.corners) != corner_key(b.corners)
        {
            pairs.entry((first.surface, second.surface)).or_default().add(first, second, common);
        }
    });
    for ((s, t), overlaps) in pairs {
        let (other, face) = (&scene.surfaces[s].name, overlaps.first);
        let element = overlaps.tally.element(&named(&scene.surfaces[t])).unwrap_or_default();
        let message = format!(
            "it lies in the plane of face {face} of '{other}' and covers a part of it; cut one where the other is, or \
             lift it by a millimetre"
        );
        let edges = overlaps.outlines.iter().flat_map(|polygon| {
            polygon.iter().zip(polygon.iter().cycle().skip(1)).map(|(&a, &b)| [a, b]).collect::<Vec<_>>()
        });
        found.push(
            Finding::warning("overlapping-faces", element, message)
                .on(t, overlaps.tally.faces.iter().copied())
                .along(edges),
        );
    }
}

/// The faces of one surface that cover parts of another.
#[derive(Default)]
struct Overlaps {
    tally: Tally,
    /// The first face that is covered.
    first: u32,
    outlines: Vec<Vec<DVec3>>,
}

impl Overlaps {
    fn add(&mut self, covered: &Placed, face: &Placed, common: Vec<DVec3>) {
        if self.tally.count == 0 {
            self.first = covered.face as u32;
        }
        // A face may cover several.
        if self.tally.faces.last() != Some(&(face.face as u32)) {
            self.tally.add(face.face as u32, 0.0);
        }
        if self.outlines.len() < MOST_PLACES {
            self.outlines.push(common);
        }
    }
}

/// The sound faces, by their least coordinate.
fn placed(scene: &Scene) -> Vec<Placed> {
    let mut faces = Vec::new();
    for (s, surface) in scene.surfaces.iter().enumerate() {
        for (f, &face) in surface.faces.iter().enumerate() {
            let corners = surface.corners(face);
            if quad::classify(corners) != Shape::Sound {
                continue;
            }
            let area = vector_area(&corners);
            faces.push(Placed {
                surface: s,
                face: f,
                corners,
                normal: area.normalize_or_zero(),
                area: area.length(),
                low: corners.into_iter().fold(corners[0], DVec3::min),
                high: corners.into_iter().fold(corners[0], DVec3::max),
            });
        }
    }
    faces
}

/// Calls `visit` for pairs of faces in one plane that look the same way and whose boxes overlap.
fn for_each_close_pair<'a>(faces: &'a [Placed], tolerance: f64, mut visit: impl FnMut(&'a Placed, &'a Placed)) {
    let mut comparisons = 0;
    // Faces that look along the same axis are swept along it, where those of one plane are thin.
    for axis in 0..3 {
        let is_along = |face: &&Placed| face.normal.abs().max_position() == axis;
        let mut order: Vec<_> = faces.iter().filter(is_along).collect();
        order.sort_by(|a, b| a.low[axis].total_cmp(&b.low[axis]));
        for (i, a) in order.iter().enumerate() {
            for b in order[i + 1..].iter().take_while(|b| b.low[axis] <= a.high[axis] + tolerance) {
                comparisons += 1;
                if comparisons > MOST_COMPARISONS {
                    return;
                }
                let boxes_meet = a.low.cmple(b.high + tolerance).all() && b.low.cmple(a.high + tolerance).all();
                if boxes_meet && a.normal.dot(b.normal) > 0.0 && is_coplanar(a, b, tolerance) {
                    visit(a, b);
                }
            }
        }
    }
}

fn is_coplanar(a: &Placed, b: &Placed, tolerance: f64) -> bool {
    let near = |face: &Placed, p: DVec3| (p - face.corners[0]).dot(face.normal).abs() <= tolerance;
    b.corners.iter().all(|&p| near(a, p)) && a.corners.iter().all(|&p| near(b, p))
}

/// What two faces of one plane have in common.
fn common_part(a: &Placed, b: &Placed) -> Vec<DVec3> {
    let mut rest = a.corners.to_vec();
    for i in 0..4 {
        let (from, to) = (b.corners[i], b.corners[(i + 1) % 4]);
        if from != to {
            rest = within(&rest, from, b.normal.cross(to - from));
        }
    }
    rest
}

fn vector_area_of(polygon: &[DVec3]) -> f64 {
    if polygon.len() > 2 { vector_area(polygon).length() } else { 0.0 }
}

/// The part of a convex polygon on the side of a line that `inward` points to.
fn within(polygon: &[DVec3], from: DVec3, inward: DVec3) -> Vec<DVec3> {
    let height = |p: DVec3| inward.dot(p - from);
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (i, &p) in polygon.iter().enumerate() {
        let next = polygon[(i + 1) % polygon.len()];
        let (h, k) = (height(p), height(next));
        if h >= 0.0 {
            kept.push(p);
        }
        if h * k < 0.0 {
            kept.push(p.lerp(next, h / (h - k)));
        }
    }
    kept
}

fn vector_area(polygon: &[DVec3]) -> DVec3 {
    let origin = polygon[0];
    0.5 * polygon.windows(2).map(|edge| (edge[0] - origin).cross(edge[1] - origin)).sum::<DVec3>()
}
