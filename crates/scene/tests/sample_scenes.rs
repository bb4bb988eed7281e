//! The scenes that are shipped: the same study in three forms, an enclosure in two, a room of View3D.

use radiosity_scene::{Light, LoadOptions, Scene, load};

fn sample(name: &str) -> Scene {
    load(format!("{}/../../scenes/{name}", env!("CARGO_MANIFEST_DIR")), &LoadOptions::default()).unwrap()
}

fn study(extension: &str) -> Scene {
    sample(&format!("study.{extension}"))
}

fn area(scene: &Scene) -> f64 {
    let faces = scene.surfaces.iter().flat_map(|surface| surface.faces.iter().map(|&face| surface.corners(face)));
    faces.map(|[a, b, c, d]| 0.5 * (c - a).cross(d - b).length()).sum()
}

/// Emitted power in the first band.
fn power(scene: &Scene) -> f64 {
    let surfaces = scene.surfaces.iter().cloned();
    surfaces
        .map(|surface| surface.material.emission[0] * area(&Scene { surfaces: vec![surface], ..Scene::default() }))
        .sum()
}

#[test]
fn studies_have_no_findings() {
    for extension in ["glb", "gltf", "obj"] {
        assert_eq!(study(extension).findings(), vec![], "{extension}");
    }
}

#[test]
fn forms_agree() {
    let (binary, text, wavefront) = (study("glb"), study("gltf"), study("obj"));
    assert_eq!(area(&binary), area(&text));
    assert!((area(&binary) - area(&wavefront)).abs() < 1e-4 * area(&binary));
    assert!((power(&binary) - power(&wavefront)).abs() < 1e-4 * power(&binary));
    assert_eq!(wavefront.face_count() * 2, binary.face_count(), "OBJ keeps its quads");
}

#[test]
fn instances_lights_and_camera_are_read() {
    let study = study("glb");
    let chairs: Vec<_> = study.surfaces.iter().filter(|surface| surface.name.starts_with("chair")).collect();
    assert_eq!(chairs.len() % 2, 0);
    assert_eq!(chairs[0].faces, chairs[chairs.len() / 2].faces);
    assert!(matches!(&study.lights[..], [Light::Point { name, .. }] if name == "bulb"));
    let camera = &study.cameras[0];
    // It stands in a corner and looks across the room, slightly down.
    assert!(camera.forward.x < -0.5 && camera.forward.z > 0.3 && camera.forward.y < -0.05, "{}", camera.forward);
    assert!(camera.up.y > 0.9);
}

/// By the divergence theorem, negative where normals point inward.
fn volume(scene: &Scene) -> f64 {
    let faces = scene.surfaces.iter().flat_map(|surface| surface.faces.iter().map(|&face| surface.corners(face)));
    faces.map(|[a, b, c, d]| a.dot(b.cross(c)) + a.dot(c.cross(d))).sum::<f64>() / 6.0
}

#[test]
fn corner_is_closed_and_looks_inward() {
    for name in ["corner.stl", "corner.ply"] {
        let scene = sample(name);
        // An L of 3 m2 and 8 m around, 1 m high.
        assert!((area(&scene) - (2.0 * 3.0 + 8.0)).abs() < 1e-12, "{name}");
        assert!((volume(&scene) + 3.0).abs() < 1e-12, "{name}: {}", volume(&scene));
        assert_eq!(scene.surfaces.len(), 1);
        assert_eq!(scene.enclosure_findings(), vec![], "{name}");
        let codes: Vec<_> = scene.findings().iter().map(|finding| finding.code).collect();
        assert_eq!(codes, ["no-material", "no-light"], "{name}");
    }
}

#[test]
fn room_of_view3d_is_closed_but_for_its_table() {
    let room = sample("room.vs3");
    let names: Vec<_> = room.surfaces.iter().map(|surface| surface.name.as_str()).collect();
    assert_eq!(names, ["floor", "ceiling", "ceiling_right", "back", "window", "front", "left", "right", "plate"]);
    let one = |i: usize| area(&Scene { surfaces: vec![room.surfaces[i].clone()], ..Scene::default() });
    assert!((one(3) - (4.0 * 2.5 - one(4))).abs() < 1e-12 && (one(4) - 1.4 * 1.1).abs() < 1e-12);
    assert_eq!(room.combined, [(2, 1)].into_iter().collect());
    assert_eq!(room.hints.tolerance, Some(1e-5));
    let table = Scene { surfaces: room.obstructions.clone(), ..Scene::default() };
    assert!((area(&table) - (1.0 - 0.16)).abs() < 1e-12);
    assert!(room.validate_geometry().is_ok());

    let mut shell = room;
    shell.surfaces.pop();
    assert!((volume(&shell) + 4.0 * 2.5 * 3.0).abs() < 1e-12);
    assert_eq!(shell.enclosure_findings(), vec![]);
}
