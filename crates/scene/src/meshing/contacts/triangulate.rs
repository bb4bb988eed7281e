//! A face with lines across it in convex pieces: a constrained Delaunay triangulation, pairs of whose triangles are
//! then merged.

use glam::{DVec2, DVec3};
use spade::handles::{FixedFaceHandle, FixedVertexHandle, InnerTag};
use spade::{ConstrainedDelaunayTriangulation, HasPosition, HierarchyHintGenerator, Point2, Triangulation as _};

use super::lines::{Frame, Line};

/// How far the area of the pieces may be from that of the face, relative to it.
const AREA: f64 = 1e-9;

/// A numbered point in the plane of a face.
#[derive(Clone, Copy)]
struct Spot {
    position: Point2<f64>,
    id: u32,
}

impl HasPosition for Spot {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        self.position
    }
}

type Mesh = ConstrainedDelaunayTriangulation<Spot, (), (), (), HierarchyHintGenerator<f64>>;

/// A triangle of numbered points, anticlockwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Triangle {
    pub(super) points: [u32; 3],
    /// The triangle across the edge that starts at each point; none where the face ends or a line runs.
    pub(super) across: [Option<usize>; 3],
}

/// Triangulates the polygon with the given outline on all `places`, so that no triangle crosses a line. Outline and
/// lines name places; those that neither names lie inside.
///
/// `None` if that cannot be done, as where rounding makes the outline cross itself.
pub(super) fn triangulate(outline: &[u32], lines: &[Line], places: &[DVec3], frame: &Frame) -> Option<Vec<Triangle>> {
    let spots: Vec<DVec2> = places.iter().map(|&p| frame.flat(p)).collect();
    let area = area(outline.iter().map(|&id| spots[id as usize]));
    let scale = 1.0 / area.sqrt();
    let mut mesh = Mesh::new();
    let mut vertices: Vec<FixedVertexHandle> = Vec::with_capacity(places.len());
    for (id, &spot) in (0u32..).zip(&spots) {
        // Numbers that are next to nothing are refused.
        let rounded = |x: f64| if x.abs() < 1e-30 { 0.0 } else { x };
        let position = Point2::new(rounded(scale * spot.x), rounded(scale * spot.y));
        vertices.push(mesh.insert(Spot { position, id }).ok()?);
    }

    let n = outline.len();
    for [a, b] in (0..n).map(|i| [outline[i], outline[(i + 1) % n]]).chain(lines.iter().copied()) {
        let (a, b) = (vertices[a as usize], vertices[b as usize]);
        if a == b || (!mesh.exists_constraint(a, b) && mesh.try_add_constraint(a, b).is_empty()) {
            return None;
        }
    }
    let triangles = inside(&mesh);
    let sum: f64 = triangles.iter().map(|t| self::area(t.points.iter().map(|&id| spots[id as usize]))).sum();
    ((sum - area).abs() <= AREA * area).then_some(triangles)
}

/// The triangles that cannot be reached from outside without crossing an edge.
fn inside(mesh: &Mesh) -> Vec<Triangle> {
    let mut is_outside = vec![false; mesh.num_all_faces()];
    let mut open = vec![mesh.outer_face().fix()];
    is_outside[open[0].index()] = true;
    while let Some(face) = open.pop() {
        let edges: Vec<_> = match mesh.face(face).as_inner() {
            Some(inner) => inner.adjacent_edges().to_vec(),
            None => mesh.convex_hull().collect(),
        };
        for edge in edges.into_iter().filter(|edge| !edge.is_constraint_edge()) {
            // Of the edges of the hull both directions are tried.
            for next in [edge.face().fix(), edge.rev().face().fix()] {
                if !std::mem::replace(&mut is_outside[next.index()], true) {
                    open.push(next);
                }
            }
        }
    }

    let is_inside = |face: FixedFaceHandle<InnerTag>| !is_outside[face.index()];
    let mut number = vec![0; mesh.num_all_faces()];
    let inner = || mesh.inner_faces().filter(|face| is_inside(face.fix()));
    inner().enumerate().for_each(|(i, face)| number[face.fix().index()] = i);
    let triangle = |face: spade::handles::FaceHandle<'_, InnerTag, Spot, (), spade::CdtEdge<()>, ()>| {
        let edges = face.adjacent_edges();
        let across = edges.map(|edge| {
            let next = edge.rev().face().as_inner().filter(|next| is_inside(next.fix()) && !edge.is_constraint_edge());
            next.map(|next| number[next.fix().index()])
        });
        Triangle { points: edges.map(|edge| edge.from().data().id), across }
    };
    inner().map(triangle).collect()
}

fn area(polygon: impl Iterator<Item = DVec2>) -> f64 {
    let corners: Vec<DVec2> = polygon.collect();
    let n = corners.len();
    0.5 * (0..n).map(|i| (corners[i] - corners[0]).perp_dot(corners[(i + 1) % n] - corners[0])).sum::<f64>()
}
