//! Polygons on shared vertices, on their way to a surface.

use std::collections::HashMap;

use glam::DVec3;

use super::names::Roll;
use super::polygon;
use crate::model::Face;

/// Polygons of any number of corners, end to end.
#[derive(Debug, Default)]
pub(super) struct Polygons {
    pub corners: Vec<u32>,
    /// Where each polygon ends in `corners`.
    pub ends: Vec<usize>,
}

impl Polygons {
    pub fn iter(&self) -> impl Iterator<Item = &[u32]> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        starts.zip(&self.ends).map(|(start, &end)| &self.corners[start..end])
    }

    pub fn push(&mut self, corners: impl IntoIterator<Item = u32>) {
        self.corners.extend(corners);
        self.ends.push(self.corners.len());
    }

    pub fn len(&self) -> usize {
        self.ends.len()
    }

    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }
}

/// The triangles and quads of the polygons of surface `name`; what cannot be kept is said in the roll.
pub(super) fn faces(polygons: &Polygons, positions: &[DVec3], name: &str, roll: &mut Roll) -> Vec<Face> {
    let mut faces = Vec::with_capacity(polygons.len());
    for corners in polygons.iter() {
        let cut = polygon::cut(corners, positions);
        if cut.bent {
            let message = "it has polygons that are not planar, which were cut into triangles";
            roll.warn("non-planar-polygons", "surface", name, message);
        }
        if cut.tangled {
            let message = "it has polygons whose edges cross, which are not covered faithfully; repair the mesh";
            roll.warn("tangled-polygons", "surface", name, message);
        }
        if cut.faces.is_empty() {
            let message = "it has polygons without area, which were left out";
            roll.warn("zero-area-polygons", "surface", name, message);
        }
        faces.extend(cut.faces);
    }
    faces
}

/// The vertices that the faces use, in metres, and the faces renumbered.
pub(super) fn compacted(positions: &[DVec3], faces: Vec<Face>, metres: f64) -> (Vec<DVec3>, Vec<Face>) {
    let (kept, faces) = renumbered(faces);
    (kept.iter().map(|&vertex| metres * positions[vertex as usize]).collect(), faces)
}

/// The vertices that the faces use, in order of first use, and the faces renumbered.
pub(super) fn renumbered(mut faces: Vec<Face>) -> (Vec<u32>, Vec<Face>) {
    let (mut place, mut kept) = (HashMap::new(), Vec::new());
    for corner in faces.iter_mut().flatten() {
        *corner = *place.entry(*corner).or_insert_with(|| {
            kept.push(*corner);
            kept.len() as u32 - 1
        });
    }
    (kept, faces)
}

/// Vertices that are found again by their position.
#[derive(Debug, Default)]
pub(super) struct Vertices {
    pub positions: Vec<DVec3>,
    known: HashMap<[u64; 3], u32>,
}

impl Vertices {
    /// The index of the vertex in this place.
    pub fn index(&mut self, position: DVec3) -> u32 {
        // Adding zero turns -0.0 into 0.0, which is the same place.
        let position = position + DVec3::ZERO;
        *self.known.entry(position.to_array().map(f64::to_bits)).or_insert_with(|| {
            self.positions.push(position);
            self.positions.len() as u32 - 1
        })
    }
}

/// Whether a coordinate is finite and within the range of single precision, beyond which areas overflow.
pub(super) fn is_coordinate(number: f64) -> bool {
    number.abs() <= f64::from(f32::MAX)
}
