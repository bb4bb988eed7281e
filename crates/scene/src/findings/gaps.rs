//! Faces that nearly touch: edges of one face only that run close by another face, so that light leaks in between.

use std::collections::BTreeMap;

use glam::DVec3;

use super::edges::{EdgeUse, Edges};
use super::{named, outline};
use crate::model::{Finding, Scene};
use crate::quad::{self, Shape};

/// Distances below this part of the size of the scene count as none.
const ROUNDING: f64 = 1e-6;

/// Gaps up to this part of the size of the scene look like mistakes: 10 mm in a room.
const NARROW: f64 = 1.5e-3;

/// The same, as a part of the length of the edge.
const NARROW_FOR_ITS_LENGTH: f64 = 0.01;

/// Where on an edge its distance from other faces is looked at.
const SAMPLES: [f64; 5] = [0.1, 0.3, 0.5, 0.7, 0.9];

/// So many samples must be near another face for the edge to run along it.
const ENOUGH: usize = 4;

/// After so many comparisons no more gaps are looked for.
const MOST_COMPARISONS: usize = 20_000_000;

/// Above this cosine two faces count as parallel.
const PARALLEL: f64 = 0.9;

/// A point of an edge that belongs to one face only, and what is next to it.
struct Sample {
    edge: usize,
    point: DVec3,
    reach: f64,
    nearest: Option<Near>,
}

#[derive(Clone, Copy)]
struct Near {
    distance: f64,
    point: DVec3,
    surface: u32,
    face: u32,
}

/// An edge that runs along a face, where it is farthest from it.
#[derive(Clone, Copy)]
struct Gap {
    edge: EdgeUse,
    point: DVec3,
    near: Near,
}

/// Edges that run close by a face that they do not touch, counted per pair of surfaces.
pub(super) fn narrow_gaps(scene: &Scene, found: &mut Vec<Finding>) {
    let Some((low, high)) = scene.bounds() else { return };
    let size = (high - low).length();
    let edges = Edges::of(scene);
    let single = edges.single();
    let mut samples = samples(&edges, &single, NARROW * size);
    let axis = (high - low).max_position();
    samples.sort_by(|a, b| a.point[axis].total_cmp(&b.point[axis]));
    measure(scene, &single, &mut samples, axis);

    let mut runs: BTreeMap<usize, Vec<(DVec3, Near)>> = BTreeMap::new();
    for sample in &samples {
        let near = sample.nearest.filter(|near| near.distance > ROUNDING * size);
        if let Some(near) = near {
            runs.entry(sample.edge).or_default().push((sample.point, near));
        }
    }
    let mut pairs: BTreeMap<(u32, u32), Vec<Gap>> = BTreeMap::new();
    for (i, run) in runs.into_iter().filter(|(_, run)| run.len() >= ENOUGH) {
        let widest = run.iter().max_by(|a, b| a.1.distance.total_cmp(&b.1.distance));
        if let Some(&(point, near)) = widest {
            let (edge, s, t) = (single[i], single[i].surface, near.surface);
            pairs.entry((s.min(t), s.max(t))).or_default().push(Gap { edge, point, near });
        }
    }
    for gaps in pairs.into_values().filter(|gaps| !is_foot(gaps)) {
        found.push(finding(scene, &edges, &gaps));
    }
}

/// Whether edges are the whole rim of a body that was set down a little above a face, such as the foot of a lamp.
fn is_foot(gaps: &[Gap]) -> bool {
    let rim: Vec<_> = gaps.iter().map(|gap| gap.edge).collect();
    let mut ends = BTreeMap::new();
    for point in rim.iter().flat_map(|edge| edge.points) {
        *ends.entry(point).or_insert(0) += 1;
    }
    let is_round = ends.values().all(|uses| uses % 2 == 0);
    // Where the other face ends too, it is a seam between the two.
    is_round && rim.iter().all(|edge| edge.surface == rim[0].surface)
}

fn samples(edges: &Edges, single: &[EdgeUse], reach: f64) -> Vec<Sample> {
    let of_edge = |(i, edge): (usize, &EdgeUse)| {
        let [a, b] = edges.ends(edge);
        let reach = reach.min(NARROW_FOR_ITS_LENGTH * a.distance(b));
        SAMPLES.map(|t| Sample { edge: i, point: a.lerp(b, t), reach, nearest: None })
    };
    single.iter().enumerate().flat_map(of_edge).collect()
}

/// Finds the nearest other face of each sample within its reach; samples are in order along the axis.
fn measure(scene: &Scene, single: &[EdgeUse], samples: &mut [Sample], axis: usize) {
    let reach = samples.iter().map(|sample| sample.reach).fold(0.0, f64::max);
    let normals: Vec<_> = single.iter().map(|edge| normal(corners(scene, edge.surface, edge.face))).collect();
    let mut comparisons = 0;
    for (s, surface) in (0u32..).zip(&scene.surfaces) {
        for f in 0..surface.faces.len() as u32 {
            let corners = corners(scene, s, f);
            if quad::classify(corners) != Shape::Sound {
                continue;
            }
            let low = corners.into_iter().fold(corners[0], DVec3::min) - reach;
            let high = corners.into_iter().fold(corners[0], DVec3::max) + reach;
            let face_normal = normal(corners);
            let from = samples.partition_point(|sample| sample.point[axis] < low[axis]);
            for sample in samples[from..].iter_mut().take_while(|sample| sample.point[axis] <= high[axis]) {
                comparisons += 1;
                if comparisons > MOST_COMPARISONS {
                    return;
                }
                let edge = &single[sample.edge];
                let is_within = sample.point.cmpge(low).all() && sample.point.cmple(high).all();
                // Leaves and cloth pass close by themselves.
                let is_own = edge.surface == s && (edge.face == f || surface.material.two_sided);
                if !is_within || is_own {
                    continue;
                }
                let point = nearest_point(corners, face_normal, sample.point);
                let apart = point - sample.point;
                let distance = apart.length();
                // A panel before a wall hides what is behind it and need not touch it.
                let is_panel = normals[sample.edge].dot(face_normal).abs() > PARALLEL
                    && apart.dot(face_normal).abs() > 0.5 * distance;
                let is_nearer = sample.nearest.is_none_or(|near| distance < near.distance);
                if distance <= sample.reach && is_nearer && !(is_panel && distance > 0.0) {
                    sample.nearest = Some(Near { distance, point, surface: s, face: f });
                }
            }
        }
    }
}

fn finding(scene: &Scene, edges: &Edges, gaps: &[Gap]) -> Finding {
    let widths = gaps.iter().map(|gap| gap.near.distance);
    let (least, most) = widths.fold((f64::INFINITY, 0.0_f64), |(low, high), w| (low.min(w), high.max(w)));
    let Gap { edge, point, near } = gaps[0];
    let width = if most - least < 0.01 * most { format!("{most:.2e}") } else { format!("{least:.2e} to {most:.2e}") };
    let count = if gaps.len() == 1 { "an edge runs".into() } else { format!("{} edges run", gaps.len()) };
    let message = format!(
        "{count} {width} m from face {} of '{}', first at ({:.4}, {:.4}, {:.4}), and light leaks in between; move one so \
         that they touch",
        near.face, scene.surfaces[near.surface as usize].name, point.x, point.y, point.z
    );
    let element = format!("{}, face {}", named(&scene.surfaces[edge.surface as usize]), edge.face);
    let own = gaps.iter().map(|gap| gap.edge).filter(|e| e.surface == edge.surface).map(|e| e.face);
    Finding::warning("narrow-gap", element, message)
        .on(edge.surface as usize, own)
        .along(gaps.iter().map(|gap| edges.ends(&gap.edge)))
        .at([point, near.point])
}

fn corners(scene: &Scene, surface: u32, face: u32) -> [DVec3; 4] {
    let surface = &scene.surfaces[surface as usize];
    surface.corners(surface.faces[face as usize])
}

/// The unit normal of a face with an area.
fn normal([a, b, c, d]: [DVec3; 4]) -> DVec3 {
    (c - a).cross(d - b).normalize_or_zero()
}

/// The point of a convex face that is nearest to another.
fn nearest_point(corners: [DVec3; 4], normal: DVec3, p: DVec3) -> DVec3 {
    let below = p - (p - corners[0]).dot(normal) * normal;
    if outline(corners).all(|[a, b]| normal.cross(b - a).dot(below - a) >= 0.0) {
        return below;
    }
    let on_edge = |[a, b]: [DVec3; 2]| a.lerp(b, ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0));
    let candidates = outline(corners).map(on_edge);
    candidates.min_by(|x, y| x.distance(p).total_cmp(&y.distance(p))).unwrap_or(below)
}
