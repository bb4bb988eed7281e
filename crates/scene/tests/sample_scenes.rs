//! The scenes that are shipped: the same study in three forms.

use radiosity_scene::{Light, LoadOptions, Scene, load};

fn study(extension: &str) -> Scene {
    let path = format!("{}/../../scenes/study.{extension}", env!("CARGO_MANIFEST_DIR"));
    load(path, &LoadOptions::default()).unwrap()
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
