//! Meshing of a scene into patches.
//!
//! Edges that two faces share, of one surface or of two, are divided once and for both: the number of segments of an
//! edge and its division points follow from its end points alone, taken in sorted order. So faces that meet in a file
//! with bit-identical vertices meet without gaps or T-junctions in the mesh.

mod adaptive;
mod contacts;
mod cut;
mod faces;
#[cfg(test)]
mod tests;

use std::ops::ControlFlow;

use glam::DVec3;
use radiosity_geometry::Patches;

use crate::{Scene, SceneError};
pub use adaptive::AdaptiveMesh;
use contacts::Drawing;
use cut::{Collector, Counter, Piece};
use faces::Polygon;
pub use faces::is_degenerate;

/// The most patches that a mesh may have.
pub const MOST_PATCHES: usize = 50_000_000;

/// How often the edge for a number of patches is corrected.
const CORRECTIONS: usize = 5;

/// A number of patches that is off by so much is near enough.
const CLOSE_COUNT: f64 = 0.03;

/// How finely to cut a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Meshing {
    /// No edge of a patch is longer than this, in metres.
    MaxEdge(f64),
    /// About this many patches, and never fewer than the faces need.
    Count(usize),
    /// One patch per face in order of surfaces and faces; faces without area stay.
    AsIs,
}

/// What becomes of lines along which faces touch or cross others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Contacts {
    /// Patches end at them, so that none is in the light and in the dark of what stands on it.
    #[default]
    Cut,
    /// Patches run on beneath what stands on them.
    Ignore,
}

/// Cuts a scene into patches, in order of surfaces, faces and rows within the face.
///
/// Unless the mesh is [`Meshing::AsIs`], pairs of coplanar triangles that make a well-shaped quadrilateral are cut as
/// one face, the one of the lower index, and faces without area are left out. Patch `(i, j)` of a face cut into a grid
/// of `nu` by `nv` has index `j * nu + i` within the face; `i` counts from corner 0 towards corner 1, `j` towards
/// corner 3.
///
/// Obstructions are not cut: each of their faces becomes one of [`Patches::obstructions`].
///
/// # Errors
/// If a face or a vertex is unusable, the fineness makes no sense, or there would be more than [`MOST_PATCHES`].
pub fn patches(scene: &Scene, meshing: &Meshing) -> Result<Patches, SceneError> {
    patches_with(scene, meshing, Contacts::Cut)
}

/// Cuts a scene into patches, as [`patches`], with a say in lines of contact.
///
/// # Errors
/// As [`patches`].
pub fn patches_with(scene: &Scene, meshing: &Meshing, contacts: Contacts) -> Result<Patches, SceneError> {
    check_faces(scene)?;
    match *meshing {
        Meshing::AsIs => as_is(scene),
        Meshing::MaxEdge(max_edge) => {
            if max_edge.is_nan() || max_edge <= 0.0 {
                return Err(refusal(scene, format!("the longest edge must be positive, not {max_edge} m")));
            }
            cut_drawing(scene, &drawing(scene, contacts), max_edge)
        }
        Meshing::Count(count) => {
            if count == 0 || count > MOST_PATCHES {
                return Err(refusal(scene, format!("ask for 1 to {MOST_PATCHES} patches, not {count}")));
            }
            let drawing = drawing(scene, contacts);
            cut_drawing(scene, &drawing, drawing_edge_for_count(&drawing, count))
        }
    }
}

/// The polygons to cut, in order of surfaces and faces, with lines where others touch or cross them.
fn drawing(scene: &Scene, contacts: Contacts) -> Drawing {
    let polygons = faces::polygons(scene);
    match contacts {
        Contacts::Cut => Drawing::new(polygons, &faces::blockers(scene)),
        Contacts::Ignore => Drawing::blank(polygons),
    }
}

/// Cuts all pieces between the lines so that no edge is longer than `max_edge`.
fn cut_drawing(scene: &Scene, drawing: &Drawing, max_edge: f64) -> Result<Patches, SceneError> {
    // What is too much for the fewest pieces is too much for all.
    check_size(scene, fewest_patches(&drawing.pieces(f64::INFINITY), max_edge))?;
    cut_to_edge(scene, &drawing.pieces(max_edge), max_edge)
}

/// The longest edge that leads to about `target` patches. What joins lines to a regular mesh takes more than the fewest
/// pieces tell of, so the edge that these ask for is corrected by what it leads to.
fn drawing_edge_for_count(drawing: &Drawing, target: usize) -> f64 {
    let coarse = drawing.pieces(f64::INFINITY);
    let mut max_edge = edge_for_count(&coarse, target);
    if !drawing.has_lines() || max_edge.is_infinite() {
        return max_edge;
    }
    let mut best = (f64::INFINITY, max_edge);
    for _ in 0..CORRECTIONS {
        let count = count_patches(&drawing.pieces(max_edge), max_edge, target.saturating_mul(8));
        let ratio = count as f64 / target as f64;
        if ratio.ln().abs() < best.0 {
            best = (ratio.ln().abs(), max_edge);
        }
        if best.0 < CLOSE_COUNT {
            break;
        }
        max_edge *= ratio.clamp(0.25, 4.0).sqrt();
    }
    best.1
}

/// Cuts each face into an explicit grid: one `(nu, nv)` per face in order of surfaces and faces.
///
/// A triangle takes `nu == nv` and is cut into the square of that number of triangles. Nothing is merged or left out,
/// and whether neighbouring faces conform is the caller's concern.
///
/// # Errors
/// If the divisions do not suit the faces, or a face is unusable.
pub fn grid(scene: &Scene, divisions: &[(usize, usize)]) -> Result<Patches, SceneError> {
    check_faces(scene)?;
    let n_faces: usize = scene.surfaces.iter().map(|surface| surface.faces.len()).sum();
    if divisions.len() != n_faces {
        let message = format!("{} divisions were given for {n_faces} faces; give one per face", divisions.len());
        return Err(refusal(scene, message));
    }
    let total = divisions.iter().fold(0usize, |sum, &(nu, nv)| sum.saturating_add(nu.saturating_mul(nv)));
    check_size(scene, total as f64)?;
    let mut builder = Builder::with_capacity(total);
    for (polygon, &(nu, nv)) in faces::raw_polygons(scene).zip(divisions) {
        let suits = nu > 0 && nv > 0 && (polygon.is_quad || nu == nv);
        if !suits {
            return Err(SceneError {
                file: scene.name.clone(),
                element: polygon.describe(scene),
                message: format!("cannot be cut into {nu} by {nv}; counts are positive, and equal for a triangle"),
            });
        }
        builder.cut(&polygon, |sink| {
            let along = |edge: usize| if edge.is_multiple_of(2) { nu as u32 } else { nv as u32 };
            polygon.piece(|edge, _, _| along(edge)).emit(sink)
        });
    }
    Ok(builder.finish(scene))
}

/// One patch per face.
fn as_is(scene: &Scene) -> Result<Patches, SceneError> {
    check_size(scene, scene.surfaces.iter().map(|surface| surface.faces.len() as f64).sum())?;
    let mut builder = Builder::default();
    for polygon in faces::raw_polygons(scene) {
        builder.cut(&polygon, |collector| {
            collector.polygons.push(polygon.corners);
            ControlFlow::Continue(())
        });
    }
    Ok(builder.finish(scene))
}

/// Cuts every polygon so that no edge is longer than `max_edge`.
fn cut_to_edge(scene: &Scene, polygons: &[Polygon], max_edge: f64) -> Result<Patches, SceneError> {
    // The bound costs nothing; only what passes it is worth counting.
    check_size(scene, fewest_patches(polygons, max_edge))?;
    let total = count_patches(polygons, max_edge, MOST_PATCHES);
    check_size(scene, total as f64)?;
    let mut builder = Builder::with_capacity(total);
    for polygon in polygons {
        builder.cut(polygon, |sink| pieces(polygon, max_edge).cut(max_edge, sink));
    }
    Ok(builder.finish(scene))
}

/// A polygon with its edges divided for `max_edge`.
fn pieces(polygon: &Polygon, max_edge: f64) -> Piece {
    polygon.piece(|_, a, b| cut::segments(a.distance(b), max_edge))
}

/// A lower bound of the number of patches: none is larger than a square, and none has two segments of one edge.
fn fewest_patches(polygons: &[Polygon], max_edge: f64) -> f64 {
    // Half a percent of slack covers the tolerance that the division of edges has.
    let bound = |p: &Polygon| 0.995 * (p.area() / max_edge.powi(2)).max(p.longest_edge() / max_edge);
    polygons.iter().map(|polygon| bound(polygon).max(1.0)).sum()
}

/// The number of patches for `max_edge`; counting ends soon after it passes `enough`.
fn count_patches(polygons: &[Polygon], max_edge: f64, enough: usize) -> usize {
    let mut counter = Counter { count: 0, enough };
    for polygon in polygons {
        if pieces(polygon, max_edge).cut(max_edge, &mut counter).is_break() {
            break;
        }
    }
    counter.count
}

/// The longest edge that leads to about `target` patches, found by bisection of its logarithm.
fn edge_for_count(polygons: &[Polygon], target: usize) -> f64 {
    if target <= polygons.len() {
        return f64::INFINITY;
    }
    let area: f64 = polygons.iter().map(Polygon::area).sum();
    let enough = target.saturating_mul(8);
    let (mut fine, mut coarse) = (None::<f64>, None::<f64>);
    let mut max_edge = (area / target as f64).sqrt();
    let mut best = (f64::INFINITY, f64::INFINITY);
    for _ in 0..60 {
        let bound = fewest_patches(polygons, max_edge);
        let count = if bound > enough as f64 { bound } else { count_patches(polygons, max_edge, enough) as f64 };
        let ratio = count / target as f64;
        if ratio.ln().abs() < best.0 {
            best = (ratio.ln().abs(), max_edge);
        }
        if best.0 < 0.01 {
            break;
        }
        *(if ratio > 1.0 { &mut fine } else { &mut coarse }) = Some(max_edge);
        max_edge = match (fine, coarse) {
            (Some(fine), Some(coarse)) if coarse / fine - 1.0 < 1e-4 => break,
            (Some(fine), Some(coarse)) => (fine * coarse).sqrt(),
            // The number of patches goes with the inverse square of their size; step a little too far.
            _ => max_edge * ratio.clamp(0.01, 100.0).powf(0.6) * if ratio > 1.0 { 1.05 } else { 0.95 },
        };
    }
    best.1
}

/// Patches in the making, one polygon after another.
#[derive(Default)]
struct Builder {
    collector: Collector,
    surface: Vec<u32>,
    face: Vec<u32>,
}

impl Builder {
    fn with_capacity(n: usize) -> Self {
        let collector = Collector { polygons: Vec::with_capacity(n) };
        Self { collector, surface: Vec::with_capacity(n), face: Vec::with_capacity(n) }
    }

    /// Has `cut` push the patches of one polygon.
    fn cut(&mut self, polygon: &Polygon, cut: impl FnOnce(&mut Collector) -> ControlFlow<()>) {
        // A collector takes everything, so there is no break to heed.
        let _ = cut(&mut self.collector);
        let n = self.collector.polygons.len();
        self.surface.resize(n, polygon.surface);
        self.face.resize(n, polygon.face);
    }

    fn finish(self, scene: &Scene) -> Patches {
        let is_two_sided = |&s: &u32| scene.surfaces[s as usize].material.two_sided;
        let two_sided = self.surface.iter().map(is_two_sided).collect();
        Patches::new(self.collector.polygons, self.surface, self.face, two_sided)
            .with_obstructions(faces::obstructions(scene))
    }
}

/// Refuses a mesh of more than [`MOST_PATCHES`].
fn check_size(scene: &Scene, n_patches: f64) -> Result<(), SceneError> {
    if n_patches <= MOST_PATCHES as f64 {
        return Ok(());
    }
    let message = format!("this would take at least {n_patches:.3e} patches, more than {MOST_PATCHES}; mesh coarser");
    Err(refusal(scene, message))
}

/// Refuses faces that name missing vertices and vertices that are no points.
fn check_faces(scene: &Scene) -> Result<(), SceneError> {
    let surfaces = scene.surfaces.iter().map(|surface| ("surface", surface));
    let obstructions = scene.obstructions.iter().map(|surface| ("obstruction", surface));
    for (kind, surface) in surfaces.chain(obstructions) {
        let fault = |element: String, message: String| {
            Err(SceneError {
                file: scene.name.clone(),
                element: format!("{kind} '{}', {element}", surface.name),
                message,
            })
        };
        if let Some(i) = surface.vertices.iter().position(|v: &DVec3| !v.is_finite()) {
            return fault(format!("vertex {i}"), "is not finite; repair the file".into());
        }
        let n = surface.vertices.len();
        if let Some(i) = surface.faces.iter().position(|face| face.iter().any(|&v| v as usize >= n)) {
            return fault(format!("face {i}"), format!("names a vertex beyond the {n} there are; repair the file"));
        }
    }
    Ok(())
}

fn refusal(scene: &Scene, message: String) -> SceneError {
    SceneError { file: scene.name.clone(), element: "meshing".into(), message }
}
