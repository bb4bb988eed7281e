//! Rules about the faces of one surface by themselves.

use glam::DVec3;

use super::{Subject, Tally};
use crate::model::{Finding, Surface};
use crate::quad::{self, Shape};

/// A face narrower than this part of its length is a sliver. Facets of finely rounded poles are wider.
const NARROWEST: f64 = 3e-4;

/// The rules about one surface or obstruction by itself; whether others can look at its corners.
pub(super) fn check(subject: &Subject, found: &mut Vec<Finding>) -> bool {
    let indexed = vertices_are_finite(subject, found) & indices_in_range(subject, found);
    if indexed {
        face_shapes(subject, found);
        unused_vertices(subject, found);
    }
    indexed
}

/// Whether all corners of a surface are points.
pub(super) fn is_indexed(surface: &Surface) -> bool {
    let count = surface.vertices.len();
    surface.vertices.iter().all(|vertex| vertex.is_finite())
        && surface.faces.iter().flatten().all(|&vertex| (vertex as usize) < count)
}

fn vertices_are_finite(subject: &Subject, found: &mut Vec<Finding>) -> bool {
    let Subject { surface, name, .. } = subject;
    let Some(bad) = surface.vertices.iter().position(|vertex| !vertex.is_finite()) else {
        return true;
    };
    let v = surface.vertices[bad];
    let users = (0u32..).zip(&surface.faces).filter(|(_, face)| face.contains(&(bad as u32)));
    let finding = Finding::error(
        "non-finite-vertex",
        format!("{name}, vertex {bad}"),
        format!("its position ({}, {}, {}) is not finite; repair the mesh", v.x, v.y, v.z),
    );
    found.push(match subject.index {
        Some(index) => finding.on(index, users.map(|(f, _)| f)),
        None => finding,
    });
    false
}

fn indices_in_range(subject: &Subject, found: &mut Vec<Finding>) -> bool {
    let Subject { surface, name, .. } = subject;
    let count = surface.vertices.len();
    let out_of_range = |face: &[u32; 4]| face.iter().any(|&vertex| vertex as usize >= count);
    let Some(bad) = surface.faces.iter().position(out_of_range) else { return true };
    let finding = Finding::error(
        "index-out-of-range",
        format!("{name}, face {bad}"),
        format!("it refers to vertices {:?} of {count}; indices count from 0", surface.faces[bad]),
    );
    found.push(match subject.index {
        Some(index) => finding.on(index, [bad as u32]),
        None => finding,
    });
    false
}

fn face_shapes(subject: &Subject, found: &mut Vec<Finding>) {
    let Subject { surface, name, .. } = subject;
    let [mut flat, mut bent, mut folded, mut slender] = [const { Tally::NONE }; 4];
    for (i, &face) in (0u32..).zip(&surface.faces) {
        let corners = surface.corners(face);
        match quad::classify(corners) {
            Shape::Sound => {
                if let Some(width) = width_of_sliver(corners) {
                    slender.add(i, width);
                }
            }
            Shape::ZeroArea => flat.add(i, 0.0),
            Shape::NonPlanar(off) => bent.add(i, off),
            Shape::NotConvex => folded.add(i, 0.0),
        }
    }
    if let Some(element) = bent.element(name) {
        let off = bent.measure;
        let message = format!("the corners of the quad lie {off:.3e} m off their plane; split it in triangles");
        found.push(subject.place(Finding::error("non-planar-face", element, message), &bent));
    }
    if let Some(element) = folded.element(name) {
        let message = "the quad has an inward corner or crosses itself; order its corners around its edge or split it in \
                       triangles";
        found.push(subject.place(Finding::error("non-convex-face", element, message), &folded));
    }
    if let Some(&first) = flat.faces.first() {
        let (count, all) = (flat.count, surface.faces.len());
        let message = format!("{count} of {all} faces have no area, face {first} first; they are left out");
        let finding = Finding::warning("zero-area-faces", name, message);
        found.push(subject.place(finding, &flat).along(flat.faces.iter().filter_map(|&f| longest_edge(surface, f))));
    }
    if let Some(element) = slender.element(name) {
        let message = format!(
            "it is {:.1e} m wide and thousands of times as long, which is hard to light; merge it with a \
             neighbour, or move its corners apart",
            slender.measure
        );
        found.push(subject.place(Finding::note("sliver-faces", element, message), &slender));
    }
}

/// The width of a face that is far longer than wide, metres.
fn width_of_sliver(corners: [DVec3; 4]) -> Option<f64> {
    let [a, b, c, d] = corners;
    let doubled = (c - a).cross(d - b).length();
    let length = [b - a, c - b, d - c, a - d, c - a, d - b].iter().map(|edge| edge.length()).fold(0.0, f64::max);
    // A triangle is as wide as it is high, a quad half as much for the same product.
    let width = if c == d { doubled / length } else { 0.5 * doubled / length };
    (width < NARROWEST * length).then_some(width)
}

fn longest_edge(surface: &Surface, face: u32) -> Option<[DVec3; 2]> {
    let [a, b, c, d] = surface.corners(surface.faces[face as usize]);
    [[a, b], [b, c], [c, d], [a, c], [b, d]]
        .into_iter()
        .max_by(|x, y| x[0].distance(x[1]).total_cmp(&y[0].distance(y[1])))
}

fn unused_vertices(subject: &Subject, found: &mut Vec<Finding>) {
    let Subject { surface, name, .. } = subject;
    let mut used = vec![false; surface.vertices.len()];
    for &vertex in surface.faces.iter().flatten() {
        used[vertex as usize] = true;
    }
    let loose: Vec<_> = surface.vertices.iter().zip(&used).filter(|(_, used)| !**used).map(|(&v, _)| v).collect();
    if !loose.is_empty() && !surface.faces.is_empty() {
        let message =
            format!("{} of {} vertices belong to no face; remove them if they are left over", loose.len(), used.len());
        found.push(Finding::note("unused-vertices", name, message).at(loose));
    }
}
