//! What there is to draw: the polygons of an enclosure with their corners welded.

use crate::enclosure::Enclosure;
use glam::DVec3;
use std::collections::HashMap;

/// How far above the horizon a polygon must reach to be seen, relative to the scene's extent: what single precision
/// may have moved a corner of a file off the plane it shares with the source. [`Enclosure`] raises the origins of
/// rays by as much.
pub(super) const COPLANAR: f64 = 1.5 * f32::EPSILON as f64;

/// Convex polygons of three or four corners over shared vertices.
///
/// Polygons that share an edge refer to the same two vertices, so whatever is computed from these is the same for both.
pub(super) struct Polygons {
    /// Vertices, coordinate by coordinate, metres.
    pub vertices: [Vec<f64>; 3],
    /// Corners of each polygon, counter-clockwise from the front; a triangle repeats its last.
    pub corners: Vec<[u32; 4]>,
    /// Who is seen from the front and from behind: a side, or [`Polygons::black`].
    pub owners: Vec<[u32; 2]>,
    /// The first polygon of every patch; obstructions follow.
    first: Vec<u32>,
    /// The extent of the scene, metres: the unit of what is drawn, so that nothing depends on its size.
    pub extent: f64,
    sides: u32,
}

impl Polygons {
    pub fn new(enclosure: &Enclosure) -> Self {
        let patches = enclosure.patches();
        let mut welder = Welder::default();
        let (mut corners, mut owners, mut first) = (Vec::new(), Vec::new(), Vec::with_capacity(patches.len() + 1));
        let black = enclosure.sides() as u32;
        let mut add = |polygon: &[DVec3; 4], owner: [u32; 2]| {
            for part in convex_parts(polygon) {
                corners.push(part.map(|p| welder.index(p)));
                owners.push(owner);
            }
            owners.len() as u32
        };
        first.push(0);
        for (patch, polygon) in patches.polygons.iter().enumerate() {
            let back = enclosure.back_of(patch).map_or(black, |side| side as u32);
            first.push(add(polygon, [patch as u32, back]));
        }
        for polygon in &patches.obstructions {
            add(polygon, [black; 2]);
        }
        let extent = extent(&welder.vertices);
        Self { vertices: welder.vertices, corners, owners, first, extent, sides: black }
    }

    /// The number of polygons.
    pub fn len(&self) -> usize {
        self.corners.len()
    }

    /// The polygons of a patch.
    pub fn of_patch(&self, patch: usize) -> std::ops::Range<usize> {
        self.first[patch] as usize..self.first[patch + 1] as usize
    }

    /// The owner of what absorbs: backs of one-sided patches, and obstructions.
    pub fn black(&self) -> u32 {
        self.sides
    }

    /// The owner of pixels that nothing covers.
    pub fn nothing(&self) -> u32 {
        self.sides + 1
    }
}

/// Numbers distinct points.
#[derive(Default)]
struct Welder {
    vertices: [Vec<f64>; 3],
    known: HashMap<[u64; 3], u32>,
}

impl Welder {
    fn index(&mut self, p: DVec3) -> u32 {
        // Adding zero makes -0 and 0 one key.
        let coordinates = [p.x + 0.0, p.y + 0.0, p.z + 0.0];
        let next = self.vertices[0].len() as u32;
        let index = *self.known.entry(coordinates.map(f64::to_bits)).or_insert(next);
        if index == next {
            for (list, value) in self.vertices.iter_mut().zip(coordinates) {
                list.push(value);
            }
        }
        index
    }
}

/// The polygon itself where it is convex, and else the two triangles that rays take it for, turned to face as it does.
/// Nothing where it has no area or no place.
fn convex_parts(polygon: &[DVec3; 4]) -> Vec<[DVec3; 4]> {
    let [a, b, c, d] = *polygon;
    let normal = (c - a).cross(d - b);
    if !normal.is_finite() || normal == DVec3::ZERO {
        return Vec::new();
    }
    let turn = |p: DVec3, q: DVec3, r: DVec3| (q - p).cross(r - q).dot(normal);
    let least = turn(a, b, c).min(turn(b, c, d)).min(turn(c, d, a)).min(turn(d, a, b));
    if c == d || least >= -1e-9 * normal.length_squared() {
        return vec![*polygon];
    }
    let facing = |p: DVec3, q: DVec3, r: DVec3| if turn(p, q, r) > 0.0 { [p, q, r, r] } else { [p, r, q, q] };
    vec![facing(a, b, c), facing(a, c, d)]
}

/// The largest extent of the vertices along an axis; 1 where there is none.
fn extent(vertices: &[Vec<f64>; 3]) -> f64 {
    let along = |axis: &Vec<f64>| {
        let (low, high) = axis.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &x| (l.min(x), h.max(x)));
        high - low
    };
    let extent = vertices.iter().map(along).fold(0.0, f64::max);
    if extent > 0.0 { extent } else { 1.0 }
}
