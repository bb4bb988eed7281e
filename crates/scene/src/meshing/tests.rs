use std::collections::HashMap;

use glam::DVec3;
use proptest::prelude::*;
use radiosity_geometry::Patches;

use super::{Contacts, Meshing, grid, is_degenerate, patches, patches_with};
use crate::{Face, Material, Scene, Surface};

/// A surface that owns copies of the corners of each face, as files with split vertices have them.
fn surface(name: &str, faces: &[Vec<DVec3>]) -> Surface {
    let mut surface = Surface { name: name.into(), ..Surface::default() };
    for corners in faces {
        let first = surface.vertices.len() as u32;
        let last = first + corners.len() as u32 - 1;
        surface.vertices.extend(corners);
        surface.faces.push([first, first + 1, first + 2, last]);
    }
    surface
}

/// A scene with every `n`-th face in the same one of `n` surfaces.
fn scene_of(faces: &[Vec<DVec3>], n: usize) -> Scene {
    let share = |k: usize| faces.iter().skip(k).step_by(n).cloned().collect::<Vec<_>>();
    let surfaces = (0..n).map(|k| surface(&format!("part {k}"), &share(k))).collect();
    Scene { name: "test".into(), surfaces, ..Scene::default() }
}

fn v(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

/// The faces of a prism over an anticlockwise polygon; the caps are given as index lists.
fn prism(outline: &[(f64, f64)], height: f64, caps: &[&[usize]]) -> Vec<Vec<DVec3>> {
    let at = |i: usize, z: f64| v(outline[i].0, outline[i].1, z);
    let n = outline.len();
    let wall = |i: usize| {
        let j = (i + 1) % n;
        vec![at(i, 0.0), at(j, 0.0), at(j, height), at(i, height)]
    };
    let mut faces: Vec<_> = (0..n).map(wall).collect();
    for cap in caps {
        faces.push(cap.iter().map(|&i| at(i, height)).collect());
        faces.push(cap.iter().rev().map(|&i| at(i, 0.0)).collect());
    }
    faces
}

fn cube(x: f64, y: f64, z: f64) -> Vec<Vec<DVec3>> {
    prism(&[(0.0, 0.0), (x, 0.0), (x, y), (0.0, y)], z, &[&[0, 1, 2, 3]])
}

fn tetrahedron() -> Vec<Vec<DVec3>> {
    let [a, b, c, d] = [v(0.0, 0.0, 0.0), v(1.3, 0.1, 0.0), v(0.4, 1.1, 0.2), v(0.3, 0.2, 0.9)];
    vec![vec![a, c, b], vec![a, b, d], vec![b, c, d], vec![c, a, d]]
}

fn l_shape() -> Vec<Vec<DVec3>> {
    let outline = [(0.0, 0.0), (2.1, 0.0), (2.1, 1.0), (1.0, 1.0), (1.0, 1.7), (0.0, 1.7)];
    prism(&outline, 1.2, &[&[0, 1, 3], &[1, 2, 3], &[0, 3, 5], &[3, 4, 5]])
}

fn trapezoids() -> Vec<Vec<DVec3>> {
    prism(&[(0.0, 0.0), (3.0, 0.0), (2.2, 1.1), (0.9, 1.1)], 0.7, &[&[0, 1, 2, 3]])
}

/// All faces as triangles.
fn triangulated(faces: &[Vec<DVec3>]) -> Vec<Vec<DVec3>> {
    faces.iter().flat_map(|f| (1..f.len() - 1).map(|i| vec![f[0], f[i], f[i + 1]])).collect()
}

/// An octahedron with every face cut in four `levels` times and its vertices pushed to a bumpy sphere.
fn sphere(levels: usize, bump: f64, phase: f64) -> Vec<Vec<DVec3>> {
    let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z];
    let mut faces: Vec<Vec<DVec3>> = Vec::new();
    for (sx, sy, sz) in
        [(1, 1, 1), (-1, 1, 1), (-1, -1, 1), (1, -1, 1), (1, 1, -1), (-1, 1, -1), (-1, -1, -1), (1, -1, -1)]
    {
        let (a, b, c) = (x * f64::from(sx), y * f64::from(sy), z * f64::from(sz));
        faces.push(if sx * sy * sz > 0 { vec![a, b, c] } else { vec![a, c, b] });
    }
    for _ in 0..levels {
        faces = faces
            .iter()
            .flat_map(|f| {
                let [p, q, r] = [f[0] + f[1], f[1] + f[2], f[2] + f[0]].map(|m| 0.5 * m);
                [vec![f[0], p, r], vec![p, f[1], q], vec![r, q, f[2]], vec![p, q, r]]
            })
            .collect();
    }
    let push = |p: &DVec3| {
        let wave = |t: f64| (t * 12.9898 + phase).sin();
        p.normalize() * (1.0 + bump * (wave(p.x) + wave(2.0 * p.y) + wave(3.0 * p.z)))
    };
    faces.iter().map(|f| f.iter().map(push).collect()).collect()
}

/// Every edge of a closed mesh is run along once each way, to the bit.
fn assert_conforming(patches: &Patches) {
    let mut uses: HashMap<[[u64; 3]; 2], usize> = HashMap::new();
    let key = |p: DVec3| p.to_array().map(|x| (x + 0.0).to_bits());
    for i in 0..patches.len() {
        let corners = patches.corners(i);
        for (k, &a) in corners.iter().enumerate() {
            *uses.entry([key(a), key(corners[(k + 1) % corners.len()])]).or_default() += 1;
        }
    }
    for (&[a, b], &n) in &uses {
        assert_eq!(n, 1, "edge used twice in one direction");
        assert_eq!(uses.get(&[b, a]), Some(&1), "edge without its counterpart");
    }
}

/// The properties that hold for every mesh of every scene.
fn assert_faithful(scene: &Scene, mesh: &Patches, max_edge: f64) {
    let raw = patches(scene, &Meshing::AsIs).unwrap();
    let (area, expected): (f64, f64) = (mesh.area.iter().sum(), raw.area.iter().sum());
    assert!((area - expected).abs() <= 1e-12 * expected, "area {area}, not {expected}");
    for i in 0..mesh.len() {
        let face = scene.surfaces[mesh.surface[i] as usize].faces[mesh.face[i] as usize];
        let [a, b, c, d] = face.map(|k| scene.surfaces[mesh.surface[i] as usize].vertices[k as usize]);
        assert!(mesh.normal[i].dot((c - a).cross(d - b).normalize()) > 1.0 - 1e-9, "patch {i} is turned");
        let corners = mesh.corners(i);
        for (k, a) in corners.iter().enumerate() {
            let length = a.distance(corners[(k + 1) % corners.len()]);
            assert!(length <= max_edge * (1.0 + 2e-6), "edge of {length} m, more than {max_edge} m");
        }
    }
    let order: Vec<_> = mesh.surface.iter().zip(&mesh.face).collect();
    assert!(order.is_sorted(), "patches out of order");
}

/// The smallest height over longest edge of any patch.
fn worst_shape(patches: &Patches) -> f64 {
    let shape = |i: usize| {
        let p = patches.corners(i);
        let longest = (0..p.len()).map(|k| p[k].distance_squared(p[(k + 1) % p.len()])).fold(0.0, f64::max);
        patches.area[i] / longest * if p.len() == 3 { 2.0 } else { 1.0 }
    };
    (0..patches.len()).map(shape).fold(f64::INFINITY, f64::min)
}

fn cut(scene: &Scene, max_edge: f64) -> Patches {
    patches(scene, &Meshing::MaxEdge(max_edge)).unwrap()
}

#[test]
fn closed_solids_are_cut_without_gaps() {
    for faces in [cube(1.0, 2.3, 0.7), tetrahedron(), l_shape(), trapezoids(), sphere(2, 0.1, 0.3)] {
        for faces in [triangulated(&faces), faces] {
            for parts in 1..4 {
                let scene = scene_of(&faces, parts);
                for max_edge in [10.0, 0.9, 0.5, 0.31, 0.1, 0.043] {
                    let mesh = cut(&scene, max_edge);
                    assert_conforming(&mesh);
                    assert_faithful(&scene, &mesh, max_edge);
                }
            }
        }
    }
}

#[test]
fn shapes_stay_good() {
    // Half a square has 0.5. The bounds are a little below what the mesher reached; they guard against getting worse.
    let cases = [(cube(1.0, 2.3, 0.7), 0.45), (tetrahedron(), 0.25), (l_shape(), 0.25), (trapezoids(), 0.25)];
    for (faces, bound) in cases {
        for max_edge in [0.9, 0.5, 0.31, 0.1, 0.043, 0.01] {
            let worst = worst_shape(&cut(&scene_of(&triangulated(&faces), 1), max_edge));
            assert!(worst > bound, "{worst} for {max_edge}");
        }
    }
}

#[test]
fn a_quad_becomes_a_grid_in_rows() {
    let face = vec![v(0.0, 0.0, 1.0), v(3.0, 0.0, 1.0), v(3.0, 2.0, 1.0), v(0.0, 2.0, 1.0)];
    let mesh = cut(&scene_of(&[face], 1), 1.0);
    assert_eq!(mesh.len(), 6);
    let expected = [v(1.0, 1.0, 1.0), v(2.0, 1.0, 1.0), v(2.0, 2.0, 1.0), v(1.0, 2.0, 1.0)];
    // Column 1, row 1 of three columns.
    assert_eq!(mesh.polygons[4], expected);
    assert_eq!(mesh.normal, vec![DVec3::Z; 6]);
}

#[test]
fn two_triangles_of_a_rectangle_are_cut_as_one() {
    let rectangle = [v(0.0, 0.0, 0.0), v(0.4, 0.0, 0.0), v(0.4, 0.3, 0.0), v(0.0, 0.3, 0.0)];
    let faces = triangulated(&[rectangle.to_vec()]);
    let mesh = cut(&scene_of(&faces, 1), 0.1);
    assert_eq!(mesh.len(), 12);
    assert!((0..12).all(|i| mesh.corners(i).len() == 4 && mesh.face[i] == 0));
    // Not across surfaces.
    let apart = cut(&scene_of(&faces, 2), 1.0);
    assert_eq!(apart.surface, [0, 1]);
}

#[test]
fn no_merging_across_an_edge_on_which_a_wall_stands() {
    let mut faces = triangulated(&[vec![v(0.0, 0.0, 0.0), v(1.0, 0.0, 0.0), v(1.0, 1.0, 0.0), v(0.0, 1.0, 0.0)]]);
    faces.push(vec![v(0.0, 0.0, 0.0), v(1.0, 1.0, 0.0), v(0.5, 0.5, 1.0)]);
    assert_eq!(cut(&scene_of(&faces, 1), 2.0).len(), 3);
}

#[test]
fn a_triangulated_grid_is_merged_back_into_its_cells() {
    let mut faces = Vec::new();
    for (i, j) in (0..7).flat_map(|i| (0..5).map(move |j| (f64::from(i), f64::from(j)))) {
        let p = |a: f64, b: f64| v((i + a) * 0.1, (j + b) * 0.1, 0.3);
        faces.extend(triangulated(&[vec![p(0.0, 0.0), p(1.0, 0.0), p(1.0, 1.0), p(0.0, 1.0)]]));
    }
    let mesh = cut(&scene_of(&faces, 1), 1.0);
    assert_eq!(mesh.len(), 35);
    assert!(mesh.area.iter().all(|a| (a - 0.01).abs() < 1e-12));
}

#[test]
fn concave_and_bent_quads_are_split() {
    let arrow = vec![v(0.0, 0.0, 0.0), v(2.0, -1.0, 0.0), v(0.5, 0.0, 0.0), v(2.0, 1.0, 0.0)];
    let mesh = cut(&scene_of(&[arrow], 1), 5.0);
    assert_eq!(mesh.len(), 2);
    assert!(mesh.normal.iter().all(|n| n.z == 1.0));
    let bent = vec![v(0.0, 0.0, 0.0), v(1.0, 0.0, 0.0), v(1.0, 1.0, 0.5), v(0.0, 1.0, 0.0)];
    assert_eq!(cut(&scene_of(&[bent], 1), 5.0).len(), 2);
}

#[test]
fn as_is_keeps_every_face() {
    let mut faces = cube(1.0, 1.0, 1.0);
    faces.push(vec![DVec3::ZERO, DVec3::X, 2.0 * DVec3::X]);
    faces.push(tetrahedron().remove(0));
    let mut scene = scene_of(&faces, 1);
    scene.surfaces[0].material = Material { two_sided: true, ..Material::default() };
    let mesh = patches(&scene, &Meshing::AsIs).unwrap();
    assert_eq!(mesh.face, (0..8).collect::<Vec<_>>());
    assert_eq!((mesh.corners(0).len(), mesh.corners(6).len(), mesh.area[6]), (4, 3, 0.0));
    assert!(mesh.two_sided.iter().all(|&t| t));
    // The other meshings leave out what has no area.
    let whole = patches_with(&scene, &Meshing::MaxEdge(9.0), Contacts::Ignore).unwrap();
    assert_eq!(whole.len(), 7);
}

#[test]
fn degenerate_quads_are_cut_as_triangles() {
    let [a, b, c] = [v(0.0, 0.0, 0.0), v(1.0, 0.0, 0.0), v(0.3, 1.0, 0.0)];
    for corners in [[a, a, b, c], [a, b, b, c], [a, b, c, c], [a, b, c, a]] {
        let mut surface = surface("s", &[corners.to_vec()]);
        surface.faces = vec![[0, 1, 2, 3]];
        let scene = Scene { surfaces: vec![surface], ..Scene::default() };
        let mesh = cut(&scene, 3.0);
        assert_eq!((mesh.len(), mesh.corners(0).len()), (1, 3));
        assert!((mesh.area[0] - 0.5).abs() < 1e-15);
        assert!(mesh.normal[0] == DVec3::Z);
    }
    assert!(is_degenerate(&[a, b, b, a]) && is_degenerate(&[a, a, a, a]) && !is_degenerate(&[a, b, c, c]));
}

#[test]
fn about_as_many_patches_as_asked_for() {
    for faces in [cube(1.0, 2.3, 0.7), triangulated(&l_shape()), trapezoids(), sphere(2, 0.1, 0.3), tetrahedron()] {
        let scene = scene_of(&faces, 2);
        for count in [300, 1000, 5000, 40_000] {
            let n = patches(&scene, &Meshing::Count(count)).unwrap().len() as f64 / count as f64;
            assert!((0.85..1.18).contains(&n), "{n} times the {count} asked for");
        }
        assert!(patches(&scene, &Meshing::Count(1)).unwrap().len() <= faces.len());
    }
}

#[test]
fn absurd_requests_are_refused() {
    let scene = scene_of(&cube(10.0, 10.0, 10.0), 1);
    for meshing in [
        Meshing::MaxEdge(1e-4),
        Meshing::MaxEdge(f64::MIN_POSITIVE),
        Meshing::MaxEdge(0.0),
        Meshing::MaxEdge(-1.0),
        Meshing::MaxEdge(f64::NAN),
        Meshing::Count(0),
        Meshing::Count(usize::MAX),
    ] {
        assert!(patches(&scene, &meshing).is_err(), "{meshing:?}");
    }
    assert!(grid(&scene, &[(1 << 40, 1 << 40); 6]).is_err());
    assert!(grid(&scene, &[(1, 1); 5]).is_err());
    assert!(grid(&scene, &[(1, 0); 6]).is_err());
}

#[test]
fn broken_faces_are_refused_by_name() {
    let mut scene = scene_of(&cube(1.0, 1.0, 1.0), 1);
    scene.surfaces[0].faces[3] = [0, 1, 2, 99] as Face;
    let error = patches(&scene, &Meshing::AsIs).unwrap_err().to_string();
    assert!(error.contains("part 0") && error.contains("face 3"), "{error}");
    scene.surfaces[0].vertices[5].y = f64::NAN;
    let error = patches(&scene, &Meshing::MaxEdge(1.0)).unwrap_err().to_string();
    assert!(error.contains("vertex 5"), "{error}");
}

#[test]
fn explicit_grids() {
    let scene = scene_of(&cube(1.0, 1.0, 1.0), 1);
    let mesh = grid(&scene, &[(1, 2), (3, 4), (1, 1), (2, 2), (1, 1), (5, 1)]).unwrap();
    assert_eq!(mesh.len(), 2 + 12 + 1 + 4 + 1 + 5);
    let [a, b, ..] = mesh.polygons[3];
    assert_eq!((a, b), (v(1.0, 1.0 / 3.0, 0.0), v(1.0, 2.0 / 3.0, 0.0)));
    let triangle = scene_of(&[tetrahedron().remove(0)], 1);
    assert_eq!(grid(&triangle, &[(3, 3)]).unwrap().len(), 9);
    assert!(grid(&triangle, &[(3, 2)]).is_err());
}

#[test]
fn an_empty_scene_has_no_patches() {
    for meshing in [Meshing::AsIs, Meshing::MaxEdge(1.0), Meshing::Count(100)] {
        assert!(patches(&Scene::default(), &meshing).unwrap().is_empty());
    }
}

proptest! {
    #[test]
    fn random_spheres_are_cut_without_gaps(
        levels in 0usize..3, bump in 0.0..0.08, phase in 0.0..6.0, max_edge in 0.03f64..1.5, parts in 1usize..4,
    ) {
        let scene = scene_of(&sphere(levels, bump, phase), parts);
        let mesh = cut(&scene, max_edge);
        assert_conforming(&mesh);
        assert_faithful(&scene, &mesh, max_edge);
        let raw = worst_shape(&patches(&scene, &Meshing::AsIs).unwrap());
        let worst = worst_shape(&mesh);
        prop_assert!(worst > 0.2 * raw, "{} of {}", worst, raw);
    }

    #[test]
    fn random_triangles_are_cut_faithfully(
        corners in prop::array::uniform3(prop::array::uniform3(-1.0..1.0f64)), max_edge in 0.02f64..1.0,
    ) {
        let corners = corners.map(DVec3::from_array);
        let height = (corners[1] - corners[0]).cross(corners[2] - corners[0]).length();
        prop_assume!(height > 0.05);
        let scene = scene_of(&[corners.to_vec()], 1);
        let mesh = cut(&scene, max_edge);
        assert_faithful(&scene, &mesh, max_edge);
        // No worse than the triangle itself, but for a factor.
        let raw = worst_shape(&patches(&scene, &Meshing::AsIs).unwrap());
        prop_assert!(worst_shape(&mesh) > 0.2 * raw, "{} of {}", worst_shape(&mesh), raw);
    }
}

#[test]
fn obstructions_stay_whole_however_the_scene_is_cut() {
    let mut scene = scene_of(&cube(1.0, 1.0, 1.0), 1);
    let (quad, triangle) = (prism(&[(0.2, 0.2), (0.8, 0.2), (0.5, 0.6)], 0.5, &[]), v(0.5, 0.5, 0.5));
    scene.obstructions.push(surface("screen", &[quad[0].clone(), vec![quad[0][0], quad[0][1], triangle]]));
    let corners = [0, 1, 2, 3].map(|i| quad[0][i]);
    let expected = vec![corners, [corners[0], corners[1], triangle, triangle]];
    let meshes = [Meshing::AsIs, Meshing::MaxEdge(0.1), Meshing::Count(50)].map(|m| patches(&scene, &m).unwrap());
    for mesh in meshes.into_iter().chain([grid(&scene, &[(2, 2); 6]).unwrap()]) {
        assert_eq!(mesh.obstructions, expected);
        assert!(mesh.surface.iter().all(|&surface| surface == 0));
    }
    scene.obstructions[0].faces[1][2] = 99;
    assert!(patches(&scene, &Meshing::AsIs).unwrap_err().to_string().contains("obstruction 'screen', face 1"));
}
