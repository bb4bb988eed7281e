use std::collections::{BTreeMap, HashMap, HashSet};

use glam::{DMat3, DVec3};
use proptest::prelude::*;
use radiosity_geometry::Patches;

use crate::meshing::{Contacts, Meshing, patches, patches_with};
use crate::{Scene, Surface};

fn v(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

type Faces = Vec<Vec<DVec3>>;

fn surface(faces: &Faces) -> Surface {
    let mut surface = Surface::default();
    for corners in faces {
        let first = surface.vertices.len() as u32;
        surface.vertices.extend(corners);
        surface.faces.push([first, first + 1, first + 2, first + corners.len() as u32 - 1]);
    }
    surface
}

/// A scene of one surface for each list of faces.
fn scene(parts: &[Faces]) -> Scene {
    Scene { name: "test".into(), surfaces: parts.iter().map(surface).collect(), ..Scene::default() }
}

/// A horizontal rectangle that looks up.
fn slab(x: [f64; 2], y: [f64; 2], z: f64) -> Faces {
    vec![vec![v(x[0], y[0], z), v(x[1], y[0], z), v(x[1], y[1], z), v(x[0], y[1], z)]]
}

/// An upright rectangle over the line from `a` to `b`.
fn wall(a: [f64; 2], b: [f64; 2], z: [f64; 2]) -> Faces {
    vec![vec![v(a[0], a[1], z[0]), v(b[0], b[1], z[0]), v(b[0], b[1], z[1]), v(a[0], a[1], z[1])]]
}

/// A box that looks outwards, with its bottom face.
fn block(low: DVec3, high: DVec3) -> Faces {
    let (a, b) = ([low.x, low.y], [high.x, high.y]);
    let z = [low.z, high.z];
    let mut faces = slab([a[0], b[0]], [a[1], b[1]], z[1]);
    faces.push(slab([a[0], b[0]], [a[1], b[1]], z[0]).remove(0).into_iter().rev().collect());
    for (p, q) in [(a, [b[0], a[1]]), ([b[0], a[1]], b), (b, [a[0], b[1]]), ([a[0], b[1]], a)] {
        faces.extend(wall(p, q, z));
    }
    faces
}

/// A room of six faces that look inwards.
fn room(size: DVec3) -> Faces {
    block(DVec3::ZERO, size).into_iter().map(|face| face.into_iter().rev().collect()).collect()
}

fn turned(parts: &[Faces], by: DMat3, shift: DVec3) -> Vec<Faces> {
    let turn = |face: &Vec<DVec3>| face.iter().map(|&p| by * p + shift).collect();
    parts.iter().map(|faces| faces.iter().map(turn).collect()).collect()
}

fn single(parts: &[Faces]) -> Vec<Faces> {
    let round = |face: &Vec<DVec3>| face.iter().map(|p| p.as_vec3().as_dvec3()).collect();
    parts.iter().map(|faces| faces.iter().map(round).collect()).collect()
}

fn cut(scene: &Scene, max_edge: f64) -> Patches {
    patches(scene, &Meshing::MaxEdge(max_edge)).unwrap()
}

fn coarse(parts: &[Faces]) -> Patches {
    cut(&scene(parts), f64::INFINITY)
}

fn key(p: DVec3) -> [u64; 3] {
    p.to_array().map(|x| (x + 0.0).to_bits())
}

/// The patches of a surface.
fn of(mesh: &Patches, surface: u32) -> Vec<Vec<DVec3>> {
    (0..mesh.len()).filter(|&i| mesh.surface[i] == surface).map(|i| mesh.corners(i).to_vec()).collect()
}

fn edges_of(polygons: &[Vec<DVec3>]) -> HashSet<[[u64; 3]; 2]> {
    let edges = polygons.iter().flat_map(|p| (0..p.len()).map(|i| [key(p[i]), key(p[(i + 1) % p.len()])]));
    edges.flat_map(|[a, b]| [[a, b], [b, a]]).collect()
}

/// Every edge of `wall` in the plane that `is_joint` tells is an edge of `floor`, to the bit.
fn assert_joined(mesh: &Patches, wall: u32, floor: u32, is_joint: impl Fn(DVec3) -> bool) {
    let (wall, floor) = (of(mesh, wall), edges_of(&of(mesh, floor)));
    let mut n = 0;
    for p in &wall {
        for (a, b) in (0..p.len()).map(|i| (p[i], p[(i + 1) % p.len()])).filter(|&(a, b)| is_joint(a) && is_joint(b)) {
            assert!(floor.contains(&[key(a), key(b)]), "no edge from {a} to {b}");
            n += 1;
        }
    }
    assert!(n > 0, "no edge at the joint");
}

/// Area, normals and ids are those of the faces; patches are convex and no edge ends on the middle of another of the
/// same face.
fn assert_faithful(scene: &Scene, mesh: &Patches, tolerance: f64) {
    let whole = patches(scene, &Meshing::AsIs).unwrap();
    // Two triangles that became one quad count for the first.
    let whole_mesh = patches_with(scene, &Meshing::MaxEdge(f64::INFINITY), Contacts::Ignore).unwrap();
    let mut areas: BTreeMap<(u32, u32), f64> = BTreeMap::new();
    for i in 0..mesh.len() {
        *areas.entry((mesh.surface[i], mesh.face[i])).or_default() += mesh.area[i];
    }
    let mut expected: BTreeMap<(u32, u32), (f64, f64)> = BTreeMap::new();
    for i in 0..whole_mesh.len() {
        let corners = whole_mesh.corners(i);
        let around: f64 = (0..corners.len()).map(|k| corners[k].distance(corners[(k + 1) % corners.len()])).sum();
        let entry = expected.entry((whole_mesh.surface[i], whole_mesh.face[i])).or_default();
        *entry = (entry.0 + whole_mesh.area[i], entry.1 + around);
    }
    assert_eq!(areas.len(), expected.len());
    for (id, area) in &areas {
        let (wanted, around) = expected[id];
        assert!((area - wanted).abs() <= 1e-12 * wanted + 4.0 * tolerance * around, "{id:?}: {area}, not {wanted}");
    }
    for i in 0..mesh.len() {
        let face = (0..whole.len()).find(|&k| (whole.surface[k], whole.face[k]) == (mesh.surface[i], mesh.face[i]));
        let cosine = mesh.normal[i].dot(whole.normal[face.unwrap()]);
        let p = mesh.corners(i);
        let shortest = (0..p.len()).map(|k| p[k].distance(p[(k + 1) % p.len()])).fold(f64::INFINITY, f64::min);
        let height = mesh.area[i] / (0..p.len()).map(|k| p[k].distance(p[(k + 1) % p.len()])).fold(0.0, f64::max);
        if shortest.min(height) > 1e3 * tolerance.max(1e-9) {
            assert!(cosine > 1.0 - 1e-5, "patch {i} is turned: {cosine}");
        }
        for k in 0..p.len() {
            let (a, b, c) = (p[k], p[(k + 1) % p.len()], p[(k + 2) % p.len()]);
            let inward = (b - a).cross(c - b).dot(mesh.normal[i]);
            assert!(inward >= -tolerance * a.distance(c), "patch {i} has an inward corner");
        }
    }
}

/// Every patch of `floor` lies on one side of the line through `a` and `b`, where it is between them.
fn assert_not_across(mesh: &Patches, floor: u32, a: DVec3, b: DVec3) {
    let along = (b - a).normalize();
    for polygon in of(mesh, floor) {
        let normal = (polygon[1] - polygon[0]).cross(polygon[2] - polygon[0]).normalize();
        let side = normal.cross(along);
        // Where the outline crosses the line.
        let mut spots = Vec::new();
        for (i, &p) in polygon.iter().enumerate() {
            let q = polygon[(i + 1) % polygon.len()];
            let (h, k) = (side.dot(p - a), side.dot(q - a));
            if h.abs() > 1e-5 && k.abs() > 1e-5 && h * k < 0.0 {
                spots.push(along.dot(p.lerp(q, h / (h - k)) - a));
            } else if h.abs() <= 1e-5 {
                spots.push(along.dot(p - a));
            }
        }
        let sides: Vec<_> = polygon.iter().map(|&p| side.dot(p - a)).collect();
        let is_across = sides.iter().any(|&h| h > 1e-5) && sides.iter().any(|&h| h < -1e-5);
        if is_across {
            let low = spots.iter().copied().fold(f64::INFINITY, f64::min).max(0.0);
            let high = spots.iter().copied().fold(f64::NEG_INFINITY, f64::max).min(a.distance(b));
            assert!(high - low < 1e-5, "{polygon:?} lies across {a} to {b}");
        }
    }
}

#[test]
fn a_partition_cuts_all_that_it_touches_into_rectangles() {
    let parts = [room(v(4.0, 3.0, 2.5)), wall([1.7, 0.0], [1.7, 3.0], [0.0, 2.5])];
    let mesh = coarse(&parts);
    assert_faithful(&scene(&parts), &mesh, 0.0);
    // Floor, ceiling and two walls in two each; the others whole.
    assert_eq!(mesh.len(), 4 * 2 + 2 + 1);
    assert!(of(&mesh, 0).iter().all(|p| p.len() == 4));
    assert_joined(&mesh, 1, 0, |_| true);
    let fine = cut(&scene(&parts), 0.3);
    assert_joined(&fine, 1, 0, |p| p.z == 0.0 || p.z == 2.5 || p.y == 0.0 || p.y == 3.0);
}

#[test]
fn a_partition_that_ends_in_the_room_cuts_no_farther() {
    let parts = [room(v(4.0, 3.0, 2.5)), wall([1.7, 0.0], [1.7, 1.9], [0.0, 2.5])];
    let mesh = coarse(&parts);
    assert_faithful(&scene(&parts), &mesh, 0.0);
    for z in [0.0, 2.5] {
        assert_not_across(&mesh, 0, v(1.7, 0.0, z), v(1.7, 1.9, z));
    }
    assert_joined(&mesh, 1, 0, |p| p.z == 0.0);
    // The wall at y = 3 has no part in it.
    assert!(of(&mesh, 0).iter().any(|p| p.iter().all(|p| p.y == 3.0) && p.len() == 4 && p[0].distance(p[2]) > 4.0));
}

#[test]
fn legs_stand_on_their_own_patches() {
    let mut parts = vec![slab([0.0, 4.0], [0.0, 3.0], 0.0)];
    for (x, y) in [(1.0, 1.0), (2.2, 1.0), (2.2, 1.8), (1.0, 1.8)] {
        parts.push(block(v(x, y, 0.0), v(x + 0.05, y + 0.05, 0.7)));
    }
    let mesh = coarse(&parts);
    assert_faithful(&scene(&parts), &mesh, 0.0);
    let feet = of(&mesh, 0).into_iter().filter(|p| {
        let area = 0.5 * (p[2] - p[0]).cross(p[(3) % p.len()] - p[1]).length();
        (area - 0.0025).abs() < 1e-12
    });
    assert_eq!(feet.count(), 4);
    (1..5).for_each(|leg| assert_joined(&mesh, leg, 0, |p| p.z == 0.0));
}

#[test]
fn crossing_faces_are_cut_where_they_cross() {
    let parts = [wall([0.0, 1.0], [2.0, 1.0], [0.0, 1.0]), wall([1.2, 0.0], [1.2, 2.0], [0.0, 1.0])];
    let mesh = coarse(&parts);
    assert_eq!(mesh.len(), 4);
    assert_joined(&mesh, 0, 1, |p| (p.x - 1.2).abs() < 1e-9 && (p.y - 1.0).abs() < 1e-9);
    // A floor that pokes half way through.
    let parts = [wall([0.0, 1.0], [2.0, 1.0], [0.0, 1.0]), slab([0.5, 1.5], [0.3, 1.6], 0.4)];
    let mesh = coarse(&parts);
    assert_not_across(&mesh, 0, v(0.5, 1.0, 0.4), v(1.5, 1.0, 0.4));
    assert_eq!(of(&mesh, 1).len(), 2);
}

#[test]
fn a_picture_is_cut_into_its_wall_by_its_outline_only() {
    let picture = wall([1.0, 0.0], [2.0, 0.0], [1.0, 1.5]);
    let triangles = vec![
        vec![picture[0][0], picture[0][1], v(1.6, 0.0, 1.2)],
        vec![picture[0][1], picture[0][2], v(1.6, 0.0, 1.2)],
        vec![picture[0][2], picture[0][3], v(1.6, 0.0, 1.2)],
        vec![picture[0][3], picture[0][0], v(1.6, 0.0, 1.2)],
    ];
    for picture in [picture, triangles] {
        let parts = [wall([0.0, 0.0], [4.0, 0.0], [0.0, 2.5]), picture.clone()];
        let mesh = coarse(&parts);
        assert_faithful(&scene(&parts), &mesh, 0.0);
        let covered = of(&mesh, 0)
            .into_iter()
            .filter(|p| p.iter().all(|p| (1.0..=2.0).contains(&p.x) && p.z >= 1.0 && p.z <= 1.5));
        assert_eq!(covered.count(), 1);
        // What only blocks cuts too.
        let mut blocked = scene(&parts[..1]);
        blocked.obstructions.push(surface(&picture));
        assert_eq!(of(&cut(&blocked, f64::INFINITY), 0), of(&mesh, 0));
    }
}

#[test]
fn points_on_an_edge_are_put_into_it() {
    // A long floor edge against short walls.
    let mut parts = vec![slab([0.0, 4.0], [0.0, 3.0], 0.0)];
    for i in 0..4 {
        parts.push(wall([f64::from(i), 0.0], [f64::from(i + 1), 0.0], [0.0, 2.0]));
    }
    let mesh = coarse(&parts);
    assert_faithful(&scene(&parts), &mesh, 0.0);
    (1..5).for_each(|i| assert_joined(&mesh, i, 0, |p| p.z == 0.0));
    // The neighbour of the floor across the far edge is untouched, the one on the cut edge is not.
    let below: Faces = vec![vec![v(4.0, 0.0, 0.0), v(0.0, 0.0, 0.0), v(0.0, 0.0, -1.0), v(4.0, 0.0, -1.0)]];
    parts.push(below);
    assert_joined(&coarse(&parts), 5, 0, |p| p.z == 0.0);
}

#[test]
fn small_gaps_count_as_contact() {
    let angle = 0.37;
    let by = DMat3::from_rotation_z(angle) * DMat3::from_rotation_x(0.21);
    let parts =
        [room(v(4.0, 3.0, 2.5)), wall([1.7, 0.0], [1.7, 1.9], [0.0, 2.5]), block(v(2.5, 1.0, 0.0), v(3.1, 1.7, 0.6))];
    let parts = single(&turned(&parts, by, v(0.3, -0.2, 0.1)));
    let mesh = coarse(&parts);
    assert_faithful(&scene(&parts), &mesh, 4e-6);
    let down = by * DVec3::Z;
    let is_low = |p: DVec3| (down.dot(p - parts[0][1][0])).abs() < 1e-5;
    assert_joined(&mesh, 1, 0, is_low);
    assert_joined(&mesh, 2, 0, is_low);
    // Half a millimetre is a gap.
    let lifted = [slab([0.0, 4.0], [0.0, 3.0], 0.0), wall([1.7, 0.5], [1.7, 1.9], [5e-4, 2.5])];
    assert_eq!(coarse(&lifted).len(), 2);
}

#[test]
fn faces_that_share_corners_are_no_contacts() {
    let parts = [room(v(4.0, 3.0, 2.5)), block(v(1.0, 1.0, 1.0), v(2.0, 2.0, 2.0))];
    let scene = scene(&parts);
    for meshing in [Meshing::MaxEdge(0.3), Meshing::Count(500)] {
        let with = patches(&scene, &meshing).unwrap();
        let without = patches_with(&scene, &meshing, Contacts::Ignore).unwrap();
        assert_eq!(with.polygons, without.polygons);
    }
}

#[test]
fn as_is_nothing_is_cut() {
    let parts = [room(v(4.0, 3.0, 2.5)), wall([1.7, 0.0], [1.7, 3.0], [0.0, 2.5])];
    assert_eq!(patches(&scene(&parts), &Meshing::AsIs).unwrap().len(), 7);
}

/// Boxes turned about all axes in a room, in its faces and in each other.
fn boxes() -> impl Strategy<Value = Vec<Faces>> {
    let one = (
        prop::array::uniform3(0.0..4.0f64),
        prop::array::uniform3(0.05..1.5f64),
        prop::array::uniform3(0.0..6.3f64),
        0usize..4,
    );
    prop::collection::vec(one, 1..6).prop_map(|boxes| {
        let mut parts = vec![room(v(4.0, 4.0, 4.0))];
        for (place, size, angles, kind) in boxes {
            let (size, place) = (DVec3::from_array(size), DVec3::from_array(place));
            let by = match kind {
                0 => DMat3::IDENTITY,
                1 => DMat3::from_rotation_z(angles[0]),
                2 => DMat3::from_rotation_z(angles[0]) * DMat3::from_rotation_x(1e-7 * angles[1]),
                _ => DMat3::from_euler(glam::EulerRot::XYZ, angles[0], angles[1], angles[2]),
            };
            let place = if kind < 3 { v(place.x, place.y, 0.0) } else { place };
            parts.extend(turned(&[block(DVec3::ZERO, size)], by, place));
        }
        parts
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn random_boxes_are_cut_faithfully(parts in boxes(), max_edge in 0.4..6.0f64) {
        let scene = scene(&parts);
        let mesh = cut(&scene, max_edge);
        assert_faithful(&scene, &mesh, 4e-6);
        let longest = (0..mesh.len()).flat_map(|i| {
            let p = mesh.corners(i);
            (0..p.len()).map(|k| p[k].distance(p[(k + 1) % p.len()]))
        });
        prop_assert!(longest.fold(0.0, f64::max) <= max_edge * (1.0 + 2e-6));
        let rounded = self::scene(&single(&parts));
        let mesh = cut(&rounded, max_edge);
        assert_faithful(&rounded, &mesh, 4e-6);
        prop_assert_eq!(mesh.polygons, cut(&rounded, max_edge).polygons);
    }

    #[test]
    fn hostile_geometry_does_no_harm(
        corners in prop::collection::vec(prop::array::uniform3(prop::sample::select(
            vec![0.0, 1.0, 1e-7, 1.0 + 1e-7, 0.5, 1e-300, 1e9, 1e200, -1.0, 0.3, 3e-6])), 3..40),
    ) {
        let corners: Vec<DVec3> = corners.into_iter().map(DVec3::from_array).collect();
        let faces: Faces = corners.windows(3).map(<[DVec3]>::to_vec).collect();
        if let Ok(mesh) = patches(&scene(&[faces]), &Meshing::MaxEdge(f64::INFINITY)) {
            prop_assert!(mesh.polygons.iter().flatten().all(|p| p.is_finite()));
        }
    }
}

#[test]
#[ignore = "a timing; run it with --release"]
fn a_hundred_thousand_faces_take_little_time() {
    let n = 224;
    let at = |i: u32, j: u32| {
        let (x, y) = (f64::from(i) * 0.1, f64::from(j) * 0.1);
        v(x, y, 0.3 * (x.sin() * (1.3 * y).cos()))
    };
    let mut faces: Faces = Vec::new();
    for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        faces.extend([vec![a, b, c], vec![a, c, d]]);
    }
    let scene = scene(&[faces, wall([3.05, 3.0], [9.0, 8.1], [-1.0, 2.0])]);
    for contacts in [Contacts::Ignore, Contacts::Cut] {
        let start = std::time::Instant::now();
        let mesh = patches_with(&scene, &Meshing::MaxEdge(f64::INFINITY), contacts).unwrap();
        println!("{contacts:?}: {} patches in {:.3} s", mesh.len(), start.elapsed().as_secs_f64());
    }
}

#[test]
fn shared_outlines_stay_shared() {
    // Every edge of a floor in tiles is run along both ways or lies at its rim.
    let mut parts = vec![];
    for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (f64::from(i), f64::from(j)))) {
        parts.push(slab([i, i + 1.0], [j, j + 1.0], 0.0));
    }
    parts.push(block(v(0.4, 0.7, 0.0), v(2.3, 1.6, 0.5)));
    parts.push(wall([0.2, 0.1], [2.9, 2.8], [0.0, 1.0]));
    let mesh = cut(&scene(&parts), 0.4);
    let mut uses: HashMap<[[u64; 3]; 2], usize> = HashMap::new();
    for polygon in (0..9).flat_map(|s| of(&mesh, s)) {
        for i in 0..polygon.len() {
            *uses.entry([key(polygon[i]), key(polygon[(i + 1) % polygon.len()])]).or_default() += 1;
        }
    }
    let rim = |p: [u64; 3]| {
        let p = p.map(f64::from_bits);
        [p[0] == 0.0, p[0] == 3.0, p[1] == 0.0, p[1] == 3.0]
    };
    for &[a, b] in uses.keys() {
        let is_rim = rim(a).iter().zip(rim(b)).any(|(&a, b)| a && b);
        assert!(is_rim || uses.contains_key(&[b, a]), "an edge has no counterpart");
    }
}
